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
