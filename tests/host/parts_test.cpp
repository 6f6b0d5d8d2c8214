// Models of which a process has only a part. The part is equal to that of the whole model, joint results are bitwise
// identical, and memory is only used for the part.
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <mutex>
#include <numeric>
#include <string>

#include "base/archive.h"
#include "base/error.h"
#include "base/index.h"
#include "base/sparse_memory.h"
#include "model/lanczos.h"
#include "scene/read_scene.h"
#include "step/collect.h"
#include "step/results.h"
#include "support.h"
#include "thread_ranks.h"

namespace quoin {
namespace {

// Returns the resident memory of this process, kB; pages of zeros that were never written do not count.
double memory_in_use() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "RssAnon:") continue;
    double kilobytes = 0.0;
    status >> kilobytes;
    return kilobytes;
  }
  return -1.0;
}

// Whether this system counts memory where it is written to, by small pages: some virtual machines do not.
bool takes_room_where_written() {
  constexpr std::size_t kBytes = std::size_t{1} << 25;
  constexpr double kOther = 1024.0;  // kB
  void* const memory =
      mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) return false;
  madvise(memory, kBytes, MADV_NOHUGEPAGE);
  auto* const bytes = static_cast<volatile char*>(memory);
  const double before = memory_in_use();
  for (std::size_t i = 0; i < kBytes; i += kPageBytes) static_cast<void>(bytes[i]);
  const double read = memory_in_use() - before;
  for (std::size_t i = 0; i < kBytes / 2; i += kPageBytes) bytes[i] = 1;
  const double written = memory_in_use() - before;
  madvise(memory, kBytes, MADV_DONTNEED);
  const double released = memory_in_use() - before;
  munmap(memory, kBytes);
  return std::max(read, released) < kOther && std::abs(written - kBytes / 2048.0) < kOther;
}

TEST(SparseMemory, TakesRoomWhereItIsWrittenTo) {
  if (!kSparse) GTEST_SKIP() << "with the address sanitizer all memory is taken at once";
  if (!takes_room_where_written()) GTEST_SKIP() << "this system does not count memory by where it is written to";
  constexpr std::size_t kNumbers = std::size_t{1} << 23;  // 64 MiB: other memory of the process changes by far less
  constexpr double kAll = 65536.0, kOther = 2048.0;       // kB
  const double before = memory_in_use();
  if (before < 0.0) GTEST_SKIP() << "no /proc/self/status";
  const bool wanted = sparse_memory_wanted.exchange(true);
  {
    LaneVector<double> numbers(kNumbers, 0.0);
    const LaneVector<double> copy = numbers;
    EXPECT_EQ(std::accumulate(copy.begin(), copy.end(), 0.0), 0.0);
    EXPECT_LT(memory_in_use() - before, kOther);
    std::fill_n(numbers.begin(), kNumbers / 2, 1.0);
    EXPECT_NEAR(memory_in_use() - before, kAll / 2, kOther);
    release_part(numbers, kNumbers / 4, kNumbers);
    EXPECT_NEAR(memory_in_use() - before, kAll / 4, kOther);
    EXPECT_EQ(std::accumulate(numbers.begin(), numbers.end(), 0.0), double(kNumbers / 4));
  }
  EXPECT_LT(memory_in_use() - before, kOther);
  sparse_memory_wanted = wanted;
}

// Compares the arrays of chunks and unit groups of `part` with those of the whole model.
void expect_laid_out(const Model& whole, const Model& part, const std::vector<int>& units,
                     const std::vector<int>& chunks) {
  const auto same = [&](const auto& field, std::size_t first, std::size_t end) {
    const auto &a = whole.*field, &b = part.*field;
    ASSERT_EQ(a.size(), b.size());
    EXPECT_TRUE(std::equal(a.begin() + first, a.begin() + end, b.begin() + first));
  };
  for (const int c : chunks) {
    const auto p = at(whole.chunks[at(c)].first_point), q = p + at(whole.chunks[at(c)].point_count);
    same(&Model::node_a, p, q), same(&Model::node_b, p, q), same(&Model::area, p, q);
    same(&Model::point_run, p, q), same(&Model::point_axis, p, q), same(&Model::point_position, p, q);
  }
  for (const int u : units) {
    const Model::Extent of = whole.extent_of_units(at(u), at(u) + 1);
    same(&Model::node_mass, of.first_line * kLine, of.end_line * kLine);
    same(&Model::node_free, of.first_line * kLine, of.end_line * kLine);
    same(&Model::slot_point, of.first_slot * kLanes, of.end_slot * kLanes);
    same(&Model::slot_run, of.first_slot, of.end_slot);
  }
}

