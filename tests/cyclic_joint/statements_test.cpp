// contact_models/cyclic_joint/LAW.md, "What must hold" and "Refused": a test for each statement, with the loaded
// library. By closed forms or by the inequalities of the law's page. Numbers in comments are those of the statements.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>

#include "joints.h"

namespace {

using namespace quoin::cyclic;

const quoin_law& law() {
  static const quoin_law& loaded = quoin::test::load_law("cyclic_joint");
  return loaded;
}

double real(Real x) { return static_cast<double>(x); }

enum { kTension, kCohesion, kFriction, kCrushing };
enum { kXi, kKappa, kQ, kL, kW, kGs, kGt, kRm, kVm, kSlip };

// One point on a path; sums dissipation and work.
struct Point {
  Joint joint;
  LawPoints points;
  double dn = 0.0, ds = 0.0, dt = 0.0, work = 0.0;
  double spent[4] = {0.0, 0.0, 0.0, 0.0};

  explicit Point(const Joint& j, bool dry = false) : joint(j), points(law(), j, 1, dry) {}
  double sigma() const { return points.batch.in[3][0]; }
  double tau_s() const { return points.batch.in[4][0]; }
  double tau() const { return std::hypot(points.batch.in[4][0], points.batch.in[5][0]); }
  double state(int k) const { return points.batch.in[6 + k][0]; }
  double stored() const { return points.stored(0); }
  double total() const { return spent[0] + spent[1] + spent[2] + spent[3]; }

