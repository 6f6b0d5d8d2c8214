// Additions to models under ground motion, against closed forms: masses, supports with different motion, damping of the
// uncracked response.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "base/error.h"
#include "model/maxwell.h"
#include "scene/damping_text.h"
#include "scene/read_scene.h"
#include "step/findings.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

// Response of joints with Maxwell elements at a frequency: damping ratio, and stiffness over that without elements.
struct MaxwellResponse {
  double damping_ratio, stiffness;
};
MaxwellResponse response_of(const std::array<MaxwellElement, kMaxwellElements>& elements, double frequency_Hz) {
  double kept = 1.0, lost = 0.0;
  for (const MaxwellElement& e : elements) {
    const double x = 2.0 * std::numbers::pi * frequency_Hz / e.rate;
    if (e.share != 0.0) kept += e.share * x * x / (1.0 + x * x), lost += e.share * x / (1.0 + x * x);
  }
  return {lost / (2.0 * kept), kept};
}

using std::numbers::pi;
using ::testing::HasSubstr;

constexpr double kGravity = 9.81;

const std::string kGround = R"(
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-1, -0.1, -1], size = [2, 0.1, 2] }
)";

// Returns a scene with a block of 2 kg, 0.1 m wide, on the ground.
std::string rider(const std::string& stages, const std::string& more = "") {
  return undamped_stone("general") + kGround + R"(
[[block]]
name = "rider"
material = "stone"
box = { lower = [0, 0, 0], size = [0.1, 0.1, 0.1] }
)" + more +
         stages;
}

double lag_of(const Simulation& simulation) {
  return block_displacement(simulation, 1)[0][1] - block_displacement(simulation, 0)[0][1];
}

void expect_refused(const std::string& text, const char* words) {
  try {
    Simulation simulation(read_scene_text(text, "scene.toml"));
    ADD_FAILURE() << "not refused: " << words;
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(words));
  }
}

// ---- Masses --------------------------------------------------------------------------------------------------------

constexpr const char* kRise = R"([[stage]]
name = "rise"
duration = 0.06
ground_motion = { direction = [0, 1, 0], time = [0, 1], acceleration = [5, 5] }
[output]
energy = true
)";

// The ground rises with acceleration a under a mass of 2 + 6 kg on 1e6 N/m. The lag is (a/w^2) (1 - cos w t), with half
// the frequency of the block alone. Steps of a hundredth of a period have an error of (w dt)^2/24 of w. A mass above
// the centre of the block is equivalent to a distributed one. On gridpoints of a deformable block the difference is its
// compression. 6 kg on 1e9 Pa through 0.05 m is 0.5 % of the deformation of the joint. That is a quarter of a percent
// of its frequency, and 6 % of the amplitude after three and a half cycles.
TEST(Masses, SwingWithTheirBlockAndBalanceItsEnergy) {
  const double w = std::sqrt(1e6 / 8.0), swing = 5.0 / (w * w);
  const struct {
    const char *more, *rigid;
    double tolerance;
  } cases[] = {{"", "", 5e-3},
               {"point = [0.05, 0.4, 0.05]\n", "", 5e-3},
               {"point = [0.05, 0.05, 0.05]\n", "rigid = false\ndivisions = [2, 2, 2]\n", 0.1}};
  for (const auto& [more, rigid, tolerance] : cases) {
    const std::string mass = fmt::format("{}[[mass]]\nblock = \"rider\"\nmass = 6.0\n{}", rigid, more);
    Simulation simulation(read_scene_text(rider(kRise, mass), "scene.toml", {"solver.time_step_fraction=0.03"}));
    EXPECT_NEAR(simulation.time_step_report().model_mass, 8.0 + 800.0, 1e-9);
    Observer nobody;
    double largest = 0.0;
    for (bool go = true; go;) {
      go = simulation.run_stage(nobody, 7);
      const double lag = lag_of(simulation);
      EXPECT_NEAR(lag, -swing * (1 - std::cos(w * simulation.time())), tolerance * swing) << more;
      largest = std::max(largest, -lag);
    }
    EXPECT_NEAR(largest, 2 * swing, 0.02 * swing);
    simulation.advance(1);
    const Energies e = *simulation.measure().energies;
    EXPECT_NEAR(e.balance_error(), 0.0, 2e-3 * e.external) << more;
  }
}