// Returns all chunks with contacts of these unit groups, in order.
std::vector<int> chunks_of(const Model& model, const std::vector<int>& units) {
  std::vector<bool> of_units(model.groups.size());
  for (const int u : units) {
    const UnitGroup& unit = model.unit_groups[at(u)];
    for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g) of_units[at(g)] = true;
  }
  std::vector<int> found;
  for (int c = 0; c < static_cast<int>(model.chunks.size()); ++c) {
    const ContactChunk& chunk = model.chunks[at(c)];
    bool touches = false;
    for (int p = chunk.first_point; p < chunk.first_point + chunk.point_count; ++p) {
      for (const int block : {model.sides_of(p).a, model.sides_of(p).b}) {
        const int group = model.place[at(block)].group;
        touches = touches || (group >= 0 && of_units[at(group)]);
      }
    }
    if (touches) found.push_back(c);
  }
  return found;
}

TEST(ModelInParts, HasTheNumbersOfTheWhole) {
  const Scene scene = wall_scene(12, 12.5);
  const Assembly assembly = assemble(scene);
  const auto materials = make_materials(assembly);
  const Model whole(assembly, materials);
  Model part(assembly, materials, LayOut::nothing);
  ASSERT_EQ(part.point_joint, whole.point_joint);
  ASSERT_GT(whole.chunks.size(), 8u);
  const int count = static_cast<int>(whole.unit_groups.size());
  std::vector<int> first, last;
  for (int u = 0; u < count; ++u) (u < count / 3 ? first : last).push_back(u);
  for (const auto& units : {first, last, first}) {
    const std::vector<int> chunks = chunks_of(whole, units);
    ASSERT_LT(chunks.size(), whole.chunks.size());
    part.keep_alone(units, chunks);
    part.lay_out(units, chunks);
    expect_laid_out(whole, part, units, chunks);
  }
  part.lay_out_all();
  std::vector<int> all_units(at(count)), all_chunks(whole.chunks.size());
  std::iota(all_units.begin(), all_units.end(), 0);
  std::iota(all_chunks.begin(), all_chunks.end(), 0);
  expect_laid_out(whole, part, all_units, all_chunks);
}

// A shared vector with the rows of all ranks.
struct InRows : SharedVectors {
  std::vector<VectorRow> all;
  std::span<const VectorRow> rows() const override { return all; }
  double sum(const Add& add) override {
    double sum = 0.0;
    for (const VectorRow& row : all) sum = add(row, sum);
    return sum;
  }
};

TEST(Lanczos, OfRowsHasTheBitsOfOneVector) {
  const auto product = [](const LaneVector<double>& x, LaneVector<double>* y) {
    double sum = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      (*y)[i] = (1.0 + 0.1 * double(i % 7)) * x[i] - (i > 0 ? 0.3 * x[i - 1] : 0.0) -
                (i + 1 < x.size() ? 0.3 * x[i + 1] : 0.0);
      sum += (*y)[i] * x[i];
    }
    return sum;
  };
  LaneVector<double> start(101);
  for (std::size_t i = 0; i < start.size(); ++i) start[i] = std::sin(1.0 + double(i));
  LanczosSettings settings;
  settings.max_steps = 60;
  settings.settled = 1e-12;
  InRows rows;
  rows.all = {{0, 17}, {17, 18}, {18, 64}, {64, 101}};
  const LargestEigenvalue one = largest_eigenvalue(product, start, settings);
  const LargestEigenvalue in_rows = largest_eigenvalue(product, start, settings, &rows);
  EXPECT_GT(one.value, 1.6);
  EXPECT_EQ(one.value, in_rows.value);
  EXPECT_EQ(one.steps, in_rows.steps);
}

// Results of a run, and its state at every pause.
struct Kept : Observer {
  std::vector<HistoryRow> rows;
  std::vector<std::vector<std::uint8_t>> saved;
  bool by_pieces = false;
  void on_row(const HistoryRow& row) override { rows.push_back(row); }
  bool wants_pause(bool) override { return true; }
  void on_pause(const Simulation& simulation, bool) override {
    std::vector<std::uint8_t>& bytes = saved.emplace_back();
    const std::size_t expected = simulation.saved_bytes();
    simulation.save(
        [&](std::span<const std::uint8_t> piece) { bytes.insert(bytes.end(), piece.begin(), piece.end()); });
    if (!bytes.empty()) {
      EXPECT_EQ(bytes.size(), expected);
    }
  }
};

Scene small_wall() {
  return read_scene(std::string(QUOIN_HOST_TESTS) + "/../cli/small_wall.toml",
                    {"wall.courses=24", "wall.units_per_course=24", "stage.precompression.duration=0.002",
                     "stage.shear.displacement=0.000001", "stage.shear.law=coulomb_slip", "output.frames=0"});
}

