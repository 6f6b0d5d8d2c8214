// C5 to C7: states, purity, memory, threads, refusals, failed points.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <latch>
#include <limits>
#include <numeric>
#include <thread>
#include <utility>

#include "checks.h"

namespace check {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNeverWritten = -7.25e77;
constexpr uint32_t kUntouched = 0xdeadbeefu;

std::vector<size_t> all_indices(size_t n) {
  std::vector<size_t> indices(n);
  std::iota(indices.begin(), indices.end(), size_t{0});
  return indices;
}

// Points of a material and everything that they give, to compare with.
struct Example {
  Example(const quoin_law& l, const Material& m, size_t count, uint64_t seed)
      : law(l), material(m), points(scattered_points(l, m, count, seed)), all(evaluate(l, m, points)) {}
  const quoin_law& law;
  const Material& material;
  const Points points;
  const Result all;
};

// An array of n records of `fields` elements, with guard values before, between and behind the records.
struct Records {
  Records(size_t n, size_t fields, int64_t stride_sign, size_t gap)
      : count(n),
        stride(static_cast<int64_t>(fields + gap) * stride_sign),
        memory((fields + gap) * (n + 2) + 1, kNeverWritten) {
    // The odd offset gives every element the alignment of a double, not of a vector.
    first = memory.data() + (fields + gap) + 1;
    if (stride_sign < 0 && n > 0) first += (fields + gap) * (n - 1);
  }
  double* column(size_t field) { return first + field; }
  double& at(size_t field, size_t i) { return first[static_cast<int64_t>(field) + static_cast<int64_t>(i) * stride]; }
  void forget(size_t field) {
    for (size_t i = 0; i < count; ++i) at(field, i) = kNeverWritten;
  }
  bool only_guards() const {
    return std::all_of(memory.begin(), memory.end(), [](double value) { return value == kNeverWritten; });
  }
  size_t count;
  int64_t stride;
  std::vector<double> memory;
  double* first;
};

// Numbers of the fields of a record: all columns of a batch side by side. in_place: old and new are the same fields.
struct Layout {
  Layout(const quoin_law& law, bool in_place) {
    const auto take = [&](size_t count) { return std::exchange(fields, fields + count); };
    const bool energy = law.capabilities & QUOIN_CAN_ENERGY, tangents = law.capabilities & QUOIN_CAN_TANGENT;
    jump = take(1);
    slip = take(2);
    traction = take(3);
    state = take(law.state_count);
    traction_new = in_place ? traction : take(3);
    state_new = in_place ? state : take(law.state_count);
    stored = take(energy ? 1 : 0);
    dissipated = take(energy ? QUOIN_DISSIPATED_COUNT : 0);
    tangent = take(tangents ? 9 : 0);
  }
  size_t fields = 0;
  size_t jump, slip, traction, state, traction_new, state_new, stored, dissipated, tangent;
};

template <class Visit>
void visit_inputs(const Layout& layout, const Points& points, Columns& columns, const Visit& visit) {
  visit(layout.jump, points.normal_jump, columns.batch.normal_jump);
  for (size_t k = 0; k < 2; ++k) visit(layout.slip + k, points.slip[k], columns.batch.slip_increment[k]);
  for (size_t k = 0; k < 3; ++k) visit(layout.traction + k, points.traction[k], columns.batch.traction_old[k]);
  for (size_t s = 0; s < points.state.size(); ++s) visit(layout.state + s, points.state[s], columns.state_old[s]);
}

template <class Visit>
void visit_outputs(const quoin_law& law, const Layout& layout, Result& result, Columns& columns, const Visit& visit) {
  quoin_batch& batch = columns.batch;
  for (size_t k = 0; k < 3; ++k) visit(layout.traction_new + k, result.traction[k], batch.traction_new[k]);
  for (size_t s = 0; s < law.state_count; ++s) visit(layout.state_new + s, result.state[s], columns.state_new[s]);
  if (law.capabilities & QUOIN_CAN_ENERGY) {
    visit(layout.stored, result.stored, batch.energy_stored);
    for (size_t k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) {
      visit(layout.dissipated + k, result.dissipated[k], batch.dissipated[k]);
    }
  }
  if (law.capabilities & QUOIN_CAN_TANGENT) {
    for (size_t k = 0; k < 9; ++k) visit(layout.tangent + k, result.tangent[k], batch.tangent[k]);
  }
}

// Takes every stride-th word behind the first. Returns whether the words between them are untouched.
bool take_words(std::vector<uint32_t>& memory, size_t stride, std::vector<uint32_t>* taken) {
  for (size_t i = 1; i + 1 < memory.size(); i += stride) taken->push_back(std::exchange(memory[i], kUntouched));
  return std::ranges::all_of(memory, [](uint32_t word) { return word == kUntouched; });
}

// Evaluates with every column in one array of records, as a host with an array of structures does. in_place: old and
// new are the same memory. Sets *clean to whether inputs and guard values are unchanged.
Result evaluate_records(const quoin_law& law, const Material& material, const Points& points, int64_t sign, size_t gap,
                        bool in_place, bool* clean) {
  const size_t n = points.size();
  const Layout layout(law, in_place);
  Records records(n, layout.fields, sign, gap);
  Columns columns(law);
  columns.batch.count = n;
  visit_inputs(layout, points, columns, [&](size_t field, const std::vector<double>& values, quoin_in& column) {
    column = {records.column(field), records.stride};
    for (size_t i = 0; i < n; ++i) records.at(field, i) = values[i];
  });
  Result result = unwritten(law, n);
  visit_outputs(law, layout, result, columns, [&](size_t field, std::vector<double>&, quoin_out& column) {
    column = {records.column(field), records.stride};
  });
  std::vector<uint32_t> flags(3 * n + 2, kUntouched), status(2 * n + 2, kUntouched);
  const bool has_flags = law.capabilities & QUOIN_CAN_FLAGS;
  if (has_flags) columns.batch.flags = {flags.data() + 1, 3};
  columns.batch.status = {status.data() + 1, 2};

  result.status = law.evaluate(material.handle, &columns.batch);

  visit_outputs(law, layout, result, columns, [&](size_t field, std::vector<double>& values, quoin_out&) {
    values.resize(n);
    for (size_t i = 0; i < n; ++i) values[i] = records.at(field, i);
  });
  *clean = take_words(status, 2, &result.point_status) && (!has_flags || take_words(flags, 3, &result.flags));
  visit_inputs(layout, points, columns, [&](size_t field, const std::vector<double>& values, quoin_in&) {
    if (in_place && field >= layout.traction) return;  // an output too
    for (size_t i = 0; i < n; ++i) *clean = *clean && records.at(field, i) == values[i];
  });
  for (size_t f = 0; f < layout.fields; ++f) records.forget(f);
  *clean = *clean && records.only_guards();
  return result;
}

}  // namespace