// Block and mass press on the ground with (2 + 6) g. A mass 0.04 m beside the centre causes the moment m g 0.04 in the
// joint. The tilt of 9e-4 moves the mass, 0.1 m above, by 1e-4 m, 0.2 % of its lever arm; 1 % for a deformable block.
TEST(Masses, HaveWeightWhereTheyAre) {
  const std::string stage =
      "[[stage]]\nname = \"stand\"\ngravity = [0, -9.81, 0]\nkind = \"rest\"\n"
      "equilibrium_ratio = 1e-9\n[output]\nmonitor = \"rider\"\n";
  for (const char* rigid : {"", "rigid = false\ndivisions = [2, 2, 2]\n"}) {
    const std::string mass =
        std::string(rigid) + "[[mass]]\nblock = \"rider\"\nmass = 6.0\npoint = [0.09, 0.1, 0.05]\n";
    Simulation simulation(
        read_scene_text(rider(stage, mass), "scene.toml", {"solver.damping=local", "solver.local_damping=0.8"}));
    Observer nobody;
    simulation.run(nobody);
    const HistoryRow row = simulation.measure();
    EXPECT_NEAR(row.base_force[1], -8.0 * kGravity, 1e-5 * 8.0 * kGravity) << rigid;
    double moment = 0.0;  // about the centre of the joint, along z, N m
    for (const ContactPoint& p : contact_points(simulation, all_points(simulation)))
      moment += (p.position[0] - 0.05) * p.area * p.traction[0];
    EXPECT_NEAR(moment, -6.0 * kGravity * 0.04, 0.01 * 6.0 * kGravity * 0.04) << rigid;
  }
}

// Removes damping = "none" from the text, so that the default damping acts.
std::string with_default_damping(std::string text) {
  const std::string none = "damping = \"none\"\n";
  return text.erase(text.find(none), none.size());
}

// The slip of Newmark's block does not depend on its mass; its friction is mu (m + M) g.
TEST(Masses, SlideAsFarAndRubHarder) {
  constexpr double kFriction = 0.3, kPulse = 0.6 * kGravity;
  const std::string stages = R"(
[[mass]]
block = "rider"
mass = 6.0
[[stage]]
name = "stand"
gravity = [0, -9.81, 0]
ramp_time = 0.05
duration = 0.1
solver = { damping = "local" }
[[stage]]
name = "shake"
duration = 0.3
ground_motion = { direction = [1, 0, 0], time = [0, 0.4], acceleration = [5.886, 5.886] }
)";
  std::string text = with_default_damping(rider(stages));
  text.replace(text.find("law = \"elastic\""), 15,
               fmt::format("law = \"coulomb_slip\"\ninitial_state = \"dry\"\nfriction_angle = {}",
                           std::atan(kFriction) * 180.0 / pi));
  // A flat block, which does not rock.
  text.replace(text.find("lower = [0, 0, 0], size = [0.1, 0.1, 0.1]"), 41,
               "lower = [0, 0, 0], size = [0.2, 0.05, 0.1]");
  Simulation simulation(read_scene_text(text, "scene.toml"));
  Observer nobody;
  ASSERT_TRUE(simulation.run_stage(nobody));
  const double begin = simulation.time();
  ASSERT_FALSE(simulation.run_stage(nobody));
  const double t = simulation.time() - begin;
  const double behind = block_displacement(simulation, 0)[0][0] - block_displacement(simulation, 1)[0][0];
  EXPECT_NEAR(behind, 0.5 * (kPulse - kFriction * kGravity) * t * t, 0.005 * behind);
  simulation.advance(1);
  EXPECT_NEAR(std::abs(simulation.measure().base_force[0]), kFriction * 8.0 * kGravity, 0.01 * 8.0 * kGravity);
}

