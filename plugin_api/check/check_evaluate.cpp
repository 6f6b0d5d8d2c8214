// C5 to C7: states, purity, memory, threads, refusals, failed points.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <latch>
#include <limits>
#include <numeric>
#include <thread>

#include "checks.h"

namespace check {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<size_t> all_indices(size_t n) {
  std::vector<size_t> indices(n);
  std::iota(indices.begin(), indices.end(), size_t{0});
  return indices;
}

// A batch whose columns a test sets.
struct Columns {
  explicit Columns(const quoin_law& law) : state_old(law.state_count), state_new(law.state_count) {
    batch.struct_size = sizeof batch;
    batch.state_old = state_old.data();
    batch.state_new = state_new.data();
  }
  Columns(const Columns&) = delete;
  quoin_batch batch = {};
  std::vector<quoin_in> state_old;
  std::vector<quoin_out> state_new;
};

// An array of n records of `fields` elements, with guard values before, between and behind the records.
struct Records {
  Records(size_t n, size_t fields, int64_t stride_sign, size_t gap)
      : count(n),
        stride(static_cast<int64_t>(fields + gap) * stride_sign),
        memory((fields + gap) * (n + 2) + 1, kGuard) {
    // The odd offset gives every element the alignment of a double, not of a vector.
    first = memory.data() + (fields + gap) + 1;
    if (stride_sign < 0 && n > 0) first += (fields + gap) * (n - 1);
  }
  double* column(size_t field) { return first + field; }
  double& at(size_t field, size_t i) { return first[static_cast<int64_t>(field) + static_cast<int64_t>(i) * stride]; }
  void forget(size_t field) {
    for (size_t i = 0; i < count; ++i) at(field, i) = kGuard;
  }
  bool only_guards() const {
    return std::all_of(memory.begin(), memory.end(), [](double value) { return value == kGuard; });
  }
  static constexpr double kGuard = -7.25e77;
  size_t count;
  int64_t stride;
  std::vector<double> memory;
  double* first;
};

// Evaluates with every column in one array of records, as a host with an array of structures does. in_place: old and
// new are the same memory. Sets *clean to whether inputs and guard values are unchanged.
Result evaluate_records(const quoin_law& law, const Material& material, const Points& points, int64_t sign, size_t gap,
                        bool in_place, bool* clean) {
  const size_t n = points.size();
  const size_t states = law.state_count;
  size_t fields = 0;
  const size_t jump = fields++, slip = fields, traction = slip + 2, state = traction + 3;
  fields = state + states;
  const size_t traction_new = in_place ? traction : fields;
  const size_t state_new = in_place ? state : traction_new + 3;
  if (!in_place) fields += 3 + states;
  const bool energy = law.capabilities & QUOIN_CAN_ENERGY;
  const bool tangents = law.capabilities & QUOIN_CAN_TANGENT;
  const size_t stored = fields, dissipated = stored + 1;
  if (energy) fields += 1 + QUOIN_DISSIPATED_COUNT;
  const size_t tangent = fields;
  if (tangents) fields += 9;

  Records records(n, fields, sign, gap);
  for (size_t i = 0; i < n; ++i) {
    records.at(jump, i) = points.normal_jump[i];
    for (size_t k = 0; k < 2; ++k) records.at(slip + k, i) = points.slip[k][i];
    for (size_t k = 0; k < 3; ++k) records.at(traction + k, i) = points.traction[k][i];
    for (size_t s = 0; s < states; ++s) records.at(state + s, i) = points.state[s][i];
  }
  std::vector<uint32_t> flags(3 * n + 2, 0xdeadbeefu), status(2 * n + 2, 0xdeadbeefu);

  Columns columns(law);
  quoin_batch& batch = columns.batch;
  batch.count = n;
  const int64_t stride = records.stride;
  batch.normal_jump = {records.column(jump), stride};
  for (size_t k = 0; k < 2; ++k) batch.slip_increment[k] = {records.column(slip + k), stride};
  for (size_t k = 0; k < 3; ++k) {
    batch.traction_old[k] = {records.column(traction + k), stride};
    batch.traction_new[k] = {records.column(traction_new + k), stride};
  }
  for (size_t s = 0; s < states; ++s) {
    columns.state_old[s] = {records.column(state + s), stride};
    columns.state_new[s] = {records.column(state_new + s), stride};
  }
  if (energy) {
    batch.energy_stored = {records.column(stored), stride};
    for (size_t k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) batch.dissipated[k] = {records.column(dissipated + k), stride};
  }
  if (tangents) {
    for (size_t k = 0; k < 9; ++k) batch.tangent[k] = {records.column(tangent + k), stride};
  }
  if (law.capabilities & QUOIN_CAN_FLAGS) batch.flags = {flags.data() + 1, 3};
  batch.status = {status.data() + 1, 2};

  Result result;
  result.status = law.evaluate(material.handle, &batch);
  const auto read = [&](size_t field) {
    std::vector<double> column(n);
    for (size_t i = 0; i < n; ++i) column[i] = records.at(field, i);
    return column;
  };
  *clean = true;
  for (size_t k = 0; k < 3; ++k) result.traction[k] = read(traction_new + k);
  for (size_t s = 0; s < states; ++s) result.state.push_back(read(state_new + s));
  if (energy) {
    result.stored = read(stored);
    for (size_t k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) result.dissipated[k] = read(dissipated + k);
  }
  if (tangents) {
    for (size_t k = 0; k < 9; ++k) result.tangent[k] = read(tangent + k);
  }
  for (size_t i = 0; i < n; ++i) {
    if (law.capabilities & QUOIN_CAN_FLAGS) result.flags.push_back(flags[1 + 3 * i]);
    result.point_status.push_back(status[1 + 2 * i]);
    flags[1 + 3 * i] = status[1 + 2 * i] = 0xdeadbeefu;
  }
  const auto untouched = [](uint32_t value) { return value == 0xdeadbeefu; };
  *clean = std::all_of(flags.begin(), flags.end(), untouched) && std::all_of(status.begin(), status.end(), untouched);

  // Inputs that are not outputs must be unchanged.
  for (size_t i = 0; i < n; ++i) {
    *clean = *clean && records.at(jump, i) == points.normal_jump[i];
    for (size_t k = 0; k < 2; ++k) *clean = *clean && records.at(slip + k, i) == points.slip[k][i];
    if (in_place) continue;
    for (size_t k = 0; k < 3; ++k) *clean = *clean && records.at(traction + k, i) == points.traction[k][i];
    for (size_t s = 0; s < states; ++s) *clean = *clean && records.at(state + s, i) == points.state[s][i];
  }
  for (size_t f = 0; f < fields; ++f) records.forget(f);
  *clean = *clean && records.only_guards();
  return result;
}

}  // namespace

