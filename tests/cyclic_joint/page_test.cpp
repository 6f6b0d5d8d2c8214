// Every step of the law against an independent implementation of the law's page in long double, from the same old
// state.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "joints.h"

namespace {

using namespace quoin::cyclic;

struct Worst {
  double traction = 0.0, state = 0.0, energy = 0.0;
};

// A random walk to targets in a few steps each, so that every branch is entered from both sides.
struct Walk {
  Reach reach;
  double dn = 0.0, goal_n = 0.0, step_s = 0.0, step_t = 0.0;
  int left = 0;
  void aim(Random& random) {
    left = 1 + static_cast<int>(uniform(random, 0.0, 12.0));
    const double kind = uniform(random, 0.0, 1.0);
    if (kind < 0.30) goal_n = uniform(random, 0.0, 1.0) * reach.open * (kind < 0.15 ? 0.2 : 1.0);
    if (kind >= 0.30 && kind < 0.70) goal_n = -uniform(random, 0.0, 1.0) * reach.close * (kind < 0.55 ? 0.1 : 1.0);
    if (kind >= 0.70 && kind < 0.75) goal_n = 0.0;
    const double length = chance(random, 0.3) ? 0.0 : reach.slide * uniform(random, 0.01, 0.5);
    const double angle = chance(random, 0.5) ? M_PI * std::floor(uniform(random, 0.0, 2.0)) : uniform(random, 0.0, 7.0);
    step_s = length * std::cos(angle) / left, step_t = length * std::sin(angle) / left;
  }
  void next(Random& random) {
    if (left == 0) aim(random);
    dn += (goal_n - dn) / left--;
  }
};

TEST(Page, EveryStepOfRandomPaths) {
  const quoin_law& law = quoin::test::load_law("cyclic_joint");
  const int joints = static_cast<int>(60 * test_scale());
  const char* seed = std::getenv("QUOIN_TEST_SEED");
  Random random(seed == nullptr ? 20261122 : std::strtoull(seed, nullptr, 10));
  constexpr std::size_t kPoints = 8;
  Worst worst;
  long open = 0, slips = 0, crushed = 0, corners = 0, reseated = 0, gave_way = 0, steps = 0, ties = 0;
  for (int number = 0; number < joints; ++number) {
    const Joint joint = random_joint(random, chance(random, 0.5) ? 1.02 : 1.3);
    LawPoints points(law, joint, kPoints, chance(random, 0.2));
    std::vector<Walk> walks(kPoints, {reach_of(joint)});
    const double scale_n = normal_scale(joint), scale_t = shear_scale(joint);
    for (int step = 0; step < 60; ++step) {
      for (std::size_t i = 0; i < kPoints; ++i) {
        walks[i].next(random);
        points.batch.in[0][i] = walks[i].dn;
        points.batch.in[1][i] = walks[i].step_s;
        points.batch.in[2][i] = walks[i].step_t;
      }
      points.batch.evaluate(points.material);
      for (std::size_t i = 0; i < kPoints; ++i) {
        ++steps;
        History page = points.history(i);
        const History old = page;
        const Outcome o = update(joint, page, walks[i].dn, walks[i].step_s, walks[i].step_t);
        // A joint with h = 0 to rounding may be open in the law and closed in the other implementation.
        const Real h = walks[i].dn + old.w - uplift(old) - old.q;
        const Real reach_n = std::abs(static_cast<Real>(walks[i].dn)) + old.w + uplift(old) + old.q;
        if (std::abs(h) < 4e-16L * reach_n) {
          ++ties;
          continue;
        }
        const auto gap = [](double a, Real b) { return static_cast<double>(std::abs(a - b)); };
        // Rounding of d_n + w - v changes the stress by kn times the error.
        const double floor = 1e-13 * static_cast<double>(joint.kn) * (std::abs(walks[i].dn));
        const double traction =
            std::max({gap(points.out(0, i), o.sigma) / (scale_n + floor), gap(points.out(1, i), page.tau[0]) / scale_t,
                      gap(points.out(2, i), page.tau[1]) / scale_t});
        const Reach reach = reach_of(joint);
        const Real rows[] = {page.kappa, page.q, page.l, page.w, page.g[0], page.g[1], page.r_m, page.v_m};
        const double lengths[] = {reach.open,  reach.open,  reach.close, reach.close,
                                  reach.slide, reach.slide, reach.slide, reach.slide};
        double state = std::min(gap(points.state(0, i), page.xi),
                                gap(static_cast<double>(joint.f(points.state(0, i))), joint.f(page.xi)));
        for (int k = 1; k < 8; ++k) state = std::max(state, gap(points.state(k + 1, i), rows[k]) / lengths[k]);
        const double kappa = std::max(points.state(1, i), static_cast<double>(joint.u0()));
        state = std::max(state, gap(kappa, rows[0]) / lengths[0]);
        double energy = gap(points.stored(i), o.stored);
        for (int mode = 0; mode < 4; ++mode)
          energy = std::max(energy, gap(points.dissipated(mode, i), o.dissipated[mode]));
        energy /= scale_n * (reach.close + reach.open) + scale_t * reach.slide;
        worst.traction = std::max(worst.traction, traction);
        worst.state = std::max(worst.state, state);
        worst.energy = std::max(worst.energy, energy);
        open += o.open, slips += o.gamma > 0, crushed += page.l > old.l, corners += page.l > old.l && o.gamma > 0;
        reseated += uplift(page) < uplift(old), gave_way += !o.open && page.q < old.q;
        EXPECT_TRUE(traction < 1e-10 && state < 1e-9 && energy < 1e-10)
            << "joint " << number << " step " << step << " point " << i << ": traction " << traction << " state "
            << state << " energy " << energy << (o.open ? " open" : " closed") << "\n law " << points.out(0, i) << " "
            << points.out(1, i) << " " << points.out(2, i) << " xi " << points.state(0, i) << " q "
            << points.state(2, i) << " l " << points.state(3, i) << " w " << points.state(4, i) << " g "
            << points.state(5, i) << " r_m " << points.state(7, i) << " v_m " << points.state(8, i) << " E "
            << points.stored(i) << " " << points.dissipated(0, i) << " " << points.dissipated(1, i) << " "
            << points.dissipated(2, i) << " " << points.dissipated(3, i) << "\n page " << o.sigma << " " << page.tau[0]
            << " " << page.tau[1] << " xi " << page.xi << " q " << page.q << " l " << page.l << " w " << page.w << " g "
            << page.g[0] << " r_m " << page.r_m << " v_m " << page.v_m << " E " << o.stored << " " << o.dissipated[0]
            << " " << o.dissipated[1] << " " << o.dissipated[2] << " " << o.dissipated[3] << "\n old xi " << old.xi
            << " kappa " << old.kappa << " q " << old.q << " l " << old.l << " w " << old.w << " g " << old.g[0] << " "
            << old.g[1] << " r_m " << old.r_m << " v_m " << old.v_m << " tau " << old.tau[0] << " " << old.tau[1]
            << " dn " << walks[i].dn << " ds " << walks[i].step_s << " " << walks[i].step_t << "\n"
            << text_of(joint);
        if (::testing::Test::HasFailure() && std::getenv("QUOIN_TEST_ALL") == nullptr) return;
      }
      points.batch.advance();
    }
  }
  std::printf(
      "%ld steps: %ld open, %ld slip, %ld crush, %ld both, %ld reseat, %ld give way, %ld ties; traction %.1e, state "
      "%.1e, "
      "energy %.1e\n",
      steps, open, slips, crushed, corners, reseated, gave_way, ties, worst.traction, worst.state, worst.energy);
}

}  // namespace