TEST(Masses, OfFloorsHaveWeightAsTheirLoadsDo) {
  const auto standing = [](const std::vector<std::string>& overrides) {
    Scene scene = read_scene(QUOIN_HOST_TESTS "/small_building.toml", overrides);
    scene.stages.resize(1);
    Simulation simulation(scene);
    Observer nobody;
    simulation.run(nobody);
    return std::pair{simulation.measure().base_force[1], simulation.time_step_report().model_mass};
  };
  const std::vector<std::string> general{"solver.kernels=general", "solver.large_motion=always"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.end(), general.begin(), general.end());
    return standing(more);
  };
  const auto [of_load, own] = with({});
  const auto [of_mass, heavier] = with({"building.floor.1.load=0", "building.floor.1.mass=2038.736"});
  EXPECT_NEAR(heavier - own, 2038.736, 1e-6);
  EXPECT_NEAR(of_mass, of_load, 0.02 * 20e3);  // the stage ends at 1 % of the mean contact force
}

TEST(Masses, AreRefusedWhereTheyMeanNothing) {
  const std::string stage = "[[stage]]\nname = \"s\"\nduration = 0.01\n";
  const auto mass = [](const std::string& keys) { return "[[mass]]\n" + keys; };
  expect_refused(rider(stage, mass("block = \"ridr\"\nmass = 1\n")), "rider");
  expect_refused(rider(stage, mass("block = \"rider\"\nmass = 0\n")), "more than 0");
  expect_refused(rider(stage, "rigid = false\ndivisions = [1, 1, 1]\n" +
                                  mass("block = \"rider\"\nmass = 1\npoint = [0.05, 0.2, 0.05]\n")),
                 "0.1 m outside of block 'rider'");
  expect_refused(rider(stage, "fixed = true\n" + mass("block = \"rider\"\nmass = 1\n")), "the block is fixed");
}

// The moment about the base is that of the forces on it, whichever block of a pair has the plane of its points. A block
// that rocks touches the ground with an edge. Then the ground has the plane, also as the second block of the pair.
TEST(OverturningMoment, DoesNotDependOnTheOrderOfBlocks) {
  const std::string pier = R"(
[[block]]
name = "pier"
material = "stone"
box = { lower = [0, 0, 0], size = [0.1, 0.4, 0.1] }
)",
                    shake = R"(
[[stage]]
name = "shake"
duration = 0.08
record_interval = 20
gravity = [0, -9.81, 0]
[stage.ground_motion]
direction = [1, 0, 0]
time = [0, 0.08]
acceleration = [6, 6]
)";
  struct Moments : Observer {
    std::vector<double> time, about_z;
    void on_row(const HistoryRow& row) override {
      time.push_back(row.time), about_z.push_back(row.overturning_moment[2]);
    }
  };
  const auto moments = [&](const std::string& blocks, bool ground_is_second) {
    Simulation simulation(read_scene_text(undamped_stone("general") + blocks + shake, "scene.toml"));
    Moments found;
    simulation.run(found);
    const auto points = contact_points(simulation);
    EXPECT_TRUE(!points.empty() && points[0].block_a == (ground_is_second ? 1 : 0)) << "the ground has no plane";
    return found;
  };
  const Moments first = moments(kGround + pier, false), second = moments(pier + kGround, true);
  ASSERT_EQ(first.time.size(), second.time.size());
  double largest = 0.0, apart = 0.0;
  for (std::size_t i = 0; i < first.time.size(); ++i) {
    largest = std::max(largest, std::abs(first.about_z[i]));
    apart = std::max(apart, std::abs(first.about_z[i] - second.about_z[i]));
  }
  EXPECT_GT(largest, 0.1);
  EXPECT_LT(apart, 0.02 * largest);  // where the pier still stands, planes differ by its rotation
}

// ---- Supports ------------------------------------------------------------------------------------------------------