  void step(double to_n, double to_s, double to_t = 0.0) {
    auto& b = points.batch;
    b.in[0][0] = to_n, b.in[1][0] = to_s - ds, b.in[2][0] = to_t - dt;
    b.evaluate(points.material);
    work += 0.5 * (b.in[3][0] + b.out[0][0]) * (to_n - dn) + 0.5 * (b.in[4][0] + b.out[1][0]) * (to_s - ds) +
            0.5 * (b.in[5][0] + b.out[2][0]) * (to_t - dt);
    dn = to_n, ds = to_s, dt = to_t;
    for (int mode = 0; mode < 4; ++mode) {
      EXPECT_GE(points.dissipated(mode, 0), 0.0);
      spent[mode] += points.dissipated(mode, 0);
    }
    b.advance();
  }
  void go(double to_n, double to_s, int steps, double to_t = 0.0) {
    const double n0 = dn, s0 = ds, t0 = dt;
    for (int i = 1; i <= steps; ++i) {
      const double x = static_cast<double>(i) / steps;
      step(n0 + (to_n - n0) * x, s0 + (to_s - s0) * x, t0 + (to_t - t0) * x);
    }
  }
};

Joint plain(Shape shape) {  // one mode at a time
  Joint j;
  j.kn = 82e9, j.ks = 36e9, j.ft = 0.2e6, j.c0 = 0.3e6, j.phi0 = j.phir = 35, j.G1 = 15, j.G2 = 125;
  j.shape = shape;
  if (shape == Shape::table) j.table = {{0, 1}, {0.25L, 0.6L}, {0.6L, 0.2L}, {1.5L, 0}};
  return j;
}
double far_end(const Joint& j) { return j.shape == Shape::exponential ? 60.0 : 1.2 * real(j.end()); }

class EveryShape : public ::testing::TestWithParam<std::tuple<int, int>> {
 protected:
  Shape shape() const { return static_cast<Shape>(std::get<0>(GetParam())); }
  int steps() const { return std::get<1>(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(ShapesSteps, EveryShape,
                         ::testing::Combine(::testing::Values(0, 1, 2), ::testing::Values(1, 2, 7, 100)));

// 1: the area under a curve is its G for any step. Residual opening does not reduce G1 until it decreases.
TEST_P(EveryShape, TensionEnclosesG1) {
  for (const double beta : {0.0, 0.4}) {
    Joint j = plain(shape());
    j.beta = beta;
    Point p(j);
    p.go(real(j.u0()) + far_end(j) * real(j.lt()), 0.0, steps());
    EXPECT_NEAR(p.spent[kTension] + p.stored(), 15.0, 1e-11);
    EXPECT_NEAR(p.state(kQ), real(j.beta * j.lt() * j.total_area()), 1e-12 * real(j.lt()));
    EXPECT_EQ(p.spent[kCohesion] + p.spent[kFriction] + p.spent[kCrushing], 0.0);
  }
}
TEST_P(EveryShape, ShearEnclosesG2AboveResidualAndFriction) {
  for (const double pressure : {0.0, 0.6e6}) {
    Joint j = plain(shape());
    j.cr = 0.05e6, j.phir = 25;
    Point p(j);
    p.go(-pressure / real(j.kn), 0.0, 1);
    const double reach = far_end(j) * real(j.su()) + (0.3e6 + 0.7002 * pressure) / real(j.ks);
    p.go(-pressure / real(j.kn), reach, steps());
    const double slip = p.state(kSlip), scale = 125.0 + (0.05e6 + pressure) * slip;
    EXPECT_NEAR(p.spent[kCohesion], 125.0 + 0.05e6 * slip, 1e-12 * scale);
    const double friction = pressure * (real(j.mur()) * slip + real((j.mu0() - j.mur()) * j.total_area() * j.su()));
    EXPECT_NEAR(p.spent[kFriction], friction, 1e-12 * scale);
  }
}
// Where c0 = cr the first slip takes the friction from mu0 to mur at once. The triangle between the elastic line and
// the strength, (p (mu0 - mur))^2/(2 ks), is spent as cohesion. It was booked nowhere: 8 % of the work.
TEST(Statement1, AFrictionThatIsLostAtTheFirstSlipIsSpent) {
  constexpr double kPressure = 1e6, kReach = 4e-5;
  for (const int steps : {1, 7, 2000}) {
    for (const double psi : {0.0, 20.0}) {
      Joint j = plain(Shape::linear);
      j.ft = j.c0 = j.cr = 0, j.phi0 = 40, j.phir = 25, j.psi0 = psi, j.sd = 1e-3;
      Point p(j);
      p.go(-kPressure / real(j.kn), 0.0, 1);
      const double stored = p.stored();
      p.work = 0.0;
      p.go(-kPressure / real(j.kn), kReach, steps);
      const double drop = kPressure * real(j.mu0() - j.mur());
      if (psi == 0.0) {
        EXPECT_NEAR(p.spent[kCohesion], drop * drop / (2.0 * real(j.ks)), 1e-12 * p.total());
        EXPECT_NEAR(p.spent[kFriction], kPressure * real(j.mur()) * p.state(kSlip), 1e-12 * p.total());
      }
      // The work is a sum of trapezia, whose error is of first order in the step at the drop.
      if (steps == 2000) {
        EXPECT_NEAR(p.work, p.stored() - stored + p.total(), 2e-4 * p.work) << psi;
      }
    }
  }
}
// fcr + (fc - fcr) is not fc to the last bit. An uncrushed joint took it for its strength beside a crushed one.
TEST(Statement1, ACrushedNeighbourChangesNoBit) {
  Joint j = plain(Shape::linear);
  j.fc = 869065.02965007734, j.fcr = 195749.60886004654, j.Gc = 675.67739807474857;
  ASSERT_NE(j.fcr + real(j.fc - j.fcr), j.fc);
  const double closing = -1.01 * real(j.fc / j.kn);
  Point alone(j);
  alone.step(closing, 0.0);
  LawPoints pair(law(), j, 2, false);
  pair.batch.in[6 + kL][1] = 1e-5;
  for (std::size_t i = 0; i < 2; ++i) pair.batch.in[0][i] = closing;
  pair.batch.evaluate(pair.material);
  EXPECT_EQ(pair.state(kL, 0), alone.state(kL));
  EXPECT_EQ(pair.out(0, 0), alone.sigma());
}
// A joint that is crushed to nothing stands at h = 0 and carries nothing, whether it opens, closes or slides. Its
// tangent was kn.
TEST(Statement1, AJointCrushedToNothingHasNoStiffness) {
  Joint j = plain(Shape::linear);
  j.fc = 5e6, j.Gc = 200;
  Point p(j);
  const double closing = -2.0 * real(j.wu());
  p.go(closing, 0.0, 100);
  for (const double slip : {0.0, 1e-5}) {
    p.step(closing, slip);
    ASSERT_EQ(p.sigma(), 0.0);
    for (int entry = 0; entry < 9; ++entry) EXPECT_EQ(p.points.tangent(entry, 0), 0.0) << entry << " slip " << slip;
  }
}
TEST_P(EveryShape, CrushingEnclosesGcHardeningIncluded) {
  Joint j = plain(shape());
  j.fc = 5e6, j.fcr = 0.5e6, j.Gc = 8000, j.fy = 2e6, j.wp = 0.09e-3L, j.chi = 0.5L;
  const double l = real(j.wp) + far_end(j) * real(j.wu());
  const double expected = real(j.F_area(0, l));
  EXPECT_NEAR(expected, real(j.wp * (j.fy + 2 * (j.fc - j.fy) / 3) + j.Gc + j.fcr * (l - j.wp)), 1e-9 * expected);
  Point p(j);
  // C(l) p + w = -d_n with dw = dl p (1/F - chi/(2 fc)), p = F: a closed form of two integrals.
  const double w = l - real(j.chi / (2 * j.fc) * j.F_area(0, l));
  p.go(-(w + real(j.compliance(l) * j.F(l))), 0.0, steps());
  EXPECT_NEAR(p.state(kL), l, 1e-11 * l);
  EXPECT_NEAR(p.state(kW), w, 1e-11 * l);
  EXPECT_NEAR(p.spent[kCrushing], expected, 1e-11 * expected);
}

// 1: crushing with slip dissipates Gc when F has fallen to fcr, for any ratio of pressure and shear. External work is
// stored plus dissipated energy, to first order.
TEST(Statement1, GcIsSpentUnderSlipToo) {
  for (const double angle : {0.2, 0.6, 1.1}) {
    Joint j = plain(Shape::linear);
    j.fc = 5e6, j.fcr = 0.5e6, j.Gc = 8000;
    double gap[2];
    int k = 0;
    for (const int steps : {2000, 8000}) {
      Point p(j);
      const double length = 12.0 * real(j.wu());
      p.go(-length * std::cos(angle), length * std::sin(angle), steps);
      EXPECT_GT(p.state(kL), real(j.wu()));
      EXPECT_NEAR(p.spent[kCrushing], 8000.0 + 0.5e6 * p.state(kL), 1e-9 * p.spent[kCrushing]);
      gap[k++] = std::abs(p.work - p.stored() - p.total()) / p.work;
    }
    EXPECT_LT(gap[1], 0.4 * gap[0] + 1e-12) << angle;
    EXPECT_LT(gap[1], 1e-2) << angle;
  }
}

// 2: monotonic opening with slip dissipates an energy between G1 and G2, for any ratio.
TEST(Statement2, MixedOpeningSpendsBetweenTheEnergies) {
  for (const double G2 : {15.0, 60.0, 125.0}) {
    for (const double degrees : {15.0, 30.0, 45.0, 60.0, 75.0, 85.0}) {
      for (const Shape shape : {Shape::linear, Shape::exponential}) {
        Joint j = plain(shape);
        j.G1 = 60, j.G2 = G2, j.ft = 0.16e6, j.c0 = 0.2e6;
        const double angle = degrees * M_PI / 180.0, far = shape == Shape::linear ? 4.0 : 40.0;
        Point p(j);
        p.go(far * real(j.lt()) * std::cos(angle), far * real(j.su()) * std::sin(angle), 20000);
        const double u = real(j.ft * j.u0() / 2), spent = p.total() + p.stored();
        EXPECT_GE(spent, std::min(60.0 - u, G2) * (1 - 1e-3)) << degrees;
        EXPECT_LE(spent, std::max(60.0, G2 + u) * (1 + 1e-3)) << degrees;
      }
    }
  }
}

// 3: in cycles over the seat the uplift does not change.
TEST(Statement3, TwentyEqualCyclesRepeatTheFirstUplift) {
  for (const bool dry : {false, true}) {
    Joint j = mortar();
    j.ks = 60e9, j.fc = std::numeric_limits<Real>::infinity(), j.fy = -1, j.wp = 0, j.chi = 0, j.psi0 = 10;
    Point p(j, dry);
    const double pressed = -0.2e6 / 82e9, amplitude = 0.5e-3;
    p.go(pressed, 0.0, 1);
    std::vector<double> highest;
    for (int cycle = 0; cycle < 20; ++cycle) {
      double most = 0.0;
      for (const double goal : {amplitude, -amplitude, 0.0}) {
        const double from = p.ds;
        for (int i = 1; i <= 50; ++i) {
          p.step(pressed, from + (goal - from) * i / 50);
          most = std::max(most, -p.sigma());
        }
      }
      highest.push_back(most);
    }
    ASSERT_GT(highest[0], 0.25e6);  // at constant d_n uplift causes pressure
    // Bond and friction soften in the first cycles; later ones have the uplift of the seat.
    for (std::size_t k = 2; k < highest.size(); ++k) EXPECT_NEAR(highest[k], highest[1], 1e-9 * highest[1]) << k;
    EXPECT_NEAR(p.state(kVm), real(uplift({0, 0, 0, 0, 0, {p.state(kRm), 0}, p.state(kRm), p.state(kVm), {0, 0}})),
                0.0);
  }
}

// 4 and 7, and no negative dissipation, on random paths of random joints.
TEST(Statement4And7, NothingBeyondTheSurfacesAndTheBounds) {
  Random random(4);
  double worst = 0.0;
  const int joints = static_cast<int>(150 * test_scale());  // with 1600 steps each
  for (int number = 0; number < joints; ++number) {
    const Joint j = random_joint(random, chance(random, 0.5) ? 1.02 : 1.3);
    LawPoints points(law(), j, 16, chance(random, 0.2));
    const Reach reach = reach_of(j);
    for (int step = 0; step < 100; ++step) {
      std::vector<double> trial(16);
      for (std::size_t i = 0; i < 16; ++i) {
        if (chance(random, 0.7))
          points.batch.in[0][i] =
              chance(random, 0.5) ? -reach.close * uniform(random, 0, 1) : reach.open * uniform(random, 0, 1);
        points.batch.in[1][i] = reach.slide * uniform(random, -0.3, 0.3);
        points.batch.in[2][i] = reach.slide * uniform(random, -0.3, 0.3);
        trial[i] = std::hypot(points.batch.in[4][i] + real(j.ks) * points.batch.in[1][i],
                              points.batch.in[5][i] + real(j.ks) * points.batch.in[2][i]);
      }
      points.batch.evaluate(points.material);
      points.batch.advance();
      for (std::size_t i = 0; i < 16; ++i) {
        const History s = points.history(i);
        const double sigma = points.batch.in[3][i], tau = std::hypot(points.batch.in[4][i], points.batch.in[5][i]);
        const Surfaces at = beyond_surfaces(j, s, sigma, tau, points.batch.in[0][i], trial[i]);
        worst = std::max(worst, at.over / at.scale);
        EXPECT_LE(at.over, 1e-11 * at.scale) << "joint " << number << text_of(j);
        EXPECT_EQ(beyond_bounds(j, s), nullptr) << "joint " << number << text_of(j);
        for (int mode = 0; mode < 4; ++mode) EXPECT_GE(points.dissipated(mode, i), 0.0);
      }
      if (HasFailure()) return;
    }
  }
  std::printf("largest excess %.1e of the scale\n", worst);
}

// A slip across the whole of a brittle cap: J rises at the end of gamma_A. The step must end on both surfaces.
TEST(Statement4, ALongSlipUnderTheCapEndsOnBothSurfaces) {
  Joint j;
  j.kn = 1.13e9, j.ks = 0.392e9, j.c0 = 1.55e6, j.cr = 0.56e6, j.phi0 = 27, j.phir = 23;
  j.fc = 10e6, j.fcr = 5e6, j.G2 = 63700, j.Gc = 22900, j.Cs = 23.5, j.shape = Shape::exponential;
  LawPoints points(law(), j, 1, false);
  points.batch.in[0][0] = -4e-3;
  points.batch.in[1][0] = 0.244;
  points.batch.in[6][0] = 5.7;  // xi
  points.batch.evaluate(points.material);
  points.batch.advance();
  const double sigma = points.batch.in[3][0], tau = points.batch.in[4][0], xi = points.batch.in[6][0];
  const double l = points.batch.in[6 + kL][0], mu = real(j.mur() + (j.mu0() - j.mur()) * j.f(xi));
  const double cohesion = real(j.cr + (j.c0 - j.cr) * j.bond(l) * j.f(xi));
  EXPECT_GT(l, 1e-3);
  EXPECT_NEAR(tau, cohesion - mu * sigma, 1e-9 * tau);
  EXPECT_NEAR(std::hypot(sigma, std::sqrt(real(j.Cs)) * tau), real(j.F(l)), 1e-9 * real(j.fc));
}

// A trial traction a million times beyond the cap is returned to the cap. The first guess of the crushing may be far
// inside it. The step is one that law_stress has found.
TEST(Statement4, ATrialFarBeyondTheCapEndsOnBothSurfaces) {
  Joint j;
  j.kn = 5.835e13, j.ks = 3.377e13, j.c0 = 90.67, j.phi0 = j.phir = 29.68, j.psi0 = 20.2;
  j.fc = 145056, j.fcr = 42418, j.G2 = 8.1093e-09, j.Gc = 0.0026619, j.pd = 40440, j.chi = 0.81592, j.Cs = 3.13834;
  j.sd = 1.3633, j.shape = Shape::exponential;
  LawPoints points(law(), j, 1, false);
  auto& b = points.batch;
  b.in[0][0] = -0.789471, b.in[1][0] = -0.13491, b.in[2][0] = -0.893055;
  const double old[] = {3.55e10, 0.4314, 0.0, 0.91737, 0.568491, -1.05516, 0.313681, 1.1008, 0.0179637, 0.0};
  for (std::size_t k = 0; k < std::size(old); ++k) b.in[6 + k][0] = old[k];
  b.evaluate(points.material);
  b.advance();
  const double sigma = b.in[3][0], tau = std::hypot(b.in[4][0], b.in[5][0]), mu = real(j.mur());
  EXPECT_GT(b.in[6 + kSlip][0], 0.1);
  // Tolerance 1e-11 of the elastic trial.
  EXPECT_NEAR(tau, -mu * sigma, 1e-11 * real(j.kn));
  EXPECT_NEAR(std::hypot(sigma, std::sqrt(real(j.Cs)) * tau), real(j.F(b.in[6 + kL][0])), 1e-11 * real(j.kn));
}

// A joint without crushing strength that is just closed slides over the middle of its seat and up the other side. The
// first guess of the crushing is NaN where pressure and strength are 0. The steps are those that law_stress has found.
TEST(Statement4, AJointCrushedToNothingSlidesUpTheOtherSideOfItsSeat) {
  Joint j;
  j.kn = 68719476736, j.ks = 7e10, j.phi0 = 35, j.phir = 30, j.psi0 = 4, j.fc = 1e6, j.fcr = 0, j.Gc = 1000;
  j.sd = 0.01, j.pd = 1e6, j.Cs = 5;
  for (const double slip : {8.012e-3, 8.06e-3, 8.2e-3, 9e-3}) {
    LawPoints points(law(), j, 1, false);
    auto& b = points.batch;
    b.in[0][0] = -0.0125, b.in[1][0] = slip;
    const double old[] = {1.0, 0.01, 0.0, 0.03, 0.0125, -4e-3, 0.0, 4e-3, 0.0, 0.1};
    for (std::size_t k = 0; k < std::size(old); ++k) b.in[6 + k][0] = old[k];
    b.evaluate(points.material);
    ASSERT_EQ(b.status[0], QUOIN_POINT_OK) << slip;
    b.advance();
    EXPECT_EQ(b.in[3][0], 0.0) << "it bears nothing";
    EXPECT_EQ(b.in[4][0], 0.0);
    EXPECT_NEAR(b.in[6 + kSlip][0], 0.1 + slip, 0.02 * slip);
    EXPECT_GT(b.in[6 + kVm][0], 0.0) << "it has climbed";
    EXPECT_GT(b.in[6 + kL][0], 0.03) << "and is crushed further";
  }
}

quoin_stiffness_bounds bounds_of(const LawPoints& points) {
  quoin_stiffness_bounds bounds = {sizeof bounds, 0, 0};
  EXPECT_EQ(law().stiffness_bounds(points.material.handle(), &bounds), QUOIN_OK);
  return bounds;
}

// "Stiffness bounds": no slope of random steps exceeds them, for slips up to which they hold.
TEST(StiffnessBounds, NoSlopeOfRandomStepsIsBeyond) {
  Random random(14);
  double most_open = 0.0, most_closed = 0.0;
  for (int number = 0; number < static_cast<int>(150 * test_scale()); ++number) {
    const Joint j = random_joint(random, chance(random, 0.5) ? 1.02 : 1.3);
    LawPoints points(law(), j, 16, chance(random, 0.2));
    const quoin_stiffness_bounds bounds = bounds_of(points);
    const Reach reach = reach_of(j);
    const bool any_slip = j.ft * j.mu0() < 0.75L * j.c0;
    for (int step = 0; step < 100; ++step) {
      for (std::size_t i = 0; i < 16; ++i) {
        if (chance(random, 0.7))
          points.batch.in[0][i] =
              chance(random, 0.5) ? -reach.close * uniform(random, 0, 0.2) : reach.open * uniform(random, 0, 0.1);
        points.batch.in[1][i] = reach.slide * uniform(random, -0.5, 0.5);
        points.batch.in[2][i] = reach.slide * uniform(random, -0.5, 0.5);
      }
      points.batch.evaluate(points.material);
      for (std::size_t i = 0; i < 16; ++i) {
        const double slip = points.state(kSlip, i) - points.batch.in[6 + kSlip][i];
        // With both surfaces active over a falling seat the law's page proves no bound; the largest known slope is 1.14
        // ks.
        constexpr std::uint32_t kFallingCorner = QUOIN_FLAG_SLIPPING | QUOIN_FLAG_CRUSHED | QUOIN_FLAG_RESEATING;
        const bool falling_corner = (points.batch.flags[i] & kFallingCorner) == kFallingCorner;
        const double shear = bounds.shear * (falling_corner ? 1.5 : 1.0 + 1e-9);
        if (!any_slip && slip > 4.0 * real(j.su())) continue;
        const double normal = points.tangent(0, i) / bounds.normal;
        double& most = points.out(0, i) > 0.0 ? most_open : most_closed;
        most = std::max(most, points.tangent(0, i) / real(j.kn));
        EXPECT_LE(normal, 1.0 + 1e-9) << "joint " << number << " slip " << slip << text_of(j);
        EXPECT_LE(points.tangent(4, i), shear) << "joint " << number << text_of(j);
        EXPECT_LE(points.tangent(8, i), shear) << "joint " << number << text_of(j);
      }
      if (HasFailure()) return;
      points.batch.advance();
    }
  }
  std::printf("steepest dsigma/dd_n: open %.2f kn, closed %.2f kn\n", most_open, most_closed);
  EXPECT_GT(most_open, 1.2);
  EXPECT_GT(most_closed, 1.2);
}
// The bond of a joint just below ft falls to nearly 0 in one slip. There the slope of open joints is equal to its
// bound, and to the formula of the law's page.
TEST(StiffnessBounds, SlipOfAnOpenJointReachesItsBound) {
  Joint j = plain(Shape::linear);
  j.phi0 = j.phir = 45;  // z = 2/3, k = 2/(1 - 1/9 c0/(ks su))
  LawPoints points(law(), j, 1, false);
  const double z = 2.0 / 3.0, su = real(j.su()), ks = real(j.ks), c0 = real(j.c0), T = c0 * (1 - z);
  const double k = z / ((1 - z) * (1 - (1 - z) * (1 - z) * c0 / (ks * su)));
  const double bound = bounds_of(points).normal;
  EXPECT_NEAR(bound, k * real(j.kn), 1e-12 * bound);
  points.batch.in[0][0] = real(j.u0()) * (1 - 1e-9);
  points.batch.in[1][0] = 0.999 * su * c0 / T;
  points.batch.evaluate(points.material);
  EXPECT_NEAR(points.tangent(0, 0), bound, 2e-3 * bound);
  EXPECT_LE(points.tangent(0, 0), bound);
}

// 5: increments of 1e-18 m change nothing: at the cap, at the corner, where contact is lost on the seat, and while the
// residual opening decreases.
TEST(Statement5, NoCreep) {
  struct Place {
    const char* name;
    std::function<void(Point&)> go;
  };
  const Joint j = [] {
    Joint m = mortar();
    m.ks = 60e9;  // no residual cohesion: an opening of 1e-18 m would lose it
    return m;
  }();
  const Place places[] = {{"cap", [&](Point& p) { p.go(-0.3e-3, 0.0, 40); }},
                          {"corner", [&](Point& p) { p.go(-0.2e-3, 0.4e-3, 200); }},
                          {"lost contact",
                           [&](Point& p) {
                             p.go(-1e-6, 0.0, 1), p.go(-1e-6, 1e-3, 200), p.go(real(p.state(kVm)) * 0.3, 1e-3, 20),
                                 p.go(p.dn, 0.5e-3, 100);
                           }},
                          {"gives way", [&](Point& p) {
                             p.go(0.15e-3, 0.0, 100);
                             p.go(0.5 * p.state(kQ), 0.0, 100);
                           }}};
  for (const Place& place : places) {
    Point p(j);
    place.go(p);
    std::vector<double> before;
    for (const auto& column : p.points.batch.in) before.push_back(column[0]);
    const double dn = p.dn;
    for (int k = 0; k < 20000; ++k) {
      auto& b = p.points.batch;
      b.in[0][0] = dn + (k % 2 == 0 ? 1e-18 : -1e-18);
      b.in[1][0] = k % 2 == 0 ? 1e-18 : -1e-18;
      b.in[2][0] = k % 3 == 0 ? 1e-18 : -0.5e-18;
      b.evaluate(p.points.material, false);
      b.advance();
    }
    const double lengths = 1e-3;
    for (std::size_t k = 3; k < before.size(); ++k) {
      const double scale = k < 6 ? 5e6 : k == 6 ? 1.0 : lengths;
      EXPECT_NEAR(p.points.batch.in[k][0], before[k], 1e-9 * scale) << place.name << ", column " << k;
    }
  }
}

// contact_models/fracture_energy/LAW.md, 4: rotation of (s, t).
TEST(Statement1, RotationTurnsAndChangesNothingElse) {
  Random random(9);
  double worst = 0.0;
  for (int number = 0; number < 60; ++number) {
    const Joint j = random_joint(random, 1.3);
    LawPoints points(law(), j, 16, false), turned(law(), j, 16, false);
    const Reach reach = reach_of(j);
    const double scale = shear_scale(j) + normal_scale(j);
    for (int step = 0; step < 40; ++step) {
      for (std::size_t i = 0; i < 16; ++i) {
        const double angle = 0.1 + 0.37 * static_cast<double>(i), c = std::cos(angle), s = std::sin(angle);
        if (chance(random, 0.7))
          points.batch.in[0][i] =
              chance(random, 0.5) ? -reach.close * uniform(random, 0, 1) : reach.open * uniform(random, 0, 1);
        for (int k : {1, 2}) points.batch.in[k][i] = reach.slide * uniform(random, -0.3, 0.3);
        for (std::size_t k = 0; k < points.batch.in.size(); ++k) turned.batch.in[k][i] = points.batch.in[k][i];
        for (const auto& [a, b] : {std::pair{1, 2}, {4, 5}, {11, 12}}) {
          turned.batch.in[a][i] = c * points.batch.in[a][i] - s * points.batch.in[b][i];
          turned.batch.in[b][i] = s * points.batch.in[a][i] + c * points.batch.in[b][i];
        }
      }
      points.batch.evaluate(points.material);
      turned.batch.evaluate(turned.material);
      for (std::size_t i = 0; i < 16; ++i) {
        const double angle = 0.1 + 0.37 * static_cast<double>(i), c = std::cos(angle), s = std::sin(angle);
        const double ts = points.out(1, i), tt = points.out(2, i);
        const History old = points.history(i);
        const double h = real(points.batch.in[0][i] + old.w - uplift(old) - old.q);
        if (std::abs(h) < 1e-14 * (reach.open + reach.close + reach.slide))
          continue;  // open in one, closed in the other
        const double gap =
            std::max({std::abs(turned.out(0, i) - points.out(0, i)), std::abs(turned.out(1, i) - (c * ts - s * tt)),
                      std::abs(turned.out(2, i) - (s * ts + c * tt))}) /
            scale;
        worst = std::max(worst, gap);
        EXPECT_LT(gap, 1e-9) << "joint " << number << text_of(j);
      }
      if (HasFailure()) return;
      points.batch.advance();
    }
  }
  std::printf("largest change by rotation %.1e\n", worst);
}

// "Refused": values just above and below every bound; the message has the name of the property.
TEST(Refused, EveryBound) {
  const auto made = [](const Joint& j, std::string* text = nullptr) {
    try {
      const quoin::api::Material material = quoin::test::make_material(law(), values_of(j));
      if (text != nullptr) *text = material.warnings();
      return true;
    } catch (const quoin::api::Error& error) {
      if (text != nullptr) *text = error.words;
      return false;
    }
  };
  const auto expect_bound = [&](const char* id, Joint j, Real Joint::*number, Real bound, bool from_above) {
    std::string text;
    j.*number = bound * (from_above ? 1 + 1e-9L : 1 - 1e-9L);
    EXPECT_TRUE(made(j, &text)) << id << ": " << text;
    j.*number = bound * (from_above ? 1 - 1e-9L : 1 + 1e-9L);
    EXPECT_FALSE(made(j, &text)) << id;
    EXPECT_NE(text.find(id), std::string::npos) << text;
  };
  Joint j = mortar();
  j.ks = 60e9, j.phir = 28;
  const Real A = j.total_area();
  expect_bound("fracture_energy_tension", j, &Joint::G1, j.ft * j.ft / j.kn / 2, true);  // 1
  const Real steepest = std::max(j.c0, j.c0 + j.fc * (j.mu0() - j.mur()));
  const Real left = j.ks - j.mu0() * j.kn * j.tan_psi();
  expect_bound("fracture_energy_shear", j, &Joint::G2, steepest * j.c0 * A / left, true);  // 2
  Joint flat = j;
  flat.cr = flat.c0, flat.sd = 1e-3L;
  expect_bound("shear_stiffness", flat, &Joint::ks, j.mu0() * j.kn * j.tan_psi(), true);
  const Real loss = j.fc - j.fcr;
  expect_bound("fracture_energy_compression", j, &Joint::Gc,
               loss * loss * A * (1 / j.kn + j.chi * j.wp / j.fc) / (1 - loss * j.chi / j.fc), true);  // 3
  expect_bound("cap_shear", j, &Joint::Cs, (1 + j.chi) * j.kn / j.ks, true);                           // 4
  Joint steep = j;
  steep.ks = 400e9;
  expect_bound("dilation_angle", steep, &Joint::psi0, steep.phir, false);  // 5
  expect_bound("compressive_yield", j, &Joint::fy, j.fc, false);           // 6
  expect_bound("residual_opening", j, &Joint::beta, 1, false);
  expect_bound(
      "crushing_recovery",
      [&] {
        Joint k = j;
        k.Gc = 1e6, k.Cs = 20;
        return k;
      }(),
      &Joint::chi, 1, false);
  Joint k = j;
  k.wp = 0;
  EXPECT_FALSE(made(k)) << "fy < fc without a length to harden over";
  k = j, k.cr = k.c0;
  EXPECT_FALSE(made(k)) << "dilation without a length to fade over";
  for (Real Joint::*number : {&Joint::pd, &Joint::fy, &Joint::Cs}) {
    k = j, k.*number = 0;
    EXPECT_FALSE(made(k));
  }
}

}  // namespace
