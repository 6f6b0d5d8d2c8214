// Dowels across joints, plates, and points through which ties slide, against closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "scenes.h"

namespace quoin {
namespace {

using members_cases::box;
using members_cases::head;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kGravity = 9.81;

std::unique_ptr<Simulation> rested(const std::string& scene) {
  auto simulation = std::make_unique<Simulation>(read_scene_text(scene, "dowel.toml"), 1);
  Observer nobody;
  simulation->run(nobody);
  return simulation;
}

const members::Members& members_of(const Simulation& simulation) {
  return *simulation.large_motion()->held_by.members.get();
}

std::string dowel(const std::string& point, double force, double shear) {
  return fmt::format(
      "[[dowel]]\nname = \"d\"\npoint = {}\ndirection = [0, 1, 0]\naxial_stiffness = 1e8\nshear_stiffness = "
      "1e7\nyield_force = {}\nyield_shear = {}\n",
      point, force, shear);
}

TEST(DowelLaw, YieldsAlongAndAcross) {
  const members::DowelLaw law{1e8, 1e7, 2e4, 5e3};
  members::DowelState state;
  const geometry::Vector along{0, 1, 0};
  state.follow(law, along, {3e-4, 1e-4, 4e-4});  // shear forces of 3000 and 4000 N: at yield
  EXPECT_DOUBLE_EQ(state.force, 1e4);
  EXPECT_NEAR(state.shear.x, 3e3, 1e-9);
  EXPECT_NEAR(state.shear.z, 4e3, 1e-9);
  EXPECT_EQ(state.dissipated, 0.0);
  state.follow(law, along, {6e-4, 3e-4, 8e-4});
  EXPECT_DOUBLE_EQ(state.force, 2e4);
  EXPECT_NEAR(norm(state.shear), 5e3, 1e-9);
  EXPECT_NEAR(state.shear.x / state.shear.z, 0.75, 1e-9);
  EXPECT_NEAR(state.dissipated, 2e4 * 1e-4 + 5e3 * 5e-4, 1e-9);
  state.follow(law, along, {0, 0, 0});
  EXPECT_NEAR(state.force, -1e4, 1e-6);
}

TEST(Dowels, ForcesTurnWithTheFirstBlock) {
  members::Dowel bar{"d", 0, 1, {0, 0, 1}, 0.2, {1000.0, 500.0, 1e9, 1e9}, {}};
  std::vector<members::Node> nodes(2);
  nodes[0].turn = matrix(geometry::rotation({0, std::numbers::pi / 2, 0}));  // z becomes x
  nodes[1].x = {0.001, 0.004, 0.002};
  bar.pull(nodes, {});
  EXPECT_NEAR(norm(nodes[0].force - geometry::Vector{1.0, 2.0, 1.0}), 0.0, 1e-12);
  EXPECT_NEAR(norm(nodes[1].force + geometry::Vector{1.0, 2.0, 1.0}), 0.0, 1e-12);
  EXPECT_NEAR(bar.columns()[0], 1.0, 1e-12) << "opens by 1 mm";
  EXPECT_NEAR(bar.columns()[1], std::sqrt(5.0), 1e-12);
  const auto line = bar.lines(nodes).front();
  EXPECT_NEAR(norm(line.from - geometry::Vector{-0.1, 0, 0}), 0.0, 1e-12);
  EXPECT_NEAR(norm(line.to - nodes[1].x - geometry::Vector{0.1, 0, 0}), 0.0, 1e-12);
}

// A block under a force along its bed: the joint carries mu W, the dowel the rest. Above mu W + V the block slides.
TEST(Dowels, TakesWhatFrictionLeaves) {
  const double weight = 2000.0 * 2 * 1 * 2 * kGravity, mu = std::tan(30.0 * M_PI / 180.0), yield = 2e4;
  const auto pushed = [&](double lambda) {
    return rested(head(30.0) + box("block", "[0, 0, 0]", "[2, 1, 2]") + dowel("[1, 0, 1]", 1e6, yield) +
                  fmt::format("[[stage]]\ngravity = [{}, {}, 0]\nramp_time = 1.0\nduration = 2.5\n", lambda * kGravity,
                              -kGravity));
  };
  const double lambda = mu + 0.8 * yield / weight;
  const auto stands = pushed(lambda);
  const members::Dowel& held = members_of(*stands).dowels().front();
  EXPECT_NEAR(norm(held.state.shear), 0.8 * yield, 0.02 * yield);
  EXPECT_EQ(norm(held.state.slid), 0.0);
  const auto slides = pushed(mu + 1.1 * yield / weight);
  EXPECT_GT(norm(members_of(*slides).dowels().front().state.slid), 0.05);
  const Energies& e = slides->large_motion()->step_sums.energies;
  EXPECT_LT(std::abs(e.balance_error()), 2e-3 * e.external);
}

// The dowel joins what lies at its joint, however long and thin. Test points were 60 mm from the joint of a plate of 12
// by 0.05 m. So the base was joined to what lay on the plate.
TEST(Dowels, HoldThinLongBlocks) {
  const auto simulation =
      rested(head(0.0) + box("plate", "[0, 0, 0]", "[12, 0.05, 0.3]") + box("top", "[0, 0.05, 0]", "[12, 1, 0.3]") +
             dowel("[3, 0, 0.15]", 1e6, 1e6) + "[[stage]]\nduration = 0.01\n");
  const members::Members& m = members_of(*simulation);
  const members::Dowel& held = m.dowels().front();
  EXPECT_EQ(m.nodes()[static_cast<std::size_t>(held.first)].block, 0);
  EXPECT_EQ(m.nodes()[static_cast<std::size_t>(held.second)].block, 1);
}

TEST(Dowels, BadOnesAreRefusedWithPlaces) {
  const auto refusal = [](const std::string& more) -> std::string {
    try {
      rested(head(30.0) + box("block", "[0, 0, 0]", "[2, 1, 2]") + more + "[[stage]]\nduration = 0.01\n");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal(dowel("[1, 0.5, 1]", 1e4, 1e4)),
              AllOf(HasSubstr("dowel.1"), HasSubstr("(1, 0.5, 1)"), HasSubstr("both sides are in block")));
  EXPECT_THAT(refusal(dowel("[1, 3, 1]", 1e4, 1e4)), AllOf(HasSubstr("in the air"), HasSubstr("2 m off")));
  EXPECT_THAT(refusal(dowel("[1, 1, 1]", 1e4, 1e4)), HasSubstr("one side is in the air"));
  EXPECT_THAT(refusal(dowel("[1, 0, 1]", 0.0, 1e4)), HasSubstr("dowel.1.yield_force = 0"));
  const auto named = [](const std::string& name) {
    std::string text = dowel("[1, 0, 1]", 1e4, 1e4);
    return text.replace(text.find("\"d\""), 3, '"' + name + '"');
  };
  EXPECT_THAT(refusal(named("a_shear") + named("a")), HasSubstr("not NAME_shear beside NAME"));
}

// A block hangs on a tie that slides through its top. Both parts have equal forces, so the block moves to the middle:
// T = W/(2 sin of their slope). Tolerance 1 %, for remaining motion.
TEST(Ties, LoopThatSlidesThroughABlockPullsAlikeOnBothSides) {
  const auto simulation = rested(
      head(30.0, 1e11, 2.0) + box("left", "[-3, 2, 0]", "[1, 1, 1]", "fixed = true") +
      box("right", "[2, 2, 0]", "[1, 1, 1]", "fixed = true") + box("hung", "[-0.3, 0.2, 0.2]", "[0.6, 0.6, 0.6]") +
      "[[tie]]\nname = \"loop\"\nfrom = { block = \"left\", point = [-2, 2.5, 0.5] }\nto = { block = \"right\", point "
      "= "
      "[2, 2.5, 0.5] }\nthrough = [{ block = \"hung\", point = [0, 0.8, 0.5] }]\narea = 1e-4\nyoung_modulus = "
      "2e11\nyield_stress = 1e9\n[[stage]]\ngravity = [0.5, -9.81, 0]\nramp_time = 0.5\nduration = 2.0\n"
      "[[stage]]\ngravity = [0, -9.81, 0]\nramp_time = 0.5\nduration = 8.0\n");
  const members::Tie& tie = members_of(*simulation).ties().front();
  const geometry::Vector at = place_of(members_of(*simulation).nodes(), tie.stops[1]);
  EXPECT_NEAR(at.x, 0.0, 0.01);
  const double slope = (2.5 - at.y) / std::hypot(2.0, 2.5 - at.y);
  const double weight = 2000.0 * 0.216 * kGravity;
  EXPECT_NEAR(tie.state.force / (weight / (2.0 * slope)), 1.0, 0.01);
}

}  // namespace
}  // namespace quoin
