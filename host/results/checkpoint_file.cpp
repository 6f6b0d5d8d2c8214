#include "results/checkpoint_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <span>

#include "base/archive.h"
#include "base/attempt.h"
#include "base/error.h"
#include "base/fnv_hash.h"
#include "base/sha256.h"
#include "files/file.h"
#include "files/file_bytes.h"
#include "scene/actions/actions.h"
#include "scene/damping_text.h"
#include "scene/scatter_text.h"
#include "step/large_motion.h"

namespace quoin {

namespace {

// Head of the file, in this order. Its first words identify, on any machine, why another machine cannot read the rest.
struct Head {
  std::array<char, 8> mark{'Q', 'U', 'O', 'I', 'N', 'R', 'U', 'N'};
  std::uint32_t word_order = 0x01020304;
  std::uint32_t format = 8;
  std::array<std::uint8_t, 4> word_sizes{sizeof(int), sizeof(long), sizeof(void*), sizeof(double)};
  std::uint32_t unused = 0;
  std::uint64_t bytes = 0;     // size of the rest of the file
  std::uint64_t checksum = 0;  // checksum of the rest of the file
};
constexpr std::uint32_t kOtherWordOrder = 0x04030201;

// Checksum of eight bytes at a time, as checkpoints may be large.
class Checksum {
 public:
  void add(std::span<const std::uint8_t> bytes) {
    if (rest_ > 0) {
      const std::size_t more = std::min(sizeof word_ - rest_, bytes.size());
      take(bytes.first(more));
      bytes = bytes.subspan(more);
    }
    while (bytes.size() >= sizeof word_) {
      std::memcpy(&word_, bytes.data(), sizeof word_);
      add_word();
      bytes = bytes.subspan(sizeof word_);
    }
    if (!bytes.empty()) take(bytes);
  }
  std::uint64_t end() {
    if (rest_ > 0) add_word();
    return hash_.value();
  }

 private:
  // Adds less than a word, or the rest of an incomplete one.
  void take(std::span<const std::uint8_t> bytes) {
    std::memcpy(reinterpret_cast<std::uint8_t*>(&word_) + rest_, bytes.data(), bytes.size());
    rest_ += bytes.size();
    if (rest_ == sizeof word_) add_word();
  }
  void add_word() {
    hash_.add(word_);
    hash_.fold();
    word_ = 0, rest_ = 0;
  }

