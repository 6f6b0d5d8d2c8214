// Everything of a simulation that changes during a run, as bytes.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "base/archive.h"
#include "step/lattice_fields.h"
#include "step/law_swap.h"

namespace quoin {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Error of_another_model() { return {Exit::bad_input, "checkpoint: of another model"}; }

constexpr char kCheckpointMark[8] = {'Q', 'U', 'O', 'I', 'N', 'C', '1', '6'};

template <class Archive, class Impl>
void transfer(Archive& archive, Impl& s) {
  each_lattice_field(s, [&](const Field& field, auto& array, int family) {
    if (!field.saved) return;
    if constexpr (requires { archive.part_of(field, array, family); })
      archive.part_of(field, array, family);
    else
      archive.array(array);
  });
  archive.array(s.ramps);
  archive.array(s.load_ramps);
  archive.value(s.gravity_from);
  archive.value(s.gravity_to);
  archive.value(s.data.gravity);
  archive.value(s.step_count);
  archive.value(s.clock_start);
  archive.value(s.clock_start_step);
  archive.value(s.stage_step);
  archive.value(s.stage_start_time);
  archive.value(s.monitor_start);
  archive.value(s.energy_dissipated);
  archive.value(s.energy_damping);
  archive.value(s.energy_external);
  archive.value(s.energy_inertia);
  archive.value(s.unbalanced_ratio);
  archive.value(s.kinetic);
  archive.value(s.calm_checks);
  archive.value(s.next_frame);
  archive.value(s.next_row);
  archive.value(s.row_interval);
  archive.value(s.in_stage);
  archive.value(s.motion_seen);
  archive.value(s.next_motion_check);
  archive.value(s.watch);
  archive.list(s.outcome.warnings, [](auto& a, auto& warning) {
    a.array(warning.about);
    a.array(warning.text);
    a.value(warning.stage);
    a.value(warning.step);
    a.value(warning.time);
  });
  archive.value(s.force_loss);
  archive.array(s.outcome.force_losses);
  if (!s.large_motion) return;
  archive.array(s.drives);
  archive.value(s.fading_loads);
  archive.value(s.fading_pressures);
  archive.value(s.multiplier);
  archive.value(s.first_load);
  archive.array(s.monitor_blocks);
  archive.value(s.monitor_stands_below);
  archive.value(s.outcome.collapse_multiplier);
  archive.value(s.outcome.base_slip_at_uplift);
}

template <class Archive, class Promotion>
void transfer_promotion(Archive& archive, Promotion& p) {
  archive.array(p.why);
  archive.value(p.stage);
  archive.value(p.step);
  archive.value(p.time);
  archive.value(p.strain_energy);
  archive.value(p.energy_jump);
}

// Laws that the stages swap in, the scene's and those of a controller, from joint family to law.
void write_law_swaps(ArchiveWriter& writer, const std::vector<Stage>& stages) {
  writer.value(std::uint64_t{stages.size()});
  for (const Stage& stage : stages) {
    writer.value(std::uint64_t{stage.law_swaps.size()});
    for (const auto& [family, law] : stage.law_swaps) writer.array(family), writer.array(law);
  }
}

// A checkpoint names no file that would be loaded as code, unless it was in use already. It may be of a run that had
// the first stages alone; later ones keep theirs.
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

}  // namespace

// The material that a joint family has in a stage: the scene's, or that of the last law swapped in until then.
std::shared_ptr<const Material> Simulation::Impl::material_in_stage(std::size_t family, int of_stage) const {
  std::shared_ptr<const Material> material = first_materials[family];
  for (int i = 0; i <= of_stage; ++i) {
    const auto& swapped = scene.stages[at(i)].law_swaps;
    if (const auto found = swapped.find(model.families[family].name); found != swapped.end())
      material = successor(model.assembly.families[family], found->second);
  }
  return material;
}