// Two piers with ground motion, one of which has its own displacements. At the samples its error is of the order of the
// squared step. Between them it follows the spline; after the last sample it is constant.
TEST(Supports, FollowTheirOwnDisplacements) {
  const std::string stages = R"(
[[block]]
name = "pier"
material = "stone"
fixed = true
box = { lower = [2, -0.1, -1], size = [1, 0.1, 1] }
[[stage]]
name = "shake"
duration = 0.5
[stage.ground_motion]
direction = [1, 0, 0]
time = [0, 1]
acceleration = [2, 2]
[[stage.ground_motion.support]]
blocks = ["pier"]
direction = [0, -1, 0]
time = [0.0, 0.1, 0.25, 0.4]
displacement = [0.0, 0.004, 0.001, 0.01]
[[stage]]
name = "after"
duration = 0.1
)";
  const Scene scene = read_scene_text(rider(stages), "scene.toml");
  Simulation simulation(scene);
  Observer nobody;
  const std::vector<std::pair<double, double>> samples{{0.1, 0.004}, {0.25, 0.001}, {0.4, 0.01}};
  std::size_t met = 0;
  double before = 0.0, at = 0.0;
  std::vector<std::uint8_t> half_way;
  while (simulation.time() < 0.499) {
    simulation.run_stage(nobody, 1);
    const double u = -block_displacement(simulation, 2)[0][1], t = simulation.time();
    if (met < samples.size() && t >= samples[met].first) {
      const double way = before + (u - before) * (samples[met].first - at) / (t - at);
      EXPECT_NEAR(way, samples[met++].second, 1e-6);
    }
    EXPECT_EQ(block_displacement(simulation, 2)[0][0], 0.0) << "its own motion alone";
    if (half_way.empty() && t > 0.2) half_way = simulation.save();
    before = u, at = t;
  }
  EXPECT_EQ(met, 3u);
  EXPECT_NEAR(block_displacement(simulation, 0)[0][0], 0.5 * 2.0 * at * at, 1e-6);
  // Rows have the displacement of the step before: 1e-3 m.
  EXPECT_NEAR(simulation.measure().ground_displacement[0], at * at, 3e-3) << "the ground is not the pier";
  simulation.run(nobody);
  EXPECT_NEAR(-block_displacement(simulation, 2)[0][1], 0.01, 1e-6);
  EXPECT_NEAR(block_displacement(simulation, 0)[0][0], at * at + 2.0 * at * (simulation.time() - at), 2e-3);
  Simulation resumed(scene, 2);
  resumed.restore(half_way);
  resumed.run(nobody);
  EXPECT_EQ(resumed.hash(), simulation.hash());
}

