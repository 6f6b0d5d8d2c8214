// The law against an independent integration of its rate equations (rates.h), on mixed cyclic paths:
// contact_models/cyclic_joint/LAW.md, "What must hold", 6.
#include "rates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "joints.h"

namespace {

using namespace quoin::cyclic;

struct Jump {
  double n, s, t;
};
using Path = std::vector<Jump>;  // corners, with straight lines between them

// Returns a path of opening, closing and sliding in both directions, with growing amplitude. Pairs of corners have
// equal normal jumps, so that the joint slips also at constant normal jump.
Path mixed_path(const Joint& joint, Random& random) {
  const Reach reach = reach_of(joint);
  Path path;
  Jump at{0.0, 0.0, 0.0};
  for (int corner = 0; corner < 8; ++corner) {
    if (corner % 3 != 2) {
      const double size = uniform(random, 0.02, 0.1) * (1 + corner);
      at.n = chance(random, 0.4) ? 0.4 * reach.open * size : -0.4 * reach.close * size;
    }
    const double slide = reach.slide * uniform(random, 0.0, 0.5), angle = uniform(random, 0.0, 7.0);
    if (corner % 3 != 0) at.s += slide * std::cos(angle), at.t += slide * std::sin(angle);
    path.push_back(at);
  }
  return path;
}

// Largest differences at the corners, relative to the joint's scales.
struct Gap {
  double traction = 0.0, state = 0.0, energy = 0.0;
  double operator[](int k) const { return k == 0 ? traction : k == 1 ? state : energy; }
};

Gap compare(const quoin_law& law, const Joint& joint, bool dry, const Path& path, int increments, int pieces) {
  LawPoints points(law, joint, 1, dry);
  quoin::cyclic_rates::Point rates(rates_of(joint), dry);
  const Reach reach = reach_of(joint);
  const double scale_n = normal_scale(joint), scale_t = shear_scale(joint);
  double spent[4] = {0.0, 0.0, 0.0, 0.0};
  Gap gap;
  Jump from{0.0, 0.0, 0.0};
  for (const Jump& to : path) {
    auto& b = points.batch;
    for (int i = 1; i <= increments; ++i) {
      b.in[0][0] = i == increments ? to.n : from.n + (to.n - from.n) * i / increments;
      b.in[1][0] = (to.s - from.s) / increments, b.in[2][0] = (to.t - from.t) / increments;
      b.evaluate(points.material);
      for (int mode = 0; mode < 4; ++mode) spent[mode] += points.dissipated(mode, 0);
      b.advance();
    }
    rates.go(to.n, to.s - from.s, to.t - from.t, pieces);
    from = to;

    const History s = points.history(0);
    const auto off = [](double a, Real exact) { return static_cast<double>(std::abs(a - exact)); };
    const auto worst = [](double& most, double other) { most = std::max(most, other); };
    worst(gap.traction, off(b.in[3][0], rates.sigma()) / scale_n);
    worst(gap.traction, std::hypot(off(b.in[4][0], rates.tau()[0]), off(b.in[5][0], rates.tau()[1])) / scale_t);
    worst(gap.state, static_cast<double>(std::abs(joint.f(s.xi) - rates.bond())));
    worst(gap.state, off(b.in[8][0], rates.residual_opening()) / reach.open);
    worst(gap.state, off(b.in[9][0], rates.crushing()) / reach.close);
    worst(gap.state, off(b.in[10][0], rates.closure()) / reach.close);
    worst(gap.state, static_cast<double>(std::abs(uplift(s) - rates.uplift())) / reach.slide);
    worst(gap.state, off(b.in[15][0], rates.slip()) / reach.slide);
    Real total = 0;
    for (const Real mode : rates.dissipated()) total += mode;
    const double elastic = scale_t * scale_t / static_cast<double>(joint.ks);
    for (int mode = 0; mode < 4; ++mode) {
      worst(gap.energy, off(spent[mode], rates.dissipated()[mode]) / (static_cast<double>(total) + elastic));
    }
  }
  return gap;
}

// Both are of first order, the law in its increments and the reference in its pieces, eight in each increment. With
// eight times as many of both the difference falls by eight, for half of all paths from the first refinement on. Other
// paths soften within an increment or have a kink between two increments, and need more increments. Their difference
// falls by three at least, or is already small. The difference of a wrong law would not fall.
TEST(Rates, MixedCyclicPathsConvergeToTheRateEquations) {
  const quoin_law& law = quoin::test::load_law("cyclic_joint");
  const int paths = static_cast<int>(24 * test_scale());
  const char* seed = std::getenv("QUOIN_TEST_SEED");
  const char* only = std::getenv("QUOIN_TEST_PATH");
  constexpr int kFirst = 64, kFiner = 8, kLast = 1 << 15, kPieces = 8;  // kFirst to kLast increments between corners
  constexpr const char* kNames[] = {"traction", "state", "energy"};
  std::vector<double> orders[3], gaps[3];
  int slow = 0;
  for (int number = 0; number < paths; ++number) {
    if (only != nullptr && std::atoi(only) != number) continue;
    Random random((seed == nullptr ? 6 : std::strtoull(seed, nullptr, 10)) * 1000003 + number);
    const Joint joint = random_joint(random, 2.0);
    const bool dry = chance(random, 0.15);
    const Path path = mixed_path(joint, random);
    const auto gap_in = [&](int increments) {
      return compare(law, joint, dry, path, increments, kPieces * increments);
    };
    int increments = kFiner * kFirst;
    Gap before = gap_in(kFirst), after = gap_in(increments);
    for (int k = 0; k < 3; ++k) {
      orders[k].push_back(std::log(before[k] / after[k]) / std::log(static_cast<double>(kFiner)));
      gaps[k].push_back(after[k]);
    }
    const auto stays = [&](int k) { return after[k] > std::max(before[k] / 3.0, 3e-4); };
    const auto any_stays = [&] { return stays(0) || stays(1) || stays(2); };
    slow += any_stays();
    while (any_stays() && increments < kLast) before = after, increments *= kFiner, after = gap_in(increments);
    for (int k = 0; k < 3; ++k) {
      EXPECT_FALSE(stays(k)) << kNames[k] << " of path " << number << ": " << before[k] << ", in " << increments
                             << " increments " << after[k] << text_of(joint);
    }
  }
  const auto median = [](std::vector<double>& values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  };
  for (int k = 0; k < 3; ++k) {
    const double order = median(orders[k]), gap = median(gaps[k]);
    std::printf("%s: order, median %.2f, least %.2f; gap at %d increments a corner, median %.1e, largest %.1e\n",
                kNames[k], order, orders[k].front(), kFiner * kFirst, gap, gaps[k].back());
    EXPECT_TRUE(only != nullptr || order > 0.9) << kNames[k];
  }
  std::printf("%d of %d paths took more increments\n", slow, paths);
  EXPECT_LE(slow, 1 + paths / 6);
}

}  // namespace