namespace {

// Counts what arrays by gridpoint and contact point would add.
struct CountingWriter : ArchiveWriter {
  std::size_t& more;
  using ArchiveWriter::array;
  void array(const LaneVector<double>& x) {
    value(std::uint64_t{x.size()});
    give(x.data(), x.size() * sizeof(double));
  }
  void give(const void*, std::size_t size) { more += size; }
};

// Hands everything on as it comes, arrays by gridpoint and contact point from all ranks.
struct PartsWriter : ArchiveWriter {
  Simulation::Impl& s;
  const Simulation::TakeBytes& take;
  using ArchiveWriter::array;
  void array(const LaneVector<double>& x) {
    value(std::uint64_t{x.size()});
    give(x.data(), x.size() * sizeof(double));
  }
  void give(const void* first, std::size_t size) {
    hand_on();
    s.give_array(first, size, take);
  }
  void hand_on() {
    if (s.ranks->rank() == 0) take(bytes);
    bytes.clear();
  }
};

void save(ArchiveWriter& writer, blocks::Model& large_motion) { large_motion.save(writer); }
template <class Writer>
void save(Writer& writer, blocks::Model& large_motion) {
  large_motion.save(writer, [&](ArchiveWriter&, const void* first, std::size_t bytes) { writer.give(first, bytes); });
}

// Takes of arrays by gridpoint and contact point what this rank holds.
struct PartsReader : ArchiveReader {
  Simulation::Impl& s;
  const Simulation::Impl::Rows elsewhere;
  void part_of(const Field& field, LaneVector<double>& x, int family) {
    x.resize(count_of(sizeof(double)));
    std::size_t done = 0;
    s.each_row_elsewhere(elsewhere, field.owner, family, x.size(), [&](std::size_t first, std::size_t end) {
      if (end > x.size()) throw of_another_model();
      take(x.data() + done, (first - done) * sizeof(double));
      source.skip((end - first) * sizeof(double));
      done = end;
    });
    take(x.data() + done, (x.size() - done) * sizeof(double));
  }
};

template <class Writer>
void write_state(Writer& writer, const Simulation::Impl& s) {
  writer.value(kCheckpointMark);
  writer.value(s.stage);
  write_law_swaps(writer, s.scene.stages);
  const std::optional<Promotion>& promotion = s.outcome.promotion;
  writer.value(promotion.has_value());
  if (promotion) transfer_promotion(writer, *promotion);
  for (const ContactFamily& family : s.model.families) {
    writer.array(std::string(family.material->api().id));
    writer.value(family.material->api().state_schema);
  }
  // The step of blocks of any shape follows their contacts: it is part of what they save.
  writer.value(s.large_motion ? 0.0 : s.data.time_step);
  transfer(writer, s);
  if (s.large_motion) save(writer, *s.large_motion);
}

}  // namespace

std::vector<std::uint8_t> Simulation::save() const {
  std::vector<std::uint8_t> bytes;
  ArchiveWriter writer{bytes};
  write_state(writer, *impl_);
  return bytes;
}

std::size_t Simulation::saved_bytes() const {
  std::vector<std::uint8_t> bytes;
  std::size_t more = 0;
  CountingWriter writer{{bytes}, more};
  write_state(writer, *impl_);
  return bytes.size() + more;
}

void Simulation::save(const TakeBytes& take) const {
  Impl& s = *impl_;
  if (!s.in_parts) {
    if (!s.ranks || s.ranks->rank() == 0) take(save());
    return;
  }
  s.gather(Part::row);
  std::vector<std::uint8_t> bytes;
  PartsWriter writer{{bytes}, s, take};
  write_state(writer, s);
  writer.hand_on();
}

