#include "results/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "members/members.h"
#include "records/record.h"
#include "records/response_spectrum.h"
#include "results/ground_response.h"
#include "results/history.h"
#include "results/json_file.h"
#include "results/plots.h"
#include "scene/collapse_load.h"
#include "scene/damping_text.h"
#include "scene/generate.h"
#include "scene/measured.h"
#include "scene/quality.h"
#include "step/findings.h"
#include "step/kernels.h"
#include "step/large_motion.h"
#include "step/results.h"

#ifndef QUOIN_VERSION
#define QUOIN_VERSION "unknown"
#endif

namespace quoin {

namespace {

using Json = nlohmann::ordered_json;

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

Json laws_of(const Simulation& simulation) {
  Json laws = Json::object();
  for (const ContactFamily& family : simulation.model().families) {
    const Law& law = family.material->law();
    laws[family.name] = {
        {"law", law.law->id}, {"version", law_text(law.law->version)}, {"library", law.library->path()}};
  }
  return laws;
}

// Series for pictures: the largest sample of each of kSpans spans.
Json thinned(const TimeSeries& series) {
  constexpr std::size_t kSpans = 600;
  Json time = Json::array(), value = Json::array();
  const std::size_t count = series.time.size();
  for (std::size_t span = 0; span < std::min(kSpans, count); ++span) {
    const std::size_t first = span * count / std::min(kSpans, count),
                      end = (span + 1) * count / std::min(kSpans, count);
    std::size_t most = first;
    for (std::size_t i = first; i < end; ++i)
      if (std::abs(series.value[i]) > std::abs(series.value[most])) most = i;
    time.push_back(series.time[most]), value.push_back(series.value[most]);
  }
  return {{"time_s", time}, {"acceleration_m_per_s2", value}};
}

Json spectrum_of(const TimeSeries& acceleration) {
  constexpr double kDamping = 0.05, kLongest = 3.0;  // share of critical; longest period, s
  constexpr std::size_t kPeriods = 150;
  std::vector<double> periods = default_periods(kPeriods);
  std::erase_if(periods, [](double period) { return period > kLongest; });
  Json values = Json::array();
  for (const SpectralOrdinates& at : response_spectrum(acceleration, kDamping, periods))
    values.push_back(at.pseudo_acceleration);
  return {{"damping", kDamping}, {"period_s", periods}, {"pseudo_acceleration_m_per_s2", values}};
}

// duration: of the stage, s; what comes later is no part of the spectrum.
Json ground_of(const GroundMotion& ground, double duration) {
  Json json;
  for (const GroundMotion::Component& c : ground.components) {
    const RecordMeasures m = measure_record(c.acceleration);
    const Json of_component = {{"direction", c.direction},
                               {"end_velocity_m_per_s", end_velocity(c)},
                               {"pga_m_per_s2", m.pga},
                               {"pgv_m_per_s", m.pgv},
                               {"end_displacement_m", m.end_displacement}};
    if (json.empty()) json = of_component;
    json["components"].push_back(of_component);
    json["components"].back()["record"] = thinned(c.acceleration);
    try {
      const TimeSeries seen = c.acceleration.part(c.acceleration.time.front(), duration);
      json["components"].back()["spectrum"] = spectrum_of(seen);
    } catch (const Error&) {  // a record of one sample, or too short or long for these periods, has none
    }
  }
  json["notes"] = ground.notes;
  if (!ground.blocks.empty()) json["blocks"] = ground.blocks;
  for (const GroundMotion& support : ground.supports) json["supports"].push_back(ground_of(support, duration));
  return json;
}

Json settings_of(const Scene& scene, const RunInfo& info) {
  const SolverSettings& s = scene.solver;
  Json stages = Json::array();
  for (size_t i = 0; i < scene.stages.size(); ++i) {
    const Stage& stage = scene.stages[i];
    const SolverSettings& used = scene.solver_in(i);
    Json j = {{"name", stage.name},
              {"ramp_time_s", stage.ramp_time},
              {"damping", name_of(used.damping)},
              {"time_step_fraction", used.time_step_fraction}};
    for (const DampingNumber& n : damping_numbers(used)) {
      if (n.of_kind) std::visit([&](auto value) { j[n.key_in_summary] = value; }, n.value);
    }
    j["local_damping"] = local_damping_in(scene, i);  // settling or not
    if (stage.ground) j["ground_motion"] = ground_of(*stage.ground, stage.duration.value_or(HUGE_VAL));
    if (stage.solver) j["deformation_inertia"] = used.deformation_inertia, j["unit_inertia"] = used.unit_inertia;
    if (stage.equilibrium_ratio) j["equilibrium_ratio"] = *stage.equilibrium_ratio;
    if (stage.displacement) j["displacement_m"] = *stage.displacement;
    if (stage.duration) j["duration_s"] = *stage.duration;
    if (stage.cycles) {
      const Cycles& c = *stage.cycles;
      j["cycles"] = {{"amplitudes_m", c.amplitudes},
                     {"counts", c.counts},
                     {"velocity_m_per_s", c.velocity},
                     {"stop_at_force_loss", number_or_null(c.stop_at_force_loss)}};
    }
    Json controls = Json::array();
    for (const BodyControl& c : stage.controls) {
      Json velocity = Json::array();
      for (size_t k = 0; k < 3; ++k)
        velocity.push_back(c.kind[k] == DofKind::free ? Json("free") : Json(c.velocity[k]));
      controls.push_back({{"body", c.body}, {"velocity_m_per_s", velocity}, {"force_N", c.force}});
    }
    j["controls"] = controls;
    for (const PointForce& f : stage.forces)
      j["forces"].push_back({{"block", f.block}, {"point_m", f.point}, {"force_N", f.force}});
    if (stage.moving_load)
      j["moving_load"] = {{"from_m", stage.moving_load->from},
                          {"to_m", stage.moving_load->to},
                          {"force_N", stage.moving_load->force},
                          {"positions", stage.moving_load->positions}};
    j["curve"] = {{"kind", curve_kind(stage)},
                  {"along", axis_name(stage)},
                  {"of", watches_nothing(scene, stage) ? Json(nullptr) : Json(moved_part(scene, stage))}};
    if (stage.ground) j["curve"]["direction"] = response_axis(stage).direction;
    stages.push_back(j);
  }
  Json settings = {{"set", info.provenance.request.overrides},
                   {"time_step_fraction", s.time_step_fraction},
                   {"critical_time_step", s.critical_time_step == CriticalTimeStep::nodal ? "nodal" : "assembled"},
                   {"mass_scaling", s.mass_scaling},
                   {"selective_time_step_s", s.selective_time_step},
                   {"deformation_inertia", s.deformation_inertia},
                   {"unit_inertia", s.unit_inertia},
                   {"damping", name_of(s.damping)}};
  for (const DampingNumber& n : damping_numbers(s)) {
    std::visit([&](auto value) { settings[n.key_in_summary] = value; }, n.value);
  }
  settings["stages"] = std::move(stages);
  return settings;
}

Json of_ties(const members::Members& members, const std::vector<HistoryRow>& rows) {
  Json ties = Json::array();
  for (std::size_t i = 0; i < members.ties().size(); ++i) {
    const members::Tie& tie = members.ties()[i];
    double largest = tie.state.force;
    for (const HistoryRow& row : rows) largest = std::max(largest, row.added[i]);
    ties.push_back({{"name", tie.name},
                    {"force_N", tie.state.force},
                    {"largest_force_N", largest},
                    {"yield_force_N", tie.law.yield},
                    {"plastic_elongation_m", tie.state.plastic},
                    {"broken", tie.state.broken != 0}});
  }
  return ties;
}

Json of_floors(const members::Members& members) {
  Json floors = Json::array();
  for (const members::Floor& floor : members.floors()) {
    floors.push_back({{"name", floor.name()},
                      {"shear_N_per_m", floor.largest_shear()},
                      {"plastic_shear", floor.plastic_shear()},
                      {"anchor_N_per_m", floor.largest_anchor()},
                      {"pulled_out_m", floor.pulled_out_length()},
                      {"connectors", floor.connectors().size()},
                      {"drawn_m", floor.largest_drawn()},
                      {"slid_m", floor.largest_slid()}});
  }
  return floors;
}

Json of_beams(const members::Members& members) {
  Json beams = Json::array();
  for (const members::Beam& beam : members.beams()) {
    beams.push_back({{"name", beam.name()},
                     {"force_N", beam.largest_force()},
                     {"moment_Nm", beam.largest_moment()},
                     {"hinge_rad", beam.largest_hinge()}});
  }
  return beams;
}

double largest_displacement(const std::vector<HistoryRow>& rows) {
  return rows.empty() ? 0.0 : rows.back().largest_displacement;
}

Json of_dowels(const members::Members& members) {
  Json dowels = Json::array();
  for (const members::Dowel& dowel : members.dowels()) {
    dowels.push_back({{"name", dowel.name},
                      {"force_N", dowel.state.force},
                      {"shear_N", norm(dowel.state.shear)},
                      {"plastic_elongation_m", dowel.state.drawn},
                      {"plastic_slip_m", norm(dowel.state.slid)}});
  }
  return dowels;
}

Json of_fills(const members::Members& members) {
  Json fills = Json::array();
  for (const members::Fill& fill : members.fills())
    fills.push_back({{"name", fill.name}, {"area_m2", fill.area}, {"force_N", geometry::array(fill.force())}});
  return fills;
}

Json of_strips(const members::Members& members) {
  Json strips = Json::array();
  for (const members::Strip& strip : members.strips())
    strips.push_back(
        {{"name", strip.name()}, {"force_N", strip.largest_force()}, {"debonded_m", strip.debonded_length()}});
  return strips;
}

// Keys of blocks of any shape alone.
Json of_blocks(const Simulation& simulation, const std::vector<HistoryRow>& rows) {
  const auto or_null = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
  const blocks::Model& m = *simulation.large_motion();
  Json json;
  json["collapse_multiplier"] = or_null(simulation.outcome().collapse_multiplier);
  json["collapse_lag"] = or_null(collapse_lag(simulation.scene(), simulation.outcome().collapse_multiplier));
  json["base_slip_at_uplift_m"] = or_null(simulation.outcome().base_slip_at_uplift);
  json["largest_displacement_m"] = largest_displacement(rows);
  json["small_displacement"] = m.is_small;
  json["contact_detections"] = m.detection.count;
  if (const members::Members* const held = m.held_by.members.get())
    json["ties"] = of_ties(*held, rows), json["floors"] = of_floors(*held), json["beams"] = of_beams(*held),
    json["strips"] = of_strips(*held), json["dowels"] = of_dowels(*held), json["fills"] = of_fills(*held);
  return json;
}

// Energies at the end, and what was dissipated in the whole run; without them null.
Json energies_of(const std::vector<HistoryRow>& rows, const Scene& scene, bool on_ground) {
  if (rows.empty() || !rows.back().energies) return nullptr;
  const Energies& e = *rows.back().energies;
  const auto damping_share = [](double damping, double joints) {
    return damping + joints > 0.0 ? Json(damping / (damping + joints)) : Json(nullptr);
  };
  Json json = {{"kinetic", e.kinetic},
               {"strain", e.strain},
               {"contact_stored", e.contact_stored},
               {"dissipated", e.dissipated_total()},
               {"damping", e.damping},
               {"damping_share", damping_share(e.damping, e.dissipated_total())},
               {"external", e.external},
               {"detection", e.detection},
               {"members_stored", e.members_stored},
               {"members_dissipated", e.members_dissipated},
               {"balance_error", e.balance_error()}};
  if (on_ground) {
    const DissipatedEnergy taken = dissipated_in_earthquake(rows, scene);
    json["damping_share_in_earthquake"] = damping_share(taken.damping, taken.joints);
  }
  return json;
}

// Keys of blocks of any shape, and of bricks under ground motion.
Json of_motion(const Simulation& simulation, const std::vector<HistoryRow>& rows) {
  Json json;
  json["largest_displacement_m"] = largest_displacement(rows);
  if (const double in_use = simulation.time_step_report().impacts.in_use; in_use > 0.0) {
    json["impact_damping_in_use"] = in_use;
    json["landing_restitution"] = landing_restitution(in_use);
  }
  return json;
}

// Names of blocks, by number.
Json block_names(const Simulation& simulation) {
  constexpr std::size_t kMost = 5000;  // largest number: more would dominate the file
  Json names = Json::object();
  const auto add = [&](const auto& blocks, const auto& name) {
    for (std::size_t i = 0; i < blocks.size() && names.size() < kMost; ++i) {
      if (!name(blocks[i]).empty()) names[std::to_string(i)] = name(blocks[i]);
    }
  };
  if (simulation.large_motion())
    add(simulation.large_motion()->assembly.blocks, [](const auto& block) { return block.name; });
  else
    add(simulation.assembly().bricks, [](const Brick& brick) { return brick.name.empty() ? brick.body : brick.name; });
  return names;
}

Json motion_of(const Simulation& simulation) {
  const MotionSeen& seen = motion_seen(simulation);
  const SolverSettings& solver = simulation.scene().solver;
  const bool large = simulation.large_motion() && !simulation.large_motion()->is_small;
  const std::string past = past_motion_bound(simulation);
  Json promoted = nullptr;
  if (const auto& p = simulation.outcome().promotion) {
    promoted = {{"why", p->why},
                {"stage", p->stage + 1},  // as in history.csv
                {"step", p->step},
                {"time_s", p->time},
                {"strain_energy_J", p->strain_energy},
                {"energy_jump_J", p->energy_jump}};
  }
  return {{"large_motion", solver.large_motion == LargeMotion::always  ? "always"
                           : solver.large_motion == LargeMotion::never ? "never"
                                                                       : "automatic"},
          {"small_displacements", !large},
          {"largest_rotation_rad", seen.rotation},
          {"largest_sliding_over_length", simulation.large_motion() ? Json(nullptr) : Json(seen.sliding)},
          {"largest_opening_over_side", simulation.large_motion() ? Json(nullptr) : Json(seen.opening)},
          {"largest_sway_over_extent", simulation.large_motion() ? Json(nullptr) : Json(seen.sway)},
          {"largest_translation_over_model", simulation.large_motion() ? Json(nullptr) : Json(seen.translation)},
          {"rotation_bound_rad", solver.motion_bound.rotation},
          {"sliding_bound", solver.motion_bound.sliding},
          {"within_bound", large ? Json(nullptr) : Json(past.empty())},
          {"exceeded", text_or_null(past)},
          {"promoted", promoted}};
}

// Findings of the checks at rows of the history. The other assumptions are under motion and quasi_static.
Json watch_json(const Simulation& simulation) {
  const Watch& w = watch_of(simulation);
  const bool balanced = w.energy_moved > 0.0;
  return {{"energy_missing_over_moved", balanced ? Json(w.energy_missing / w.energy_moved) : Json(nullptr)},
          {"energy_missing_allowed", Watch::kAllowedMissing},
          {"energy_of_all_steps", simulation.scene().output.energy},
          {"largest_overlap_m", w.overlap},
          {"overlap_allowed_m", allowed_overlap(simulation)},
          {"largest_overlap_at_m", w.overlap_at},
          {"crushed_out", w.crushed_out},
          {"stiffness_over_bound", w.stiffness_ratio > 0.0 ? Json(w.stiffness_ratio) : Json(nullptr)}};
}

Json ranks_of(const std::vector<RankTraffic>& ranks) {
  Json each = Json::array();
  for (const RankTraffic& r : ranks) {
    const double steps = std::max(1.0, r.steps);
    each.push_back({{"blocks", r.blocks},
                    {"contact_points", r.points},
                    {"contact_points_on_borders", r.shared_points},
                    {"bytes_a_step", r.halo_bytes / steps},
                    {"messages_a_step", r.halo_messages / steps},
                    {"peak_memory_bytes", r.peak_memory},
                    {"own_work_s", r.own_seconds},
                    {"waiting_s", r.waiting_seconds},
                    {"gathering_s", r.gathering_seconds},
                    {"stepping_s", r.step_seconds}});
  }
  const RankTraffic& first = ranks.front();
  return {{"count", ranks.size()},
          {"steps", first.steps},
          {"gathers", first.gathers},
          {"gathered_bytes", first.gathered_bytes},
          {"divided_anew", first.repartitions},
          {"most_over_mean_before", first.repartitions > 0.0 ? Json(first.uneven_before) : Json(nullptr)},
          {"most_over_mean", first.uneven > 0.0 ? Json(first.uneven) : Json(nullptr)},
          {"by_rank", each}};
}

}  // namespace

bool laws_answer(const Simulation& simulation) {
  const auto& families = simulation.model().families;
  return std::all_of(families.begin(), families.end(),
                     [](const ContactFamily& f) { return f.material->fault().empty(); });
}

std::string overdue_text(const Simulation& simulation, const Material& material, const quoin_batch& batch,
                         double seconds) {
  return fmt::format(
      "the law '{}' of {} has not returned from a batch within {:g} s: {}; step {}. Tell its author, choose another "
      "law, "
      "or give it more time with ",
      material.api().id, material.law().library->path(), seconds, batch_text(simulation, batch), simulation.step());
}

std::string law_names(const Assembly& assembly) {
  std::set<std::string> names;
  std::string each;
  for (const JointFamily& family : assembly.families) {
    names.insert(family.law);
    each += (each.empty() ? "" : ", ") + family.name + ": " + family.law;
  }
  return names.size() == 1 ? *names.begin() : each;
}

std::string modes_text(const StageModes& modes) {
  if (!modes.why_none.empty()) return "damping of the first modes not computed: " + modes.why_none;
  std::string text = "damping of the first modes:";
  for (const StageModes::Mode& mode : modes.modes)
    text += fmt::format("{} {:.3g} Hz {:.2g} %", &mode == modes.modes.data() ? "" : ",", mode.frequency,
                        100.0 * mode.ratio);
  return text;
}

std::string why_error_unknown(const Scene& scene, const RunInfo& info) {
  if (info.status != "done") return "the run did not reach its end";
  const std::string outside = outside_measured(scene);
  return outside.empty() ? info.quasi_static.reason() : outside;
}

void write_summary(const std::filesystem::path& path, const Simulation& simulation, const std::vector<HistoryRow>& rows,
                   const RunInfo& info) {
  write_file(path, summary_text(simulation, rows, info));
}

namespace {

// Adds numbers of blocks, beams, zones and contact points.
void add_counts(const Simulation& simulation, bool law_answers, Json* json) {
  const auto count_beams = [](const auto& blocks) {
    return std::count_if(blocks.begin(), blocks.end(), [](const auto& b) { return b.beam; });
  };
  const blocks::Model* const large_motion = simulation.large_motion();
  const auto beams =
      large_motion ? count_beams(large_motion->assembly.blocks) : count_beams(simulation.assembly().bricks);
  (*json)["blocks"] = simulation.block_count() - beams;
  (*json)["beams"] = beams;
  (*json)["block_names"] = block_names(simulation);
  (*json)["symmetry_factor"] = simulation.assembly().symmetry_factor;
  (*json)["zones"] = simulation.zone_count();
  (*json)["contact_points"] = simulation.point_count();
  Json& states = (*json)["contact_points_by_state"];
  const auto counts = law_answers ? condition_counts(simulation) : std::array<long, kConditionCount>{};
  for (const Condition c : {Condition::elastic, Condition::softening, Condition::open, Condition::slipping,
                            Condition::crushing, Condition::crushed_out})
    states[condition_name(c)] = law_answers ? Json(counts[static_cast<size_t>(c)]) : Json(nullptr);
}

Json quality_of(const Scene& scene, const RunInfo& info) {
  const std::string unknown = why_error_unknown(scene, info);
  Json errors = nullptr;
  if (unknown.empty()) {
    const Quality& quality = quality_named(scene.quality);
    errors = {{"peak", quality.peak_error}, {"curve", quality.curve_error}, {"work", quality.work_error}};
  }
  return {{"name", scene.quality},
          {"as_is", scene.quality_as_is},
          {"expected_error", errors},
          {"why_unknown", text_or_null(unknown)}};
}

Json quasi_static_of(const QuasiStatic& check) {
  return {{"dynamic_force_over_peak", number_or_null(check.dynamic_force_ratio)},
          {"dynamic_force_at_peak", number_or_null(check.dynamic_force_at_peak)},
          {"kinetic_energy_over_work", number_or_null(check.kinetic_energy_ratio)},
          {"displacement_beyond_asked", check.overshoot_ratio},
          {"holds", check.quasi_static()},
          {"why_not", text_or_null(check.reason())}};
}

Json force_losses_of(const Simulation& simulation) {
  Json stops = Json::array();
  for (const StopAtForceLoss& stop : simulation.outcome().force_losses)
    stops.push_back({{"stage", simulation.scene().stages[static_cast<size_t>(stop.stage)].name},
                     {"half_cycle", stop.half_cycle + 1},
                     {"force_N", stop.force},
                     {"largest_force_before_N", stop.largest}});
  return stops;
}

Json damping_of(const StageModes& of_stage) {
  Json modes = nullptr;
  if (of_stage.why_none.empty()) modes = Json::array();
  for (const StageModes::Mode& mode : of_stage.modes)
    modes.push_back({{"frequency_Hz", mode.frequency}, {"damping_ratio", mode.ratio}});
  return modes;
}

Json list_of(const std::vector<Warning>& warnings, const Scene& scene) {
  Json list = Json::array();
  for (const Warning& w : warnings)
    list.push_back({{"about", w.about},
                    {"text", w.text},
                    {"stage", scene.stages.empty() ? "" : scene.stages[static_cast<size_t>(w.stage)].name},
                    {"step", w.step},
                    {"time_s", w.time}});
  return list;
}

Json response_json(const std::vector<HistoryRow>& rows, const Scene& scene) {
  const std::optional<GroundResponse> response = find_ground_response(rows, scene);
  if (!response) return nullptr;
  return {{"of", response->of},
          {"axis", response->axis.name},
          {"displacement_m", response->displacement},
          {"displacement_at_s", response->moved_at},
          {"base_force_N", response->base_force},
          {"base_force_at_s", response->sheared_at}};
}

}  // namespace

std::string summary_text(const Simulation& simulation, const std::vector<HistoryRow>& rows, const RunInfo& info) {
  const Scene& scene = simulation.scene();
  const TimeStepReport& step = simulation.time_step_report();
  const Peak peak = find_peak(rows, scene);
  const double area = bed_area(scene);

  Json json;
  json["version"] = QUOIN_VERSION;
  json["scene"] = scene.file;
  json["title"] = scene.title;
  json["law"] = law_names(simulation.assembly());
  json["status"] = info.status;
  json["interrupted"] = info.status == "interrupted";
  if (!info.message.empty()) json["message"] = info.message;
  const auto of_peak = [&](bool has_it, double value) { return has_it && peak.row >= 0 ? Json(value) : Json(nullptr); };
  json["peak_horizontal_force_N"] = of_peak(!is_vertical(scene), peak.force);
  json["peak_vertical_force_N"] = of_peak(is_vertical(scene), peak.force);
  json["displacement_at_peak_m"] = of_peak(true, peak.displacement);
  json["peak_of"] = peak.row >= 0 ? Json(moved_part(scene, stage_of_curve(scene))) : Json(nullptr);
  json["response"] = response_json(rows, scene);
  json["vertical_stress_at_peak_Pa"] = of_peak(area > 0, peak.vertical_force / area);
  json["bed_area_m2"] = area;
  json["steps"] = simulation.step();
  json["simulated_time_s"] = simulation.time();
  json["time_step_s"] = step.time_step;
  json["critical_time_step_s"] = step.critical.value;
  json["model_mass_kg"] = step.model_mass;
  json["added_mass_kg"] = step.added_mass;
  json["wall_clock_s"] = info.wall_clock_s;
  json["threads"] = simulation.thread_count();
  if (!rank_traffic(simulation).empty()) json["ranks"] = ranks_of(rank_traffic(simulation));
  json["instruction_set"] = kernel_instruction_set();
  add_counts(simulation, info.law_answers, &json);
  json["overlap_of_crushed_out_m"] = info.crushed_out.overlap;
  json["laws"] = laws_of(simulation);
  json["quality"] = quality_of(scene, info);
  if (std::any_of(scene.stages.begin(), scene.stages.end(), [](const Stage& s) { return s.cycles.has_value(); }))
    json["stopped_at_force_loss"] = force_losses_of(simulation);
  json["quasi_static"] = quasi_static_of(info.quasi_static);
  json["motion"] = motion_of(simulation);
  const bool on_ground =
      std::any_of(scene.stages.begin(), scene.stages.end(), [](const Stage& s) { return s.ground.has_value(); });
  if (simulation.large_motion()) json.update(of_blocks(simulation, rows));
  if (simulation.large_motion() || on_ground) json.update(of_motion(simulation, rows));
  if (const Json energies = energies_of(rows, scene, on_ground); !energies.is_null()) json["energy_J"] = energies;
  for (const StageModes& of_stage : info.modes)
    json["damping_of_modes"][scene.stages[static_cast<size_t>(of_stage.stage)].name] = damping_of(of_stage);
  json["watch"] = watch_json(simulation);
  json["warnings"] = list_of(info.warnings, scene);
  json["set"] = info.provenance.request.overrides;
  json["settings"] = settings_of(scene, info);
  json["provenance"] = to_json(info.provenance);
  return json_text(json);
}

}  // namespace quoin
