// The law against the independent reference, on random parameters and random paths.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "law_case.h"

namespace quoin::test {
namespace {

// Largest differences along one path, relative to the scales of its case.
struct Errors {
  double stress = 0.0, state = 0.0, energy = 0.0;
  // True within the tolerances of every path. Law and reference are of first order in the sub-step and have equal
  // sub-steps, at least 1000 for each increment. They differ by a few thousandths of the scales where a path changes
  // direction, softens or opens quickly, and much less elsewhere.
  bool small() const { return stress < 0.003 && state < 0.005 && energy < 0.01; }
  std::string text() const { return fmt::format("stress {:.2e}, state {:.2e}, energy {:.2e}", stress, state, energy); }
};

// Compares both along the path, with `refinement` times the sub-steps. details: prints every corner.
Errors compare(const Case& c, const std::vector<Jump>& path, int refinement, bool details) {
  MaterialPoint law = c.point();
  reference::Point reference = c.reference_point();
  Errors errors;
  double work = 1e-300;
  Jump last{0.0, 0.0, 0.0};
  for (const Jump& to : path) {
    const int substeps = substeps_between(c, last, to, refinement);
    for (int i = 1; i <= substeps; ++i) {
      const double x = static_cast<double>(i) / substeps;
      const auto between = [&](double a, double b) { return i == substeps ? b : a + (b - a) * x; };
      law.move_to(between(last.dn, to.dn), between(last.ds, to.ds), between(last.dt, to.dt));
    }
    reference.advance(to.dn, to.ds - last.ds, to.dt - last.dt, substeps);
    last = to;
    const auto& now = law.now();
    const auto gap = [](double a, reference::Real b) { return std::abs(a - static_cast<double>(b)); };
    const double normal = gap(now.traction[0], reference.sigma()) / c.normal_scale();
    const double shear =
        std::hypot(gap(now.traction[1], reference.tau_s()), gap(now.traction[2], reference.tau_t())) / c.shear_scale();
    errors.stress = std::max({errors.stress, normal, shear});
    const auto of = [&](const char* id) { return now.state[law.material().law().state_index(id)]; };
    // A joint that is crushed out without residual is at e = 0, with either sign by rounding. There v and w may
    // increase together by slip without effect, so their difference is compared.
    const bool crushed_out = c.p.fcr == 0 && c.wu() > 0.0 && c.f(of("w") / c.wu()) == 0.0;
    const double shift = gap(of("w") - of("v"), reference.w() - reference.v());
    const double parts[] = {gap(c.f(of("xi_t")), reference.strength_factor_tension()),
                            gap(c.f(of("xi_s")), reference.strength_factor_shear()),
                            (crushed_out ? shift : gap(of("w"), reference.w())) / c.closing_range(),
                            (crushed_out ? 0.0 : gap(of("v"), reference.v())) / c.sliding_range(),
                            gap(of("slip"), reference.slip()) / c.sliding_range()};
    errors.state = std::max(errors.state, *std::max_element(std::begin(parts), std::end(parts)));
    if (details) {
      fmt::print("  gap {:.2e}\n", fmt::join(parts, " "));
      fmt::print(
          "to {:.4e} {:.4e} {:.4e}\n  law {:.6e} {:.6e} {:.6e} | f {:.6f} {:.6f} w {:.5e} v {:.5e} slip {:.5e} | "
          "{:.5e} {:.5e} {:.5e} {:.5e}\n",
          to.dn, to.ds, to.dt, now.traction[0], now.traction[1], now.traction[2], c.f(of("xi_t")), c.f(of("xi_s")),
          of("w"), of("v"), of("slip"), now.dissipated[0], now.dissipated[1], now.dissipated[2], now.dissipated[3]);
      fmt::print(
          "  ref {:.6e} {:.6e} {:.6e} | f {:.6f} {:.6f} w {:.5e} v {:.5e} slip {:.5e} | {:.5e} {:.5e} {:.5e} {:.5e}\n",
          reference.sigma(), reference.tau_s(), reference.tau_t(), reference.strength_factor_tension(),
          reference.strength_factor_shear(), reference.w(), reference.v(), reference.slip(), reference.dissipated()[0],
          reference.dissipated()[1], reference.dissipated()[2], reference.dissipated()[3]);
    }
    double total = 0.0;
    for (int mode = 0; mode < 4; ++mode) total += static_cast<double>(reference.dissipated()[mode]);
    work = std::max(work, total);
    for (int mode = 0; mode < 4; ++mode) {
      errors.energy = std::max(errors.energy, gap(now.dissipated[mode], reference.dissipated()[mode]));
    }
  }
  const double amplification = 1.0 / (1.0 - std::min(0.99, c.nearness()));
  errors.stress /= amplification;
  errors.state /= amplification;
  // A path may dissipate nearly nothing: then the scale is the elastic energy at the strengths.
  const double elastic = c.shear_scale() * c.shear_scale() / static_cast<double>(c.p.ks);
  errors.energy /= (work + 0.01 * elastic) * amplification;
  return errors;
}

// One random case with its path.
struct Walk {
  int number;
  Case c;
  std::vector<Jump> path;
  Errors errors;