void expect_same(Report& report, const quoin_law& law, const Result& expected, const Result& found,
                 const std::string& when) {
  const std::string what = difference(law, expected, found);
  report.expect(what.empty(), "%s: %s", when.c_str(), what.c_str());
}

namespace {

void check_initial_states(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  const Material material(law, subject.base);
  report.clause("C5.1");
  for (uint64_t k = 0; k < law.initial_state_count; ++k) {
    std::vector<double> values(law.state_count + 2, kNan);
    values.back() = kNeverWritten;
    report.expect(law.initial_state(material.handle, law.initial_states[k], values.data()) == QUOIN_OK, "%s: refused",
                  law.initial_states[k]);
    for (uint64_t s = 0; s < law.state_count; ++s) {
      report.expect(values[s] >= law.states[s]->lower && values[s] <= law.states[s]->upper && std::isfinite(values[s]),
                    "%s: %s = %g is not within its bounds %g to %g", law.initial_states[k], law.states[s]->id,
                    values[s], law.states[s]->lower, law.states[s]->upper);
    }
    report.expect(values.back() == kNeverWritten, "%s: more than state_count values are written",
                  law.initial_states[k]);
  }
  std::vector<double> values(law.state_count + 1);
  report.expect(law.initial_state(material.handle, "no_such_state", values.data()) == QUOIN_ERROR_ARGUMENT,
                "an unknown initial state is given");
}

// Each step of a walk again with a new material, as after a restart from saved columns.
void check_restored(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  report.clause("C5.4");
  for (const Settings& settings : subject.varied) {
    const Material kept(law, settings);
    Walk walk(law, kept, 40, 31, 10);
    for (int step = 0; step < 80; ++step) {
      walk.aim();
      const Result through = evaluate(law, kept, walk.points);
      const Material fresh(law, settings);
      const Result restored = evaluate(law, fresh, walk.points);
      expect_same(report, law, through, restored, "step " + std::to_string(step));
      walk.advance(through);
    }
  }
}

}  // namespace