void check_states(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  const Material material(law, subject.base);
  report.clause("C5.1");
  for (uint64_t k = 0; k < law.initial_state_count; ++k) {
    std::vector<double> values(law.state_count + 2, kNan);
    values.back() = -7.25e77;
    report.expect(law.initial_state(material.handle, law.initial_states[k], values.data()) == QUOIN_OK, "%s: refused",
                  law.initial_states[k]);
    for (uint64_t s = 0; s < law.state_count; ++s) {
      report.expect(values[s] >= law.states[s]->lower && values[s] <= law.states[s]->upper && std::isfinite(values[s]),
                    "%s: %s = %g is not within its bounds %g to %g", law.initial_states[k], law.states[s]->id,
                    values[s], law.states[s]->lower, law.states[s]->upper);
    }
    report.expect(values.back() == -7.25e77, "%s: more than state_count values are written", law.initial_states[k]);
  }
  std::vector<double> values(law.state_count + 1);
  report.expect(law.initial_state(material.handle, "no_such_state", values.data()) == QUOIN_ERROR_ARGUMENT,
                "an unknown initial state is given");

  // Two equal walks: the states of the second are saved as bytes after every step and continue with a new material.
  report.clause("C5.4");
  for (const Settings& settings : subject.varied) {
    const Material kept(law, settings);
    Walk walk(law, kept, 40, 31, 10);
    for (int step = 0; step < 80; ++step) {
      walk.aim();
      const Result through = evaluate(law, kept, walk.points);
      const Material fresh(law, settings);
      const Result restored = evaluate(law, fresh, walk.points);
      const std::string what = difference(law, through, restored);
      report.expect(what.empty(), "step %d: %s", step, what.c_str());
      walk.advance(through);
    }
  }
}