  Walk(unsigned seed, int number_, bool details) : number(number_), c(), path() {
    Random random(seed * 1000003u + number);
    c = random_case(random);
    path = random_path(c, random, 8);
    errors = compare(c, path, 1, details);
  }
};

// A path may end close to a drop of strength: an opening, an end of softening, a change of direction at S = 0. Law and
// reference may then be on different sides of it. Such a difference must vanish with smaller sub-steps. With more of
// them both are on one side, and the path has the tolerances of all others.
TEST(Reference, RandomPathsAndParameters) {
  const int paths = static_cast<int>(40 * test_scale());
  const char* first = std::getenv("QUOIN_TEST_SEED");
  const unsigned seed = first == nullptr ? 1u : static_cast<unsigned>(std::atoi(first));
  const char* only = std::getenv("QUOIN_TEST_PATH");  // number of the only path, whose corners are printed
  std::vector<double> stress_errors, state_errors, energy_errors;
  std::vector<Walk> outliers;
  for (int number = 0; number < paths; ++number) {
    if (only != nullptr && std::atoi(only) != number) continue;
    const Walk walk(seed, number, only != nullptr);
    if (!walk.errors.small()) outliers.push_back(walk);
    stress_errors.push_back(walk.errors.stress);
    state_errors.push_back(walk.errors.state);
    energy_errors.push_back(walk.errors.energy);
  }
  fmt::print("{} paths, {} outliers\n", stress_errors.size(), outliers.size());
  for (Walk& walk : outliers) fmt::print("path {}: {}\n", walk.number, walk.errors.text());
  ASSERT_LE(outliers.size(), 1 + stress_errors.size() / 50) << "more than ties";
  for (Walk& walk : outliers) {
    int refinement = 1;
    while (!walk.errors.small() && refinement < 256) {
      refinement *= 4;
      walk.errors = compare(walk.c, walk.path, refinement, only != nullptr);
      fmt::print("path {}, {} times the sub-steps: {}\n", walk.number, refinement, walk.errors.text());
      std::fflush(stdout);
    }
    EXPECT_TRUE(walk.errors.small()) << "path " << walk.number << " (seed " << seed << "): " << walk.c.text()
                                     << ", nearness " << walk.c.nearness() << ", " << walk.errors.text();
  }
  const auto hold = [](const char* what, std::vector<double> errors, double typical) {
    std::sort(errors.begin(), errors.end());
    const double median = errors[errors.size() / 2];
    fmt::print("{}: median {:.2e}, 90 % {:.2e}, 98 % {:.2e}, largest {:.2e}\n", what, median,
               errors[errors.size() * 9 / 10], errors[errors.size() * 98 / 100], errors.back());
    EXPECT_LT(median, typical) << what;
  };
  hold("stress error / strength", stress_errors, 0.00015);
  hold("state error / range", state_errors, 0.00025);
  hold("energy error / dissipated", energy_errors, 0.0005);
}

}  // namespace
}  // namespace quoin::test