// History, checkpoints, hash and conditions are bitwise identical to those of one process. No rank has all contact
// points in memory, except for rank 0 on request.
TEST(RunInParts, IsThatOfOneProcess) {
  Simulation alone(small_wall());
  Kept kept;
  alone.run(kept);
  ASSERT_GT(kept.rows.size(), 3u);
  ASSERT_GT(kept.saved.size(), 1u);
  for (const auto& [count, gathered] : {std::pair(2, true), {3, false}}) {
    std::mutex one_at_a_time;
    on_ranks(count, [&](Ranks& ranks) {
      Simulation simulation(small_wall(), 1, &ranks);
      Kept here;
      simulation.run(here);
      if (gathered) gather_at_first(simulation);
      const std::lock_guard lock(one_at_a_time);
      ASSERT_EQ(here.rows.size(), kept.rows.size());
      for (std::size_t i = 0; i < kept.rows.size(); ++i) {
        EXPECT_EQ(here.rows[i].resistance, kept.rows[i].resistance);
        EXPECT_EQ(here.rows[i].unbalanced_ratio, kept.rows[i].unbalanced_ratio);
        EXPECT_EQ(here.rows[i].kinetic_energy, kept.rows[i].kinetic_energy);
      }
      EXPECT_EQ(simulation.time_step_report().critical.value, alone.time_step_report().critical.value);
      EXPECT_EQ(simulation.time_step_report().added_mass, alone.time_step_report().added_mass);
      const Model& model = simulation.model();
      long points = 0;
      for (int c = 0; c < static_cast<int>(model.chunks.size()); ++c)
        points += model.has_laid_out(c) ? model.chunks[at(c)].point_count : 0;
      EXPECT_EQ(points == model.point_count, gathered && ranks.rank() == 0) << points << " of " << model.point_count;
      if (ranks.rank() != 0) return;
      ASSERT_EQ(here.saved.size(), kept.saved.size());
      constexpr long kCounters = 512;  // bytes at the end, some between fields: all arrays are before them
      for (std::size_t i = 0; i < kept.saved.size(); ++i) {
        const auto &of_ranks = here.saved[i], &of_one = kept.saved[i];
        ASSERT_EQ(of_ranks.size(), of_one.size());
        EXPECT_TRUE(std::equal(of_one.begin(), of_one.end() - kCounters, of_ranks.begin())) << i;
      }
      EXPECT_EQ(simulation.hash(), alone.hash());
      EXPECT_EQ(condition_counts(simulation), condition_counts(alone));
    });
  }
}

// Counts the bytes of a state that are read.
struct CountedBytes : BytesInMemory {
  using BytesInMemory::BytesInMemory;
  std::size_t taken = 0;
  void take(void* to, std::size_t size) override { BytesInMemory::take(to, size), taken += size; }
};

// Resumes from states of one process: before the first stage, in it and in the next one.
TEST(RunInParts, GoesOnFromWhatEachRankReadsOfAState) {
  Simulation alone(small_wall());
  Kept kept;
  const std::vector<std::uint8_t> start = alone.save();
  alone.run(kept);
  ASSERT_GT(kept.saved.size(), 2u);
  for (const auto& [count, state] : {std::pair(4, kept.saved.back()), {2, kept.saved.front()}, {3, start}}) {
    on_ranks(count, [&](Ranks& ranks) {
      Simulation simulation(small_wall(), 1, &ranks);
      CountedBytes source(state);
      simulation.restore(source);
      // In a small wall most chunks of contact points are at borders: a rank reads 0.79 to 0.97 of the state.
      EXPECT_LT(double(source.taken), 0.98 * double(state.size())) << count;
      Observer nobody;
      simulation.run(nobody);
      if (ranks.rank() == 0) {
        EXPECT_EQ(simulation.hash(), alone.hash()) << count;
      }
    });
  }
}

// A state whose array sizes are those of another model is refused before a rank writes beyond its arrays.
TEST(RunInParts, RefusesAStateOfAnotherModelOrCutShort) {
  Scene larger = small_wall(), smaller = small_wall();
  larger.wall->courses += 1, smaller.wall->courses -= 1;
  // States with the time step of this model, since the time step is checked before the sizes.
  Simulation here(small_wall());
  for (const Scene& of_other : {larger, smaller}) {
    Simulation other(of_other);
    std::vector<std::uint8_t> state = other.save();
    const auto put = [&](double from, double to) {
      for (std::size_t at = 0; at + sizeof from <= state.size(); ++at) {
        if (std::memcmp(&state[at], &from, sizeof from) == 0) return std::memcpy(&state[at], &to, sizeof to), true;
      }
      return false;
    };
    ASSERT_TRUE(put(other.time_step_report().time_step, here.time_step_report().time_step));
    for (const std::size_t size : {state.size(), state.size() / 2}) {
      const std::vector<std::uint8_t> bytes(state.begin(), state.begin() + static_cast<long>(size));
      EXPECT_THROW(on_ranks(2,
                            [&](Ranks& ranks) {
                              Simulation simulation(small_wall(), 1, &ranks);
                              BytesInMemory source(bytes);
                              simulation.restore(source);
                            }),
                   Error);
    }
  }
}

}  // namespace
}  // namespace quoin