void check_purity(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  std::vector<Material> materials;
  for (const Settings& settings : subject.varied) materials.emplace_back(law, settings);
  constexpr size_t kCount = 1000;
  for (size_t m = 0; m < materials.size(); ++m) {
    const Material& material = materials[m];
    const Points points = scattered_points(law, material, kCount, 100 + m);
    const Result expected = evaluate(law, material, points);

    report.clause("C6.1");
    std::string what = difference(law, expected, evaluate(law, material, points));
    report.expect(what.empty(), "evaluated twice: %s", what.c_str());
    for (const Material& other : materials) evaluate(law, other, scattered_points(law, other, 17, 5));
    what = difference(law, expected, evaluate(law, material, points));
    report.expect(what.empty(), "after other materials and points: %s", what.c_str());
    {
      const Material passing(law, subject.base);  // made and destroyed in between
      evaluate(law, passing, points);
    }
    what = difference(law, expected, evaluate(law, material, points));
    report.expect(what.empty(), "after a material was made, used and destroyed: %s", what.c_str());

    report.clause("C6.2");
    std::mt19937_64 random(m + 1);
    std::vector<size_t> shuffled = all_indices(kCount);
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    what = difference(law, expected.take(shuffled), evaluate(law, material, points.take(shuffled)));
    report.expect(what.empty(), "shuffled: %s", what.c_str());
    for (const size_t size : {1u, 2u, 3u, 7u, 8u, 64u, 333u, 999u}) {
      for (size_t begin = 0; begin < kCount; begin += size) {
        std::vector<size_t> part;
        for (size_t i = begin; i < std::min(begin + size, kCount); ++i) part.push_back(i);
        what = difference(law, expected.take(part), evaluate(law, material, points.take(part)));
        report.expect(what.empty(), "in batches of %zu: %s", size, what.c_str());
      }
    }
  }
}

void check_memory(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  const Material material(law, subject.base);
  for (const size_t count : {1u, 7u, 100u, 1000u}) {
    const Points points = scattered_points(law, material, count, 200 + count);
    const Result expected = evaluate(law, material, points);
    for (const int sign : {1, -1}) {
      for (const size_t gap : {0u, 1u, 5u}) {
        for (const bool in_place : {false, true}) {
          bool clean = true;
          report.clause(in_place ? "C6.4" : "C6.3");
          const Result result = evaluate_records(law, material, points, sign, gap, in_place, &clean);
          const std::string what = difference(law, expected, result);
          report.expect(what.empty(), "%zu records%s, %s, gap %zu: %s", count, sign < 0 ? " backwards" : "",
                        in_place ? "in place" : "old and new apart", gap, what.c_str());
          report.clause("C6.6");
          report.expect(clean, "%zu records, gap %zu: an input or memory between the elements was written", count, gap);
        }
      }
    }
    // Contiguous and in place, as a host with a structure of arrays does.
    report.clause("C6.4");
    Points in_place = points;
    Columns columns(law);
    columns.batch.count = count;
    columns.batch.normal_jump = {in_place.normal_jump.data(), 1};
    for (size_t k = 0; k < 2; ++k) columns.batch.slip_increment[k] = {in_place.slip[k].data(), 1};
    for (size_t k = 0; k < 3; ++k) {
      columns.batch.traction_old[k] = {in_place.traction[k].data(), 1};
      columns.batch.traction_new[k] = {in_place.traction[k].data(), 1};
    }
    for (size_t s = 0; s < law.state_count; ++s) {
      columns.state_old[s] = {in_place.state[s].data(), 1};
      columns.state_new[s] = {in_place.state[s].data(), 1};
    }
    Result result;
    result.status = law.evaluate(material.handle, &columns.batch);
    result.traction = in_place.traction;
    result.state = in_place.state;
    std::string what = difference(law, expected, result);
    report.expect(what.empty(), "%zu contiguous points in place: %s", count, what.c_str());

    // One value for all points by stride 0.
    report.clause("C6.3");
    Points same = points;
    for (double& value : same.normal_jump) value = points.normal_jump[0];
    for (auto& column : same.slip) std::fill(column.begin(), column.end(), column[0]);
    const Result repeated = evaluate(law, material, same);
    columns.batch.normal_jump = {same.normal_jump.data(), 0};
    for (size_t k = 0; k < 2; ++k) columns.batch.slip_increment[k] = {same.slip[k].data(), 0};
    for (size_t k = 0; k < 3; ++k) {
      result.traction[k].assign(count, kNan);
      columns.batch.traction_old[k] = {same.traction[k].data(), 1};
      columns.batch.traction_new[k] = {result.traction[k].data(), 1};
    }
    for (size_t s = 0; s < law.state_count; ++s) {
      result.state[s].assign(count, kNan);
      columns.state_old[s] = {same.state[s].data(), 1};
      columns.state_new[s] = {result.state[s].data(), 1};
    }
    result.status = law.evaluate(material.handle, &columns.batch);
    what = difference(law, repeated, result);
    report.expect(what.empty(), "%zu points with repeated inputs (stride 0): %s", count, what.c_str());
  }
}

