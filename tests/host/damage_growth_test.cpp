// Frames where damage grows (output.frames_at_damage), against the closed form of one joint that softens linearly.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <string>

#include "scene/read_scene.h"
#include "step/simulation.h"

namespace quoin {
namespace {

using ::testing::HasSubstr;

constexpr double kFt = 0.2e6, kG = 15.0, kKn = 82e9, kXi = 0.4;  // Pa, J/m2, Pa/m; damage of the lower joint
constexpr double kU0 = kFt / kKn,
                 kLt = (kG - kFt * kU0 / 2) / (kFt / 2);  // m; of contact_models/fracture_energy/LAW.md
constexpr double kEnd = (1 - kXi) / (2 - kXi);            // of two joints of equal area
constexpr double kSlow = 0.000125;                        // m/s: some 300 passes while the joint softens
constexpr double kWay = 3e-4;                             // m, of the beam

// A unit between two beams. The upper one is drawn up slowly, and the lower joint, which is damaged, opens.
Scene drawn(const std::string& solver, double growth, double velocity = 0.005, const std::string& state = "bonded") {
  constexpr const char* text = R"(
[materials.brick]
young_modulus = 16.7e9
poisson_ratio = 0.15
density = 1900.0
[joints.mortar]
law = "fracture_energy"
normal_stiffness = 82e9
shear_stiffness = 36e9
tensile_strength = 0.2e6
cohesion = 0.3e6
friction_angle = 35
fracture_energy_tension = 15
fracture_energy_shear = 125
[wall]
courses = 1
units_per_course = 1
unit = [0.22, 0.0625, 0.1]
zones = [1, 1, 1]
mid_unit_joints = false
unit_material = "brick"
bed_joint = "mortar"
head_joint = "mortar"
beam_joint = "mortar"
[[stage]]
name = "drawn"
kind = "custom"
monitor = "top_beam"
direction = "y"
displacement = 3e-4
ramp_time = 0.002
[[stage.control]]
body = "bottom_beam"
velocity = [0, 0, 0]
[[stage.control]]
body = "top_beam"
velocity = [0, {}, 0]
[output]
frames = 0
)";
  const char* const damage = "[[damage]]\njoints = \"mortar\"\nto = [1, 0.01, 1]\nxi = 0.4\n";
  Scene scene = read_scene_text(fmt::format(text, velocity) + (state == "bonded" ? damage : ""), "drawn.toml",
                                {solver, "joints.mortar.initial_state=" + state});
  scene.output.frames_at_damage = growth;
  return scene;
}

struct Seen : Observer {
  std::vector<HistoryRow> rows, rows_then;
  std::vector<long> frames, frames_then;  // steps
  std::vector<Warning> warnings;
  std::vector<std::uint8_t> saved;
  long save_after = -1;
  void on_row(const HistoryRow& row) override { rows.push_back(row); }
  void on_frame(const Simulation& s, int, int) override { frames.push_back(s.step()); }
  void on_warning(const Warning& warning) override { warnings.push_back(warning); }
  bool wants_pause(bool) override { return save_after >= 0 && saved.empty(); }
  void on_pause(const Simulation& s, bool) override {
    if (s.step() >= save_after) saved = s.save(), rows_then = rows, frames_then = frames;
  }
};

class DamageGrowth : public ::testing::TestWithParam<const char*> {};

// e of the lower joint is the way of the beam but for elastic parts of unit and upper joint, 3.2e-6 m at ft.
// Its damage grows from 0.4 to 1 while e goes from u0 + 0.4 lt to u0 + lt, a third of the way.
TEST_P(DamageGrowth, HasFramesWhileTheJointSoftensAndNoOthers) {
  constexpr double kGrowth = 0.02, kElastic = 3.2e-6;
  Simulation simulation(drawn(GetParam(), kGrowth, kSlow), 1);
  Seen seen;
  simulation.run(seen);
  std::vector<long> expected{1};
  double at_frame = 0.0;
  std::vector<double> ways;
  for (const HistoryRow& row : seen.rows) {
    ASSERT_EQ(row.added.size(), 1u);
    if (row.added[0] - at_frame < kGrowth) continue;
    at_frame = row.added[0], ways.push_back(row.displacement), expected.push_back(row.step);
  }
  EXPECT_EQ(seen.frames, expected) << "as the column says";
  EXPECT_NEAR(seen.rows.back().added[0], kEnd, 1e-9);
  // Between two passes the damage grows by less than a tenth of kGrowth.
  EXPECT_GE(ways.size(), static_cast<std::size_t>(kEnd / (1.1 * kGrowth)));
  EXPECT_LE(ways.size(), static_cast<std::size_t>(kEnd / kGrowth));
  EXPECT_GT(ways.front(), kU0 + kXi * kLt);
  EXPECT_LT(ways.back(), kU0 + kLt + kElastic);
  EXPECT_LT(ways.back() - ways.front(), 0.35 * kWay);
  for (const HistoryRow& row : seen.rows) {
    const double xi = std::clamp((row.displacement - kU0) / kLt, kXi, 1.0), lost = (xi - kXi) / (2 - kXi);
    EXPECT_NEAR(row.added[0], lost, kElastic / kLt) << row.displacement;
  }
  EXPECT_THAT(seen.warnings, ::testing::IsEmpty());
}

TEST_P(DamageGrowth, FramesChangeNoBit) {
  std::vector<std::uint64_t> hashes;
  for (const double growth : {0.0, 0.02}) {
    Simulation simulation(drawn(GetParam(), growth), 1);
    Seen seen;
    simulation.run(seen);
    hashes.push_back(simulation.hash());
    EXPECT_EQ(seen.frames.empty(), growth == 0.0);
    EXPECT_EQ(seen.rows.back().added.empty(), growth == 0.0);
  }
  EXPECT_EQ(hashes[1], hashes[0]);
}

TEST_P(DamageGrowth, ResumedRunsHaveTheSameFrames) {
  const Scene scene = drawn(GetParam(), 0.02);
  Seen whole, resumed;
  Simulation simulation(scene, 1);
  simulation.run(whole);
  whole.save_after = simulation.step() / 3;  // in the middle of the growth
  whole.rows.clear(), whole.frames.clear();
  Simulation(scene, 1).run(whole);
  Simulation again(scene, 1);
  again.restore(whole.saved);
  resumed.rows = whole.rows_then, resumed.frames = whole.frames_then;
  again.run(resumed);
  EXPECT_EQ(resumed.frames, whole.frames);
  ASSERT_EQ(resumed.rows.size(), whole.rows.size());
  for (std::size_t i = 0; i < whole.rows.size(); ++i) EXPECT_EQ(resumed.rows[i].added, whole.rows[i].added) << i;
}

// A frame at each pass would fill a disk.
TEST_P(DamageGrowth, FramesHaveAnEndThatIsSaid) {
  Simulation simulation(drawn(GetParam(), 1e-6, kSlow), 1);
  Seen seen;
  simulation.run(seen);
  EXPECT_EQ(seen.frames.size(), 200u);
  ASSERT_EQ(seen.warnings.size(), 1u);
  EXPECT_THAT(seen.warnings[0].text, HasSubstr("stage 'drawn' has 200 frames where damage grows"));
}

TEST_P(DamageGrowth, JointsWithoutStrengthHaveNone) {
  Simulation simulation(drawn(GetParam(), 0.02, 0.005, "dry"), 1);
  Seen seen;
  simulation.run(seen);
  EXPECT_EQ(seen.frames, std::vector<long>{1});
  ASSERT_EQ(seen.warnings.size(), 1u);
  EXPECT_THAT(seen.warnings[0].text, HasSubstr("output.frames_at_damage has no effect"));
}

INSTANTIATE_TEST_SUITE_P(Kinds, DamageGrowth,
                         ::testing::Values("solver.kernels=lattice", "solver.kernels=general",
                                           "solver.large_motion=always"));

}  // namespace
}  // namespace quoin