// The clamped spline through u = 0, 1, 0 at t = 0, 1, 2 has the accelerations 6, -6, 6:
//   2 a0 + a1 = 6, a0 + 4 a1 + a2 = -12, a1 + 2 a2 = 6.
TEST(Supports, DisplacementsAreSplines) {
  const Scene scene = read_scene_text(
      rider("[[stage]]\nname = \"s\"\nduration = 2\nground_motion = { direction = [1, 0, 0], time = [0, 1, 2], "
            "displacement = [0.5, 1.5, 0.5], scale = 2 }\n"),
      "scene.toml");
  const auto& a = scene.stages[0].ground->components[0].acceleration.value;
  ASSERT_EQ(a.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(a[i], i == 1 ? -12.0 : 12.0, 1e-12) << i;
}

TEST(Supports, AreRefusedWhereTheyMeanNothing) {
  const auto with = [](const std::string& support) {
    return rider("[[stage]]\nname = \"s\"\nduration = 0.01\n[[stage.ground_motion.support]]\n" + support);
  };
  const std::string still = "direction = [1, 0, 0]\ntime = [0, 1]\nacceleration = [0, 0]\n";
  expect_refused(with("blocks = [\"rider\"]\n" + still), "'rider' is not fixed");
  expect_refused(
      with("blocks = [\"ground\"]\n" + still + "[[stage.ground_motion.support]]\nblocks = [\"ground\"]\n" + still),
      "in two groups");
  expect_refused(with("blocks = []\n" + still), "a list of names of fixed blocks");
  expect_refused(
      with("blocks = [\"ground\"]\ndirection = [1, 0, 0]\ntime = [0, 1]\ndisplacement = [0, 1]\nstart = 1\n"),
      "only without displacement");
}

// ---- Landing -------------------------------------------------------------------------------------------------------

// The closed form of the rebound against the equation of motion, integrated in steps of 1e-5/omega.
TEST(Landing, ComesBackAsItsEquationSays) {
  for (const double z : {0.1, 0.5, 0.7, 1.0, 1.6}) {
    double u = 0.0, v = -1.0;
    while (-u - 2.0 * z * v > 0.0 || u == 0.0) {
      v += 1e-5 * (-u - 2.0 * z * v);
      u += 1e-5 * v;
    }
    EXPECT_NEAR(landing_restitution(z), v, 1e-4) << z;
  }
  EXPECT_NEAR(landing_restitution(0.7), 0.21, 0.001);
  EXPECT_EQ(landing_restitution(0.0), 1.0);
}

// Rows of a block of 0.2 t that lands flat at 1 m/s and slides throughout, at 5 m/s.
class SlidingLanding : public Observer {
 public:
  double along = 0.0, across = 0.0, push = 0.0;  // impulses, N s; largest force along the sliding, N
  void on_row(const HistoryRow& row) override {
    along -= row.joint_force[0] * (row.time - before_), across += row.joint_force[1] * (row.time - before_);
    push = std::max(push, row.joint_force[0]);
    before_ = row.time;
  }

 private:
  double before_ = 0.0;
};

// Friction never pushes along the sliding, though the dashpots take all compression before the block leaves. So the
// impulse along the joint is that of Coulomb, tan 30 degrees = 0.577 of the normal one, but for 5 %. It was 0.52.
TEST(Landing, IsNotPushedAlongItsSliding) {
  const std::string text = R"([solver]
kernels = "general"
damping = "impact"
time_step_fraction = 0.05
[materials.stone]
young_modulus = 1e9
poisson_ratio = 0.2
density = 2000
[joints.joint]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 4e8
friction_angle = 30
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-2, -0.5, -2], size = [6, 0.5, 4] }
[[block]]
name = "rider"
material = "stone"
rigid = true
box = { lower = [0, 0.02, 0], size = [1, 0.1, 1] }
[[stage]]
name = "throw"
duration = 1e-3
velocity = [{ block = "rider", velocity = [5, -1, 0], omega = [0, 0, 0] }]
[[stage]]
name = "fly"
duration = 0.03
[output]
monitor = "rider"
record_interval = 1e-5
)";
  SlidingLanding rows;
  Simulation simulation(read_scene_text(text, "scene.toml"));
  simulation.run(rows);
  EXPECT_GT(rows.across, 200.0);  // 200 kg that come at 1 m/s, and go
  EXPECT_LT(rows.push, 1.0);
  EXPECT_NEAR(rows.along / rows.across, std::tan(pi / 6.0), 0.05 * std::tan(pi / 6.0));
}

// ---- Maxwell elements ----------------------------------------------------------------------------------------------

// K''/(2 K') of the three elements in closed form is within 10 % of the ratio over the band. All elements dissipate.
TEST(Maxwell, IsFlatOverItsBand) {
  for (const double ratio : {0.01, 0.02, 0.05}) {
    for (const double width : {10.0, 30.0, 50.0, 100.0}) {
      const auto elements = maxwell_elements(ratio, {0.5, 0.5 * width});
      for (const MaxwellElement& e : elements) EXPECT_GT(e.share, 0.0) << ratio << " " << width;
      for (double f = 0.5; f <= 0.5 * width * 1.0001; f *= std::pow(width, 0.01))
        EXPECT_NEAR(response_of(elements, f).damping_ratio, ratio, 0.1 * ratio) << f << " of " << width;
    }
  }
}