void Simulation::Impl::give_array(const void* array, std::size_t whole, const Simulation::TakeBytes& take) {
  struct Stretch {
    std::size_t begin, end;  // bytes from the beginning of the array
    int rank;
  };
  std::vector<Stretch> stretches;
  const auto* const first = static_cast<const std::uint8_t*>(array);
  const auto note = [&](int rank, const void* memory, std::size_t bytes) {
    const auto* const from = static_cast<const std::uint8_t*>(memory);
    if (from < first || from >= first + whole) return;
    const auto begin = static_cast<std::size_t>(from - first);
    if (!stretches.empty() && stretches.back().rank == rank && stretches.back().end == begin)
      stretches.back().end += bytes;
    else
      stretches.push_back({begin, begin + bytes, rank});
  };
  const auto note_of = [&](int rank) {
    return [&note, rank](const void* memory, std::size_t bytes) { note(rank, memory, bytes); };
  };
  if (large_motion) large_motion->each_owned_memory(note);
  for (std::size_t i = 0; !large_motion && i < share.rank_of_item.size(); ++i)
    each_memory_of_item(Part::all, static_cast<int>(i), note_of(share.rank_of_item[i]));
  for (std::size_t c = 0; !large_motion && c < share.rank_of_chunk.size(); ++c)
    each_memory_of_chunk(Part::all, static_cast<int>(c), note_of(share.rank_of_chunk[c]));
  std::sort(stretches.begin(), stretches.end(), [](const Stretch& x, const Stretch& y) { return x.begin < y.begin; });

  const int here = ranks->rank();
  std::vector<std::size_t> sizes(at(ranks->count()));
  std::vector<std::uint8_t> own, all, piece;
  auto next = stretches.begin();
  for (std::size_t begin = 0; begin < whole; begin += kGatherBuffer) {
    const std::size_t end = std::min(begin + kGatherBuffer, whole);
    while (next != stretches.end() && next->end <= begin) ++next;
    const auto each_here = [&](const auto& visit) {
      for (auto i = next; i != stretches.end() && i->begin < end; ++i)
        visit(i->rank, std::max(i->begin, begin), std::min(i->end, end));
    };
    std::fill(sizes.begin(), sizes.end(), 0);
    own.clear();
    each_here([&](int rank, std::size_t from, std::size_t to) {
      sizes[at(rank)] += to - from;
      if (rank == here) own.insert(own.end(), first + from, first + to);
    });
    all.resize(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}));
    ranks->gather(std::as_bytes(std::span(own)), sizes, std::as_writable_bytes(std::span(all)));
    if (here != 0) continue;
    piece.assign(first + begin, first + end);
    std::vector<std::size_t> place(sizes.size());
    std::exclusive_scan(sizes.begin(), sizes.end(), place.begin(), std::size_t{0});
    each_here([&](int rank, std::size_t from, std::size_t to) {
      std::memcpy(piece.data() + (from - begin), all.data() + place[at(rank)], to - from);
      place[at(rank)] += to - from;
    });
    take(piece);
  }
}

void Simulation::restore(ByteSource& source) { impl_->restore(source); }

void Simulation::restore(const std::vector<std::uint8_t>& bytes) {
  BytesInMemory source(bytes);
  if (impl_->in_parts) return impl_->restore(source);  // a run that cannot ends
  const std::vector<std::uint8_t> undo = save();
  const std::vector<Stage> stages = impl_->scene.stages;
  try {
    impl_->restore(source);
  } catch (const Error&) {
    impl_->scene.stages = stages;
    BytesInMemory before(undo);
    impl_->restore(before);
    throw;
  }
}

