// The solver tables of the scene and of its stages.
#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <string_view>

#include "scene/block_kinds.h"
#include "scene/driven.h"
#include "scene/reader.h"

namespace quoin::reader {

namespace {

void read_large_motion(Table& t, SolverSettings* s) {
  t.choice("large_motion", s->large_motion,
           {{"automatic", LargeMotion::automatic}, {"never", LargeMotion::never}, {"always", LargeMotion::always}});
  t.number("rotation_bound", s->motion_bound.rotation, kPositive, "rad");
  t.number("sliding_bound", s->motion_bound.sliding, kPositive, "of the length of a joint");
  bool& stop = s->motion_bound.stop;
  if (t.choice("past_motion_bound", stop, {{"stop", true}, {"warn", false}}) && s->large_motion != LargeMotion::never)
    t.refuse("past_motion_bound", "only with large_motion = \"never\"; remove it, or change large_motion");
}

void read_kernels(Table& t, SolverSettings* s) {
  t.choice("kernels", s->kernels,
           {{"automatic", Kernels::automatic}, {"lattice", Kernels::lattice}, {"general", Kernels::general}});
  if (s->kernels == Kernels::lattice && s->large_motion == LargeMotion::always)
    t.refuse("kernels", "\"automatic\" or \"general\" with large_motion = \"always\", which the lattice does not have");
}

// Reads what a stage may change: damping and the fraction of the time step.
void read_damping_and_fraction(Table& t, SolverSettings& s) {
  read_damping(t, s);
  t.number("time_step_fraction", s.time_step_fraction, above_to(0, 1),
           "of the critical time step (0.6 of 2/omega_max is sound)");
}

void read_inertia(Table& t, SolverSettings& s) {
  t.number("mass_scaling", s.mass_scaling, between(1, 1e9), "times the true inertia");
  t.number("selective_time_step", s.selective_time_step, between(0, 1), "s (0: none)");
  t.number("deformation_inertia", s.deformation_inertia, between(1, 1e6), "times the true inertia against deformation");
  t.number("unit_inertia", s.unit_inertia, between(1, 1e6),
           "times the true inertia against motion of the halves of a unit on each other");
  for (const auto& [key, factor] :
       {std::pair{"deformation_inertia", s.deformation_inertia}, std::pair{"unit_inertia", s.unit_inertia}}) {
    if (factor == 1.0) continue;
    if (s.selective_time_step > 0.0)
      t.refuse(key, "1 with selective_time_step, which has its own way to raise the step; use one");
    if (damping_of(s).eq1 == Eq1::gridpoints)
      t.refuse(key,
               "1 with damping = \"local\": slow vibrations inside units would brake their motion (a wall came out "
               "15 % too strong); use damping = \"block\"");
  }
}

}  // namespace

SolverSettings read_solver(Table t, const Quality* quality) {
  SolverSettings s;
  const DampingKind usual = quality ? quality->solver.damping : s.damping;
  s.damping = usual;
  read_damping_kind(t, s);
  // The errors of a quality hold for all its settings together. With another damping or mass scaling, defaults are
  // plain ones.
  const double selective = t.toml()["selective_time_step"].value_or(0.0);
  if (quality && s.damping == usual && selective == 0.0) s = quality->solver;
  read_damping_and_fraction(t, s);
  read_inertia(t, s);
  read_large_motion(t, &s);
  read_kernels(t, &s);
  t.choice("critical_time_step", s.critical_time_step,
           {{"assembled", CriticalTimeStep::assembled}, {"nodal", CriticalTimeStep::nodal}});
  if (s.critical_time_step == CriticalTimeStep::nodal &&
      (s.selective_time_step > 0.0 || s.deformation_inertia != 1.0 || s.unit_inertia != 1.0))
    t.refuse("critical_time_step",
             "\"assembled\" where inertia is raised, which eq. 3 leaves out; for \"nodal\" take damping = "
             "\"local\", or deformation_inertia = 1 and unit_inertia = 1, and no selective_time_step");
  t.choice("internal_forces", s.internal_forces,
           {{"automatic", InternalForces::automatic},
            {"assembled", InternalForces::assembled},
            {"zones", InternalForces::zones}});
  t.boolean("skip_resting_bodies", s.skip_resting_bodies);
  t.finish();
  return s;
}

SolverSettings read_solver_of_stage(Table t, const SolverSettings& before, bool moves_ground) {
  SolverSettings s = before;
  read_damping_kind(t, s);
  // Eq. 1 at gridpoints needs shorter steps than the damping of a quality.
  if (s.damping == DampingKind::local && before.damping != DampingKind::local)
    s.time_step_fraction = std::min(s.time_step_fraction, SolverSettings().time_step_fraction);
  read_damping_and_fraction(t, s);
  if (moves_ground) {
    t.number("deformation_inertia", s.deformation_inertia, between(1, 1e6), "times the true inertia");
    t.number("unit_inertia", s.unit_inertia, between(1, 1e6), "times the true inertia");
    for (const auto& [key, of_run] :
         {std::pair("mass_scaling", before.mass_scaling), {"selective_time_step", before.selective_time_step}}) {
      double repeated = of_run;
      if (t.number(key, repeated, kNotNegative, "") && repeated != of_run)
        t.refuse(key, fmt::format("that of [solver], {:g}: it is of the whole run", of_run));
    }
  }
  for (const char* key : {"mass_scaling", "selective_time_step", "deformation_inertia", "unit_inertia"}) {
    if (!moves_ground) t.refuse_if_given(key, "not in a stage: inertia is of the whole run; give it in [solver]");
  }
  if (damping_of(s).is_implicit() && (s.deformation_inertia != 1.0 || s.unit_inertia != 1.0))
    t.refuse("implicit_contacts", "only with true inertia: deformation_inertia = 1 and unit_inertia = 1");
  if (damping_of(s).eq1 == Eq1::gridpoints && (s.deformation_inertia != 1.0 || s.unit_inertia != 1.0))
    t.refuse("damping",
             "damping other than \"local\" with solver.deformation_inertia or unit_inertia above 1: slow vibrations of "
             "blocks would brake their motion");
  t.finish();
  return s;
}

namespace {

// Defaults of a stage with ground motion: true inertia, and the damping of [solver] where the stage before has eq. 1.
// Where [solver] has eq. 1 too, it is impact damping. What [solver] writes against these is refused, unless the stage
// repeats it.
SolverSettings settings_on_ground(Table& t, const toml::table* own, const SolverSettings& before,
                                  const SolverSettings& of_run) {
  SolverSettings s = before;
  const auto written = [&](const char* key) {
    const bool given = t.context().solver && t.context().solver->contains(key) && !(own && own->contains(key));
    if (given)
      t.context().fault(
          fmt::format("{}: the stage moves the ground, and solver.{} = {} would falsify its motion; remove "
                      "it there, or repeat it with this value in the solver table of the stage",
                      t.where(), key, text_of(*t.context().solver->get(key))));
    return given;
  };
  const bool says = own && own->contains("damping");
  if (damping_of(s).gamma > 0.0 && !says) {
    if (damping_of(of_run).gamma == 0.0)
      static_cast<DampingSettings&>(s) = of_run;
    else if (!written("damping") && !written("local_damping"))
      s.damping = DampingKind::impact;
  }
  for (const auto& [key, inertia] : {std::pair("deformation_inertia", &SolverSettings::deformation_inertia),
                                     std::pair("unit_inertia", &SolverSettings::unit_inertia)}) {
    if (s.*inertia != 1.0 && (of_run.*inertia == 1.0 || !written(key))) s.*inertia = 1.0;
  }
  if (s.mass_scaling != 1.0) written("mass_scaling");
  if (s.selective_time_step > 0.0) written("selective_time_step");
  return s;
}

// solver: table of the scene or of a stage; null: there is none.
bool chooses_damping(const toml::table* solver) {
  return std::ranges::any_of(std::array{"damping", "local_damping", "settling_damping"},
                             [&](const char* key) { return solver && solver->contains(key); });
}

// gamma of a stage of rigid blocks alone whose damping the scene does not choose; none: not such a stage.
std::optional<double> gamma_by_default(Table& t, const Scene& scene, const Stage& stage) {
  const bool is_chosen = t.context().damping_is_chosen || chooses_damping(t.context().solver);
  const BlockKinds kinds = kinds_of_blocks(scene);
  if (is_chosen || stage.ground || !scene.blocks || !kinds.rigid || kinds.deformable) return std::nullopt;
  return moves_blocks(stage) ? kGammaInMotion : scene.solver.local_damping;
}

}  // namespace

void read_stage_solver(Table& t, Stage& stage, const Scene& scene) {
  const auto* own = t.table("solver", "a table: damping and time_step_fraction from this stage on");
  const SolverSettings& before = scene.solver_in(scene.stages.size());
  SolverSettings base = stage.ground ? settings_on_ground(t, own, before, scene.solver) : before;
  if (damping_of(before).eq1 == Eq1::gridpoints)
    base.local_damping = gamma_by_default(t, scene, stage).value_or(base.local_damping);
  const bool differs = base.damping != before.damping || base.local_damping != before.local_damping ||
                       base.deformation_inertia != before.deformation_inertia ||
                       base.unit_inertia != before.unit_inertia;
  if (own)
    stage.solver = read_solver_of_stage({t.context(), *own, t.path("solver")}, base, stage.ground.has_value());
  else if (differs)
    stage.solver = base;
  t.context().damping_is_chosen |= chooses_damping(own);
}

}  // namespace quoin::reader
