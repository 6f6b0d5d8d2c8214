// Floors and beams in limit analysis, against mechanisms by hand. A linear programme of forces at nodes: 1e-4 unless
// stated.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/limit_of_scene.h"
#include "base/error.h"
#include "scenes.h"

namespace quoin {
namespace {

using geometry::Vector;
using members_cases::box;
using members_cases::head;
using ::testing::HasSubstr;

constexpr double kGravity = 9.81;

const std::string kWeight = "[[stage]]\ngravity = [0, -9.81, 0]\nduration = 0.1\n";

SceneLimit limit_of_text(const std::string& scene, const std::vector<double>& direction, bool associated = true) {
  const Simulation simulation(read_scene_text(scene + kWeight, "limit.toml"), 1);
  LimitOptions options;
  options.direction = direction, options.associated = associated;
  return limit_of(simulation, options);
}

const LimitMember& member_of(const SceneLimit& limit, const std::string& what) {
  const auto found = std::find_if(limit.members.begin(), limit.members.end(),
                                  [&](const LimitMember& member) { return member.what == what; });
  EXPECT_NE(found, limit.members.end()) << what;
  return *found;
}

// A bar of steel: 78.5 kg/m.
std::string beam(const std::string& points, const std::string& keys) {
  return fmt::format(
      "[[beam]]\nname = \"b\"\npoints = {}\nspacing = 0.25\narea = 0.01\ninertia = [1e-5, 1e-5]\ntorsion = "
      "1e-5\nyoung_modulus = 2e11\ndensity = 7850\n{}\n",
      points, keys);
}

// Built in at both ends: hinges there and in the middle, w L^2/16 = My. The weight alone is a 1 + lambda of it.
TEST(LimitOfMembers, LintelFallsByThreeHinges) {
  const double length = 4.0, yield = 3e3, w = 78.5 * kGravity;
  const SceneLimit limit =
      limit_of_text(head(30.0) + box("left", "[-1, 0, 0]", "[1, 2, 1]", "fixed = true") +
                        box("right", "[4, 0, 0]", "[1, 2, 1]", "fixed = true") +
                        beam("[[-0.1, 1, 0.5], [0, 1, 0.5], [4, 1, 0.5], [4.1, 1, 0.5]]",
                             fmt::format("yield_moment = [{0}, {0}]\n[[beam.support]]\npoint = [0, 1, 0.5]\nblock = "
                                         "\"left\"\n[[beam.support]]\npoint = [4, 1, 0.5]\nblock = \"right\"",
                                         yield)),
                    {0, -1, 0});
  ASSERT_TRUE(limit.limit);
  EXPECT_NEAR(limit.limit->multiplier, 16.0 * yield / (w * length * length) - 1.0, 1e-4);
  EXPECT_EQ(limit.block_count, 3u);
  // The middle goes down the fastest.
  const LimitBody& body = limit.bodies.front();
  double fastest = 0.0;
  Vector at;
  for (int n = body.first; n < body.end; ++n) {
    const Vector& v = limit.limit->velocity[static_cast<std::size_t>(n)].force;
    if (-v.y > fastest) fastest = -v.y, at = limit.problem.blocks[static_cast<std::size_t>(n)].centre;
  }
  EXPECT_NEAR(at.x, 2.0, 1e-9);
  const MemberForce moment = largest_force(member_of(limit, "moment_up_Nm"), *limit.limit);
  EXPECT_NEAR(moment.largest, yield, 1e-6 * yield);
  EXPECT_GE(moment.at_strength, 3);
}

// Sway of a frame that is built in at its feet, with a hinge at x along the beam in place of its left corner:
// lambda (Wb + Wc) h + Wb x/2 = My (2 + 2 L/(L - x)), Wc of each column. The least of all nodes; x = 0 for a short
// beam.
TEST(LimitOfMembers, PortalFrameSways) {
  const double h = 3.0, yield = 4e3;
  for (const double length : {2.0, 8.0}) {
    const SceneLimit limit = limit_of_text(
        head(30.0) + beam(fmt::format("[[0, 0, 0.5], [0, {0}, 0.5], [{1}, {0}, 0.5], [{1}, 0, 0.5]]", h, length),
                          fmt::format("up = [0, 0, 1]\nyield_moment = [{0}, {0}]\n[[beam.support]]\npoint = [0, 0, "
                                      "0.5]\n[[beam.support]]\npoint = [{1}, 0, 0.5]",
                                      yield, length)),
        {1, 0, 0});
    ASSERT_TRUE(limit.limit);
    const double w = 78.5 * kGravity, beam_weighs = w * length, column = w * h;
    double least = 1e300, hinge = 0.0;
    for (double x = 0.0; x < length; x += 0.25) {
      const double lambda =
          (yield * (2.0 + 2.0 * length / (length - x)) - beam_weighs * x / 2) / ((beam_weighs + column) * h);
      if (lambda < least) least = lambda, hinge = x;
    }
    EXPECT_NEAR(limit.limit->multiplier, least, 1e-4) << length;
    EXPECT_EQ(hinge > 0.0, length > 4.0);
  }
}

// What rests slides at its friction; the beam is a block of its own then, and its forces are those of a contact.
TEST(LimitOfMembers, BeamThatRestsSlidesAtItsFriction) {
  for (const bool associated : {true, false}) {
    const SceneLimit limit = limit_of_text(
        head(30.0) + box("left", "[-0.5, 0, 0]", "[1, 1, 1]", "fixed = true") +
            box("right", "[3.5, 0, 0]", "[1, 1, 1]", "fixed = true") +
            beam("[[0, 1, 0.5], [4, 1, 0.5]]",
                 "friction = 0.4\n[[beam.support]]\npoint = [0, 1, 0.5]\nblock = \"left\"\nhold = "
                 "\"resting\"\n[[beam.support]]\npoint = [4, 1, 0.5]\nblock = \"right\"\nhold = \"resting\""),
        {1, 0, 0}, associated);
    ASSERT_TRUE(limit.limit);
    EXPECT_NEAR(limit.limit->multiplier, 0.4, 1e-4);
    if (!associated) {
      ASSERT_TRUE(limit.without_dilation->settled);
      EXPECT_NEAR(limit.without_dilation->multiplier, 0.4, 0.004);
    }
  }
}

std::string floor_of(const std::string& corner, const std::string& along, const std::string& across,
                     const std::string& keys) {
  return fmt::format(
      "[[floor]]\nname = \"f\"\ncorner = {}\nalong = {}\nacross = {}\nspacing = 0.5\naxial_stiffness = [1e9, "
      "1e9]\nshear_stiffness = 1e7\nmass = 100\n{}\n",
      corner, along, across, keys);
}

// A diaphragm between two walls that stand still, pushed along them: panels next to the walls yield. Each carries what
// lies beyond its middle: lambda g m (L - a)/2 = ty.
TEST(LimitOfMembers, DiaphragmYieldsInShear) {
  const double length = 6.0, panel = 0.5, mass = 100.0, yield = 500.0;
  const SceneLimit limit = limit_of_text(
      head(30.0) + box("left", "[-1, 0, -1]", "[1, 1, 6]", "fixed = true") +
          box("right", "[6, 0, -1]", "[1, 1, 6]", "fixed = true") +
          floor_of("[0, 0.5, 0]", "[6, 0, 0]", "[0, 0, 4]",
                   fmt::format("shear_yield = {}\nspan = \"along\"\nconnector = {{ axial_stiffness = 1e9, "
                               "shear_stiffness = 1e9 }}",
                               yield)),
      {0, 0, 1});
  ASSERT_TRUE(limit.limit);
  EXPECT_NEAR(limit.limit->multiplier, yield / (kGravity * mass * 0.5 * (length - panel)), 1e-4);
  EXPECT_NEAR(largest_force(member_of(limit, "shear_N_per_m"), *limit.limit).largest, yield, 1e-6 * yield);
}

// A facade of one block turns about its outer edge with the floor that it carries at the height y, whose anchors yield
// at the wall behind: lambda (W h/2 + Wf y) = W t/2 + Ta L y + Wf t/2. Half of the floor's weight is on its inner face.
TEST(LimitOfMembers, FacadeHeldByAFloorTurnsOver) {
  const double t = 0.3, h = 3.0, width = 3.0, y = 2.5, anchor = 800.0, load = 100.0 * kGravity;
  const double weight = h * t * width * 2000.0 * kGravity;
  const SceneLimit limit = limit_of_text(
      head(45.0) + box("facade", "[0, 0, 0]", fmt::format("[{}, {}, {}]", width, h, t)) +
          box("back", "[0, 0, -5]", fmt::format("[{}, 3, 1]", width), "fixed = true") +
          floor_of("[0, 2.5, -4]", "[3, 0, 0]", "[0, 0, 4]",
                   fmt::format("connector = {{ axial_stiffness = 1e9, shear_stiffness = 1e9, axial_strength = {} }}",
                               anchor)),
      {0, 0, 1});
  ASSERT_TRUE(limit.limit);
  const double floor_weighs = load * 4.0 * width;
  const double expected =
      (weight * t / 2 + anchor * width * y + floor_weighs * t / 2) / (weight * h / 2 + floor_weighs * y);
  EXPECT_NEAR(limit.limit->multiplier, expected, 1e-4);
  EXPECT_NEAR(largest_force(member_of(limit, "anchor_N_per_m"), *limit.limit).largest, anchor, 1e-6 * anchor);
}

TEST(LimitOfMembers, CablesAreRefused) {
  try {
    limit_of_text(head(30.0) +
                      "[[beam]]\nname = \"c\"\npoints = [[0, 0, 0], [4, 0, 0]]\nspacing = 0.5\narea = "
                      "1e-4\nyoung_modulus = 2e11\ndensity = 7850\n[[beam.support]]\npoint = [0, 0, "
                      "0]\n[[beam.support]]\npoint = [4, 0, 0]\n",
                  {0, 0, 1});
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("beam 'c' does not bend both ways (inertia)"));
  }
}

}  // namespace
}  // namespace quoin