namespace {

// The law that a joint family has in the stage that the checkpoint is of.
void take_law_of(std::size_t f, Simulation::Impl& s, ArchiveReader& reader) {
  ContactFamily& family = s.model.families[f];
  family.material = s.material_in_stage(f, s.stage);
  if (s.large_motion) s.large_motion->take_law(static_cast<int>(f), family.material);
  const quoin_law& api = family.material->api();
  s.law_state[f].resize(api.state_count * at(family.point_count));
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

// Counters that no run comes to were written by somebody, and would be counted up for ever.
bool counts_are_sound(const Simulation::Impl& s) {
  constexpr long kMost = 1L << 53;
  const auto is_count = [](long value, long least) { return value >= least && value <= kMost; };
  return is_count(s.step_count, 0) && is_count(s.stage_step, 0) && is_count(s.next_row, 0) &&
         is_count(s.row_interval, 1) && is_count(s.next_frame, 0);
}

}  // namespace

void Simulation::Impl::restore(ByteSource& source) {
  char mark[sizeof kCheckpointMark] = {};
  if (source.left() >= sizeof mark) source.take(mark, sizeof mark);
  if (std::memcmp(mark, kCheckpointMark, sizeof mark) != 0)
    throw Error(Exit::bad_input, "checkpoint: not a checkpoint of this version");
  ArchiveReader reader{source};
  reader.value(stage);
  if (stage < -1 || stage >= static_cast<int>(scene.stages.size())) throw of_another_model();
  read_law_swaps(reader, scene.stages);
  bool promoted = false;
  reader.value(promoted);
  if (promoted) {
    Promotion promotion;
    transfer_promotion(reader, promotion);
    if (!large_motion) leave_lattice();
    outcome.promotion = promotion;
  } else if (outcome.promotion) {
    return_to_lattice();
    outcome.promotion.reset();
  } else if (!large_motion && std::any_of(scene.stages.begin(), scene.stages.end(),
                                          [](const Stage& s) { return s.solver.has_value(); })) {
    follow_solver();
  }
  std::vector<std::size_t> expected{ramps.size(), load_ramps.size()};
  for (std::size_t f = 0; f < model.families.size(); ++f) take_law_of(f, *this, reader);
  const auto note_sizes = [&](std::vector<std::size_t>& sizes) {
    each_lattice_field(*this, [&](const Field& field, const auto& array, int) {
      if (field.saved && field.when == When::always) sizes.push_back(array.size());
    });
  };
  note_sizes(expected);
  double dt = 0.0;
  reader.value(dt);
  if (const double here = large_motion ? 0.0 : data.time_step; dt != here) {
    throw Error(Exit::bad_input,
                fmt::format("checkpoint: time step {:.17g} s, here {:.17g} s: another model or other solver settings",
                            dt, here));
  }
  if (in_parts && !large_motion) {
    PartsReader of_rank{{source}, *this, rows_elsewhere(held_with(share))};
    transfer(of_rank, *this);
  } else {
    transfer(reader, *this);
  }
  std::vector<std::size_t> sizes{ramps.size(), load_ramps.size()};
  note_sizes(sizes);
  const std::size_t damped = time_step.impacts.viscosity.empty() || large_motion ? 0 : at(model.point_count);
  const auto has_columns = [damped](const auto& column) { return column.size() == damped; };
  if (!std::all_of(std::begin(viscous), std::end(viscous), has_columns) || !has_columns(old_jump))
    throw of_another_model();
  if (sizes != expected || (!normal_shift.empty() && normal_shift.size() != at(model.point_count)))
    throw of_another_model();
  if (large_motion) {
    const auto is_block = [&](int i) { return i >= 0 && i < large_motion->block_count(); };
    if (!want_energy) large_motion->book_energy(watch.pending);
    large_motion->restore(reader);
    if (!std::all_of(monitor_blocks.begin(), monitor_blocks.end(), is_block)) throw of_another_model();
    for (const Drive& drive : drives) {
      if (!is_block(drive.block)) throw of_another_model();
    }
    follow_time_step();
    partition_work();
  }
  if (reader.left() != 0) throw of_another_model();
  if (!counts_are_sound(*this)) throw of_another_model();
  const bool in_cycles =
      std::any_of(ramps.begin(), ramps.end(), [](const BodyRamp& ramp) { return ramp.in_cycles != Vec3{}; }) ||
      std::any_of(drives.begin(), drives.end(), [](const Drive& drive) { return drive.in_cycles != 0; });
  const bool on_ground = std::all_of(ramps.begin(), ramps.end(), [&](const BodyRamp& ramp) {
    return ramp.of_ground <= 7 && ramp.motion >= 0 && ramp.motion <= std::numeric_limits<std::int32_t>::max();
  });
  if (!on_ground || !std::isfinite(clock_start) || clock_start_step < 0 || clock_start_step > step_count)
    throw of_another_model();
  if (in_cycles && (stage < 0 || !scene.stages[at(stage)].cycles)) throw of_another_model();

  if (!large_motion && stage >= 0)
    find_monitor(scene.stages[at(stage)]);
  else
    monitor.clear();
  bind_whiffletree();
  choose_damping();
  controls_settled = stage < 0;
  bind_controls();
  flags_step = -1;
  energies.reset();
  swaps.clear();
  bind_columns();
  if (ranks) partition_work();
}

}  // namespace quoin
