// Ties: the force of a bar along its axis, and blocks with ties, against closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "model/world_results.h"
#include "scenes.h"

namespace quoin {
namespace {

using members::TieLaw;
using members::TieState;
using members_cases::box;
using members_cases::head;
using members_cases::tie;
using ::testing::AllOf;
using ::testing::HasSubstr;

TieLaw steel() {
  TieLaw law;
  law.stiffness = 1e7, law.yield = 5e4;  // N/m, N: yields at 5 mm
  return law;
}

TEST(TieLaw, IsElasticThenPlasticAndSlackens) {
  TieState tie;
  const TieLaw law = steel();
  tie.follow(law, 4e-3, 0.0);
  EXPECT_DOUBLE_EQ(tie.force, 4e4);
  tie.follow(law, 8e-3, 0.0);
  EXPECT_DOUBLE_EQ(tie.force, 5e4);
  EXPECT_DOUBLE_EQ(tie.plastic, 3e-3);
  EXPECT_DOUBLE_EQ(tie.dissipated, 5e4 * 3e-3);
  EXPECT_DOUBLE_EQ(tie.stored, 0.5 * 5e4 * 5e-3);
  tie.follow(law, 2e-3, 0.0);  // below the plastic elongation
  EXPECT_EQ(tie.force, 0.0);
  EXPECT_EQ(tie.stored, 0.0);
  tie.follow(law, 5e-3, 0.0);
  EXPECT_DOUBLE_EQ(tie.force, 1e7 * (5e-3 - 3e-3));
  EXPECT_DOUBLE_EQ(tie.dissipated, 5e4 * 3e-3);
}

// Kinematic hardening: the elastic range has a constant width and moves with the plastic elongation.
TEST(TieLaw, HardensKinematically) {
  TieLaw law = steel();
  law.hardening = 1e6, law.compression = true;
  const double tangent = law.stiffness * law.hardening / (law.stiffness + law.hardening);
  TieState tie;
  tie.follow(law, 15e-3, 0.0);
  const double top = 5e4 + tangent * 10e-3;
  EXPECT_NEAR(tie.force, top, 1e-9 * top);
  double work = 0.5 * 5e4 * 5e-3 + 0.5 * (5e4 + top) * 10e-3;
  EXPECT_NEAR(tie.stored + tie.dissipated, work, 1e-9 * work);
  const double reversal = 15e-3 - 2 * 5e4 / law.stiffness;
  tie.follow(law, reversal, 0.0);
  EXPECT_NEAR(tie.force, top - 1e5, 1e-6);
  EXPECT_NEAR(tie.plastic, 10e-3 * law.stiffness / (law.stiffness + law.hardening), 1e-12);
  tie.follow(law, reversal - 1e-3, 0.0);
  EXPECT_NEAR(tie.force, top - 1e5 - tangent * 1e-3, 1e-6);
}

TEST(TieLaw, ShortensUnderItsJackAndBreaks) {
  TieLaw law = steel();
  law.pretension = 2e4, law.rupture = 0.02;
  TieState tie;
  for (int i = 0; i <= 10; ++i) tie.follow(law, 0.0, 0.1 * i);
  EXPECT_DOUBLE_EQ(tie.force, 2e4);
  EXPECT_NEAR(tie.jack_work, tie.stored, 1e-9);  // W = T0^2/2k: the ends are fixed
  tie.follow(law, 0.0179, 1.0);
  EXPECT_FALSE(tie.broken);
  const double had = tie.stored + tie.dissipated;
  tie.follow(law, 0.0181, 1.0);  // plus 2 mm by the jack
  EXPECT_TRUE(tie.broken);
  EXPECT_EQ(tie.force, 0.0);
  EXPECT_EQ(tie.dissipated, had);
  tie.follow(law, 0.0, 1.0);
  EXPECT_EQ(tie.force, 0.0);
}

TEST(TieLaw, HasSlackBeforeItBears) {
  TieLaw law = steel();
  law.slack = 2e-3;
  TieState tie;
  tie.follow(law, 1.9e-3, 0.0);
  EXPECT_EQ(tie.force, 0.0);
  tie.follow(law, 3e-3, 0.0);
  EXPECT_DOUBLE_EQ(tie.force, 1e7 * 1e-3);
}

// A plate of 0.6 x 0.3 m at one end, a point that it slides through, and a point at the other: 3 and 2 m apart. Means
// of squares are those of six equal parts, a^2/12 (1 - 1/36).
TEST(Ties, PlacesAndLawFollowFromTheirKeys) {
  const Simulation simulation(
      read_scene_text(
          head(35.0) + box("left", "[0, 0, 0]", "[1, 2, 1]") + box("middle", "[3, 0, 0]", "[1, 2, 1]") +
              box("right", "[3, 0, 3]", "[1, 2, 1]") +
              "[[tie]]\nname = \"t\"\nfrom = { block = \"left\", point = [0, 1, 0.5], plate = [0.6, 0.3] }\n"
              "through = [{ block = \"middle\", point = [3, 1, 0.5] }]\n"
              "to = { block = \"right\", point = [3, 1, 3] }\narea = 2e-5\nyoung_modulus = 2e11\n"
              "yield_stress = 3e8\nhardening = 0.2\nrupture_strain = 0.01\nslack = 1e-3\n"
              "[[stage]]\nduration = 0.1\n",
          "tie.toml"),
      1);
  const members::Members& m = *simulation.large_motion()->held_by.members.get();
  const members::Tie& tie = m.ties().front();
  EXPECT_NEAR(tie.length, 3.0 + 2.5, 1e-12);
  const double stiffness = 2e11 * 2e-5 / 5.5;
  EXPECT_NEAR(tie.law.stiffness, stiffness, 1e-6);
  EXPECT_NEAR(tie.law.yield, 6e3, 1e-9);
  EXPECT_NEAR(tie.law.hardening * stiffness / (tie.law.hardening + stiffness), 0.2 * stiffness, 1e-6) << "tangent";
  EXPECT_NEAR(tie.law.rupture, 0.055, 1e-12);
  EXPECT_EQ(tie.law.slack, 1e-3);
  ASSERT_EQ(tie.stops.size(), 3u);
  double shares = 0.0, yy = 0.0, zz = 0.0;
  for (const auto& [node, share] : tie.stops[0]) {
    const geometry::Vector at = m.nodes()[std::size_t(node)].start - geometry::Vector{0, 1, 0.5};
    EXPECT_NEAR(at.x, 0.0, 1e-12);
    shares += share, yy += share * at.y * at.y, zz += share * at.z * at.z;
  }
  EXPECT_NEAR(shares, 1.0, 1e-12);
  EXPECT_NEAR(norm(start_of(m.nodes(), tie.stops[0]) - geometry::Vector{0, 1, 0.5}), 0.0, 1e-12);
  EXPECT_NEAR(zz, 0.36 / 12 * (1 - 1.0 / 36), 1e-12) << "its first side is level";
  EXPECT_NEAR(yy, 0.09 / 12 * (1 - 1.0 / 36), 1e-12);
  EXPECT_EQ(tie.stops[1].size(), 1u);
  // To the ground: k |g_i| sum |g_j|, with |g| the share at ends, at most twice at the stop between them.
  double at_plate = 0.0, at_middle = 0.0, at_end = 0.0;
  tie.each_spring([&](int node, int other, double k) {
    EXPECT_EQ(other, members::kGround);
    (node == tie.stops[1][0].first ? at_middle : node == tie.stops[2][0].first ? at_end : at_plate) += k;
  });
  EXPECT_NEAR(at_end, 4.0 * stiffness, 1e-6);
  EXPECT_NEAR(at_plate, 4.0 * stiffness, 1e-6);
  EXPECT_NEAR(at_middle, 8.0 * stiffness, 1e-6);
}

// Forces of a stretched tie over a corner: its force along each piece, on both pieces at the corner.
TEST(Ties, ForcesAreAlongEachPiece) {
  members::Tie tie{"t", {{{0, 1.0}}, {{1, 1.0}}, {{2, 0.25}, {3, 0.75}}}, 7.0, {}, {}};
  tie.law.stiffness = 10.0, tie.law.yield = 1e9;
  std::vector<members::Node> nodes(4);
  nodes[1].x = {3.1, 0, 0}, nodes[2].x = nodes[3].x = {3.1, 4.2, 0};
  members::Surroundings step{};
  tie.pull(nodes, step);
  const double force = 10.0 * 0.3;
  EXPECT_NEAR(tie.columns()[0], force, 1e-12);
  const geometry::Vector expected[] = {{force, 0, 0}, {-force, force, 0}, {0, -0.25 * force, 0}, {0, -0.75 * force, 0}};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(norm(nodes[i].force - expected[i]), 0.0, 1e-12) << i;
}

// A slender block on its toe, with a long tie at the top corner above the toe. The horizontal body force is lambda
// times the weight. In equilibrium
//   lambda(theta) = [W R sin(alpha - theta) + (T0 + 2 k h sin theta) 2 h cos theta]/[W R cos(alpha - theta)].
//
// Tolerance 1 %: the joint of 1e11 Pa/m closes by a tenth of a millimetre at the toe.
TEST(Ties, RockingBlockRestsWhereTheTieHoldsIt) {
  const double b = 0.25, h = 1.0, area = 1e-5, length = 40.0, pretension = 1e3, g = 9.81;
  const double stiffness = 200e9 * area / length, weight = 2000.0 * 2 * b * 2 * h * 0.5 * g;
  const double radius = std::hypot(b, h), alpha = std::atan2(b, h);
  for (const double lambda : {0.6, 0.8, 1.0, 1.2}) {
    const Scene scene = read_scene_text(
        head(75.0) + box("block", "[-0.5, 0, 0]", "[0.5, 2, 0.5]") +
            box("anchor", "[-41, 1.5, 0]", "[1, 1, 0.5]", "fixed = true") +
            tie("top", "block", "[0, 2, 0.25]", "anchor", "[-40, 2, 0.25]",
                fmt::format("area = {}\nyoung_modulus = 200e9\nyield_stress = 1e9\npretension = {}", area,
                            pretension)) +
            fmt::format("[[stage]]\nname = \"push\"\ngravity = [{}, {}, 0]\nramp_time = 1.0\nduration = 6.0\n",
                        lambda * g, -g),
        "rocking.toml");
    Simulation simulation(scene, 1);
    Observer nobody;
    simulation.run(nobody);
    const blocks::Model& m = *simulation.large_motion();
    const geometry::Matrix r = orientation_of(m, m.assembly.blocks[1].name == "block" ? 1 : 0);
    const double theta = std::asin(r.row[0].y);
    ASSERT_GT(theta, 0.005) << lambda;
    const double tension = pretension + 2 * stiffness * h * std::sin(theta);
    const double expected = (weight * radius * std::sin(alpha - theta) + tension * 2 * h * std::cos(theta)) /
                            (weight * radius * std::cos(alpha - theta));
    EXPECT_NEAR(expected / lambda, 1.0, 0.01) << "theta " << theta;
    EXPECT_NEAR(m.held_by.members.get()->ties().front().state.force / tension, 1.0, 0.005);
    std::printf("  | rocking block on a tie: theta %.5f rad, lambda %.5f by the closed form, %.5f applied\n", theta,
                expected, lambda);
  }
}

// A block on springs with a tie that yields and then is slack: plastic elongation, slack and energies are states.
TEST(Members, GoOnFromACheckpointBitForBit) {
  const Scene scene = read_scene_text(
      head(35.0, 1e9) + box("block", "[-0.5, 0, 0]", "[0.5, 2, 0.5]") +
          box("anchor", "[-41, 1.5, 0]", "[1, 1, 0.5]", "fixed = true") +
          "[[spring]]\nname = \"foot\"\nblock = \"block\"\nnormal = [1, 0, 0]\nnormal_stiffness = 1e6\n"
          "shear_stiffness = 1e5\nnormal_dashpot = 100.0\nfriction_angle = 20.0\n" +
          tie("top", "block", "[0, 2, 0.25]", "anchor", "[-40, 2, 0.25]",
              "area = 1e-5\nyoung_modulus = 200e9\nyield_stress = 50e6\npretension = 300.0\nhardening = 0.1") +
          "[[stage]]\nname = \"weight\"\ngravity = [0, -9.81, 0]\nramp_time = 0.1\nduration = 0.2\n[[stage]]\nname = "
          "\"push\"\ngravity = [9.81, -9.81, 0]\nramp_time = 0.1\nduration = 0.5\n",
      "checkpoint.toml");
  Simulation whole(scene, 1), before(scene, 1), after(scene, 1);
  whole.advance(3000), before.advance(3000);
  const std::vector<std::uint8_t> bytes = before.save();
  after.advance(37);
  after.restore(bytes);
  whole.advance(2000), after.advance(2000);
  EXPECT_EQ(whole.hash(), after.hash());
  const auto &one = whole.large_motion()->held_by.members.get()->ties().front().state,
             &other = after.large_motion()->held_by.members.get()->ties().front().state;
  EXPECT_EQ(one.force, other.force);
  EXPECT_EQ(one.dissipated, other.dissipated);
  EXPECT_EQ(whole.large_motion()->step_sums.energies.external, after.large_motion()->step_sums.energies.external);
  EXPECT_EQ(whole.large_motion()->step_sums.energies.members_dissipated,
            after.large_motion()->step_sums.energies.members_dissipated);
}

}  // namespace
}  // namespace quoin
