// Restores a simulation from the bytes of save(). Throws where they are of another model, or were changed.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "base/archive.h"
#include "model/contact_frames.h"
#include "step/actions/actions.h"
#include "step/controls.h"
#include "step/large_motion_run.h"
#include "step/law_swap.h"
#include "step/monitor.h"
#include "step/promotion.h"
#include "step/rank_part.h"
#include "step/saved_state.h"
#include "step/set_up.h"
#include "step/stages.h"
#include "step/work_division.h"

namespace quoin {

namespace {

Error of_another_model() { return {Exit::bad_input, "checkpoint: of another model"}; }

// Material of a joint family in a stage: that of the scene, or of the last law swap up to the stage.
std::shared_ptr<const Material> material_in_stage(const Simulation::Impl& s, std::size_t family, int of_stage) {
  std::shared_ptr<const Material> material = s.laws.first[family];
  for (int i = 0; i <= of_stage; ++i) {
    const auto& swapped = s.scene.stages[at(i)].law_swaps;
    if (const auto found = swapped.find(s.model.families[family].name); found != swapped.end())
      material = successor(s.model.assembly.families[family], found->second);
  }
  return material;
}

// Reads the law swaps of stages. Laws are loaded as code: a checkpoint may name only files that are in use already. It
// may hold fewer stages than the scene; later ones keep their swaps.
void read_law_swaps(ArchiveReader& reader, std::vector<Stage>& stages) {
  std::set<std::string> known;
  for (const Stage& stage : stages) {
    for (const auto& [family, law] : stage.law_swaps) known.insert(law);
  }
  std::uint64_t written = 0;
  reader.value(written);
  if (written > stages.size()) throw Error(Exit::bad_input, "checkpoint: of a scene with more stages");
  for (std::size_t s = 0; s < written; ++s) {
    Stage& stage = stages[s];
    std::uint64_t count = 0;
    reader.value(count);
    stage.law_swaps.clear();
    for (std::uint64_t i = 0; i < count; ++i) {
      std::string family, law;
      reader.array(family), reader.array(law);
      if (law.find('/') != std::string::npos && !known.contains(law))
        throw Error(
            Exit::bad_input,
            fmt::format("checkpoint: joint family '{}' has been given the law {}, a file that the scene does not "
                        "name; swap it in before",
                        family, law));
      stage.law_swaps[family] = law;
    }
  }
}

// Reads the rows that this rank holds of arrays by gridpoint and contact point.
struct PartsReader : ArchiveReader {
  Simulation::Impl& s;
  const RowsElsewhere elsewhere;
  void part_of(const Field& field, LaneVector<double>& x, int family) {
    x.resize(count_of(sizeof(double)));
    std::size_t done = 0;
    each_row_elsewhere(s, elsewhere, field.owner, family, x.size(), [&](std::size_t first, std::size_t end) {
      if (end > x.size()) throw of_another_model();
      take(x.data() + done, (first - done) * sizeof(double));
      source.skip((end - first) * sizeof(double));
      done = end;
    });
    take(x.data() + done, (x.size() - done) * sizeof(double));
  }
};

// Sets the law of a joint family in the stage of the checkpoint.
void take_law_of(std::size_t f, Simulation::Impl& s, ArchiveReader& reader) {
  ContactFamily& family = s.model.families[f];
  family.material = material_in_stage(s, f, s.progress.stage);
  if (s.large_motion) s.large_motion->take_law(static_cast<int>(f), family.material);
  const quoin_law& api = family.material->api();
  s.lattice.law_state[f].resize(api.state_count * at(family.point_count));
  std::string law;
  std::uint64_t schema = 0;
  reader.array(law);
  reader.value(schema);
  if (law == api.id && schema == api.state_schema) return;
  throw Error(Exit::bad_input,
              fmt::format("checkpoint: joint family '{}' has states of law '{}' (schema {:#x}); here it has law "
                          "'{}' (schema {:#x})",
                          family.name, law, schema, api.id, api.state_schema));
}

// Whether counters are in the range of any run: larger ones are of a changed file, and no run reaches them.
bool counts_are_sound(const Simulation::Impl& s) {
  constexpr long kMost = 1L << 53;
  const auto is_count = [](long value, long least) { return value >= least && value <= kMost; };
  return is_count(s.progress.step, 0) && is_count(s.progress.stage_step, 0) && is_count(s.progress.next_row, 0) &&
         is_count(s.progress.row_interval, 1) && is_count(s.progress.next_frame, 0) &&
         std::isfinite(s.progress.clock_start) && s.progress.clock_start_step >= 0 &&
         s.progress.clock_start_step <= s.progress.step;
}

void require_sound_controls(const Simulation::Impl& s) {
  const bool has_cycles = s.progress.stage >= 0 && current_stage(s).cycles;
  for (const Drive& drive : s.actions.drives) {
    if (drive.block < 0 || drive.block >= block_count(s) || drive.of_ground > kOfGround || drive.motion < 0 ||
        (drive.in_cycles != 0 && !has_cycles) ||
        (!s.large_motion && s.model.place[at(drive.block)].body < 0 && !s.controls.loaded(drive.block)))
      throw of_another_model();
  }
}

// Changes to the kind of motion of the saved run: lattice or large motion.
void take_kind_of_motion(Simulation::Impl& s, ArchiveReader& reader) {
  bool promoted = false;
  reader.value(promoted);
  if (promoted) {
    Promotion promotion;
    transfer_promotion(reader, promotion);
    if (!s.large_motion) leave_lattice(s);
    s.outcome.promotion = promotion;
  } else if (s.outcome.promotion) {
    return_to_lattice(s);
    s.outcome.promotion.reset();
  }
}

// Chooses the time step of the lattice again where stages have settings of their own, or laws of other stiffness.
void take_time_step(Simulation::Impl& s) {
  if (s.large_motion) return;
  bool changes = std::ranges::any_of(s.scene.stages, [](const Stage& stage) { return stage.solver.has_value(); });
  for (std::size_t f = 0; f < s.model.families.size(); ++f) {
    ContactFamily& family = s.model.families[f];
    const std::array before{family.normal_stiffness, family.shear_stiffness};
    family.normal_stiffness = family.shear_stiffness = 0.0;
    for (int stage = -1; stage <= s.progress.stage; ++stage) take_stiffness(s, f, *material_in_stage(s, f, stage));
    changes |= before != std::array{family.normal_stiffness, family.shear_stiffness};
  }
  if (changes) follow_solver(s);
}

void require_same_time_step(const Simulation::Impl& s, ArchiveReader& reader) {
  double dt = 0.0;
  reader.value(dt);
  if (const double here = s.large_motion ? 0.0 : s.data.time_step; dt != here)
    throw Error(Exit::bad_input,
                fmt::format("checkpoint: time step {:.17g} s, here {:.17g} s: another model, other solver settings, or "
                            "a stage with another whiffletree, whose stiffness counts from the start",
                            dt, here));
}

// Sizes that depend on the model alone.
std::vector<std::size_t> sizes_of(const Simulation::Impl& s) {
  std::vector<std::size_t> sizes;
  each_lattice_field(s.lattice, [&](const Field& field, const auto& array, int) {
    if (field.saved && field.when == When::always) sizes.push_back(array.size());
  });
  return sizes;
}

void take_state(Simulation::Impl& s, ArchiveReader& reader) {
  const std::vector<std::size_t> expected = sizes_of(s);
  require_same_time_step(s, reader);
  if (s.parts.divided && !s.large_motion) {
    PartsReader of_rank{{reader.source}, s, rows_elsewhere(s, held_with(s, s.division.share))};
    transfer_state(of_rank, s);
  } else {
    transfer_state(reader, s);
  }
  const LatticeState& lattice = s.lattice;
  const std::size_t damped = !s.time_step.damps_joints() || s.large_motion ? 0 : at(s.model.point_count);
  const auto has_columns = [damped](const auto& column) { return column.size() == damped; };
  if (sizes_of(s) != expected || !has_columns(lattice.old_jump) ||
      !std::all_of(std::begin(lattice.viscous), std::end(lattice.viscous), has_columns) ||
      (!lattice.normal_shift.empty() && lattice.normal_shift.size() != at(s.model.point_count)))
    throw of_another_model();
}

void take_large_motion(Simulation::Impl& s, ArchiveReader& reader) {
  const auto is_block = [&](int i) { return i >= 0 && i < s.large_motion->block_count(); };
  if (!s.energy.wanted) s.large_motion->book_energy(s.watch.pending);
  s.large_motion->solver = solver_in_use(s);
  const double springs = s.large_motion->stepping.springs;
  s.large_motion->restore(reader);
  if (!std::ranges::all_of(s.monitor.blocks, is_block)) throw of_another_model();
  s.large_motion->hold_by_springs(springs);  // another scene may go on from the state with a whiffletree of its own
  follow_time_step(s);
  partition_work(s);
}

// Binds data that follow from the state.
void bind_restored(Simulation::Impl& s) {
  if (!s.large_motion) {
    s.monitor.blocks.clear();
    if (s.progress.stage >= 0) watch_blocks(s, current_stage(s));
  }
  bind_floors(s);
  choose_damping(s);
  s.controls.settled = s.progress.stage < 0;
  bind_controls(s);
  s.lattice.flags_step = -1;
  s.energy.now.reset();
  s.laws.swaps.clear();
  bind_columns(s);
  if (s.ranks) partition_work(s);
}

// An Error leaves the simulation restored in part.
void restore_state(Simulation::Impl& s, ByteSource& source) {
  char mark[sizeof kCheckpointMark] = {};
  if (source.left() >= sizeof mark) source.take(mark, sizeof mark);
  if (std::memcmp(mark, kCheckpointMark, sizeof mark) != 0)
    throw Error(Exit::bad_input, "checkpoint: not a checkpoint of this version");
  ArchiveReader reader{source};
  reader.value(s.progress.stage);
  if (s.progress.stage < -1 || s.progress.stage >= static_cast<int>(s.scene.stages.size())) throw of_another_model();
  read_law_swaps(reader, s.scene.stages);
  take_kind_of_motion(s, reader);
  for (std::size_t f = 0; f < s.model.families.size(); ++f) take_law_of(f, s, reader);
  take_time_step(s);
  take_state(s, reader);
  require_sound_controls(s);  // before the drives are followed
  if (s.large_motion) take_large_motion(s, reader);
  if (reader.left() != 0 || !counts_are_sound(s)) throw of_another_model();
  bind_restored(s);
}

}  // namespace

void blocks::Model::restore(ArchiveReader& reader) {
  const std::size_t body_count = bodies.size(), node_count = nodes.x.size();
  transfer_blocks(reader, *this);
  settle(is_settling);
  const auto require = [](bool fits) {
    if (!fits) throw of_another_model();
  };
  const auto require_items = [&](const Field& field, size_t count, size_t items) {
    const bool wanted = field.when == When::always ||
                        (field.when == When::with_stiffness_damping && damping.of_contacts()) ||
                        (field.when == When::with_maxwell && damping.has_maxwell()) ||
                        (field.when == When::with_energies && books_energy);
    require(count == items || (!wanted && count == 0));
  };
  WorldFields::of_blocks(*this, [&](const Field& field, const auto& array) {
    require_items(
        field, array.size(),
        field.owner == Owner::gridpoint ? node_count : (field.owner == Owner::body ? body_count : blocks.size()));
  });
  WorldFields::of_pairs(
      *this, [&](const Field& field, const auto& array) { require_items(field, array.size(), contacts.list.size()); });
  require(start_joints.kept.empty() || start_joints.kept.size() == start_joints.point.size() * kept_width(*this));
  require(impacts.landing.size() == (damping.impacts ? contacts.families.size() * blocks.size() : 0));
  require(actions.loaded.size() == blocks.size() &&
          (actions.applied.empty() || actions.applied.size() == blocks.size()));
  const auto is_block = [&](int i) { return i >= 0 && size_t(i) < blocks.size(); };
  const auto is_facet = [&](int i, int block) {
    return blocks[size_t(block)].body >= 0 ? i < 0 : i >= 0 && size_t(i) < contacts.facets.size();
  };
  for (Family& f : contacts.families) {
    WorldFields::of_points(
        [&](const Field& field, const auto& column) { require_items(field, column.size(), f.size()); }, f);
    for (const Point& p : f.point)
      require(is_block(p.a) && is_block(p.b) && is_facet(p.facet_a, p.a) && is_facet(p.facet_b, p.b));
  }
  for (const Contact& c : contacts.list) {
    const bool fits = is_block(c.pair.a) && is_block(c.pair.b) && c.family < int(contacts.families.size()) &&
                      (c.family < 0 ? c.count == 0
                                    : size_t(c.first) + c.count <= contacts.families[size_t(c.family)].size() &&
                                          c.first_facet + size_t(c.count) * size_t(facets_a_point(*this, c)) <=
                                              contacts.facets.size());
    require(fits);
  }
  for (const PairCheck& check : checks.pair) require(is_block(check.a) && is_block(check.b));
  for (const AssumedMotion& motion : checks.assumed) require(motion.step >= 0 && motion.step <= stepping.count);
  for (int i = 0; i < block_count(); ++i) {
    const int other = units.other_half[size_t(i)];
    require(units.apart[size_t(i)] == (other < 0 ? 0 : units.apart[size_t(other)]));
  }
  frames.are_old = pieces.velocities_lag = false;
  pieces.are_old = pieces.motion_is_old = true;
  divide_work(*this);
}

void Simulation::restore(ByteSource& source) { restore_state(*impl_, source); }

void Simulation::restore(const std::vector<std::uint8_t>& bytes) {
  BytesInMemory source(bytes);
  if (impl_->parts.divided) return restore_state(*impl_, source);  // ranks that hold parts cannot undo
  const std::vector<std::uint8_t> undo = save();
  const std::vector<Stage> stages = impl_->scene.stages;
  try {
    restore_state(*impl_, source);
  } catch (...) {
    impl_->scene.stages = stages;
    BytesInMemory before(undo);
    restore_state(*impl_, before);
    throw;
  }
}

}  // namespace quoin