// Free vibration of a block on a joint about its static deflection. The logarithmic decrement over ten cycles gives a
// damping ratio within 10 % of the requested one over the band, and within 3 % of that of the elements. The frequency
// is that of the stiffer spring. The weight is so small that the block settles by at most 4 mm. There is no impact
// damping, so only the elements dissipate.
TEST(Maxwell, DampsVibrationsAlikeOverTheBand) {
  constexpr double kMass = 2.0, kArea = 0.01, kRatio = 0.03;
  const auto elements = maxwell_elements(kRatio, {0.5, 25.0});
  for (const double f : {0.6, 3.0, 20.0}) {
    const double stiffness = std::pow(2.0 * pi * f, 2) * kMass / kArea;
    const std::string stages = fmt::format(R"(
[[stage]]
name = "weight"
gravity = [0, -0.05, 0]
kind = "rest"
equilibrium_ratio = 1e-6
solver = {{ damping = "local" }}
[[stage]]
name = "shake"
duration = {}
solver = {{ impact_damping = 0, maxwell_damping = {}, maxwell_band = [0.5, 25], time_step_fraction = 0.02 }}
ground_motion = {{ direction = [0, 1, 0], time = [0, {}], acceleration = [0.005, 0.005] }}
)",
                                           14.0 / f, kRatio, 0.25 / f);
    Simulation simulation(
        read_scene_text(with_default_damping(rider(stages)), "scene.toml",
                        {fmt::format("joints.dry.normal_stiffness={}", stiffness),
                         fmt::format("joints.dry.shear_stiffness={}", stiffness), "contact.small_displacement=0"}));
    Observer nobody;
    ASSERT_TRUE(simulation.run_stage(nobody));
    const double begin = simulation.time();
    std::vector<std::pair<double, double>> tops;  // time and lag
    double last = lag_of(simulation), before = last, rest = last;
    for (bool go = true; go;) {
      go = simulation.run_stage(nobody, 1);
      const double lag = lag_of(simulation), t = simulation.time() - begin;
      if (t > 0.5 / f && last > before && last >= lag) tops.push_back({t, last - rest});
      before = last, last = lag;
    }
    ASSERT_GE(tops.size(), 12u) << f;
    const double period = (tops[11].first - tops[1].first) / 10.0;
    const double decrement = std::log(tops[1].second / tops[11].second) / 10.0;
    const double ratio = decrement / std::hypot(2.0 * pi, decrement);
    const MaxwellResponse expected = response_of(elements, 1.0 / period);
    EXPECT_NEAR(ratio, kRatio, 0.1 * kRatio) << f;
    EXPECT_NEAR(ratio, expected.damping_ratio, 0.03 * kRatio) << f;
    EXPECT_NEAR(1.0 / period, f * std::sqrt(expected.stiffness), 0.01 * f) << f;
  }
}

// Blocks dropped onto joints whose stiffness scatters vibrate with the damping ratio of their own frequency (10 %, from
// two cycles). Elements of joints softer than 5 % of the stiffest counted as sliding, and did not damp.
TEST(Maxwell, DampsSoftJointsBesideStiffOnes) {
  constexpr int kBlocks = 12;
  constexpr double kRatio = 0.05;
  std::string scene = undamped_stone("general") + kGround + "[random]\nseed = 1\n";
  for (int i = 0; i < kBlocks; ++i)
    scene += fmt::format("[[block]]\nmaterial = \"stone\"\nbox = {{ lower = [0, 0, {}], size = [0.1, 0.1, 0.1] }}\n",
                         -0.9 + 0.15 * i);
  scene += fmt::format(
      "[[stage]]\ngravity = [0, -0.05, 0]\nduration = 6\nsolver = {{ damping = \"impact\", impact_damping "
      "= 0, maxwell_damping = {} }}\n",
      kRatio);
  Simulation simulation(read_scene_text(
      scene, "scene.toml",
      {"joints.dry.normal_stiffness={ distribution = \"lognormal\", mean = 1e6, cov = 3.0, level = \"joint\" }",
       "joints.dry.shear_stiffness=1e5", "contact.small_displacement=0"}));
  struct Turn {
    double time, place;
  };
  std::array<std::vector<Turn>, kBlocks> turns;  // extremes of each block
  std::array<std::array<double, 2>, kBlocks> last{};
  Observer nobody;
  for (bool go = true; go;) {
    go = simulation.run_stage(nobody, 1);
    for (int i = 0; i < kBlocks; ++i) {
      auto& [before, then] = last[static_cast<std::size_t>(i)];
      const double now = block_displacement(simulation, i + 1)[0][1];
      if ((now - then) * (then - before) < 0.0) turns[static_cast<std::size_t>(i)].push_back({simulation.time(), then});
      before = then, then = now;
    }
  }
  const auto elements = maxwell_elements(kRatio, {0.5, 25.0});
  std::vector<double> in_band;
  for (const std::vector<Turn>& of : turns) {
    ASSERT_GE(of.size(), 6u);
    const double frequency = 2.0 / (of[4].time - of[0].time);
    if (frequency > 25.0) continue;
    const double decrement = std::log((of[1].place - of[0].place) / (of[5].place - of[4].place)) / 2.0;
    EXPECT_NEAR(decrement / std::hypot(2.0 * pi, decrement), response_of(elements, frequency).damping_ratio,
                0.1 * kRatio)
        << frequency;
    in_band.push_back(frequency);
  }
  const auto [softest, stiffest] = std::ranges::minmax(in_band);
  EXPECT_LT(softest * softest, 0.05 * stiffest * stiffest);
}

