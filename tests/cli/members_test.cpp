// Members through the command line: shipped scenes, limit analysis against runs, files, refusals.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "program.h"
#include "results/read_vtu.h"

namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class Members : public Cli {
 protected:
  nlohmann::json run(const std::string& scene, const std::vector<std::string>& settings = {}) {
    std::vector<std::string> words{"run", QUOIN_SCENES "/" + scene, "--out", out(), "--set", "output.plots=false"};
    for (const std::string& setting : settings) words.insert(words.end(), {"--set", setting});
    EXPECT_EQ(quoin(words), 0) << error_;
    return summary();
  }
};

// Multipliers of a facade that rotates about its outer edge: by the closed form, by limit analysis and by a run.
// Tolerance 3 %, since the run counts as collapsed at 6 mm of 3 m, and its edge has the stiffness of the joints.
TEST_F(Members, FacadeHeldByTiesFallsAtTheMultiplierOfLimitAnalysis) {
  const double t = 0.3, h = 3.0, weight = 2.4 * h * t * 2000.0 * 9.81, yield = 1e3, y = 2.25;
  const double expected = (weight * t / 2 + 2 * yield * y) / (weight * h / 2);
  ASSERT_EQ(quoin({"limit", QUOIN_SCENES "/tied_facade.toml", "--associated", "--out", out()}), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("tie left"));
  const auto limit = nlohmann::json::parse(read_all(fs::path(out()) / "limit.json"));
  EXPECT_NEAR(limit["multiplier"], expected, 1e-4);
  for (const double force : limit["tie_force_N"]) EXPECT_NEAR(force, yield, 1e-3 * yield);
  const auto s = run("tied_facade.toml");
  std::printf("  | facade: closed form %.4f, limit analysis %.4f, run %.4f\n", expected,
              limit["multiplier"].get<double>(), s["collapse_multiplier"].get<double>());
  EXPECT_NEAR(s["collapse_multiplier"].get<double>() / expected, 1.0, 0.03);
  ASSERT_EQ(s["ties"].size(), 2u);
  for (const auto& tie : s["ties"]) {
    EXPECT_NEAR(tie["largest_force_N"], yield, 1e-6 * yield);
    EXPECT_GT(tie["plastic_elongation_m"], 0.0);
    EXPECT_FALSE(tie["broken"]);
  }
  EXPECT_LT(std::abs(s["energy_J"]["balance_error"].get<double>()), 1e-3 * s["energy_J"]["external"].get<double>());
  EXPECT_GT(s["energy_J"]["members_dissipated"], 0.0);
  EXPECT_THAT(read_all(fs::path(out()) / "history.csv"), HasSubstr("tie_left_N,tie_right_N"));
  const quoin::VtuFile lines(fs::path(out()) / "members_0000.vtu");
  EXPECT_EQ(lines.values_of<float>("force_N").size(), 2u);
  EXPECT_THAT(read_all(fs::path(out()) / "members.pvd"), HasSubstr("members_0003.vtu"));
}

// Multipliers of a facade with a floor on anchors, which moves with it; the inertia force of the floor acts, too.
TEST_F(Members, FacadeHeldByAFloorFallsAtTheMultiplierOfLimitAnalysis) {
  const double t = 0.3, h = 3.0, width = 2.4, weight = width * h * t * 2000.0 * 9.81, y = 2.25;
  const double floor_weighs = 40.0 * width * 4.0 * 9.81, anchor = 1000.0;
  const double expected =
      (weight * t / 2 + anchor * width * y + floor_weighs * t / 2) / (weight * h / 2 + floor_weighs * y);
  ASSERT_EQ(quoin({"limit", QUOIN_SCENES "/floor_facade.toml", "--associated", "--out", out()}), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("floor 'timber' anchor_N_per_m: at most 1000 of 1000"));
  const auto limit = nlohmann::json::parse(read_all(fs::path(out()) / "limit.json"));
  EXPECT_NEAR(limit["multiplier"], expected, 1e-4);
  EXPECT_EQ(limit["member_forces"].size(), 3u);
  const auto s = run("floor_facade.toml", {"output.frames=0"});
  std::printf("  | facade and floor: closed form %.4f, limit analysis %.4f, run %.4f\n", expected,
              limit["multiplier"].get<double>(), s["collapse_multiplier"].get<double>());
  EXPECT_NEAR(s["collapse_multiplier"].get<double>() / expected, 1.0, 0.03);
}