void check_threads(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  std::vector<Material> materials;
  std::vector<Points> points;
  std::vector<Result> expected;
  for (const Settings& settings : subject.varied) {
    materials.emplace_back(law, settings);
    points.push_back(scattered_points(law, materials.back(), 2001, 300 + points.size()));
    expected.push_back(evaluate(law, materials.back(), points.back()));
  }
  report.clause("C6.5");
  constexpr size_t kThreads = 4;
  constexpr auto kDuration = std::chrono::milliseconds(300);
  std::vector<std::string> faults(kThreads);
  std::latch start(kThreads);
  std::vector<std::thread> threads;
  for (size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      start.arrive_and_wait();
      const auto end = std::chrono::steady_clock::now() + kDuration;
      for (int round = 0; std::chrono::steady_clock::now() < end && faults[t].empty(); ++round) {
        // Every thread evaluates other points, so that scratch memory shared by threads changes results.
        const size_t m = (t / 2 + static_cast<size_t>(round)) % materials.size();
        std::vector<size_t> part;
        for (size_t i = t; i < points[m].size(); i += kThreads) part.push_back(i);
        faults[t] = difference(law, expected[m].take(part), evaluate(law, materials[m], points[m].take(part)));
        if (round % 16 == 0) {
          const Material passing(law, subject.base);
          if (passing.handle == nullptr) faults[t] = "a material was refused";
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::string& fault : faults) {
    report.expect(fault.empty(), "%zu threads: %s", kThreads, fault.c_str());
  }
}

void check_optional(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  const Material material(law, subject.base);
  const Points points = scattered_points(law, material, 100, 400);
  report.clause("C6.7");
  const Result all = evaluate(law, material, points);
  report.expect(all.status == QUOIN_OK, "everything wanted: returns %d", all.status);
  for (unsigned wanted = 0; wanted < kAll; ++wanted) {
    const Result some = evaluate(law, material, points, wanted);
    const std::string what = difference(law, all, some);
    report.expect(some.status == QUOIN_OK && what.empty(), "wanted only %s%s%s%s%s: %s",
                  wanted & kEnergy ? "energy " : "", wanted & kTangent ? "tangent " : "",
                  wanted & kFlags ? "flags " : "", wanted & kStatus ? "status " : "", wanted & kDamage ? "damage" : "",
                  what.c_str());
  }
  const auto finite = [&](const std::vector<double>& column) {
    return std::all_of(column.begin(), column.end(), [](double value) { return std::isfinite(value); });
  };
  for (const auto& column : all.dissipated) report.expect(finite(column), "a dissipation is not written or not finite");
  for (const auto& column : all.tangent) report.expect(finite(column), "a tangent is not written or not finite");
  report.expect(finite(all.stored), "a stored energy is not written or not finite");
  for (const uint32_t flags : all.flags) report.expect(flags < 2 * QUOIN_FLAG_GAVE_WAY, "flags %x", flags);

  const auto columns_of = [&](Columns& columns, Result& result) {
    columns.batch.count = points.size();
    columns.batch.normal_jump = {points.normal_jump.data(), 1};
    for (size_t k = 0; k < 2; ++k) columns.batch.slip_increment[k] = {points.slip[k].data(), 1};
    for (size_t k = 0; k < 3; ++k) {
      result.traction[k].assign(points.size(), kNan);
      columns.batch.traction_old[k] = {points.traction[k].data(), 1};
      columns.batch.traction_new[k] = {result.traction[k].data(), 1};
    }
    result.state.assign(law.state_count, {});
    for (uint64_t s = 0; s < law.state_count; ++s) {
      result.state[s].assign(points.size(), kNan);
      columns.state_old[s] = {points.state[s].data(), 1};
      columns.state_new[s] = {result.state[s].data(), 1};
    }
  };
  if (law.capabilities & QUOIN_CAN_ENERGY) {
    for (size_t one = 0; one <= QUOIN_DISSIPATED_COUNT; ++one) {  // each energy alone
      Columns columns(law);
      Result result;
      columns_of(columns, result);
      std::vector<double> energy(points.size(), kNan);
      (one == 0 ? columns.batch.energy_stored : columns.batch.dissipated[one - 1]) = {energy.data(), 1};
      result.status = law.evaluate(material.handle, &columns.batch);
      (one == 0 ? result.stored : result.dissipated[one - 1]) = energy;
      const std::string what = difference(law, all, result);
      report.expect(what.empty(), "one energy output alone: %s", what.c_str());
    }
  }
  if (!(law.capabilities & QUOIN_CAN_ENERGY) || !(law.capabilities & QUOIN_CAN_TANGENT) ||
      !(law.capabilities & QUOIN_CAN_FLAGS)) {
    Columns columns(law);
    Result result;
    columns_of(columns, result);
    std::vector<double> data(points.size(), kNan);
    std::vector<uint32_t> flags(points.size());
    if (!(law.capabilities & QUOIN_CAN_FLAGS)) {
      columns.batch.flags = {flags.data(), 1};
    } else {
      (law.capabilities & QUOIN_CAN_ENERGY ? columns.batch.tangent[0] : columns.batch.energy_stored) = {data.data(), 1};
    }
    report.expect(law.evaluate(material.handle, &columns.batch) == QUOIN_ERROR_UNSUPPORTED,
                  "an output that the capabilities do not offer is accepted");
  }

  for (size_t one = 0; one < QUOIN_DAMAGE_COUNT; ++one) {  // each damage alone
    Columns columns(law);
    Result result;
    columns_of(columns, result);
    std::vector<double> damage(points.size(), kNan);
    columns.batch.damage[one] = {damage.data(), 1};
    result.status = law.evaluate(material.handle, &columns.batch);
    if (law.capabilities & QUOIN_CAN_DAMAGE) {
      result.damage[one] = damage;
      const std::string what = difference(law, all, result);
      report.expect(what.empty(), "one damage output alone: %s", what.c_str());
    } else {  // a law of version 1.0 does not read the damage columns
      report.expect(result.status == QUOIN_ERROR_UNSUPPORTED || std::isnan(damage[0]),
                    "damage, which the capabilities do not offer, is written");
    }
  }

  report.clause("C6.8");
  bool diagnostics = false;
  Columns columns(law);
  Result result;
  columns_of(columns, result);
  for (uint64_t s = 0; s < law.state_count; ++s) {
    if (law.states[s]->role != QUOIN_ROLE_DIAGNOSTIC) continue;
    diagnostics = true;
    columns.state_old[s].data = nullptr;
    columns.state_new[s].data = nullptr;
    result.state[s].clear();
  }
  if (!diagnostics) {
    report.skip("the law has no diagnostic state");
    return;
  }
  result.status = law.evaluate(material.handle, &columns.batch);
  const std::string what = difference(law, all, result);
  report.expect(what.empty(), "without diagnostics: %s", what.c_str());
}

void check_refusals(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  const Material material(law, subject.base);
  const Points points = scattered_points(law, material, 7, 500);
  Columns columns(law);
  Result result;
  quoin_batch& batch = columns.batch;
  const auto reset = [&] {
    batch = {};
    batch.struct_size = sizeof batch;
    batch.count = points.size();
    batch.state_old = columns.state_old.data();
    batch.state_new = columns.state_new.data();
    batch.normal_jump = {points.normal_jump.data(), 1};
    for (size_t k = 0; k < 2; ++k) batch.slip_increment[k] = {points.slip[k].data(), 1};
    for (size_t k = 0; k < 3; ++k) {
      result.traction[k].assign(points.size(), -7.25e77);
      batch.traction_old[k] = {points.traction[k].data(), 1};
      batch.traction_new[k] = {result.traction[k].data(), 1};
    }
    result.state.resize(law.state_count);
    for (uint64_t s = 0; s < law.state_count; ++s) {
      result.state[s].assign(points.size(), -7.25e77);
      columns.state_old[s] = {points.state[s].data(), 1};
      columns.state_new[s] = {result.state[s].data(), 1};
    }
  };
  const auto expect_refused = [&](const char* what) {
    report.expect(law.evaluate(material.handle, &batch) == QUOIN_ERROR_ARGUMENT, "%s: accepted", what);
    bool written = false;
    for (const auto& column : result.traction) written = written || column[0] != -7.25e77;
    for (const auto& column : result.state) written = written || column[0] != -7.25e77;
    report.expect(!written, "%s: refused, but outputs were written", what);
    reset();
  };

  report.clause("C6.10");
  reset();
  batch.count = 0;
  batch.failed_count = batch.clamped_count = 77;
  batch.worst_status = batch.any_yielding = 77;
  report.expect(law.evaluate(material.handle, &batch) == QUOIN_OK, "a batch of 0 is refused");
  report.expect(result.traction[0][0] == -7.25e77, "a batch of 0 writes");
  report.expect(
      batch.failed_count == 0 && batch.clamped_count == 0 && batch.worst_status == 0 && batch.any_yielding == 0,
      "the summary of a batch of 0 is not 0");
  quoin_batch nothing = {};
  nothing.struct_size = sizeof nothing;
  report.expect(law.evaluate(material.handle, &nothing) == QUOIN_OK, "a batch of 0 without columns is refused");
  nothing.state_old = columns.state_old.data();
  nothing.state_new = columns.state_new.data();
  for (auto& column : columns.state_old) column = {};
  for (auto& column : columns.state_new) column = {};
  report.expect(law.evaluate(material.handle, &nothing) == QUOIN_OK, "a batch of 0 with null columns is refused");

  report.clause("C6.11");
  reset();
  report.expect(law.evaluate(nullptr, &batch) == QUOIN_ERROR_ARGUMENT, "a null material is accepted");
  report.expect(law.evaluate(material.handle, nullptr) == QUOIN_ERROR_ARGUMENT, "a null batch is accepted");
  batch.struct_size = 64;
  expect_refused("a batch of 64 bytes");
  batch.normal_jump.data = nullptr;
  expect_refused("null normal_jump");
  batch.slip_increment[1].data = nullptr;
  expect_refused("null slip_increment[1]");
  batch.traction_old[2].data = nullptr;
  expect_refused("null traction_old[2]");
  batch.traction_new[0].data = nullptr;
  expect_refused("null traction_new[0]");
  batch.traction_new[1].stride = 0;
  expect_refused("traction_new[1] with stride 0");
  if (law.state_count > 0) {
    batch.state_old = nullptr;
    expect_refused("null state_old");
    batch.state_new = nullptr;
    expect_refused("null state_new");
  }
  for (uint64_t s = 0; s < law.state_count; ++s) {
    if (law.states[s]->role != QUOIN_ROLE_HISTORY) continue;
    columns.state_old[s].data = nullptr;
    expect_refused("a history state without old values");
    columns.state_new[s].data = nullptr;
    expect_refused("a history state without new values");
    break;
  }
  const quoin_property_column unknown = {"no_such_property", {points.normal_jump.data(), 1}};
  batch.property_column_count = 1;
  batch.property_columns = &unknown;
  expect_refused("a property column of an unknown property");
  batch.struct_size = QUOIN_BATCH_SIZE_1_0;  // a host of version 1.0: the memory behind may have any contents
  double behind = 77;
  for (auto& column : batch.damage) column = {&behind, 0};
  report.expect(law.evaluate(material.handle, &batch) == QUOIN_OK && behind == 77,
                "a batch of version 1.0 is refused, or read beyond its end");
  reset();
  batch.struct_size = sizeof batch + 64;  // a newer host
  report.expect(law.evaluate(material.handle, &batch) == QUOIN_OK, "a longer batch of a newer host is refused");
}

void check_property_columns(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  report.clause("C6.9");
  if (!(law.capabilities & QUOIN_CAN_PROPERTY_COLUMNS)) {
    report.skip("the law does not offer property columns");
    return;
  }
  const Material material(law, subject.base);
  const Points points = scattered_points(law, material, 60, 600);
  const size_t n = points.size();
  int tried = 0;
  for (uint64_t p = 0; p < law.property_count; ++p) {
    const quoin_property_info& property = *law.properties[p];
    if (!(property.flags & QUOIN_PROPERTY_PER_POINT) || property.kind != QUOIN_PROPERTY_NUMBER) continue;
    const double base = material.number(property.id);
    std::vector<double> bad = values_outside(property);
    bad.insert(bad.begin(), kNan);
    for (const double factor : {1.0, 1.03, 0.98}) {
      if (factor != 1.0 && !std::isfinite(base)) break;
      Settings settings = subject.base;
      settings[property.id] = shortest(base * factor);
      // The other properties keep the material's values. So do those whose default is this property, where allowed.
      Settings kept = settings;
      for (uint64_t q = 0; q < law.property_count; ++q) {
        const quoin_property_info& follower = *law.properties[q];
        if (follower.default_from == nullptr || std::strcmp(follower.default_from, property.id) != 0) continue;
        kept.emplace(follower.id, shortest(material.number(follower.id)));
      }
      const Material other(law, Material(law, kept).handle != nullptr ? kept : settings);
      if (other.handle == nullptr) continue;
      ++tried;
      const Result expected = evaluate(law, other, points);
      // Every second point has a value that must be refused.
      std::vector<double> values(n, std::strtod(settings[property.id].c_str(), nullptr));
      for (size_t i = 1; i < n; i += 2) values[i] = bad[i / 2 % bad.size()];
      const quoin_property_column column = {property.id, {values.data(), 1}};
      Columns columns(law);
      Result result;
      columns.batch.count = n;
      columns.batch.normal_jump = {points.normal_jump.data(), 1};
      for (size_t k = 0; k < 2; ++k) columns.batch.slip_increment[k] = {points.slip[k].data(), 1};
      result.point_status.assign(n, 77);
      columns.batch.status = {result.point_status.data(), 1};
      for (size_t k = 0; k < 3; ++k) {
        result.traction[k].assign(n, kNan);
        columns.batch.traction_old[k] = {points.traction[k].data(), 1};
        columns.batch.traction_new[k] = {result.traction[k].data(), 1};
      }
      result.state.resize(law.state_count);
      for (uint64_t s = 0; s < law.state_count; ++s) {
        result.state[s].assign(n, kNan);
        columns.state_old[s] = {points.state[s].data(), 1};
        columns.state_new[s] = {result.state[s].data(), 1};
      }
      columns.batch.property_column_count = 1;
      columns.batch.property_columns = &column;
      report.expect(law.evaluate(material.handle, &columns.batch) == QUOIN_OK, "%s as a column is refused",
                    property.id);
      const Scales scales(law, material);
      for (size_t i = 0; i < n; ++i) {
        const bool refused = i % 2 == 1;
        report.expect((result.point_status[i] == QUOIN_POINT_FAILED) == refused, "%s = %g at point %zu: status %u",
                      property.id, values[i], i, result.point_status[i]);
        for (size_t k = 0; k < 3; ++k) {
          const double should = refused ? points.traction[k][i] : expected.traction[k][i];
          const double scale =
              scales.traction + std::abs(should) + scales.normal_stiffness * std::abs(points.normal_jump[i]);
          report.expect(std::abs(result.traction[k][i] - should) <= (refused ? 0 : 1e-9 * scale),
                        "%s = %g at point %zu: traction[%zu] is %.12g, a material of that value gives %.12g",
                        property.id, values[i], i, k, result.traction[k][i], should);
        }
      }
      report.expect(columns.batch.failed_count == n / 2, "%s: failed_count %llu of %zu", property.id,
                    static_cast<unsigned long long>(columns.batch.failed_count), n / 2);
    }
  }
  report.expect(tried > 0, "QUOIN_CAN_PROPERTY_COLUMNS, but no property is PER_POINT");
}

void check_failed_points(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  const Material material(law, subject.base);
  const Points good = scattered_points(law, material, 90, 700);
  const Result expected = evaluate(law, material, good);
  const size_t inputs = 6 + law.state_count;
  for (size_t input = 0; input < inputs; ++input) {
    if (input >= 6 && law.states[input - 6]->role != QUOIN_ROLE_HISTORY) continue;
    Points points = good;
    std::vector<double>& column = input == 0  ? points.normal_jump
                                  : input < 3 ? points.slip[input - 1]
                                  : input < 6 ? points.traction[input - 3]
                                              : points.state[input - 6];
    const std::string name = input == 0  ? "normal_jump"
                             : input < 3 ? "slip_increment"
                             : input < 6 ? "traction_old"
                                         : law.states[input - 6]->id;
    const double bad[3] = {kNan, kInfinity, -kInfinity};
    for (size_t i = 2; i < points.size(); i += 5) column[i] = bad[i % 3];
    const Result result = evaluate(law, material, points);
    uint64_t failed = 0, clamped = 0;
    uint32_t worst = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const bool is_bad = i % 5 == 2;
      if (is_bad) {
        report.clause("C7.1");
        // A law may not use old sigma and states: sigma follows from d_n, or a mode is switched off. Then the point
        // does not fail, and only the column itself may have the bad value.
        const bool may_be_unused = input == 3 || input >= 6;
        if (may_be_unused && result.point_status[i] == QUOIN_POINT_OK) {
          bool same = true;
          for (size_t k = 0; k < 3; ++k) same = same && result.traction[k][i] == expected.traction[k][i];
          for (size_t s = 0; s < points.state.size(); ++s) {
            same = same && (s + 6 == input || result.state[s][i] == expected.state[s][i]);
          }
          report.expect(same, "%s = %g: neither failed nor unused", name.c_str(), column[i]);
          continue;
        }
        report.expect(result.point_status[i] == QUOIN_POINT_FAILED, "%s = %g: status %u", name.c_str(), column[i],
                      result.point_status[i]);
        bool kept = true;
        for (size_t k = 0; k < 3; ++k) {
          kept = kept && std::memcmp(&result.traction[k][i], &points.traction[k][i], sizeof(double)) == 0;
        }
        for (size_t s = 0; s < points.state.size(); ++s) {
          kept = kept && (std::memcmp(&result.state[s][i], &points.state[s][i], sizeof(double)) == 0 ||
                          (std::isnan(result.state[s][i]) && std::isnan(points.state[s][i])));
        }
        report.expect(
            kept || (std::isnan(column[i]) && input >= 3 && input < 6 && std::isnan(result.traction[input - 3][i])),
            "%s = %g: traction and state are not the old ones", name.c_str(), column[i]);
        bool nothing = result.stored.empty() || result.stored[i] == 0;
        for (const auto& mode : result.dissipated) nothing = nothing && (mode.empty() || mode[i] == 0);
        for (const auto& entry : result.tangent) nothing = nothing && (entry.empty() || entry[i] == 0);
        for (const auto& mode : result.damage) nothing = nothing && (mode.empty() || mode[i] == 0);
        report.expect(nothing && (result.flags.empty() || result.flags[i] == 0),
                      "%s = %g: energy, dissipation, tangent, damage or flags are not 0", name.c_str(), column[i]);
      } else {
        report.clause("C7.2");
        const std::string what = difference(law, expected.take({i}), result.take({i}));
        report.expect(what.empty(), "%s is bad at other points: %s", name.c_str(), what.c_str());
      }
      failed += result.point_status[i] == QUOIN_POINT_FAILED;
      clamped += result.point_status[i] == QUOIN_POINT_CLAMPED;
      worst = std::max(worst, result.point_status[i]);
    }
    report.clause("C7.3");
    report.expect(result.status == QUOIN_OK, "a batch with failed points returns %d", result.status);
    report.expect(result.failed == failed && result.clamped == clamped && result.worst == worst,
                  "failed %llu of %llu, clamped %llu of %llu, worst %u of %u",
                  static_cast<unsigned long long>(result.failed), static_cast<unsigned long long>(failed),
                  static_cast<unsigned long long>(result.clamped), static_cast<unsigned long long>(clamped),
                  result.worst, worst);
    if (input >= 6 || input == 3) continue;
    const Result unasked = evaluate(law, material, points, 0);
    report.expect(unasked.failed == failed && unasked.worst == worst, "the summary is another one without status");
  }
}

}  // namespace check