// Elements do not hold a block that slides: the slip of Newmark's block with 5 % is that without elements to 0.5 %.
TEST(Maxwell, LetsGoOfWhatSlides) {
  const std::string stages = R"(
[[stage]]
name = "stand"
gravity = [0, -9.81, 0]
ramp_time = 0.05
duration = 0.1
solver = { damping = "local" }
[[stage]]
name = "shake"
duration = 1.0
solver = { maxwell_damping = 0.05 }
ground_motion = { direction = [1, 0, 0], time = [0, 0.4], acceleration = [5.886, 5.886] }
)";
  std::string text = with_default_damping(rider(stages));
  text.replace(
      text.find("law = \"elastic\""), 15,
      fmt::format("law = \"coulomb_slip\"\ninitial_state = \"dry\"\nfriction_angle = {}", std::atan(0.3) * 180.0 / pi));
  text.replace(text.find("lower = [0, 0, 0], size = [0.1, 0.1, 0.1]"), 41,
               "lower = [0, 0, 0], size = [0.2, 0.05, 0.1]");
  text.replace(text.find("lower = [-1, -0.1, -1], size = [2, 0.1, 2]"), 42,
               "lower = [-3, -0.1, -1], size = [6, 0.1, 2]");
  Simulation simulation(read_scene_text(text, "scene.toml"));
  Observer nobody;
  simulation.run(nobody);
  EXPECT_NEAR(block_displacement(simulation, 0)[0][0] - block_displacement(simulation, 1)[0][0], 0.47088,
              0.005 * 0.47088);
}

// The elements have a state: a run resumed in the middle of a pulse is bitwise identical. They do not change the time
// step of the facade.
TEST(Maxwell, GoesOnWhereItWasLeft) {
  const std::vector<std::string> overrides{
      "stage.weight.duration=0.05", "stage.earthquake.duration=0.3",
      "stage.earthquake.ground_motion={direction=[1, 0, 0], pulse={shape='sine', amplitude=20, period=0.3}}"};
  std::vector<std::string> damped = overrides;
  damped.emplace_back("stage.earthquake.solver={maxwell_damping=0.02}");
  const Scene shaken = read_scene(QUOIN_SCENES "/facade.toml", damped);
  Simulation simulation(shaken), without(read_scene(QUOIN_SCENES "/facade.toml", overrides));
  Observer nobody;
  ASSERT_TRUE(simulation.run_stage(nobody));
  ASSERT_TRUE(without.run_stage(nobody));
  ASSERT_TRUE(simulation.run_stage(nobody, 700));
  ASSERT_TRUE(without.run_stage(nobody, 1));
  EXPECT_EQ(simulation.time_step_report().time_step, without.time_step_report().time_step);
  const std::vector<std::uint8_t> half_way = simulation.save();
  simulation.run(nobody);
  Simulation resumed(shaken, 2);
  resumed.restore(half_way);
  resumed.run(nobody);
  EXPECT_EQ(resumed.hash(), simulation.hash());
}

}  // namespace
}  // namespace quoin