// A moving load on an arch: limit.json has its worst position, and moving.csv all positions.
TEST_F(Members, MovingLoadHasItsWorstPlace) {
  const fs::path scene = folder_ / "moving.toml";
  std::string text = read_all(QUOIN_SCENES "/arch.toml");
  text += R"(
[[stage]]
name = "crossing"
gravity = [0.0, -9.81, 0.0]
duration = 1.0
moving_load = { from = [-6.0, 14.0, 0.5], to = [6.0, 14.0, 0.5], force = [0.0, -1000.0, 0.0], positions = 7 }
)";
  std::ofstream(scene) << text;
  ASSERT_EQ(quoin({"limit", scene.string(), "--moving", "--associated", "--out", out()}), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("of the moving load (0, -1000, 0) N where it is worst"));
  const auto limit = nlohmann::json::parse(read_all(fs::path(out()) / "limit.json"));
  double least = 1e300;
  for (const auto& place : limit["moving"]["positions"])
    if (!place["multiplier"].is_null()) least = std::min(least, place["multiplier"].get<double>());
  EXPECT_EQ(limit["multiplier"].get<double>(), least);
  EXPECT_THAT(read_all(fs::path(out()) / "moving.csv"), HasSubstr("position,x_m,y_m,z_m,block"));
  EXPECT_EQ(quoin({"limit", scene.string(), "--moving", "--given", "0.1"}), 3);
  EXPECT_THAT(error_, HasSubstr("leave --direction, --multiply and --given out"));
  EXPECT_EQ(quoin({"limit", QUOIN_SCENES "/arch.toml", "--moving"}), 3);
  EXPECT_THAT(error_, HasSubstr("no stage has a moving load"));
  EXPECT_EQ(quoin({"check", scene.string(), "--set", "stage.crossing.moving_load.to=[6.0, 13.0, 0.5]"}), 0) << error_;
  EXPECT_EQ(quoin({"check", scene.string(), "--set", "stage.crossing.moving_load.force=[0, 0, 0]"}), 3);
  EXPECT_THAT(error_, HasSubstr("moving_load.force"));
}

// The arch spreads until its thrust is the minimum thrust, which is the force of its tie. By limit analysis a tie with
// a yield force 3 % below it does not carry the weight, and one 3 % above does.
TEST_F(Members, TieOfAnArchOnRollersHasItsLeastThrust) {
  const auto s = run("tied_arch.toml", {"output.frames=0"});
  const double thrust = s["ties"][0]["force_N"];
  const auto limit = [&](double of_thrust) {
    return quoin({"limit", QUOIN_SCENES "/tied_arch.toml", "--associated", "--direction", "1", "0", "0", "--set",
                  fmt::format("tie.rod.yield_stress={}", of_thrust * thrust / 50e-6)});
  };
  std::printf("  | arch on rollers: thrust %.1f N\n", thrust);
  EXPECT_EQ(limit(0.97), 5);
  EXPECT_THAT(error_, HasSubstr("the given loads cannot be carried"));
  EXPECT_EQ(limit(1.03), 0) << error_;
}

TEST_F(Members, BadTiesAreRefusedWithPlaceValueAndRange) {
  const auto refusal = [&](const std::string& setting) {
    EXPECT_EQ(quoin({"check", QUOIN_SCENES "/tied_facade.toml", "--set", setting}), 3) << setting;
    return error_;
  };
  EXPECT_THAT(refusal("tie.left.to.point=[0.6,2.25,-1.0]"), AllOf(HasSubstr("tie.1.to"), HasSubstr("(0.6, 2.25, -1)"),
                                                                  HasSubstr("is in the air"), HasSubstr("1 m away")));
  EXPECT_THAT(refusal("tie.left.from.block=bacK"), AllOf(HasSubstr("bacK"), HasSubstr("did you mean 'back'")));
  EXPECT_THAT(refusal("tie.left.pretension=1001"),
              AllOf(HasSubstr("tie.1.pretension = 1001"), HasSubstr("0 to 1000 N")));
  EXPECT_THAT(refusal("tie.left.area=0"), AllOf(HasSubstr("tie.1.area = 0"), HasSubstr("more than 0")));
  EXPECT_THAT(refusal("tie.left.hardening=1"), HasSubstr("less than 1"));
  EXPECT_THAT(refusal("tie.left.rupture_strain=1e-4"), HasSubstr("more than 0.0005, the strain at yield"));
  EXPECT_THAT(refusal("tie.left.name=right"), HasSubstr("'right' is taken"));
  EXPECT_THAT(refusal("tie.left.to.point=[0.6,2.1,0.15]"), HasSubstr("meet"));
  EXPECT_THAT(refusal("solver.kernels=lattice"), HasSubstr("members"));
}

}  // namespace