  FnvHash hash_;
  std::uint64_t word_ = 0;
  std::size_t rest_ = 0;  // bytes of an incomplete word
};

std::uint64_t checksum_of_rest(ByteSource& source) {
  constexpr std::size_t kPiece = std::size_t{1} << 20;  // bytes: the whole file may be as large as the model
  Checksum sum;
  std::vector<std::uint8_t> piece;
  while (source.left() > 0) {
    piece.resize(std::min(kPiece, source.left()));
    source.take(piece.data(), piece.size());
    sum.add(piece);
  }
  return sum.end();
}

template <class Archive, class Parts>
void transfer_identity(Archive& archive, Parts& parts) {
  archive.list(parts, [](auto& a, auto& part) {
    a.array(part.what);
    a.array(part.value);
  });
}

template <class Archive, class Results>
void transfer_results(Archive& archive, Results& results) {
  archive.list(results.rows, [](auto& a, auto& row) {
    using Numbers = std::conditional_t<std::is_const_v<std::remove_reference_t<decltype(row)>>, const HistoryNumbers,
                                       HistoryNumbers>;
    a.value(static_cast<Numbers&>(row));
    a.array(row.added);
  });
  archive.array(results.frame_times);
  archive.list(results.modes, [](auto& a, auto& of_stage) {
    a.value(of_stage.stage);
    a.array(of_stage.modes);
    a.array(of_stage.why_none);
  });
  archive.list(results.monitor_rows, [](auto& a, auto& row) { a.array(row); });
}

void add_series(const TimeSeries& series, Sha256& hash) {
  for (const auto* column : {&series.time, &series.value}) hash.add(column->data(), column->size() * sizeof(double));
}

void add_motion(const GroundMotion& ground, Sha256& hash) {
  for (const std::string& block : ground.blocks) hash.add_text(block);
  for (const GroundMotion::Component& c : ground.components) add_series(c.acceleration, hash);
  for (const GroundMotion& support : ground.supports) add_motion(support, hash);
}

}  // namespace

Identity identity_of(const Simulation& simulation, const Provenance& provenance) {
  const Scene& scene = simulation.scene();
  Identity identity;
  identity.parts.push_back({"version of quoin", provenance.program});
  identity.parts.push_back({"build of quoin", provenance.program_sha256});
  // Before the scene, whose hash has what laws answer at the start.
  for (const HashedFile& law : provenance.laws)
    identity.parts.push_back({fmt::format("library of the law '{}'", law.name), law.sha256});
  Sha256 hash;
  hash.add_text(provenance.scene_text);
  for (const std::string& text : provenance.request.overrides) hash.add_text(text);
  hash.add_text(provenance.request.law);
  for (std::size_t i = 0; i < std::min(scene.inputs.size(), provenance.inputs.size()); ++i)
    hash.add_text(provenance.inputs[i].sha256);
  for (const Stage& stage : scene.stages) {
    if (!stage.ground) continue;
    add_motion(*stage.ground, hash);
  }
  const std::uint64_t start = simulation.hash();
  const long points = simulation.point_count();
  hash.add(&start, sizeof start);
  hash.add(&points, sizeof points);
  identity.parts.push_back({"scene", hash.end()});
  return identity;
}

namespace {

// What precedes the state.
void write_results(ArchiveWriter writer, const Identity& identity, const ResultsSoFar& results,
                   std::uint64_t state_bytes) {
  transfer_identity(writer, identity.parts);
  transfer_results(writer, results);
  writer.value(state_bytes);
}

// give: passes the state on piece by piece. It is called even if the file fails, as other ranks wait for it.
void write_stored(const std::filesystem::path& path, const Identity& identity, const ResultsSoFar& results,
                  std::uint64_t state_bytes, const std::function<void(const Simulation::TakeBytes&)>& give) {
  Attempt unless_it_failed;
  std::unique_ptr<DurableFile> file;
  Head head;
  Checksum sum;
  const auto append = [&](std::span<const std::uint8_t> bytes) {
    file->append(bytes);
    sum.add(bytes);
    head.bytes += bytes.size();
  };
  const auto as_bytes = [](const Head& h) { return std::span(reinterpret_cast<const std::uint8_t*>(&h), sizeof h); };
  unless_it_failed([&] {
    std::vector<std::uint8_t> bytes;
    write_results({bytes}, identity, results, state_bytes);
    file = std::make_unique<DurableFile>(path);
    file->append(as_bytes(head));
    append(bytes);
  });
  give([&](std::span<const std::uint8_t> bytes) { unless_it_failed([&] { append(bytes); }); });
  unless_it_failed([&] {
    head.checksum = sum.end();
    file->finish(as_bytes(head));
  });
  unless_it_failed.rethrow();
}

}  // namespace

void write_checkpoint(const std::filesystem::path& path, const Identity& identity, const Checkpoint& checkpoint) {
  write_stored(path, identity, checkpoint.results, checkpoint.state.size(),
               [&](const Simulation::TakeBytes& take) { take(checkpoint.state); });
}

void write_checkpoint(const std::filesystem::path& path, const Identity& identity, const ResultsSoFar& results,
                      const Simulation& simulation) {
  write_stored(path, identity, results, simulation.saved_bytes(),
               [&](const Simulation::TakeBytes& take) { simulation.save(take); });
}

namespace {

struct Stored {
  Identity identity;
  Checkpoint checkpoint;  // its state is still in the file
};

// Reads what precedes the state, whose size it sets.
Stored read_results(ByteSource& source) {
  ArchiveReader reader{source};
  Stored stored;
  transfer_identity(reader, stored.identity.parts);
  transfer_results(reader, stored.checkpoint.results);
  stored.checkpoint.stored.bytes = reader.count_of(1);
  return stored;
}

using Fault = std::function<Error(const std::string& reason)>;

Head read_head(FileBytes& file, const Fault& fault) {
  Head head;
  const Head here;
  if (file.left() < sizeof head) throw fault("is no checkpoint of quoin, or is cut short");
  file.take(&head, sizeof head);
  if (head.mark != here.mark) throw fault("is no checkpoint of quoin");
  if (head.word_order == kOtherWordOrder)
    throw fault("was written on a machine of the other word order (little or big endian)");
  if (head.word_order != here.word_order || head.word_sizes != here.word_sizes)
    throw fault("was written on a machine with words of another size");
  if (head.format != here.format)
    throw fault(fmt::format("has version {} of the format of checkpoints; this program reads version {}", head.format,
                            here.format));
  if (head.bytes != file.left())
    throw fault(fmt::format("is damaged: it has {} bytes and says {}", file.left(), head.bytes));
  return head;
}

Stored read_stored(const std::filesystem::path& path, const Fault& fault) {
  FileBytes whole(path), file(path);
  const Head head = read_head(whole, fault);
  if (head.checksum != checksum_of_rest(whole)) throw fault("is damaged: its checksum does not fit");
  file.skip(sizeof head);
  Stored stored = read_results(file);
  stored.checkpoint.stored.begin = file.position(), stored.checkpoint.stored.checksum = head.checksum;
  return stored;
}

constexpr const char *kStageCount = "number of first stages", *kEnergy = "output.energy",
                     *kKernels = "kind of kernels at its start";

std::string name_of_part(const Identity& identity, std::size_t i) {
  return i < identity.parts.size() ? identity.parts[i].what : "none";
}

// Compares part by part, so that the message names the first difference.
void refuse_another(const Identity& identity, const Identity& expected, const Fault& fault) {
  for (std::size_t i = 0; i < std::max(identity.parts.size(), expected.parts.size()); ++i) {
    if (i >= identity.parts.size() || i >= expected.parts.size() || identity.parts[i].what != expected.parts[i].what)
      throw fault(fmt::format("is of a scene with other laws or keys ({}; here {})", name_of_part(identity, i),
                              name_of_part(expected, i)));
    if (identity.parts[i].value != expected.parts[i].value)
      throw fault(fmt::format(
          "is of another {} ({}; here {}{})", identity.parts[i].what, identity.parts[i].value, expected.parts[i].value,
          identity.parts[i].what == kKernels ? "; solver.kernels = \"general\" in both scenes makes them alike" : ""));
  }
}

// Hash of materials, masses, joints and their random samples. Geometry and settings have parts of their own.
std::string masonry_hash(const Scene& scene) {
  Sha256 hash;
  for (const auto& [name, m] : scene.materials)
    hash.add_text(fmt::format("{} {} {} {}", name, m.young_modulus, m.poisson_ratio, m.density));
  for (const AddedMass& m : scene.masses)
    hash.add_text(fmt::format("{} {} {}", m.block, m.mass, m.point ? fmt::format("{}", fmt::join(*m.point, " ")) : ""));
  for (const auto& [name, f] : scene.joints) {
    hash.add_text(fmt::format("{} {} {} {}", name, f.law, f.initial_state, f.missing_mortar));
    for (const PropertySetting& p : f.properties)
      hash.add_text(
          fmt::format("{} {} {} {}", p.id, p.text, fmt::join(p.numbers, " "), p.scatter ? text_of(*p.scatter) : ""));
    for (const PropertyCorrelation& c : f.correlation)
      hash.add_text(fmt::format("{} {} {}", c.first, c.second, c.value));
    if (f.is_random()) hash.add_text(fmt::format("{} {}", scene.random.seed, scene.random.sample));
  }
  return hash.end();
}

// Text of a stage's actions and settings, without its name and its records.
std::string text_of(const Scene& scene, std::size_t index) {
  const Stage& s = scene.stages[index];
  std::string text =
      fmt::format("{}, gravity {}, ramp_time {}, displacement {}, duration {}, equilibrium_ratio {}, max_steps {}, {}",
                  s.kind, fmt::join(s.gravity, " "), s.ramp_time, s.displacement.value_or(0.0),
                  s.duration.value_or(0.0), s.equilibrium_ratio.value_or(0.0), s.max_steps,
                  solver_text(scene.solver_in(index), s.equilibrium_ratio.has_value()));
  const auto add = [&](const std::string& more) { text += ", " + more; };
  if (s.displacement) add(fmt::format("monitor {} along {}", s.monitor, "xyz"[s.direction]));
  for (const BodyControl& c : s.controls) {
    add(fmt::format("{}:", c.body));
    for (std::size_t k = 0; k < 3; ++k)
      text += c.kind[k] == DofKind::free ? fmt::format(" {} N", c.force[k]) : fmt::format(" {} m/s", c.velocity[k]);
    text += fmt::format("{} {}", c.may_turn ? " may turn" : "", fmt::join(c.omega, " "));
  }
  if (s.cycles)
    add(fmt::format("{} at {} m/s, {}", text_of(*s.cycles), s.cycles->velocity,
                    s.cycles->stop_at_force_loss.value_or(0.0)));
  if (s.whiffletree) add(fmt::format("whiffletree {} N/m, {} m/s", s.whiffletree->stiffness, s.whiffletree->velocity));
  for (const std::string& action : action_texts(s)) add(action);
  for (const auto& [family, law] : s.law_swaps) add(fmt::format("law of {}: {}", family, law));
  return text;
}

// Settings of [solver] on which the bits of a run depend.
std::vector<Identity::Part> parts_of(const SolverSettings& s) {
  std::vector<Identity::Part> parts;
  const auto add = [&](const std::string& key, double value) {
    parts.push_back({fmt::format("solver.{}", key), fmt::format("{}", value)});
  };
  parts.push_back({"solver.damping", name_of(s.damping)});
  for (const DampingNumber& number : damping_numbers(s)) {
    if (const auto* band = std::get_if<std::array<double, 2>>(&number.value)) {
      add(number.key + ", lowest", (*band)[0]), add(number.key + ", highest", (*band)[1]);
    } else {
      std::visit(
          [&](auto value) {
            if constexpr (std::is_arithmetic_v<decltype(value)>) add(number.key, static_cast<double>(value));
          },
          number.value);
    }
  }
  add("time_step_fraction", s.time_step_fraction);
  add("mass_scaling", s.mass_scaling);
  add("selective_time_step", s.selective_time_step);
  add("deformation_inertia", s.deformation_inertia);
  add("unit_inertia", s.unit_inertia);
  add("internal_forces", static_cast<double>(s.internal_forces));
  add("large_motion", static_cast<double>(s.large_motion));
  add("rotation_bound", s.motion_bound.rotation);
  add("sliding_bound", s.motion_bound.sliding);
  return parts;
}

// Hash of places, sizes and kinds of blocks at the start, to eight digits. A lattice and the same blocks in large
// motion differ by rounding alone.
std::string geometry_hash(const Simulation& simulation) {
  Sha256 hash;
  const auto add = [&](const geometry::Vector& lower, const geometry::Vector& upper, bool rigid) {
    hash.add_text(fmt::format("{:.8g} {:.8g} {:.8g} {:.8g} {:.8g} {:.8g} {}", lower.x, lower.y, lower.z, upper.x,
                              upper.y, upper.z, rigid));
  };
  for (const Brick& brick : simulation.assembly().bricks) {
    const geometry::Vector lower = geometry::vector(brick.origin);
    add(lower, lower + geometry::vector(brick.size), brick.rigid);
  }
  if (!simulation.large_motion()) return hash.end();
  const blocks::Assembly& assembly = simulation.large_motion()->assembly;
  for (const blocks::Block& block : assembly.blocks) {
    geometry::Vector lower{1e300, 1e300, 1e300}, upper = -1.0 * lower;
    for (const geometry::Vector& corner : assembly.shapes[static_cast<std::size_t>(block.shape)].vertices) {
      const geometry::Vector at = block.position + matrix(block.orientation) * corner;
      lower = min(lower, at), upper = max(upper, at);
    }
    add(lower, upper, block.rigid);
  }
  return hash.end();
}

// Identity of a run whose end state others start from: its stages in place of its whole scene. Laws of later stages
// have no states yet.
Identity end_identity(const Simulation& simulation, Provenance provenance, std::size_t stages) {
  provenance.laws = law_files(simulation.scene(), stages);
  Identity identity = identity_of(simulation, provenance);
  for (Identity::Part& part : identity.parts) {
    if (part.what != "scene") continue;
    part = {"list of first stages", ""};
    for (std::size_t i = 0; i < std::min(stages, simulation.scene().stages.size()); ++i)
      part.value += fmt::format("{}'{}'", i > 0 ? ", " : "", simulation.scene().stages[i].name);
  }
  const bool on_lattice = !simulation.large_motion() || simulation.outcome().promotion;
  identity.parts.push_back({kKernels, on_lattice ? "lattice" : "general"});
  identity.parts.push_back({"set of materials, joints and samples of them", masonry_hash(simulation.scene())});
  identity.parts.push_back({"arrangement of blocks", geometry_hash(simulation)});
  for (const auto& [name, text] : simulation.scene().arrangement) identity.parts.push_back({name, text});
  for (Identity::Part& part : parts_of(simulation.scene().solver)) identity.parts.push_back(std::move(part));
  for (std::size_t i = 0; i < std::min(stages, simulation.scene().stages.size()); ++i)
    identity.parts.push_back(
        {fmt::format("version of stage '{}'", simulation.scene().stages[i].name), text_of(simulation.scene(), i)});
  identity.parts.push_back({kEnergy, simulation.scene().output.energy ? "true" : "false"});
  identity.parts.push_back({kStageCount, std::to_string(stages)});
  return identity;
}

}  // namespace

std::vector<std::uint8_t> checkpoint_bytes(const Identity& identity, const Checkpoint& checkpoint) {
  std::vector<std::uint8_t> bytes;
  write_results({bytes}, identity, checkpoint.results, checkpoint.state.size());
  ArchiveWriter{bytes}.append(checkpoint.state.data(), checkpoint.state.size());
  return bytes;
}

Checkpoint checkpoint_of(std::span<const std::uint8_t> bytes, const Identity& expected) {
  BytesInMemory source(bytes);
  Stored stored = read_results(source);
  refuse_another(stored.identity, expected, [](const std::string& reason) {
    return Error(Exit::bad_input,
                 fmt::format("state: {}; restore it in a simulation of the scene that it is of", reason));
  });
  stored.checkpoint.state.resize(source.left());
  source.take(stored.checkpoint.state.data(), source.left());
  return std::move(stored.checkpoint);
}

Checkpoint find_checkpoint(const std::filesystem::path& path, const Identity& expected) {
  const Fault fault = [&](const std::string& reason) {
    return Error(Exit::bad_input, fmt::format("{}: {}; start the run anew without --resume", path.string(), reason));
  };
  Stored stored = read_stored(path, fault);
  refuse_another(stored.identity, expected, fault);
  return std::move(stored.checkpoint);
}

Checkpoint read_checkpoint(const std::filesystem::path& path, const Identity& expected) {
  Checkpoint checkpoint = find_checkpoint(path, expected);
  checkpoint.state.resize(checkpoint.stored.bytes);
  FileBytes file(path);
  file.skip(checkpoint.stored.begin);
  file.take(checkpoint.state.data(), checkpoint.state.size());
  return checkpoint;
}

void restore_from(const std::filesystem::path& path, const StoredState& state, Simulation* simulation) {
  const Fault fault = [&](const std::string& reason) {
    return Error(Exit::bad_input,
                 fmt::format("{}: {}; all ranks must find the same file there", path.string(), reason));
  };
  FileBytes file(path);
  const Head head = read_head(file, fault);
  if (head.checksum != state.checksum || state.begin > sizeof head + head.bytes ||
      state.bytes > sizeof head + head.bytes - state.begin)
    throw fault("is not the file that rank 0 has found whole");
  file.skip(state.begin - file.position());
  file.end_after(state.bytes);
  simulation->restore(file);
}

void write_end_state(const std::filesystem::path& folder, const Simulation& simulation, const Provenance& provenance) {
  const Identity identity = end_identity(simulation, provenance, simulation.scene().stages.size());
  write_checkpoint(folder / "end_state.bin", identity, ResultsSoFar{}, simulation);
}

void keep_start(const Scene& scene, const std::filesystem::path& folder) {
  std::error_code unknown;
  if (scene.start.empty() || !std::filesystem::equivalent(scene.start, folder, unknown)) return;
  throw Error(Exit::bad_input,
              fmt::format("{}: start: {} is the folder of the results too, which are removed before the run; give "
                          "another one for them (--out)",
                          scene.file, scene.start));
}

namespace {

std::filesystem::path start_file(const Scene& scene) { return std::filesystem::path(scene.start) / "end_state.bin"; }

Fault start_fault(const Scene& scene) {
  return [&scene](const std::string& reason) {
    return Error(Exit::bad_input,
                 fmt::format("{}: start: {} {}; it must be the end of a run of this program with output.end_state = "
                             "true, whose masonry, laws, settings and first stages are those of this scene",
                             scene.file, start_file(scene).string(), reason));
  };
}

}  // namespace

void require_start(const Scene& scene) {
  std::error_code unknown;
  if (!scene.start.empty() && !std::filesystem::exists(start_file(scene), unknown))
    throw start_fault(scene)("does not exist");
}

void take_start(Simulation* simulation) {
  const Scene& scene = simulation->scene();
  if (scene.start.empty()) return;
  require_start(scene);
  const std::filesystem::path path = start_file(scene);
  const Fault fault = start_fault(scene);
  Stored stored = read_stored(path, fault);
  for (Identity::Part& part : stored.identity.parts) {
    if (part.what == kEnergy && !scene.output.energy) part.value = "false";  // more columns than this scene requests
  }
  const auto& parts = stored.identity.parts;
  const bool known = !parts.empty() && parts.back().what == kStageCount;
  const std::size_t stages = known ? std::strtoul(parts.back().value.c_str(), nullptr, 10) : 0;
  refuse_another(stored.identity, end_identity(*simulation, provenance_of(*simulation, {}), stages), fault);
  if (stages >= scene.stages.size()) throw fault(fmt::format("is after stage {}, and nothing is left to do", stages));
  try {
    restore_from(path, stored.checkpoint.stored, simulation);
  } catch (const Error& error) {
    throw fault(fmt::format("does not fit ({})", error.what()));
  }
}

}  // namespace quoin