void check_states(Report& report, const Subject& subject) {
  check_initial_states(report, subject);
  check_restored(report, subject);
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
    expect_same(report, law, expected, evaluate(law, material, points), "evaluated twice");
    for (const Material& other : materials) evaluate(law, other, scattered_points(law, other, 17, 5));
    expect_same(report, law, expected, evaluate(law, material, points), "after other materials and points");
    {
      const Material passing(law, subject.base);  // made and destroyed in between
      evaluate(law, passing, points);
    }
    expect_same(report, law, expected, evaluate(law, material, points),
                "after a material was made, used and destroyed");

    report.clause("C6.2");
    std::mt19937_64 random(m + 1);
    std::vector<size_t> shuffled = all_indices(kCount);
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    expect_same(report, law, expected.take(shuffled), evaluate(law, material, points.take(shuffled)), "shuffled");
    for (const size_t size : {1u, 2u, 3u, 7u, 8u, 64u, 333u, 999u}) {
      for (size_t begin = 0; begin < kCount; begin += size) {
        std::vector<size_t> part;
        for (size_t i = begin; i < std::min(begin + size, kCount); ++i) part.push_back(i);
        expect_same(report, law, expected.take(part), evaluate(law, material, points.take(part)),
                    "in batches of " + std::to_string(size));
      }
    }
  }
}

namespace {

void check_records(Report& report, const Example& example) {
  const size_t count = example.points.size();
  for (const int sign : {1, -1}) {
    for (const size_t gap : {0u, 1u, 5u}) {
      for (const bool in_place : {false, true}) {
        bool clean = true;
        report.clause(in_place ? "C6.4" : "C6.3");
        const Result result =
            evaluate_records(example.law, example.material, example.points, sign, gap, in_place, &clean);
        const std::string what = difference(example.law, example.all, result);
        report.expect(what.empty(), "%zu records%s, %s, gap %zu: %s", count, sign < 0 ? " backwards" : "",
                      in_place ? "in place" : "old and new apart", gap, what.c_str());
        report.clause("C6.6");
        report.expect(clean, "%zu records, gap %zu: an input or memory between the elements was written", count, gap);
      }
    }
  }
}

// Contiguous and in place, as a host with a structure of arrays does.
void check_in_place(Report& report, const Example& example) {
  report.clause("C6.4");
  const size_t count = example.points.size();
  Points in_place = example.points;
  Columns columns(example.law);
  columns.read(in_place);
  columns.write(in_place.traction, in_place.state);
  Result result;
  result.status = example.law.evaluate(example.material.handle, &columns.batch);
  result.traction = in_place.traction;
  result.state = in_place.state;
  expect_same(report, example.law, example.all, result, std::to_string(count) + " contiguous points in place");
}

// One value for all points.
void check_stride_0(Report& report, const Example& example) {
  report.clause("C6.3");
  Points same = example.points;
  std::fill(same.normal_jump.begin(), same.normal_jump.end(), example.points.normal_jump[0]);
  for (auto& column : same.slip) std::fill(column.begin(), column.end(), double{column[0]});
  const Result expected = evaluate(example.law, example.material, same);
  Result result = unwritten(example.law, same.size());
  Columns columns(example.law, same, result);
  columns.batch.normal_jump.stride = 0;
  for (quoin_in& column : columns.batch.slip_increment) column.stride = 0;
  result.status = example.law.evaluate(example.material.handle, &columns.batch);
  expect_same(report, example.law, expected, result,
              std::to_string(same.size()) + " points with repeated inputs (stride 0)");
}

}  // namespace

