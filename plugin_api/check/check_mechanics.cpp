// C5.2, C5.3, C7.4, C8 and C9: what a law must do on paths.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "checks.h"

namespace check {
namespace {

// Returns the scale of rounding errors, Pa: strength, tractions, and the larger stiffness times all lengths of a point.
double traction_scale(const quoin_law& law, const Scales& scales, const Points& points, size_t i) {
  double length = std::abs(points.normal_jump[i]) + std::abs(points.slip[0][i]) + std::abs(points.slip[1][i]);
  for (uint64_t s = 0; s < law.state_count; ++s) {
    if (std::strcmp(law.states[s]->unit, "m") == 0) length += std::abs(points.state[s][i]);
  }
  return scales.traction + std::max(scales.normal_stiffness, scales.shear_stiffness) * length +
         std::abs(points.traction[0][i]) + std::hypot(points.traction[1][i], points.traction[2][i]);
}

double work_of_step(const Walk& walk, const Points& points, const Result& result, size_t i) {
  return (points.traction[0][i] + result.traction[0][i]) / 2 * (points.normal_jump[i] - walk.normal_before[i]) +
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

}  // namespace

namespace {

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

}  // namespace

void check_paths(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  for (uint64_t initial = 0; initial < law.initial_state_count; ++initial) {
    for (size_t m = 0; m < subject.varied.size(); ++m) {
      const Material material(law, subject.varied[m]);
      const Scales scales(law, material);
      constexpr size_t kCount = 100;
      constexpr int kSteps = 25, kLegs = 10;
      Walk walk(law, material, kCount, 1000 + 10 * initial + m, kSteps, law.initial_states[initial]);
      std::mt19937_64 random(m);
      std::vector<double> angle(kCount), range(law.state_count, 0.0);
      for (double& a : angle) a = uniform(random, 0, 6.283185307179586);
      for (int step = 0; step < kSteps * kLegs; ++step) {
        walk.aim();
        const Points& points = walk.points;
        const Result result = evaluate(law, material, points);

        const bool history_moved = expect_sound(report, law, points, result, &range);
        report.clause("C7.4");
        report.expect(result.any_yielding != 0 || !history_moved, "any_yielding is 0, but a monotonic state grew");
        bool flagged = false;
        for (const uint32_t flags : result.flags) flagged = flagged || (flags & QUOIN_FLAG_YIELDING);
        report.expect(result.any_yielding != 0 || !flagged, "any_yielding is 0, but a point has the flag YIELDING");
        report.expect(result.flags.empty() || result.any_yielding == 0 || flagged,
                      "any_yielding is %u, but no point has the flag YIELDING", result.any_yielding);

        // A second step from the end of the first, without a change of d_n and without sliding.
        report.clause("C8.1");
        Points still = points;
        still.traction = result.traction;
        still.state = result.state;
        for (auto& column : still.slip) std::fill(column.begin(), column.end(), 0.0);
        const Result stayed = evaluate(law, material, still);
        for (size_t i = 0; i < kCount; ++i) {
          const double scale = traction_scale(law, scales, still, i);
          for (size_t k = 0; k < 3; ++k) {
            report.expect(std::abs(stayed.traction[k][i] - still.traction[k][i]) <= 1e-9 * scale,
                          "traction[%zu] goes from %.12g to %.12g", k, still.traction[k][i], stayed.traction[k][i]);
          }
          for (uint64_t s = 0; s < law.state_count; ++s) {
            report.expect(std::abs(stayed.state[s][i] - still.state[s][i]) <= 1e-9 * range[s],
                          "%s goes from %.12g to %.12g", law.states[s]->id, still.state[s][i], stayed.state[s][i]);
          }
          report.expect(stayed.dissipation(i) <= 1e-9 * scale * scale / scales.normal_stiffness,
                        "%g J/m2 are dissipated", stayed.dissipation(i));
        }

        report.clause("C8.2");
        const Result turned = evaluate(law, material, rotated(law, points, angle));
        Points should = points;
        should.traction = result.traction;
        should.state = result.state;
        const Points turned_back = rotated(law, should, angle);
        for (size_t i = 0; i < kCount; ++i) {
          const double scale = traction_scale(law, scales, points, i);
          for (size_t k = 0; k < 3; ++k) {
            report.expect(std::abs(turned.traction[k][i] - turned_back.traction[k][i]) <= 1e-9 * scale,
                          "turned by %.4f rad: traction[%zu] is %.12g, not %.12g", angle[i], k, turned.traction[k][i],
                          turned_back.traction[k][i]);
          }
          for (uint64_t s = 0; s < law.state_count; ++s) {
            report.expect(std::abs(turned.state[s][i] - turned_back.state[s][i]) <= 1e-9 * range[s],
                          "turned by %.4f rad: %s is %.12g, not %.12g", angle[i], law.states[s]->id, turned.state[s][i],
                          turned_back.state[s][i]);
          }
        }

        report.clause("C8.4");
        for (size_t i = 0; i < kCount; ++i) {
          const double scale = traction_scale(law, scales, points, i);
          for (size_t mode = 0; mode < result.dissipated.size(); ++mode) {
            if (result.dissipated[mode].empty()) continue;
            report.expect(result.dissipated[mode][i] >= -1e-12 * scale * scale / scales.normal_stiffness,
                          "dissipated[%zu] = %g J/m2", mode, result.dissipated[mode][i]);
          }
        }
        walk.advance(result);
      }

      check_far(report, law, material, 6000 + 10 * initial + m, law.initial_states[initial]);

      // Sliding along s alone does not change tau_t.
      report.clause("C8.2");
      Walk plane(law, material, kCount, 2000 + m, kSteps, law.initial_states[initial]);
      for (int step = 0; step < kSteps * 4; ++step) {
        plane.aim();
        std::fill(plane.points.slip[1].begin(), plane.points.slip[1].end(), 0.0);
        const Result result = evaluate(law, material, plane.points);
        for (size_t i = 0; i < kCount; ++i) {
          report.expect(result.traction[2][i] == 0, "d_t = 0 gives tau_t = %g", result.traction[2][i]);
        }
        plane.advance(result);
      }
    }
  }
  report.clause("C5.2");
  report.note("walked to %g MPa of elastic pressure, openings of %g mm and slips of %g mm", kFarPressure * 1e-6,
              kFarOpening * 1e3, kFarSlip * 1e3);
}

void check_energy(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  report.clause("C8.3");
  if (!(law.capabilities & QUOIN_CAN_ENERGY)) {
    report.skip("the law does not offer energies");
    return;
  }
  constexpr size_t kCount = 200;
  constexpr int kLegs = 6;
  for (const Settings& settings : subject.varied) {
    const Material material(law, settings);
    double error[4] = {0, 0, 0, 0};
    double worst = 0;
    for (int level = 0; level < 4; ++level) {
      const int steps = 60 << (2 * level);
      Walk walk(law, material, kCount, 3000, steps);
      std::vector<double> work(kCount, 0.0), dissipated(kCount, 0.0), stored(kCount, 0.0), largest(kCount, 0.0);
      const std::vector<double> first = evaluate(law, material, walk.points).stored;
      for (int step = 0; step < steps * kLegs; ++step) {
        walk.aim();
        const Result result = evaluate(law, material, walk.points, kEnergy);
        for (size_t i = 0; i < kCount; ++i) {
          work[i] += work_of_step(walk, walk.points, result, i);
          dissipated[i] += result.dissipation(i);
          stored[i] = result.stored[i];
          largest[i] = std::max(largest[i], std::abs(stored[i]));
        }
        walk.advance(result);
      }
      // A point that fails at its first step converts no energy but that of a step, which vanishes as its square.
      constexpr double kLeastShare = 1e-3;  // of the mean energy
      double mean = 0.0;
      for (size_t i = 0; i < kCount; ++i) mean += (dissipated[i] + largest[i]) / kCount;
      for (size_t i = 0; i < kCount; ++i) {
        const double scale = std::max(dissipated[i] + largest[i], kLeastShare * mean) + 1e-300;
        const double fault = std::abs(work[i] - (stored[i] - first[i]) - dissipated[i]) / scale;
        error[level] += fault / kCount;
        if (level == 3) worst = std::max(worst, fault);
      }
    }
    // Error without its first-order part.
    const double remainder = error[3] - (error[2] - error[3]) / 3;
    report.note("energy closure: mean error %.2e, %.2e, %.2e, %.2e of the energy at h, h/4, h/16, h/64; worst %.2e",
                error[0], error[1], error[2], error[3], worst);
    report.expect(error[3] < 1e-9 || (remainder < 0.4 * error[3] && error[3] < 0.05),
                  "the error of work against stored plus dissipated does not vanish with the step: %.3e, %.3e, %.3e, "
                  "%.3e of the energy at h, h/4, h/16, h/64",
                  error[0], error[1], error[2], error[3]);
  }
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
    constexpr size_t kCount = 200;
    Walk walk(law, material, kCount, 4000, 20);
    double seen_normal = 0, seen_shear = 0;
    size_t compared = 0, kinks = 0, jumps = 0;
    double largest_jump = 0;
    for (int step = 0; step < 200; ++step) {
      walk.aim();
      const Result base = evaluate(law, material, walk.points, kTangent);
      for (const double relative : {1e-2, 1e-5}) {
        for (size_t direction = 0; direction < 3; ++direction) {
          std::vector<double> delta(kCount);
          Points plus = walk.points, minus = walk.points;
          std::vector<double>& up = direction == 0 ? plus.normal_jump : plus.slip[direction - 1];
          std::vector<double>& down = direction == 0 ? minus.normal_jump : minus.slip[direction - 1];
          for (size_t i = 0; i < kCount; ++i) {
            const double length = scales.strengths[i % scales.strengths.size()] /
                                  (direction == 0 ? scales.normal_stiffness : scales.shear_stiffness);
            const double centre = up[i];
            up[i] += relative * length;
            down[i] -= relative * length;
            delta[i] = std::max(up[i] - centre, centre - down[i]);
          }
          const Result right = evaluate(law, material, plus, 0);
          const double bound = direction == 0 ? bounds.normal : bounds.shear;
          Points half = walk.points;
          for (size_t i = 0; i < kCount; ++i) {
            (direction == 0 ? half.normal_jump : half.slip[direction - 1])[i] += delta[i] / 2;
          }
          const Result halfway = evaluate(law, material, half, 0);
          for (size_t i = 0; i < kCount; ++i) {
            if (!(delta[i] > 0)) continue;
            const double rounding = 1e-14 * traction_scale(law, scales, walk.points, i) / delta[i];
            const double rise = right.traction[direction][i] - base.traction[direction][i];
            const double slope = rise / delta[i];
            const double near = (halfway.traction[direction][i] - base.traction[direction][i]) / (delta[i] / 2);
            // A jump in the first half is in `near` twice, one in the second half only in `slope`.
            const double without_jump = std::min({slope, near, 2 * slope - near});
            const double allowed = bound * (1 + 1e-6) + 3 * rounding;
            const bool is_slope = std::abs(slope - near) <= 0.02 * std::abs(slope) + rounding;
            if (slope > allowed && (!is_slope || without_jump <= allowed)) {
              ++jumps;
              largest_jump = std::max(largest_jump, rise - bound * delta[i]);
            }
            if (!is_slope) continue;
            double& seen = direction == 0 ? seen_normal : seen_shear;
            seen = std::max(seen, without_jump - rounding);
            report.clause("C8.5");
            report.expect(without_jump <= allowed, "%s: %.9g Pa/m is seen at d_n = %g, the bound is %.9g",
                          direction == 0 ? "d sigma / d d_n" : "d tau / d d_s", slope, walk.points.normal_jump[i],
                          bound);
          }
          if (base.tangent[0].empty() || relative > 1e-4) continue;
          const Result left = evaluate(law, material, minus, 0);
          report.clause("C8.6");
          const double stiffness = std::max(bounds.normal, bounds.shear);
          for (size_t i = 0; i < kCount; ++i) {
            // Near the apex of the friction cone the direction of slip changes within the difference quotient, so there
            // is no derivative.
            const double trial = std::hypot(walk.points.traction[1][i], walk.points.traction[2][i]) +
                                 bounds.shear * std::hypot(walk.points.slip[0][i], walk.points.slip[1][i]);
            const bool at_rest = trial < 100 * bounds.shear * delta[i];
            if (direction > 0 && at_rest) continue;
            for (size_t row = 0; row < 3; ++row) {
              const double after = (right.traction[row][i] - base.traction[row][i]) / delta[i];
              const double before = (base.traction[row][i] - left.traction[row][i]) / delta[i];
              const double rounding = 1e-13 * traction_scale(law, scales, walk.points, i) / delta[i];
              const double tolerance = 1e-3 * (stiffness + std::abs(after)) + rounding;
              if (!(std::abs(after - before) <= tolerance)) {
                ++kinks;  // a branch ends here: no derivative
                continue;
              }
              ++compared;
              report.expect(std::abs(base.tangent[3 * row + direction][i] - (after + before) / 2) <= 2 * tolerance,
                            "tangent[%zu] = %.6g, finite differences give %.6g (d_n = %g)", 3 * row + direction,
                            base.tangent[3 * row + direction][i], (after + before) / 2, walk.points.normal_jump[i]);
            }
          }
        }
      }
      walk.advance(base);
    }
    report.note("largest slopes seen: %.4g and %.4g Pa/m, bounds %.4g and %.4g", seen_normal, seen_shear, bounds.normal,
                bounds.shear);
    if (jumps > 0) {
      report.note(
          "%zu times a traction jumped up with a displacement, at most by %.4g Pa: no stiffness bound holds there",
          jumps, largest_jump);
    }
    report.clause("C8.6");
    if (law.capabilities & QUOIN_CAN_TANGENT) {
      report.expect(compared > kinks, "only %zu of %zu entries are smooth enough to compare", compared,
                    compared + kinks);
    } else {
      report.skip("the law does not offer the tangent");
    }
  }
}

void check_migration(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  report.clause("C9.1");
  if (!(law.capabilities & QUOIN_CAN_MIGRATE) || law.migrate_state == nullptr) {
    report.skip("the law does not offer migration");
    return;
  }
  const Material material(law, subject.base);
  const Scales scales(law, material);
  Points points = scattered_points(law, material, 100, 800);
  {
    // Points at the end of a step, as in a law swap.
    const Result end = evaluate(law, material, points);
    points.traction = end.traction;
    points.state = end.state;
  }
  const size_t n = points.size();
  std::vector<const char*> ids;
  for (uint64_t s = 0; s < law.state_count; ++s) ids.push_back(law.states[s]->id);
  for (const bool own : {true, false}) {
    std::vector<quoin_in> from;
    std::vector<quoin_out> to;
    Points after = points;
    for (uint64_t s = 0; s < law.state_count; ++s) {
      from.push_back({points.state[s].data(), 1});
      to.push_back({after.state[s].data(), 1});
    }
    std::vector<double> shift(n, 1e300), jump(n, 1e300);
    std::vector<uint32_t> status(n, 77);
    quoin_migration migration = {};
    migration.struct_size = sizeof migration;
    migration.count = n;
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
    Text text;
    const quoin_status result = law.migrate_state(material.handle, &migration, &text.text);
    const char* what = own ? "from itself" : "from a law without states";
    if (result != QUOIN_OK) {
      report.expect(!own && !text.str().empty(), "%s: refused (%d): %s", what, result, text.str().c_str());
      continue;
    }
    Points still = after;
    for (auto& column : still.slip) std::fill(column.begin(), column.end(), 0.0);
    for (size_t i = 0; i < n; ++i) {
      if (status[i] == QUOIN_POINT_OK) still.normal_jump[i] = points.normal_jump[i] + shift[i];
    }
    const Result stayed = evaluate(law, material, still);
    uint64_t failed = 0;
    for (size_t i = 0; i < n; ++i) {
      failed += status[i] == QUOIN_POINT_FAILED;
      if (own) {
        report.expect(status[i] == QUOIN_POINT_OK, "%s: point %zu is refused", what, i);
        for (uint64_t s = 0; s < law.state_count; ++s) {
          report.expect(after.state[s][i] == points.state[s][i], "%s: %s goes from %.17g to %.17g", what,
                        law.states[s]->id, points.state[s][i], after.state[s][i]);
        }
      }
      if (status[i] != QUOIN_POINT_OK) continue;
      const double scale = traction_scale(law, scales, still, i);
      for (size_t k = 0; k < 3; ++k) {
        report.expect(std::abs(stayed.traction[k][i] - points.traction[k][i]) <= 1e-9 * scale,
                      "%s: traction[%zu] goes from %.12g to %.12g", what, k, points.traction[k][i],
                      stayed.traction[k][i]);
      }
      report.expect(std::isfinite(jump[i]) && jump[i] != 1e300, "%s: the energy jump is not written", what);
    }
    report.expect(migration.failed_count == failed, "%s: failed_count %llu, %llu points have failed", what,
                  static_cast<unsigned long long>(migration.failed_count), static_cast<unsigned long long>(failed));
  }
}

}  // namespace check
