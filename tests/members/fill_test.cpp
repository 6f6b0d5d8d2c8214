// Soil beside and on walls, against Rankine's pressures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "scenes.h"

namespace quoin {
namespace {

using members_cases::box;
using members_cases::head;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kHeight = 4.0, kDepth = 2.0, kUnitWeight = 18e3;  // m, m, N/m3

std::string fill(const std::string& keys) {
  return fmt::format(
      "[[fill]]\nname = \"f\"\nblock = \"wall\"\nunit_weight = {}\nfriction_angle = 30\nstiffness = 1e7\n{}\n",
      kUnitWeight, keys);
}

std::unique_ptr<Simulation> moved(double way, const std::string& keys) {
  auto simulation = std::make_unique<Simulation>(
      read_scene_text(
          head(30.0) + box("wall", "[0, 0, 0]", fmt::format("[1, {}, {}]", kHeight, kDepth)) + fill(keys) +
              "[[stage]]\nramp_time = 0.1\nduration = 0.2\n[[stage.velocity]]\nblock = \"wall\"\nvelocity = "
              "[0, 0, 0]\n" +
              fmt::format("[[stage]]\nduration = 1.0\n[[stage.velocity]]\nblock = \"wall\"\nvelocity = [{}, 0, "
                          "0]\n",
                          way),
          "fill.toml"),
      1);
  Observer nobody;
  simulation->run(nobody);
  return simulation;
}

// A point of 2 m2 seen from the side and 3 m2 from above, under 10 Pa: K0 = 0.5, Ka = 0.2, Kp = 4, 100 Pa/m. By hand.
TEST(FillLaw, PressuresAndEnergiesAreThoseOfASpringBetweenTwoLimits) {
  members::FillLaw law{{0, 1, 0}, {1, 0, 0}, 3.0, 2.0, 10.0, 0.5, 0.2, 4.0, 100.0};
  members::FillState s;
  const auto expect = [&](double pressure, double stored, double dissipated, double outside) {
    EXPECT_NEAR(s.pressure, pressure, 1e-12);
    EXPECT_NEAR(s.stored, stored, 1e-12);
    EXPECT_NEAR(s.dissipated, dissipated, 1e-12);
    EXPECT_NEAR(s.outside, outside, 1e-12);
    EXPECT_NEAR(s.force.x, -2.0 * pressure, 1e-12);
  };
  s.follow(law, 0.5, {});  // half of the weight: 2.5 Pa at rest; its work is that of the spring
  expect(2.5, 2.0 * 0.5 * 2.5 * 0.025, 0.0, 0.0625);
  EXPECT_NEAR(s.force.y, -3.0 * 5.0, 1e-12);
  s.follow(law, 1.0, {});
  expect(5.0, 2.0 * 0.5 * 5.0 * 0.05, 0.0, 0.25);
  s.follow(law, 1.0, {0.02, 0.01, 0});  // 2 Pa more; it lifts 30 N by 1 cm
  expect(7.0, 2.0 * 0.5 * 7.0 * 0.07, 0.0, 0.25 - 0.3);
  s.follow(law, 1.0, {0.45, 0.01, 0});  // 50 Pa would be; 40 Pa flow by 0.1 m
  expect(40.0, 2.0 * 0.5 * 40.0 * 0.4, 2.0 * 40.0 * 0.1, -0.05);
  s.follow(law, 1.0, {0.0, 0.01, 0});  // -5 Pa would be; 2 Pa follow by 0.07 m with the soil's weight
  expect(2.0, 2.0 * 0.5 * 2.0 * 0.02, 8.0, -0.05 + 2.0 * 2.0 * 0.07);
}

// A wall at rest, moving away from the soil and into it: K gamma H^2/2 over its depth, at a third of its height. Both
// integrals are exact, 1e-9. phi = 30 deg: Ka = 1/3, K0 = 1/2, Kp = 3.
TEST(Fills, PressureIsAtRestActiveAndPassive) {
  const struct { double way, coefficient; } cases[] = {{0.0, 0.5}, {-0.2, 1.0 / 3.0}, {0.2, 3.0}};
  for (const auto& [way, coefficient] : cases) {
    const auto simulation = moved(way, fmt::format("towards = [1, 0, 0]\nsurface = [0, {}, 0]", kHeight));
    const members::Members& m = *simulation->large_motion()->held_by.members.get();
    const geometry::Vector force = m.fills().front().force();
    const double expected = -0.5 * coefficient * kUnitWeight * kHeight * kHeight * kDepth;
    EXPECT_NEAR(force.x / expected, 1.0, 1e-9) << way;
    EXPECT_NEAR(force.y, 0.0, 1e-6);
    double moment = 0.0;
    for (const members::FillPoint& p : m.fills().front().points)
      moment += p.state.force.x * m.nodes()[static_cast<std::size_t>(p.node)].start.y;
    EXPECT_NEAR(moment / force.x, kHeight / 3.0, 1e-9) << way;
    const Energies& e = simulation->large_motion()->step_sums.energies;
    EXPECT_LT(std::abs(e.balance_error()), 1e-3 * std::abs(e.external)) << way;
    EXPECT_EQ(e.members_dissipated > 0.0, way > 0.0);
  }
}

// Surcharge up to the surface, wherever that is: at the top of the face, in it, between its points. Both integrals are
// exact, 1e-9. Points at a depth of 0 were left out: 4 % of the force, on the unsafe side.
TEST(Fills, SurchargeActsUpToTheSurface) {
  constexpr double kSurcharge = 1e4, kAtRest = 0.5;
  for (const double surface : {kHeight, 2.7, 1.0}) {
    const auto simulation =
        moved(0.0, fmt::format("towards = [1, 0, 0]\nsurface = [0, {}, 0]\nsurcharge = {}", surface, kSurcharge));
    const members::Members& m = *simulation->large_motion()->held_by.members.get();
    double moment = 0.0;
    for (const members::FillPoint& p : m.fills().front().points)
      moment += p.state.force.x * m.nodes()[static_cast<std::size_t>(p.node)].start.y;
    const double of_surcharge = -kAtRest * kDepth * kSurcharge * surface;
    const double of_soil = -0.5 * kAtRest * kDepth * kUnitWeight * surface * surface;
    EXPECT_NEAR(m.fills().front().force().x / (of_surcharge + of_soil), 1.0, 1e-9) << surface;
    EXPECT_NEAR(moment / (of_surcharge * surface / 2 + of_soil * surface / 3), 1.0, 1e-9) << surface;
    EXPECT_NEAR(m.fills().front().area, kDepth * surface, 1e-9);
  }
}

// Weight and surcharge act on a top below the surface. Faces above the surface or below another block have no load.
TEST(Fills, WeighsOnWhatIsBelow) {
  const auto simulation = moved(0.0, fmt::format("surface = [0, {}, 0]\nsurcharge = 5e3", kHeight + 0.5));
  const members::Members& m = *simulation->large_motion()->held_by.members.get();
  EXPECT_NEAR(m.fills().front().force().y, -(0.5 * kUnitWeight + 5e3) * 1.0 * kDepth, 1e-6);
  EXPECT_NEAR(m.fills().front().area, 1.0 * kDepth, 1e-9);
}

// On an arch: the weight of the soil between its polygonal extrados and the surface. Left and right pressures are
// equal, to 1e-6.
TEST(Fills, LiesOnAnExtrados) {
  const double radius = 2.2, surface = 3.0, depth = 1.0;
  const int voussoirs = 12;
  Simulation simulation(
      read_scene_text(
          head(40.0) + fmt::format("[[arch]]\nname = \"arch\"\nmaterial = \"stone\"\ncentre = [0, 0, 0]\nradius "
                                   "= 2.0\nthickness = 0.4\ndepth = {}\nvoussoirs = {}\nangles = [0, 180]\n[[fill]]"
                                   "\nblock = \"arch\"\nsurface = [0, {}, 0]\nunit_weight = {}\nfriction_angle = "
                                   "30\nstiffness = 1e7\n[[stage]]\nramp_time = 0.01\nduration = 0.02\n",
                                   depth, voussoirs, surface, kUnitWeight),
          "fill.toml"),
      1);
  Observer nobody;
  simulation.run(nobody);
  double area = 0.0;
  for (int k = 0; k < voussoirs; ++k) {
    const double a = M_PI * k / voussoirs, b = M_PI * (k + 1) / voussoirs;
    area += radius * (std::cos(a) - std::cos(b)) * (surface - 0.5 * radius * (std::sin(a) + std::sin(b)));
  }
  const members::Members& m = *simulation.large_motion()->held_by.members.get();
  double upright = 0.0, level = 0.0;
  for (const members::FillPoint& p : m.fills().front().points) {
    upright += p.law.upright * p.law.vertical;
    level += p.law.level * p.law.vertical * p.law.out.x;
  }
  EXPECT_NEAR(upright / (kUnitWeight * area * depth), 1.0, 1e-6);
  EXPECT_NEAR(level / upright, 0.0, 1e-9);
  EXPECT_NEAR(m.fills().front().force().y / -upright, 1.0, 1e-9);
}

// A lining of 20 mm covers a face of any size, here its lower half. On a block of 12 m the soil pressed on both.
TEST(Fills, PressesThinLiningsAndNotWhatTheyCover) {
  Simulation simulation(
      read_scene_text(head(30.0) + box("wall", "[0, 0, 0]", "[1, 4, 12]") +
                          box("lining", "[1, 0, 0]", "[0.02, 2, 12]") +
                          fill("towards = [1, 0, 0]\nsurface = [0, 4, 0]") + "[[stage]]\nduration = 0.01\n",
                      "fill.toml"),
      1);
  EXPECT_NEAR(simulation.large_motion()->held_by.members.get()->fills().front().area, 2.0 * 12.0, 1e-9);
}

TEST(Fills, BadOnesAreRefusedWithPlaces) {
  const auto refusal = [](const std::string& keys) -> std::string {
    try {
      moved(0.0, keys);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal("surface = [0, 3, 0]"),
              AllOf(HasSubstr("fill.1"), HasSubstr("'wall'"), HasSubstr("below (0, 3, 0)")));
  EXPECT_THAT(refusal("surface = [0, 5, 0]\nactive = 0.7"),
              AllOf(HasSubstr("fill.1.active = 0.7"), HasSubstr("at most at_rest (0.5)")));
  EXPECT_THAT(refusal("surface = [0, 5, 0]\ntoward = [1, 0, 0]"), HasSubstr("did you mean 'towards'"));
}

}  // namespace
}  // namespace quoin