void check_memory(Report& report, const Subject& subject) {
  const Material material(subject.law, subject.base);
  for (const size_t count : {1u, 7u, 100u, 1000u}) {
    const Example example(subject.law, material, count, 200 + count);
    check_records(report, example);
    check_in_place(report, example);
    check_stride_0(report, example);
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

namespace {

void check_wanted(Report& report, const Example& example) {
  report.expect(example.all.status == QUOIN_OK, "everything wanted: returns %d", example.all.status);
  for (unsigned wanted = 0; wanted < kAll; ++wanted) {
    const Result some = evaluate(example.law, example.material, example.points, wanted);
    const std::string what = difference(example.law, example.all, some);
    report.expect(some.status == QUOIN_OK && what.empty(), "wanted only %s%s%s%s%s: %s",
                  wanted & kEnergy ? "energy " : "", wanted & kTangent ? "tangent " : "",
                  wanted & kFlags ? "flags " : "", wanted & kStatus ? "status " : "", wanted & kDamage ? "damage" : "",
                  what.c_str());
  }
}

void check_written(Report& report, const Result& all) {
  const auto finite = [](const std::vector<double>& column) {
    return std::all_of(column.begin(), column.end(), [](double value) { return std::isfinite(value); });
  };
  for (const auto& column : all.dissipated) report.expect(finite(column), "a dissipation is not written or not finite");
  for (const auto& column : all.tangent) report.expect(finite(column), "a tangent is not written or not finite");
  report.expect(finite(all.stored), "a stored energy is not written or not finite");
  for (const uint32_t flags : all.flags) report.expect(flags < 2 * QUOIN_FLAG_GAVE_WAY, "flags %x", flags);
}

// Evaluates with one optional output: `column` of the batch, into `values` of the result.
template <class Column, class Values>
Result evaluate_one(const Example& example, const Column& column, const Values& values) {
  Result result = unwritten(example.law, example.points.size());
  Columns columns(example.law, example.points, result);
  std::vector<double>& output = values(result);
  output.assign(example.points.size(), kNan);
  column(columns.batch) = {output.data(), 1};
  result.status = example.law.evaluate(example.material.handle, &columns.batch);
  return result;
}

void check_each_energy(Report& report, const Example& example) {
  if (!(example.law.capabilities & QUOIN_CAN_ENERGY)) return;
  for (size_t one = 0; one <= QUOIN_DISSIPATED_COUNT; ++one) {
    const Result result = evaluate_one(
        example,
        [&](quoin_batch& batch) -> quoin_out& { return one == 0 ? batch.energy_stored : batch.dissipated[one - 1]; },
        [&](Result& r) -> std::vector<double>& { return one == 0 ? r.stored : r.dissipated[one - 1]; });
    expect_same(report, example.law, example.all, result, "one energy output alone");
  }
}

void check_each_damage(Report& report, const Example& example) {
  for (size_t one = 0; one < QUOIN_DAMAGE_COUNT; ++one) {
    const Result result = evaluate_one(
        example, [&](quoin_batch& batch) -> quoin_out& { return batch.damage[one]; },
        [&](Result& r) -> std::vector<double>& { return r.damage[one]; });
    if (example.law.capabilities & QUOIN_CAN_DAMAGE) {
      expect_same(report, example.law, example.all, result, "one damage output alone");
    } else {  // a law of version 1.0 does not read the damage columns
      report.expect(result.status == QUOIN_ERROR_UNSUPPORTED || std::isnan(result.damage[one][0]),
                    "damage, which the capabilities do not offer, is written");
    }
  }
}

void check_unsupported(Report& report, const Example& example) {
  const uint64_t offered = example.law.capabilities;
  if ((offered & QUOIN_CAN_ENERGY) && (offered & QUOIN_CAN_TANGENT) && (offered & QUOIN_CAN_FLAGS)) return;
  Result result = unwritten(example.law, example.points.size());
  Columns columns(example.law, example.points, result);
  std::vector<double> data(example.points.size(), kNan);
  std::vector<uint32_t> flags(example.points.size());
  if (!(offered & QUOIN_CAN_FLAGS)) {
    columns.batch.flags = {flags.data(), 1};
  } else {
    (offered & QUOIN_CAN_ENERGY ? columns.batch.tangent[0] : columns.batch.energy_stored) = {data.data(), 1};
  }
  report.expect(example.law.evaluate(example.material.handle, &columns.batch) == QUOIN_ERROR_UNSUPPORTED,
                "an output that the capabilities do not offer is accepted");
}

void check_without_diagnostics(Report& report, const Example& example) {
  const quoin_law& law = example.law;
  report.clause("C6.8");
  bool diagnostics = false;
  Result result = unwritten(law, example.points.size());
  Columns columns(law, example.points, result);
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
  result.status = law.evaluate(example.material.handle, &columns.batch);
  expect_same(report, law, example.all, result, "without diagnostics");
}

}  // namespace

void check_optional(Report& report, const Subject& subject) {
  const Material material(subject.law, subject.base);
  report.clause("C6.7");
  const Example example(subject.law, material, 100, 400);
  check_wanted(report, example);
  check_written(report, example.all);
  check_each_energy(report, example);
  check_unsupported(report, example);
  check_each_damage(report, example);
  check_without_diagnostics(report, example);
}

namespace {

void check_empty_batch(Report& report, const quoin_law& law, const Material& material, const Points& points) {
  report.clause("C6.10");
  Result result = unwritten(law, points.size(), kNeverWritten);
  Columns columns(law, points, result);
  quoin_batch& batch = columns.batch;
  batch.count = 0;
  batch.failed_count = batch.clamped_count = 77;
  batch.worst_status = batch.any_yielding = 77;
  report.expect(law.evaluate(material.handle, &batch) == QUOIN_OK, "a batch of 0 is refused");
  report.expect(result.traction[0][0] == kNeverWritten, "a batch of 0 writes");
  report.expect(
      batch.failed_count == 0 && batch.clamped_count == 0 && batch.worst_status == 0 && batch.any_yielding == 0,
      "the summary of a batch of 0 is not 0");
  quoin_batch nothing = {};
  nothing.struct_size = sizeof nothing;
  report.expect(law.evaluate(material.handle, &nothing) == QUOIN_OK, "a batch of 0 without columns is refused");
  Columns null_columns(law);
  report.expect(law.evaluate(material.handle, &null_columns.batch) == QUOIN_OK,
                "a batch of 0 with null columns is refused");
}

void check_ill_formed_batches(Report& report, const quoin_law& law, const Material& material, const Points& points) {
  report.clause("C6.11");
  Result unused = unwritten(law, points.size());
  Columns good(law, points, unused);
  report.expect(law.evaluate(nullptr, &good.batch) == QUOIN_ERROR_ARGUMENT, "a null material is accepted");
  report.expect(law.evaluate(material.handle, nullptr) == QUOIN_ERROR_ARGUMENT, "a null batch is accepted");
  const auto expect_refused_batch = [&](const char* what, const std::function<void(Columns&)>& spoil) {
    Result result = unwritten(law, points.size(), kNeverWritten);
    Columns columns(law, points, result);
    spoil(columns);
    report.expect(law.evaluate(material.handle, &columns.batch) == QUOIN_ERROR_ARGUMENT, "%s: accepted", what);
    const auto written = [](const std::vector<double>& column) { return column[0] != kNeverWritten; };
    report.expect(std::ranges::none_of(result.traction, written) && std::ranges::none_of(result.state, written),
                  "%s: refused, but outputs were written", what);
  };
  expect_refused_batch("a batch of 64 bytes", [](Columns& c) { c.batch.struct_size = 64; });
  expect_refused_batch("null normal_jump", [](Columns& c) { c.batch.normal_jump.data = nullptr; });
  expect_refused_batch("null slip_increment[1]", [](Columns& c) { c.batch.slip_increment[1].data = nullptr; });
  expect_refused_batch("null traction_old[2]", [](Columns& c) { c.batch.traction_old[2].data = nullptr; });
  expect_refused_batch("null traction_new[0]", [](Columns& c) { c.batch.traction_new[0].data = nullptr; });
  expect_refused_batch("traction_new[1] with stride 0", [](Columns& c) { c.batch.traction_new[1].stride = 0; });
  if (law.state_count > 0) {
    expect_refused_batch("null state_old", [](Columns& c) { c.batch.state_old = nullptr; });
    expect_refused_batch("null state_new", [](Columns& c) { c.batch.state_new = nullptr; });
  }
  for (uint64_t s = 0; s < law.state_count; ++s) {
    if (law.states[s]->role != QUOIN_ROLE_HISTORY) continue;
    expect_refused_batch("a history state without old values", [&](Columns& c) { c.state_old[s].data = nullptr; });
    expect_refused_batch("a history state without new values", [&](Columns& c) { c.state_new[s].data = nullptr; });
    break;
  }
  const quoin_property_column unknown = {"no_such_property", {points.normal_jump.data(), 1}};
  expect_refused_batch("a property column of an unknown property", [&](Columns& c) {
    c.batch.property_column_count = 1;
    c.batch.property_columns = &unknown;
  });
}

void check_batches_of_other_versions(Report& report, const quoin_law& law, const Material& material,
                                     const Points& points) {
  report.clause("C6.11");
  Result result = unwritten(law, points.size());
  Columns old(law, points, result), newer(law, points, result);
  old.batch.struct_size = QUOIN_BATCH_SIZE_1_0;  // the memory behind may have any contents
  double behind = 77;
  for (auto& column : old.batch.damage) column = {&behind, 0};
  report.expect(law.evaluate(material.handle, &old.batch) == QUOIN_OK && behind == 77,
                "a batch of version 1.0 is refused, or read beyond its end");
  newer.batch.struct_size = sizeof newer.batch + 64;
  report.expect(law.evaluate(material.handle, &newer.batch) == QUOIN_OK, "a longer batch of a newer host is refused");
}

}  // namespace

void check_refusals(Report& report, const Subject& subject) {
  const Material material(subject.law, subject.base);
  const Points points = scattered_points(subject.law, material, 7, 500);
  check_empty_batch(report, subject.law, material, points);
  check_ill_formed_batches(report, subject.law, material, points);
  check_batches_of_other_versions(report, subject.law, material, points);
}

namespace {

// Settings with another value of one property. The other properties keep the material's values. So do those whose
// default is this property, where the law allows it: then *kept_values is true.
Settings with_value(const quoin_law& law, const Material& material, const char* id, const std::string& value,
                    bool* kept_values) {
  Settings settings = material.settings;
  settings[id] = value;
  Settings kept = settings;
  for (const quoin_property_info* follower : properties_of(law)) {
    if (follower->default_from == nullptr || std::strcmp(follower->default_from, id) != 0) continue;
    kept.emplace(follower->id, shortest(material.number(follower->id)));
  }
  *kept_values = Material(law, kept).handle != nullptr;
  return *kept_values ? kept : settings;
}

// Compares a column of this value with a material of it. Every second point has a value that must be refused.
// may_refuse: the law does not allow this value with the material's others, and may refuse it at other points too.
void check_property_column(Report& report, const quoin_law& law, const Material& material, const Points& points,
                           const quoin_property_info& property, double value, bool may_refuse, const Result& expected) {
  const size_t n = points.size();
  std::vector<double> bad = values_outside(property);
  bad.insert(bad.begin(), kNan);
  std::vector<double> values(n, value);
  for (size_t i = 1; i < n; i += 2) values[i] = bad[i / 2 % bad.size()];
  const quoin_property_column column = {property.id, {values.data(), 1}};
  Result result = unwritten(law, n);
  result.point_status.assign(n, 77);
  Columns columns(law, points, result);
  columns.batch.status = {result.point_status.data(), 1};
  columns.batch.property_column_count = 1;
  columns.batch.property_columns = &column;
  report.expect(law.evaluate(material.handle, &columns.batch) == QUOIN_OK, "%s as a column is refused", property.id);
  const Scales scales(law, material);
  size_t refusals = 0;
  for (size_t i = 0; i < n; ++i) {
    const bool refused = i % 2 == 1 || (may_refuse && result.point_status[i] == QUOIN_POINT_FAILED);
    refusals += refused;
    report.expect((result.point_status[i] == QUOIN_POINT_FAILED) == refused, "%s = %g at point %zu: status %u",
                  property.id, values[i], i, result.point_status[i]);
    for (size_t k = 0; k < 3; ++k) {
      const double should = refused ? points.traction[k][i] : expected.traction[k][i];
      const double scale =
          scales.traction + std::abs(should) + scales.normal_stiffness * std::abs(points.normal_jump[i]);
      report.expect(std::abs(result.traction[k][i] - should) <= (refused ? 0 : 1e-9 * scale),
                    "%s = %g at point %zu: traction[%zu] is %.12g, a material of that value gives %.12g", property.id,
                    values[i], i, k, result.traction[k][i], should);
    }
  }
  report.expect(columns.batch.failed_count == refusals, "%s: failed_count %llu of %zu", property.id,
                static_cast<unsigned long long>(columns.batch.failed_count), refusals);
}

}  // namespace

void check_property_columns(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  report.clause("C6.9");
  if (!(law.capabilities & QUOIN_CAN_PROPERTY_COLUMNS)) {
    report.skip("the law does not offer property columns");
    return;
  }
  const Material material(law, subject.base);
  const Points points = scattered_points(law, material, 60, 600);
  bool tried = false;
  for (const quoin_property_info* property : numbers_of(law)) {
    if (!(property->flags & QUOIN_PROPERTY_PER_POINT)) continue;
    const double base = material.number(property->id);
    for (const double factor : {1.0, 1.03, 0.98}) {
      if (factor != 1.0 && !std::isfinite(base)) break;
      const double value = base * factor;
      bool kept_values = false;
      const Material other(law, with_value(law, material, property->id, shortest(value), &kept_values));
      if (other.handle == nullptr) continue;
      tried = true;
      check_property_column(report, law, material, points, *property, value, !kept_values,
                            evaluate(law, other, points));
    }
  }
  report.expect(tried, "QUOIN_CAN_PROPERTY_COLUMNS, but no property is PER_POINT");
}

namespace {

// Inputs by number: normal_jump, two slip increments, three tractions, then the states.
constexpr size_t kFirstSlip = 1, kFirstTraction = 3, kFirstState = 6;

std::vector<double>& input_column(Points& points, size_t input) {
  if (input < kFirstSlip) return points.normal_jump;
  if (input < kFirstTraction) return points.slip[input - kFirstSlip];
  return input < kFirstState ? points.traction[input - kFirstTraction] : points.state[input - kFirstState];
}

const char* input_name(const quoin_law& law, size_t input) {
  if (input < kFirstSlip) return "normal_jump";
  if (input < kFirstTraction) return "slip_increment";
  return input < kFirstState ? "traction_old" : law.states[input - kFirstState]->id;
}

// A law may not use old sigma and states: sigma follows from d_n, or a mode is switched off.
bool may_be_unused(size_t input) { return input == kFirstTraction || input >= kFirstState; }

// An unused input: only its own column may have the bad value, and energies, tangent, damage and flags are the same.
void check_unused(Report& report, const Example& example, const Result& result, size_t input, double value, size_t i) {
  bool same = true;
  for (size_t k = 0; k < 3; ++k) same = same && result.traction[k][i] == example.all.traction[k][i];
  for (size_t s = 0; s < result.state.size(); ++s) {
    same = same && (s + kFirstState == input || result.state[s][i] == example.all.state[s][i]);
  }
  const auto same_column = [&](const auto& a, const auto& b) { return a.empty() || a[i] == b[i]; };
  const auto same_columns = [&](const auto& a, const auto& b) { return std::ranges::equal(a, b, same_column); };
  const Result& all = example.all;
  same = same && same_column(result.stored, all.stored) && same_columns(result.dissipated, all.dissipated) &&
         same_columns(result.tangent, all.tangent) && same_columns(result.damage, all.damage) &&
         same_column(result.flags, all.flags);
  report.expect(same, "%s = %g: neither failed nor unused", input_name(example.law, input), value);
}

void check_failed_point(Report& report, const Points& points, const Result& result, const char* name, size_t input,
                        double value, size_t i) {
  report.expect(result.point_status[i] == QUOIN_POINT_FAILED, "%s = %g: status %u", name, value,
                result.point_status[i]);
  const auto same_bits = [&](const std::vector<double>& a, const std::vector<double>& b) {
    return std::memcmp(&a[i], &b[i], sizeof(double)) == 0;
  };
  bool kept = true;
  for (size_t k = 0; k < 3; ++k) kept = kept && same_bits(result.traction[k], points.traction[k]);
  for (size_t s = 0; s < points.state.size(); ++s) {
    kept = kept && (same_bits(result.state[s], points.state[s]) ||
                    (std::isnan(result.state[s][i]) && std::isnan(points.state[s][i])));
  }
  const bool is_traction = input >= kFirstTraction && input < kFirstState;
  report.expect(kept || (std::isnan(value) && is_traction && std::isnan(result.traction[input - kFirstTraction][i])),
                "%s = %g: traction and state are not the old ones", name, value);
  const auto zero = [&](const auto& column) { return column.empty() || column[i] == 0; };
  report.expect(zero(result.stored) && std::ranges::all_of(result.dissipated, zero) &&
                    std::ranges::all_of(result.tangent, zero) && std::ranges::all_of(result.damage, zero) &&
                    zero(result.flags),
                "%s = %g: energy, dissipation, tangent, damage or flags are not 0", name, value);
}

void check_summary(Report& report, const Example& example, const Points& points, const Result& result) {
  report.clause("C7.3");
  const auto count = [&](uint32_t status) {
    return static_cast<unsigned long long>(std::ranges::count(result.point_status, status));
  };
  const unsigned long long failed = count(QUOIN_POINT_FAILED), clamped = count(QUOIN_POINT_CLAMPED);
  const uint32_t worst = std::ranges::max(result.point_status);
  report.expect(result.status == QUOIN_OK, "a batch with failed points returns %d", result.status);
  report.expect(result.failed == failed && result.clamped == clamped && result.worst == worst,
                "failed %llu of %llu, clamped %llu of %llu, worst %u of %u",
                static_cast<unsigned long long>(result.failed), failed, static_cast<unsigned long long>(result.clamped),
                clamped, result.worst, worst);
  const Result unasked = evaluate(example.law, example.material, points, 0);
  report.expect(unasked.failed == failed && unasked.worst == worst, "the summary is another one without status");
}

}  // namespace

void check_failed_points(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  const Material material(law, subject.base);
  const Example example(law, material, 90, 700);
  for (size_t input = 0; input < kFirstState + law.state_count; ++input) {
    if (input >= kFirstState && law.states[input - kFirstState]->role != QUOIN_ROLE_HISTORY) continue;
    Points points = example.points;
    const char* name = input_name(law, input);
    const auto is_bad = [](size_t i) { return i % 5 == 2; };
    constexpr double kBad[3] = {kNan, kInfinity, -kInfinity};
    std::vector<double>& column = input_column(points, input);
    for (size_t i = 0; i < points.size(); ++i) {
      if (is_bad(i)) column[i] = kBad[i % 3];
    }
    const Result result = evaluate(law, material, points);
    for (size_t i = 0; i < points.size(); ++i) {
      report.clause(is_bad(i) ? "C7.1" : "C7.2");
      if (!is_bad(i)) {
        expect_same(report, law, example.all.take({i}), result.take({i}),
                    name + std::string(" is bad at other points"));
      } else if (may_be_unused(input) && result.point_status[i] == QUOIN_POINT_OK) {
        check_unused(report, example, result, input, column[i], i);
      } else {
        check_failed_point(report, points, result, name, input, column[i], i);
      }
    }
    check_summary(report, example, points, result);
  }
}

}  // namespace check
