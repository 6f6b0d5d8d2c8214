// C5.2, C5.3, C7.4, C8 and C9: what a law must do on paths.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numeric>

#include "checks.h"

namespace check {
namespace {

// Returns the sum of all lengths of a point, m.
double length_of(const quoin_law& law, const Points& points, size_t i) {
  double length = std::abs(points.normal_jump[i]) + std::abs(points.slip[0][i]) + std::abs(points.slip[1][i]);
  for (uint64_t s = 0; s < law.state_count; ++s) {
    if (std::strcmp(law.states[s]->unit, "m") == 0) length += std::abs(points.state[s][i]);
  }
  return length;
}

// Returns the scale of rounding errors, Pa: strength, tractions, and the larger stiffness times all lengths of a point.
double traction_scale(const quoin_law& law, const Scales& scales, const Points& points, size_t i) {
  return scales.traction + std::max(scales.normal_stiffness, scales.shear_stiffness) * length_of(law, points, i) +
         std::abs(points.traction[0][i]) + std::hypot(points.traction[1][i], points.traction[2][i]);
}

double work_of_step(double normal_before, const Points& points, const Result& result, size_t i) {
  return (points.traction[0][i] + result.traction[0][i]) / 2 * (points.normal_jump[i] - normal_before) +
         (points.traction[1][i] + result.traction[1][i]) / 2 * points.slip[0][i] +
         (points.traction[2][i] + result.traction[2][i]) / 2 * points.slip[1][i];
}

// Returns the points with (s, t) of each rotated by its own angle.
Points rotated(const quoin_law& law, Points points, const std::vector<double>& angle) {
  const auto turn = [&](std::vector<double>& s, std::vector<double>& t) {
    for (size_t i = 0; i < s.size(); ++i) {
      const double c = std::cos(angle[i]), d = std::sin(angle[i]), x = s[i], y = t[i];
      s[i] = c * x - d * y;
      t[i] = d * x + c * y;
    }
  };
  turn(points.slip[0], points.slip[1]);
  turn(points.traction[1], points.traction[2]);
  for (uint64_t s = 0; s + 1 < law.state_count; ++s) {
    if (law.states[s]->kind == QUOIN_STATE_PAIR_S) turn(points.state[s], points.state[s + 1]);
  }
  return points;
}

// Returns the points at the end of a step, with nothing to do in the next one.
Points at_rest(Points points, const Result& result) {
  points.traction = result.traction;
  points.state = result.state;
  for (auto& column : points.slip) std::fill(column.begin(), column.end(), 0.0);
  return points;
}

// Expects results of points that are finite and within bounds, and states that do not decrease where they must not.
// Returns whether a monotonic state of the history has grown. range: largest magnitude so far, by state.
bool expect_sound(Report& report, const quoin_law& law, const Points& points, const Result& result,
                  std::vector<double>* range) {
  report.clause("C5.2");
  report.expect(result.status == QUOIN_OK && result.failed == 0, "returns %d, %llu points failed", result.status,
                static_cast<unsigned long long>(result.failed));
  for (size_t i = 0; i < points.size(); ++i) {
    for (size_t k = 0; k < 3; ++k) {
      report.expect(std::isfinite(result.traction[k][i]), "traction[%zu] = %g at d_n = %g after a slip of %g, %g", k,
                    result.traction[k][i], points.normal_jump[i], points.slip[0][i], points.slip[1][i]);
    }
  }
  bool history_moved = false;
  for (uint64_t s = 0; s < law.state_count; ++s) {
    const quoin_state_info& state = *law.states[s];
    for (size_t i = 0; i < points.size(); ++i) {
      const double before = points.state[s][i], after = result.state[s][i];
      report.clause("C5.2");
      report.expect(after >= state.lower && after <= state.upper && std::isfinite(after), "%s = %.17g outside %g to %g",
                    state.id, after, state.lower, state.upper);
      if (state.flags & QUOIN_STATE_MONOTONIC) {
        report.clause("C5.3");
        report.expect(after >= before, "%s goes from %.17g to %.17g", state.id, before, after);
        history_moved = history_moved || (after != before && state.role == QUOIN_ROLE_HISTORY);
      }
      (*range)[s] = std::max((*range)[s], std::abs(after));
    }
  }
  return history_moved;
}

// Walks far beyond the strengths.
void check_far(Report& report, const quoin_law& law, const Material& material, uint64_t seed, const char* initial) {
  constexpr size_t kCount = 100;
  constexpr int kSteps = 4, kLegs = 25;
  Walk walk(law, material, kCount, seed, kSteps, initial, Walk::Reach::far);
  std::vector<double> range(law.state_count, 0.0);
  for (int step = 0; step < kSteps * kLegs; ++step) {
    walk.aim();
    const Result result = evaluate(law, material, walk.points);
    expect_sound(report, law, walk.points, result, &range);
    walk.advance(result);
  }
}

// A step of a walk. range: largest magnitude of each state so far.
struct Step {
  const quoin_law& law;
  const Material& material;
  const Scales& scales;
  const Points& points;
  const Result& result;
  const std::vector<double>& range;
};

void check_yielding(Report& report, const Result& result, bool history_moved) {
  report.clause("C7.4");
  report.expect(result.any_yielding != 0 || !history_moved, "any_yielding is 0, but a monotonic state grew");
  const bool flagged =
      std::ranges::any_of(result.flags, [](uint32_t flags) { return (flags & QUOIN_FLAG_YIELDING) != 0; });
  report.expect(result.any_yielding != 0 || !flagged, "any_yielding is 0, but a point has the flag YIELDING");
  report.expect(result.flags.empty() || result.any_yielding == 0 || flagged,
                "any_yielding is %u, but no point has the flag YIELDING", result.any_yielding);
}

// A second step from the end of the first, without a change of d_n and without sliding.
void check_zero_increment(Report& report, const Step& step) {
  report.clause("C8.1");
  const Points still = at_rest(step.points, step.result);
  const Result stayed = evaluate(step.law, step.material, still);
  for (size_t i = 0; i < still.size(); ++i) {
    const double scale = traction_scale(step.law, step.scales, still, i);
    for (size_t k = 0; k < 3; ++k) {
      report.expect(std::abs(stayed.traction[k][i] - still.traction[k][i]) <= 1e-9 * scale,
                    "traction[%zu] goes from %.12g to %.12g", k, still.traction[k][i], stayed.traction[k][i]);
    }
    for (uint64_t s = 0; s < step.law.state_count; ++s) {
      report.expect(std::abs(stayed.state[s][i] - still.state[s][i]) <= 1e-9 * step.range[s],
                    "%s goes from %.12g to %.12g", step.law.states[s]->id, still.state[s][i], stayed.state[s][i]);
    }
    report.expect(stayed.dissipation(i) <= 1e-9 * scale * scale / step.scales.normal_stiffness,
                  "%g J/m2 are dissipated", stayed.dissipation(i));
  }
}

// Returns how point i of a turned step differs from what it should be; empty: not beyond rounding.
std::string turned_difference(const Step& step, const Result& turned, const Points& should, size_t i, size_t k_should) {
  char text[160] = "";
  const double scale = traction_scale(step.law, step.scales, step.points, i);
  const auto compare = [&](const char* what, double found, double expected, double allowed) {
    if (*text != 0 || std::abs(found - expected) <= allowed) return;
    std::snprintf(text, sizeof text, "%s is %.12g, not %.12g", what, found, expected);
  };
  static const char* const tractions[3] = {"traction[0]", "traction[1]", "traction[2]"};
  for (size_t k = 0; k < 3; ++k) {
    compare(tractions[k], turned.traction[k][i], should.traction[k][k_should], 1e-9 * scale);
  }
  for (uint64_t s = 0; s < step.law.state_count; ++s) {
    compare(step.law.states[s]->id, turned.state[s][i], should.state[s][k_should], 1e-9 * step.range[s]);
  }
  return text;
}

// The step again with (s, t) of each point turned by its angle, rad. Turning rounds. At a jump of the law, as where a
// joint opens, a rounding of d_n decides on the side. Then the turned step may be that of the other side.
void check_rotation(Report& report, const Step& step, const std::vector<double>& angle) {
  report.clause("C8.2");
  const quoin_law& law = step.law;
  const Result turned = evaluate(law, step.material, rotated(law, step.points, angle));
  const Points should = rotated(law, at_rest(step.points, step.result), angle);
  for (size_t i = 0; i < should.size(); ++i) {
    const std::string difference = turned_difference(step, turned, should, i, i);
    bool same = difference.empty();
    for (const double side : {-1.0, 1.0}) {
      if (same) break;
      Points other = step.points.take({i});
      other.normal_jump[0] += side * 1e-15 * length_of(law, step.points, i);
      const Result moved = evaluate(law, step.material, other);
      same = turned_difference(step, turned, rotated(law, at_rest(other, moved), {angle[i]}), i, 0).empty();
    }
    report.expect(same, "turned by %.4f rad: %s", angle[i], difference.c_str());
  }
}

void check_dissipation(Report& report, const Step& step) {
  report.clause("C8.4");
  for (size_t i = 0; i < step.points.size(); ++i) {
    const double scale = traction_scale(step.law, step.scales, step.points, i);
    for (size_t mode = 0; mode < step.result.dissipated.size(); ++mode) {
      const std::vector<double>& dissipated = step.result.dissipated[mode];
      if (dissipated.empty()) continue;
      report.expect(dissipated[i] >= -1e-12 * scale * scale / step.scales.normal_stiffness, "dissipated[%zu] = %g J/m2",
                    mode, dissipated[i]);
    }
  }
}

constexpr size_t kPathPoints = 100;
constexpr int kPathSteps = 25;  // a leg

// All clauses of a step, near the strengths. angle: of the turned step, rad.
void check_near(Report& report, const quoin_law& law, const Material& material, uint64_t seed, const char* initial,
                const std::vector<double>& angle) {
  constexpr int kLegs = 10;
  const Scales scales(law, material);
  Walk walk(law, material, kPathPoints, seed, kPathSteps, initial);
  std::vector<double> range(law.state_count, 0.0);
  for (int i = 0; i < kPathSteps * kLegs; ++i) {
    walk.aim();
    const Result result = evaluate(law, material, walk.points);
    const bool history_moved = expect_sound(report, law, walk.points, result, &range);
    check_yielding(report, result, history_moved);
    const Step step = {law, material, scales, walk.points, result, range};
    check_zero_increment(report, step);
    check_rotation(report, step, angle);
    check_dissipation(report, step);
    walk.advance(result);
  }
}

// Sliding along s alone does not change tau_t.
void check_plane(Report& report, const quoin_law& law, const Material& material, uint64_t seed, const char* initial) {
  report.clause("C8.2");
  constexpr int kLegs = 4;
  Walk plane(law, material, kPathPoints, seed, kPathSteps, initial);
  for (int step = 0; step < kPathSteps * kLegs; ++step) {
    plane.aim();
    std::fill(plane.points.slip[1].begin(), plane.points.slip[1].end(), 0.0);
    const Result result = evaluate(law, material, plane.points);
    for (const double tau_t : result.traction[2]) report.expect(tau_t == 0, "d_t = 0 gives tau_t = %g", tau_t);
    plane.advance(result);
  }
}

// A virgin point opens and closes. The change from d_n = 0 counts, so that the law may have an initial stress.
void check_sign(Report& report, const quoin_law& law, const Material& material) {
  report.clause("C3.2");
  const Scales scales(law, material);
  std::vector<double> lengths = {kFarPressure / scales.normal_stiffness};
  for (const double share : {1e-3, 1e-2, 0.1, 0.5}) {
    for (const double strength : scales.strengths) lengths.push_back(share * strength / scales.normal_stiffness);
  }
  const auto sigma_at = [&](double sign) {
    Points points = points_at(law, material, lengths.size(), nullptr);
    for (size_t i = 0; i < lengths.size(); ++i) points.normal_jump[i] = sign * lengths[i];
    return evaluate(law, material, points).traction[0];
  };
  const std::vector<double> still = sigma_at(0), opened = sigma_at(1), closed = sigma_at(-1);
  bool resists = false;
  for (size_t i = 0; i < lengths.size(); ++i) {
    const double pull = opened[i] - still[i], push = closed[i] - still[i];
    const double rounding = 1e-9 * scales.normal_stiffness * lengths[i];
    report.expect(pull >= -rounding, "d_n = %g m changes sigma by %g Pa: opening must give tension or nothing",
                  lengths[i], pull);
    report.expect(push <= rounding, "d_n = %g m changes sigma by %g Pa: closing must give compression", -lengths[i],
                  push);
    resists = resists || push < -rounding;
  }
  report.expect(resists, "closing by up to %g m gives no compression", lengths[0]);
}

}  // namespace

void check_paths(Report& report, const Subject& subject) {
  for (const Settings& settings : subject.varied) check_sign(report, subject.law, Material(subject.law, settings));
  for (uint64_t initial = 0; initial < subject.law.initial_state_count; ++initial) {
    const char* id = subject.law.initial_states[initial];
    for (size_t m = 0; m < subject.varied.size(); ++m) {
      const Material material(subject.law, subject.varied[m]);
      std::mt19937_64 random(m);
      std::vector<double> angle(kPathPoints);
      for (double& a : angle) a = uniform(random, 0, 6.283185307179586);
      check_near(report, subject.law, material, 1000 + 10 * initial + m, id, angle);
      check_far(report, subject.law, material, 6000 + 10 * initial + m, id);
      check_plane(report, subject.law, material, 2000 + m, id);
    }
  }
  report.clause("C5.2");
  report.note("walked to %g MPa of elastic pressure, openings of %g mm and slips of %g mm", kFarPressure * 1e-6,
              kFarOpening * 1e3, kFarSlip * 1e3);
}

namespace {

constexpr size_t kEnergyPoints = 200;
constexpr int kEnergyLegs = 6;

// Energies of the points of a walk so far, J/m2.
struct Energies {
  std::vector<double> work, dissipated, stored, largest;  // largest: stored at most
};

// How steps are divided: by four, again and again, where they leave more than `share` of a point's energy unbooked.
struct Division {
  double share = std::numeric_limits<double>::infinity();
  std::vector<double> energy;  // of the points, J/m2
  long left = 5'000'000;       // evaluations that divisions may still take
};
constexpr int kMostDivisions = 14;  // of a step into four

// Takes the step to `points` from the jumps `before`, in parts where division asks for them, and books its energies.
// which: the points in energies. divisions: how often the step is already divided.
Result take_step(const quoin_law& law, const Material& material, const Points& points,
                 const std::vector<double>& before, const std::vector<size_t>& which, Energies& energies,
                 Division& division, int divisions = 0) {
  Result result = evaluate(law, material, points, kEnergy);
  if (divisions > 0) division.left -= static_cast<long>(points.size());
  std::vector<size_t> coarse, coarse_which;
  for (size_t i = 0; i < points.size(); ++i) {
    const size_t e = which[i];
    const double work = work_of_step(before[i], points, result, i), dissipated = result.dissipation(i);
    const double unbooked = std::abs(work - (result.stored[i] - energies.stored[e]) - dissipated);
    if (divisions < kMostDivisions && division.left > 0 && unbooked > division.share * division.energy[e]) {
      coarse.push_back(i), coarse_which.push_back(e);
      continue;
    }
    energies.work[e] += work;
    energies.dissipated[e] += dissipated;
    energies.stored[e] = result.stored[i];
    energies.largest[e] = std::max(energies.largest[e], std::abs(result.stored[i]));
  }
  if (coarse.empty()) return result;

  constexpr int kParts = 4;
  Points part = points.take(coarse);
  const std::vector<double> end = part.normal_jump;
  for (auto& column : part.slip) {
    for (double& slip : column) slip /= kParts;
  }
  std::vector<double> from(coarse.size());
  for (size_t i = 0; i < coarse.size(); ++i) from[i] = before[coarse[i]];
  const std::vector<double> start = from;
  for (int k = 1; k <= kParts; ++k) {
    for (size_t i = 0; i < coarse.size(); ++i) {
      part.normal_jump[i] = k == kParts ? end[i] : start[i] + (end[i] - start[i]) * k / kParts;
    }
    const Result ended = take_step(law, material, part, from, coarse_which, energies, division, divisions + 1);
    from = part.normal_jump;
    part.traction = ended.traction;
    part.state = ended.state;
  }
  for (size_t i = 0; i < coarse.size(); ++i) {
    for (size_t k = 0; k < 3; ++k) result.traction[k][coarse[i]] = part.traction[k][i];
    for (size_t s = 0; s < part.state.size(); ++s) result.state[s][coarse[i]] = part.state[s][i];
  }
  return result;
}

// Energies of the points of a walk, J/m2.
struct Closure {
  std::vector<double> converted, error;  // stored at most and dissipated; work that is neither
};
// Walks the points `which` of the walk of kEnergyPoints points.
Closure closure_of(const quoin_law& law, const Material& material, int steps_per_leg, const std::vector<size_t>& which,
                   Division division) {
  const size_t count = which.size();
  Walk walk(law, material, kEnergyPoints, 3000, steps_per_leg);
  walk.keep(which);
  const std::vector<double> first = evaluate(law, material, walk.points).stored, none(count, 0.0);
  Energies energies = {none, none, first, none};
  std::vector<size_t> all(count);
  std::iota(all.begin(), all.end(), size_t{0});
  for (int step = 0; step < steps_per_leg * kEnergyLegs; ++step) {
    walk.aim();
    walk.advance(take_step(law, material, walk.points, walk.normal_before, all, energies, division));
  }
  Closure closure;
  for (size_t i = 0; i < count; ++i) {
    closure.converted.push_back(energies.dissipated[i] + energies.largest[i]);
    closure.error.push_back(std::abs(energies.work[i] - (energies.stored[i] - first[i]) - energies.dissipated[i]));
  }
  return closure;
}

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// Whether an error vanishes at first order: what remains without its first-order part is small. The steps of the last
// error are a quarter of those of the one before.
bool vanishes(double before, double last) {
  const double remainder = last - (before - last) / 3;
  return last < 1e-9 || (remainder < 0.4 * last && last < 0.05);
}

// Softening may be much shorter than the legs. So steps are refined until the order shows, or the error stands still,
// with the points that do not show the order. From kUniformLevels on only those steps are, whose energies do not close:
// the error falls with the root of the share that they may leave.
void check_closure(Report& report, const quoin_law& law, const Material& material) {
  constexpr int kCoarsest = 60;
  constexpr size_t kUniformLevels = 4, kMostLevels = 8;
  std::vector<size_t> which(kEnergyPoints);
  std::iota(which.begin(), which.end(), size_t{0});
  std::vector<double> before;
  std::string list;
  double least = 0.0;  // J/m2
  bool closes = false, stands = false;
  Division division;
  division.energy.assign(kEnergyPoints, 0.0);
  for (size_t level = 0; level < kMostLevels && !closes && !stands; ++level) {
    if (level >= kUniformLevels) division.share = 1e-5 / std::pow(16.0, static_cast<double>(level - kUniformLevels));
    const int steps = kCoarsest << (2 * std::min(level, kUniformLevels - 1));
    const Closure closure = closure_of(law, material, steps, which, division);
    // A point that fails at its first step converts no energy but that of a step, which vanishes as its square.
    if (level < kUniformLevels) least = 1e-3 * mean_of(closure.converted) + 1e-300;
    division.energy = closure.converted;
    std::vector<double> error;
    for (size_t i = 0; i < which.size(); ++i) {
      division.energy[i] = std::max(division.energy[i], least);
      error.push_back(closure.error[i] / division.energy[i]);
    }
    char text[64];
    std::snprintf(text, sizeof text, "%s%.2e (%zu points)", level == 0 ? "" : ", ", mean_of(error), which.size());
    list += text;
    if (level + 1 >= kUniformLevels) {
      closes = vanishes(mean_of(before), mean_of(error));
      stands = level >= kUniformLevels && mean_of(error) > 0.9 * mean_of(before);
      std::vector<size_t> left;
      std::vector<double> left_error, left_energy;
      for (size_t i = 0; i < which.size(); ++i) {
        if (vanishes(before[i], error[i])) continue;
        left.push_back(which[i]), left_error.push_back(error[i]), left_energy.push_back(division.energy[i]);
      }
      which = left, error = left_error, division.energy = left_energy;
    }
    before = error;
  }
  report.note("energy closure: mean error %s of the energy at h, h/4, h/16 ...", list.c_str());
  report.expect(closes,
                "the error of work against stored plus dissipated does not vanish with the step: %s of the energy at "
                "h, h/4, h/16 ...",
                list.c_str());
}

}  // namespace

void check_energy(Report& report, const Subject& subject) {
  report.clause("C8.3");
  if (!(subject.law.capabilities & QUOIN_CAN_ENERGY)) {
    report.skip("the law does not offer energies");
    return;
  }
  for (const Settings& settings : subject.varied) check_closure(report, subject.law, Material(subject.law, settings));
}

void check_damage(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  report.clause("C8.7");
  if (!(law.capabilities & QUOIN_CAN_DAMAGE)) {
    report.skip("the law does not offer damage");
    return;
  }
  struct Mode {
    const char* name;
    uint32_t begun, complete;
  };
  constexpr Mode kModes[QUOIN_DAMAGE_COUNT] = {{"tension", QUOIN_FLAG_TENSION_DAMAGED, QUOIN_FLAG_TENSION_COMPLETE},
                                               {"cohesion", QUOIN_FLAG_SHEAR_DAMAGED, QUOIN_FLAG_SHEAR_COMPLETE},
                                               {"crushing", QUOIN_FLAG_CRUSHED, QUOIN_FLAG_CRUSHING_COMPLETE}};
  constexpr size_t kCount = 100;
  for (const Settings& settings : subject.varied) {
    const Material material(law, settings);
    Walk walk(law, material, kCount, 5000, 20);
    std::array<std::vector<double>, QUOIN_DAMAGE_COUNT> before;
    before.fill(std::vector<double>(kCount, 0.0));
    for (int step = 0; step < 200; ++step) {
      walk.aim();
      const Result result = evaluate(law, material, walk.points, kDamage | kFlags);
      for (size_t k = 0; k < QUOIN_DAMAGE_COUNT; ++k) {
        const Mode& mode = kModes[k];
        for (size_t i = 0; i < kCount; ++i) {
          const double damage = result.damage[k][i];
          report.expect(damage >= 0 && damage <= 1, "damage in %s is %.17g", mode.name, damage);
          report.expect(damage >= before[k][i], "damage in %s falls from %.17g to %.17g", mode.name, before[k][i],
                        damage);
          before[k][i] = damage;
          if (result.flags.empty()) continue;
          const uint32_t flags = result.flags[i];
          report.expect(damage == 0 || (flags & mode.begun), "damage in %s is %g, and its flag is not set", mode.name,
                        damage);
          report.expect(damage == 1 || !(flags & mode.complete), "damage in %s is %g, and its flag says complete",
                        mode.name, damage);
        }
      }
      walk.advance(result);
    }
  }
}

namespace {

// What the steps of a walk have shown of the stiffness.
struct Seen {
  double normal = 0, shear = 0;  // largest slopes, Pa/m
  size_t jumps = 0;
  double largest_jump = 0;         // Pa
  size_t compared = 0, kinks = 0;  // entries of the tangent
};

// A step, and the same with a displacement of each point a little more and less.
struct Difference {
  const quoin_law& law;
  const Scales& scales;
  const quoin_stiffness_bounds& bounds;
  const Points& points;
  const Result& base;
  size_t direction;           // of the displacement: n, s, t
  std::vector<double> delta;  // change of the displacement, m
  Points plus, minus;
};

std::vector<double>& displacement(Points& points, size_t direction) {
  return direction == 0 ? points.normal_jump : points.slip[direction - 1];
}

// relative: change of the displacement, as a share of that at a strength.
Difference difference_of(const quoin_law& law, const Scales& scales, const quoin_stiffness_bounds& bounds,
                         const Points& points, const Result& base, size_t direction, double relative) {
  Difference step = {law, scales, bounds, points, base, direction, std::vector<double>(points.size()), points, points};
  std::vector<double>& up = displacement(step.plus, direction);
  std::vector<double>& down = displacement(step.minus, direction);
  for (size_t i = 0; i < points.size(); ++i) {
    const double length = scales.strengths[i % scales.strengths.size()] /
                          (direction == 0 ? scales.normal_stiffness : scales.shear_stiffness);
    const double centre = up[i];
    up[i] += relative * length;
    down[i] -= relative * length;
    step.delta[i] = std::max(up[i] - centre, centre - down[i]);
  }
  return step;
}

// right: results of step.plus.
void check_bound(Report& report, const Material& material, const Difference& step, const Result& right, Seen* seen) {
  report.clause("C8.5");
  const size_t direction = step.direction;
  const double bound = direction == 0 ? step.bounds.normal : step.bounds.shear;
  Points half = step.points;
  for (size_t i = 0; i < half.size(); ++i) displacement(half, direction)[i] += step.delta[i] / 2;
  const Result halfway = evaluate(step.law, material, half, 0);
  for (size_t i = 0; i < half.size(); ++i) {
    const double delta = step.delta[i];
    if (!(delta > 0) || std::hypot(half.slip[0][i], half.slip[1][i]) > step.scales.short_slip) continue;
    const double rounding = 1e-14 * traction_scale(step.law, step.scales, step.points, i) / delta;
    const double rise = right.traction[direction][i] - step.base.traction[direction][i];
    const double slope = rise / delta;
    const double near = (halfway.traction[direction][i] - step.base.traction[direction][i]) / (delta / 2);
    // A jump in the first half is in `near` twice, one in the second half only in `slope`.
    const double without_jump = std::min({slope, near, 2 * slope - near});
    const double allowed = bound * (1 + 1e-6) + 3 * rounding;
    const bool is_slope = std::abs(slope - near) <= 0.02 * std::abs(slope) + rounding;
    if (slope > allowed && (!is_slope || without_jump <= allowed)) {
      ++seen->jumps;
      seen->largest_jump = std::max(seen->largest_jump, rise - bound * delta);
    }
    if (!is_slope) continue;
    double& largest = direction == 0 ? seen->normal : seen->shear;
    largest = std::max(largest, without_jump - rounding);
    report.expect(without_jump <= allowed, "%s: %.9g Pa/m is seen at d_n = %g, the bound is %.9g",
                  direction == 0 ? "d sigma / d d_n" : "d tau / d d_s", slope, step.points.normal_jump[i], bound);
  }
}

// Difference quotients of an entry of the tangent on both sides of the step.
struct Quotient {
  double after, before, tolerance;
  bool is_smooth() const { return std::abs(after - before) <= tolerance; }  // else a branch ends here: no derivative
  double mean() const { return (after + before) / 2; }
  bool agrees(double tangent) const { return is_smooth() && std::abs(tangent - mean()) <= 2 * tolerance; }
};
// right, left: results of step.plus and step.minus.
Quotient quotient_of(const Difference& step, const Result& right, const Result& left, size_t i, size_t row) {
  const double delta = step.delta[i], centre = step.base.traction[row][i];
  const double after = (right.traction[row][i] - centre) / delta, before = (centre - left.traction[row][i]) / delta;
  const double rounding = 1e-13 * traction_scale(step.law, step.scales, step.points, i) / delta;
  const double stiffness = std::max(step.bounds.normal, step.bounds.shear);
  return {after, before, 1e-3 * (stiffness + std::abs(after)) + rounding};
}

constexpr double kTangentShare = 1e-5;  // displacement of the quotients, as a share of that at a strength

void check_tangent(Report& report, const Material& material, const Difference& step, const Result& right, Seen* seen) {
  report.clause("C8.6");
  struct Entry {
    size_t point, row;
    double quotient;
  };
  std::vector<Entry> off;
  const Points& points = step.points;
  const auto tangent = [&](const Entry& e) { return step.base.tangent[3 * e.row + step.direction][e.point]; };
  const Result left = evaluate(step.law, material, step.minus, 0);
  for (size_t i = 0; i < points.size(); ++i) {
    // Near the apex of the friction cone the direction of slip, or contact, changes within the difference quotient, so
    // there is no derivative.
    const double trial = std::hypot(points.traction[1][i], points.traction[2][i]) +
                         step.bounds.shear * std::hypot(points.slip[0][i], points.slip[1][i]);
    const double stress = step.direction > 0 ? trial : std::max(trial, std::abs(step.base.traction[0][i]));
    const double stiffness = step.direction > 0 ? step.bounds.shear : step.bounds.normal;
    const bool at_apex = stress < 100 * stiffness * step.delta[i];
    for (size_t row = 0; row < 3; ++row) {
      if (at_apex && (step.direction > 0 || row > 0)) continue;
      const Quotient quotient = quotient_of(step, right, left, i, row);
      ++(quotient.is_smooth() ? seen->compared : seen->kinks);
      const Entry entry = {i, row, quotient.mean()};
      if (!quotient.is_smooth()) continue;
      if (!quotient.agrees(tangent(entry))) {
        off.push_back(entry);
      } else {
        report.expect(true, "the tangent agrees");
      }
    }
  }
  // A branch may be shorter than the displacement, and its ends on both sides may hide from the quotients.
  for (double share = kTangentShare / 10; share > 1e-10 && !off.empty(); share /= 10) {
    const Difference finer =
        difference_of(step.law, step.scales, step.bounds, points, step.base, step.direction, share);
    const Result after = evaluate(step.law, material, finer.plus, 0),
                 before = evaluate(step.law, material, finer.minus, 0);
    std::erase_if(off,
                  [&](const Entry& e) { return quotient_of(finer, after, before, e.point, e.row).agrees(tangent(e)); });
  }
  for (const Entry& e : off) {
    report.expect(false, "tangent[%zu] = %.6g, finite differences give %.6g (d_n = %g)", 3 * e.row + step.direction,
                  tangent(e), e.quotient, points.normal_jump[e.point]);
  }
}

void report_seen(Report& report, const quoin_law& law, const quoin_stiffness_bounds& bounds, const Seen& seen) {
  report.note("largest slopes seen: %.4g and %.4g Pa/m, bounds %.4g and %.4g", seen.normal, seen.shear, bounds.normal,
              bounds.shear);
  if (seen.jumps > 0) {
    report.note(
        "%zu times a traction jumped up with a displacement, at most by %.4g Pa: no stiffness bound holds there",
        seen.jumps, seen.largest_jump);
  }
  report.clause("C8.6");
  if (law.capabilities & QUOIN_CAN_TANGENT) {
    report.expect(seen.compared > seen.kinks, "only %zu of %zu entries are smooth enough to compare", seen.compared,
                  seen.compared + seen.kinks);
  } else {
    report.skip("the law does not offer the tangent");
  }
}

}  // namespace

void check_stiffness(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  for (const Settings& settings : subject.varied) {
    const Material material(law, settings);
    const Scales scales(law, material);
    quoin_stiffness_bounds bounds = {sizeof bounds, 0, 0};
    report.clause("C8.5");
    report.expect(law.stiffness_bounds(material.handle, &bounds) == QUOIN_OK && bounds.normal > 0 && bounds.shear > 0 &&
                      std::isfinite(bounds.normal) && std::isfinite(bounds.shear),
                  "bounds %g and %g", bounds.normal, bounds.shear);
    Walk walk(law, material, 200, 4000, 20);
    Seen seen;
    for (int i = 0; i < 200; ++i) {
      walk.aim();
      const Result base = evaluate(law, material, walk.points, kTangent);
      for (const double relative : {1e-2, kTangentShare}) {
        for (size_t direction = 0; direction < 3; ++direction) {
          const Difference step = difference_of(law, scales, bounds, walk.points, base, direction, relative);
          const Result right = evaluate(law, material, step.plus, 0);
          check_bound(report, material, step, right, &seen);
          if (base.tangent[0].empty() || relative > kTangentShare) continue;
          check_tangent(report, material, step, right, &seen);
        }
      }
      walk.advance(base);
    }
    report_seen(report, law, bounds, seen);
  }
}

namespace {

// The columns that a migration reads and writes. own: from the same law; else from a law without states.
struct MigrationColumns {
  MigrationColumns(const quoin_law& law, const Points& points, bool own)
      : after(points), shift(points.size(), kNeverSet), jump(points.size(), kNeverSet), status(points.size(), 77) {
    for (uint64_t s = 0; s < law.state_count; ++s) {
      ids.push_back(law.states[s]->id);
      from.push_back({points.state[s].data(), 1});
      to.push_back({after.state[s].data(), 1});
    }
    migration.struct_size = sizeof migration;
    migration.count = points.size();
    migration.from_law = own ? law.id : "some_other_law";
    migration.from_schema = own ? law.state_schema : 1;
    migration.from_state_count = own ? law.state_count : 0;
    migration.from_state_ids = ids.data();
    migration.from_states = from.data();
    migration.normal_jump = {points.normal_jump.data(), 1};
    for (size_t k = 0; k < 3; ++k) migration.traction[k] = {points.traction[k].data(), 1};
    migration.normal_shift = {shift.data(), 1};
    migration.state_new = to.data();
    migration.energy_jump = {jump.data(), 1};
    migration.status = {status.data(), 1};
  }
  MigrationColumns(const MigrationColumns&) = delete;
  static constexpr double kNeverSet = 1e300;
  Points after;  // its states are the new ones
  std::vector<double> shift, jump;
  std::vector<uint32_t> status;
  quoin_migration migration = {};
  std::vector<const char*> ids;
  std::vector<quoin_in> from;
  std::vector<quoin_out> to;
};

void expect_kept_states(Report& report, const quoin_law& law, const char* what, const Points& points,
                        const MigrationColumns& columns, size_t i) {
  report.expect(columns.status[i] == QUOIN_POINT_OK, "%s: point %zu is refused", what, i);
  for (uint64_t s = 0; s < law.state_count; ++s) {
    const double before = points.state[s][i], after = columns.after.state[s][i];
    report.expect(after == before, "%s: %s goes from %.17g to %.17g", what, law.states[s]->id, before, after);
  }
}

void check_migrated(Report& report, const quoin_law& law, const Material& material, const Points& points, bool own) {
  MigrationColumns columns(law, points, own);
  Text text;
  const quoin_status result = law.migrate_state(material.handle, &columns.migration, &text.text);
  const char* what = own ? "from itself" : "from a law without states";
  if (result != QUOIN_OK) {
    report.expect(!own && !text.str().empty(), "%s: refused (%d): %s", what, result, text.str().c_str());
    return;
  }
  Points still = columns.after;
  for (size_t i = 0; i < still.size(); ++i) {
    if (columns.status[i] == QUOIN_POINT_OK) still.normal_jump[i] += columns.shift[i];
  }
  const Scales scales(law, material);
  const Result stayed = evaluate(law, material, still);
  for (size_t i = 0; i < still.size(); ++i) {
    if (own) expect_kept_states(report, law, what, points, columns, i);
    if (columns.status[i] != QUOIN_POINT_OK) continue;
    const double scale = traction_scale(law, scales, still, i);
    for (size_t k = 0; k < 3; ++k) {
      report.expect(std::abs(stayed.traction[k][i] - points.traction[k][i]) <= 1e-9 * scale,
                    "%s: traction[%zu] goes from %.12g to %.12g", what, k, points.traction[k][i],
                    stayed.traction[k][i]);
    }
    report.expect(std::isfinite(columns.jump[i]) && columns.jump[i] != columns.kNeverSet,
                  "%s: the energy jump is not written", what);
  }
  const auto failed =
      static_cast<unsigned long long>(std::ranges::count(columns.status, static_cast<uint32_t>(QUOIN_POINT_FAILED)));
  report.expect(columns.migration.failed_count == failed, "%s: failed_count %llu, %llu points have failed", what,
                static_cast<unsigned long long>(columns.migration.failed_count), failed);
}

}  // namespace

void check_migration(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  report.clause("C9.1");
  if (!(law.capabilities & QUOIN_CAN_MIGRATE) || law.migrate_state == nullptr) {
    report.skip("the law does not offer migration");
    return;
  }
  const Material material(law, subject.base);
  const Points points = scattered_points(law, material, 100, 800);
  // Points at the end of a step, as in a law swap.
  const Points ended = at_rest(points, evaluate(law, material, points));
  for (const bool own : {true, false}) check_migrated(report, law, material, ended, own);
}

}  // namespace check
