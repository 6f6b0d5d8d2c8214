// Promotions: runs that change from small displacements to large motion.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "../scene_of_text.h"
#include "scene/read_scene.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

// A wall whose promotion is early, with so small a motion that small displacements and large motion agree.
Scene wall(const std::string& large_motion, std::vector<std::string> more = {}) {
  more.insert(more.end(), {"solver.damping=local", "solver.large_motion=" + large_motion, "solver.rotation_bound=1e-4",
                           "wall.units_per_course=3", "output.frames=0"});
  return read_scene(QUOIN_HOST_TESTS "/../cli/small_wall.toml", more);
}

// A contact point in a form that is independent of the order of its two blocks. The traction is that on the block with
// the lower number, along fixed axes.
struct Seen {
  double sigma;
  Vec3 shear;
  std::vector<double> state;
  Vec3 seat{};  // of cyclic_joint, along fixed axes, m
};
using Key = std::array<long, 5>;

std::map<Key, Seen> look(const Simulation& simulation, const std::vector<Vec3>& places) {
  std::map<Key, Seen> seen;
  std::vector<std::vector<double>> states;
  const bool has_seat = simulation.scene().joints.at("mortar").law == "cyclic_joint";
  const std::vector<std::string> ids = has_seat
                                           ? std::vector<std::string>{"xi", "kappa", "q", "r_m", "v_m", "g_s", "g_t"}
                                           : std::vector<std::string>{"xi_t", "xi_s", "w", "v"};
  for (const std::string& id : ids) states.push_back(law_state(simulation, id));
  for (const ContactPoint& p : contact_points(simulation)) {
    const Vec3& x = places.empty() ? p.position : places[static_cast<std::size_t>(p.index)];
    const auto um = [](double length) { return std::lround(1e5 * length); };
    Seen s{p.traction[0], {}, {}};
    const double side = p.block_a < p.block_b ? 1.0 : -1.0;
    for (std::size_t c = 0; c < 3; ++c) s.shear[c] = side * (p.traction[1] * p.s[c] + p.traction[2] * p.t[c]);
    for (const auto& column : states) s.state.push_back(column[static_cast<std::size_t>(p.index)]);
    if (has_seat) {
      const double t = s.state.back(), along_s = s.state[s.state.size() - 2];
      for (std::size_t c = 0; c < 3; ++c) s.seat[c] = side * (along_s * p.s[c] + t * p.t[c]);
      s.state.resize(s.state.size() - 2);
    }
    const auto [low, high] = std::minmax(p.block_a, p.block_b);
    EXPECT_TRUE(seen.try_emplace({um(x[0]), um(x[1]), um(x[2]), low, high}, s).second);
  }
  return seen;
}

// Returns displacement and velocity of every gridpoint of deformable blocks, by block and initial position in um.
std::map<std::array<long, 4>, std::pair<Vec3, Vec3>> motion_of(const Simulation& simulation) {
  std::map<std::array<long, 4>, std::pair<Vec3, Vec3>> motion;
  for (int b = 0; b < static_cast<int>(simulation.block_count()); ++b) {
    const auto mesh = block_mesh(simulation, b);
    if (mesh.zone.empty()) continue;
    const auto displacement = block_displacement(simulation, b), velocity = block_velocity(simulation, b);
    for (std::size_t i = 0; i < mesh.gridpoint.size(); ++i) {
      const Vec3& x = mesh.gridpoint[i];
      const auto um = [](double length) { return std::lround(1e6 * length); };
      motion[{b, um(x[0]), um(x[1]), um(x[2])}] = {displacement[i], velocity[i]};
    }
  }
  return motion;
}

struct Watch : Observer {
  const Simulation* simulation = nullptr;
  std::vector<HistoryRow> rows;
  std::map<Key, Seen> before, after;
  std::map<std::array<long, 4>, std::pair<Vec3, Vec3>> gridpoints;  // block, position in um: displacement, velocity
  double strain_energy = 0.0;
  int promotions = 0, warnings = 0;
  std::vector<std::uint8_t> saved;
  void on_row(const HistoryRow& row) override { rows.push_back(row); }
  void on_warning(const Warning& w) override {
    if (w.about != "small_displacements") return;
    ++warnings;
    if (simulation) before = look(*simulation, {}), gridpoints = motion_of(*simulation);
  }
  void on_promotion(const Simulation& promoted) override {
    ++promotions;
    saved = promoted.save();
    gridpoints = motion_of(promoted);
    if (!simulation) return;
    // Points of large motion are at their current positions; they are identified by their initial positions.
    const Simulation at_start(wall("always"));
    after = look(promoted, [&] {
      std::vector<Vec3> places;
      for (const ContactPoint& p : contact_points(at_start)) places.push_back(p.position);
      return places;
    }());
  }
};

// The wall in small displacements, and the wall with a promotion.
struct Both {
  std::vector<std::string> settings;
  Simulation small{[this] {
    Scene stays = wall("never", settings);
    stays.solver.motion_bound.stop = false;
    return stays;
  }()};
  Simulation promoted{wall("automatic", settings)};
  Watch of_small, of_promoted;
  explicit Both(std::vector<std::string> more = {}) : settings(std::move(more)) {
    of_small.simulation = &small, of_promoted.simulation = &promoted;
    small.run(of_small);
    promoted.run(of_promoted);
  }
};

double peak(const std::vector<HistoryRow>& rows) {
  double largest = 0.0;
  for (const HistoryRow& row : rows) {
    if (row.stage == 1) largest = std::max(largest, row.resistance);
  }
  return largest;
}

struct SlipAtPromotion : Observer {
  std::vector<double> slip;
  void on_promotion(const Simulation& promoted) override { slip = law_state(promoted, "slip"); }
};

// Steps in small displacements keep the law's accumulated slip with output.energy alone. Without it large motion begins
// with the shear displacement less its elastic part. That is the law's for points that slide in one direction. Points
// that vibrate at the beginning slide back a little: 0.04 % of the slip of this wall.
class SlipSoFar : public testing::TestWithParam<const char*> {};  // shear stiffness of joints, Pa/m

TEST_P(SlipSoFar, IsThatOfTheLaw) {
  const auto slip_with = [](const char* energy) {
    Scene scene = wall("automatic", {"stage.shear.displacement=0.003", fmt::format("output.energy={}", energy),
                                     fmt::format("joints.mortar.shear_stiffness={}", GetParam())});
    scene.solver.motion_bound.sliding = 8e-3;
    scene.solver.motion_bound.rotation = 0.1;  // the wall slides before it turns so far
    SlipAtPromotion seen;
    Simulation(scene).run(seen);
    return seen.slip;
  };
  const std::vector<double> kept = slip_with("true"), estimated = slip_with("false");
  ASSERT_EQ(estimated.size(), kept.size());
  double all = 0.0, wrong = 0.0;
  int sliding = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    all += kept[i], wrong += std::abs(estimated[i] - kept[i]);
    sliding += kept[i] > 1e-5;
  }
  EXPECT_GT(sliding, 50);
  EXPECT_LT(wrong, 1e-3 * all);
}

INSTANTIATE_TEST_SUITE_P(Promotion, SlipSoFar,
                         testing::Values("36e9", "{mean=36e9, cov=0.3, distribution='lognormal'}"));

// The beam has a prescribed velocity of 0.1 m/s, which does not count as kinetic energy. The work of the second half of
// the last step before the promotion is included. The balance is as good as in a run in small displacements. The beam's
// m v^2/2 is 0.05 J, or half a step of work at 20 kN. As kinetic energy it would be an error of 2e-3 of the work.
TEST(Promotion, KeepsTheBalanceOfEnergyWithADrivenBeam) {
  for (const char* large_motion : {"never", "automatic", "always"}) {
    Scene scene =
        wall(large_motion, {"stage.shear.velocity=0.1", "stage.shear.ramp_time=0.0005", "output.energy=true"});
    scene.solver.motion_bound.stop = false;
    Simulation s(scene);
    Watch watch;
    s.run(watch);
    EXPECT_EQ(watch.promotions, large_motion == std::string("automatic"));
    double worst = 0.0;
    for (const HistoryRow& row : watch.rows) worst = std::max(worst, std::abs(row.energies->balance_error()));
    const double work = watch.rows.back().energies->external;
    EXPECT_GT(work, 1.0);
    EXPECT_LT(worst, 3e-4 * work) << large_motion;
  }
}

// A slender part of the shipped wall that falls, in one run: it cracks in small displacements, overturns and is
// released. At the end it lies on the ground, with contacts between blocks that had no joint. Energies balance at every
// row to 1e-3 of the work (measured: 6e-4, by impacts in single steps), through promotion, sliding over corners and
// impacts.
TEST(Promotion, AWallFallsToTheGround) {
  std::ostringstream shipped;
  shipped << std::ifstream(QUOIN_SCENES "/solid_wall_030_collapse.toml").rdbuf();
  std::string text = shipped.str();
  const std::string held = "[0.5, 0.0, 0.0]";
  text.replace(text.find(held), held.size(), "[0.8, 'free', 0.0]");
  Scene scene = scene_of_text(
      text, {"dry_wall.wall.courses=8", "dry_wall.wall.units_per_course=1", "block.top_beam.position=[0,0.5,0]",
             "block.top_beam.box={lower=[0,0,0],size=[0.22,0.1,0.1]}",
             "block.bottom_beam.box={lower=[0,-0.1,0],size=[0.22,0.1,0.1]}", "stage.push.displacement=0.35",
             "stage.shear.displacement=0.004", "stage.fall.duration=1", "output.frames=0"});
  Simulation s(scene);
  const auto pairs = [&](bool pressed) {
    std::set<std::pair<int, int>> met;
    for (const ContactPoint& p : contact_points(s)) {
      if (!pressed || p.traction[0] < 0) met.insert(std::minmax(p.block_a, p.block_b));
    }
    return met;
  };
  const auto joints = pairs(false);
  Watch watch;
  s.run(watch);
  ASSERT_EQ(watch.promotions, 1);
  EXPECT_EQ(s.outcome().promotion->stage, 2);
  double worst = 0.0;
  for (const HistoryRow& row : watch.rows)
    worst = std::max(worst, std::abs(row.energies->balance_error()) / (1.0 + row.energies->external));
  EXPECT_LT(worst, 2e-3);
  int ground = 0;
  while (block_mesh(s, ground).gridpoint[0][1] > -0.25) ++ground;
  // The number of blocks on the ground, and which of them have pressure at the end, is random.
  int met = 0, pressed_on_ground = 0;
  for (const auto& pair : pairs(false)) met += joints.count(pair) == 0;
  for (const auto& [a, b] : pairs(true)) pressed_on_ground += joints.count({a, b}) == 0 && (a == ground || b == ground);
  EXPECT_GE(met, 2);
  EXPECT_GE(pressed_on_ground, 1);
}

// At the step of the promotion tractions and states are bitwise identical to those of the run in small displacements.
// Contact points of both are at the same gridpoints and have the same axes.
TEST(Promotion, KeepsTractionAndStateOfEveryContactPoint) {
  const Both runs;
  const auto& [settings, small, promoted, of_small, of_promoted] = runs;
  ASSERT_EQ(of_small.warnings, 1);
  ASSERT_EQ(of_promoted.promotions, 1);
  ASSERT_TRUE(promoted.large_motion());
  const Promotion& p = *promoted.outcome().promotion;
  EXPECT_GT(p.step, 0);
  EXPECT_EQ(p.stage, 1);
  EXPECT_THAT(p.why, ::testing::HasSubstr("has turned by"));

  const auto &before = of_small.before, &after = of_promoted.after;
  ASSERT_GT(before.size(), 100u);
  ASSERT_EQ(before.size(), after.size());
  int loaded = 0, damaged = 0;
  for (const auto& [key, a] : before) {
    const auto found = after.find(key);
    ASSERT_NE(found, after.end());
    const Seen& b = found->second;
    EXPECT_EQ(a.sigma, b.sigma);
    // Axes of blocks that have rotated by 1e-4: the components are equal, their directions in space differ.
    EXPECT_NEAR(std::hypot(a.shear[0], a.shear[1], a.shear[2]), std::hypot(b.shear[0], b.shear[1], b.shear[2]),
                1e-15 * (std::abs(a.sigma) + 1e6));
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(a.shear[c], b.shear[c], 5e-4 * (std::abs(a.sigma) + 1e6));
    EXPECT_EQ(a.state, b.state);
    loaded += a.sigma != 0.0;
    damaged += a.state[0] > 0.0 || a.state[1] > 0.0;
  }
  EXPECT_GT(loaded, 100);
  EXPECT_GT(damaged, 0);
}

// Seats of dilating joints are vectors along the axes of a point, which are others in large motion. Scalars beside them
// stay to the bit. Blocks have turned by 1e-4.
TEST(Promotion, SeatsOfJointsKeepTheirDirectionInSpace) {
  const Both runs({"joints.mortar.law=cyclic_joint", "joints.mortar.dilation_angle=15",
                   "joints.mortar.dilation_length=1e-4", "joints.mortar.dilation_pressure=5e6",
                   "joints.mortar.cohesion=0.02e6", "joints.mortar.fracture_energy_shear=2",
                   "joints.mortar.friction_angle=20", "stage.precompression.pressure=0.1e6"});
  const auto& [settings, small, promoted, of_small, of_promoted] = runs;
  ASSERT_EQ(of_promoted.promotions, 1);
  ASSERT_EQ(of_small.before.size(), of_promoted.after.size());
  int seated = 0;
  for (const auto& [key, a] : of_small.before) {
    const Seen& b = of_promoted.after.at(key);
    EXPECT_EQ(a.state, b.state);
    const double length = std::hypot(a.seat[0], a.seat[1], a.seat[2]);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(a.seat[c], b.seat[c], 5e-4 * length);
    seated += length > 1e-8;
  }
  EXPECT_GT(seated, 10);
}

// Positions and velocities are continuous. The tolerance is the second-order part of a rotation of 1e-4 rad, 1e-8 / 2
// of a block's size of 0.2 m.
TEST(Promotion, KeepsPlaceAndVelocityOfEveryGridpoint) {
  const Both runs;
  const auto& [settings, small, promoted, of_small, of_promoted] = runs;
  ASSERT_GT(of_small.gridpoints.size(), 100u);
  ASSERT_EQ(of_small.gridpoints.size(), of_promoted.gridpoints.size());
  double largest = 0.0, fastest = 0.0;
  for (const auto& [place, before] : of_small.gridpoints) {
    const auto after = of_promoted.gridpoints.find(place);
    ASSERT_NE(after, of_promoted.gridpoints.end());
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(before.first[c], after->second.first[c], 1e-9);
      EXPECT_NEAR(before.second[c], after->second.second[c], 2e-4 * 0.02);
      largest = std::max(largest, std::abs(before.first[c]));
      fastest = std::max(fastest, std::abs(before.second[c]));
    }
  }
  EXPECT_GT(largest, 1e-6) << "nothing has moved: nothing is tested";
  EXPECT_GT(fastest, 1e-3);
}

// Up to 0.5 mm the two walls differ by what small displacements neglect. Tolerance 0.5 % of the peak, as for large
// motion from the start (large_motion_test).
TEST(Promotion, GoesOnAlongTheSameCurve) {
  Scene stays = wall("never");
  stays.solver.motion_bound.stop = false;
  Simulation small(stays), promoted(wall("automatic"));
  Watch of_small, of_promoted;
  small.run(of_small);
  promoted.run(of_promoted);
  ASSERT_GT(peak(of_small.rows), 1e3);
  EXPECT_NEAR(peak(of_promoted.rows), peak(of_small.rows), 0.005 * peak(of_small.rows));
  // Force and displacement are continuous at the promotion: neighbouring rows differ by less than 2 % of the peak.
  const long step = promoted.outcome().promotion->step;
  const auto& rows = of_promoted.rows;
  const auto next = std::find_if(rows.begin(), rows.end(), [&](const HistoryRow& r) { return r.step > step; });
  ASSERT_NE(next, rows.end());
  ASSERT_NE(next, rows.begin());
  EXPECT_NEAR(next->resistance, (next - 1)->resistance, 0.02 * peak(rows));
  EXPECT_GT(next->time, (next - 1)->time);
  EXPECT_GE(next->displacement, (next - 1)->displacement);
  EXPECT_NEAR(next->vertical_force, (next - 1)->vertical_force, 0.02 * (next - 1)->vertical_force);
}

// Strain energy is that of the displacements without rigid rotation: its change is a share of 1e-4, the strain. The
// balance error at the end is at most 1 % of the work.
TEST(Promotion, EnergyGoesOnToClose) {
  Simulation promoted(wall("automatic", {"output.energy=true"}));
  Watch watch;
  promoted.run(watch);
  ASSERT_EQ(watch.promotions, 1);
  const Promotion& p = *promoted.outcome().promotion;
  EXPECT_GT(p.strain_energy, 0.0);
  EXPECT_LT(std::abs(p.energy_jump), 1e-3 * p.strain_energy);
  const Energies& end = *watch.rows.back().energies;
  EXPECT_GT(end.external, 0.0);
  EXPECT_LT(std::abs(end.balance_error()), 0.01 * end.external);
}

// Some blocks of this building have turned past the bound of fixed frames. So there are more pieces than before, and
// all of them must move from the first step on. Where some stood still, 1e9 J came from nowhere. The balance of energy
// closes to 1 % of the work at every row, while more blocks leave their fixed frames.
TEST(Promotion, MovesAllPiecesAndClosesWhereSomeFramesStayFixed) {
  Simulation s(read_scene(
      QUOIN_HOST_TESTS "/small_building.toml",
      {"stage.push.displacement=0.006", "stage.push.record_interval=10", "output.energy=true", "output.frames=0"}));
  Watch watch;
  s.run(watch);
  ASSERT_EQ(watch.promotions, 1);
  const auto& fixed = s.large_motion()->frames.fixed;
  EXPECT_GT(std::ranges::count(fixed, 1), 10);
  EXPECT_GT(std::ranges::count(fixed, 0), 10);
  double worst = 0.0;
  for (const HistoryRow& row : watch.rows) worst = std::max(worst, std::abs(row.energies->balance_error()));
  EXPECT_LT(worst, 0.01 * watch.rows.back().energies->external);
}

// The strain energy of soft units sheared by a tenth differs between large rotations and small strains by a thousandth
// or more. This jump is not work; it is a term of the energy balance. The balance error changes by at most a twentieth
// of the jump. This holds from the second step on, since in the first one blocks still have old frames.
TEST(Promotion, TheJumpOfStrainEnergyIsInTheBalance) {
  Simulation s(read_scene(
      QUOIN_HOST_TESTS "/../cli/small_wall.toml",
      {"materials.brick.young_modulus=2e7",
       "joints.mortar={law = \"elastic\", normal_stiffness = 3e9, shear_stiffness = 3e9}", "solver.damping=viscous",
       "solver.mass_damping=20", "solver.rotation_bound=0.05", "solver.sliding_bound=0.2",
       "solver.time_step_fraction=0.3", "stage.precompression.pressure=1e3", "stage.shear.velocity=1.0",
       "stage.shear.displacement=0.04", "stage.shear.record_interval=1", "output.energy=true", "output.frames=0"}));
  Watch watch;
  s.run(watch);
  ASSERT_EQ(watch.promotions, 1);
  const Promotion& p = *s.outcome().promotion;
  const auto after = std::find_if(watch.rows.begin(), watch.rows.end(), [&](const auto& r) { return r.step > p.step; });
  ASSERT_GT(watch.rows.end() - after, 5);
  EXPECT_GT(std::abs(p.energy_jump), 1e-3 * p.strain_energy);
  const double before = (after - 1)->energies->balance_error();
  for (auto row = after + 1; row != after + 5; ++row)
    EXPECT_NEAR(row->energies->balance_error(), before, 0.05 * std::abs(p.energy_jump)) << row->step - p.step;
}

// A run resumed after the promotion is bitwise identical to the uninterrupted run. So is one restored to a state before
// the promotion.
TEST(Promotion, IsKeptByCheckpoints) {
  const Scene scene = wall("automatic");
  Simulation whole(scene);
  Watch watch;
  whole.run(watch);
  ASSERT_FALSE(watch.saved.empty());
  Simulation resumed(scene, 2);
  const std::vector<std::uint8_t> start = resumed.save();
  resumed.restore(watch.saved);
  ASSERT_TRUE(resumed.large_motion());
  EXPECT_EQ(resumed.outcome().promotion->step, whole.outcome().promotion->step);
  Watch rest;
  resumed.run(rest);
  EXPECT_EQ(resumed.hash(), whole.hash());
  EXPECT_EQ(rest.rows.back().resistance, watch.rows.back().resistance);

  resumed.restore(start);
  EXPECT_FALSE(resumed.large_motion());
  EXPECT_FALSE(resumed.outcome().promotion);
  Watch again;
  resumed.run(again);
  EXPECT_EQ(resumed.hash(), whole.hash());
}

// Gridpoints in the plane of symmetry stay in it, and forces are those of the whole wall.
TEST(Promotion, HalfOfTheThicknessKeepsItsPlane) {
  Simulation half(wall("automatic", {"wall.zones=[2,1,2]", "wall.half_thickness=true"})),
      all(wall("automatic", {"wall.zones=[2,1,2]"}));
  Watch of_half, of_all;
  half.run(of_half);
  all.run(of_all);
  ASSERT_EQ(of_half.promotions, 1);
  ASSERT_EQ(of_all.promotions, 1);
  EXPECT_NEAR(peak(of_half.rows), peak(of_all.rows), 0.01 * peak(of_all.rows));
  for (int b = 0; b < half.block_count(); ++b) {
    const auto mesh = block_mesh(half, b);
    const auto moved = block_displacement(half, b);
    for (std::size_t i = 0; i < moved.size(); ++i) {
      if (mesh.gridpoint[i][2] != 0.0) continue;
      EXPECT_NEAR(moved[i][2], 0.0, 1e-16);  // corners of a beam: rounding
    }
  }
}

// Floors under a whiffletree and deformable blocks with loads continue their motion. Displacement and force of the roof
// agree with the run in small displacements, to 2 % of the peak. A restart of the whiffletree's ramp at the promotion
// would raise the force by 15 kN.
TEST(Promotion, WhiffletreeGoesOn) {
  const std::vector<std::string> more = {"solver.rotation_bound=5e-4", "stage.push.displacement=0.0025",
                                         "stage.push.record_interval=50", "output.frames=0"};
  const auto building = [&](const std::string& large_motion) {
    std::vector<std::string> settings = more;
    settings.push_back("solver.large_motion=" + large_motion);
    Scene scene = read_scene(QUOIN_HOST_TESTS "/small_building.toml", settings);
    scene.solver.motion_bound.stop = false;
    return scene;
  };
  Simulation small(building("never")), promoted(building("automatic"));
  Watch of_small, of_promoted;
  small.run(of_small);
  promoted.run(of_promoted);
  ASSERT_EQ(of_promoted.promotions, 1);
  EXPECT_LT(promoted.outcome().promotion->step, small.step());
  const double largest = peak(of_small.rows);
  ASSERT_GT(largest, 5e3);
  EXPECT_NEAR(peak(of_promoted.rows), largest, 0.02 * largest);
  EXPECT_NEAR(of_promoted.rows.back().time, of_small.rows.back().time, 0.02 * of_small.rows.back().time);
  double before = 0.0;
  for (const HistoryRow& row : of_promoted.rows) {
    if (row.stage == 0) continue;
    EXPECT_GT(row.displacement, before - 5e-5) << "at step " << row.step;
    before = row.displacement;
  }
}

// A stage that goes over where it begins, and releases the beam that the stage before has pushed. The force of the
// support fades over its ramp, as in large motion from the start: within 1 % of it, the difference of the two strains.
// Without that reaction the beam would spring back at once, by a third of the force in 20 steps.
void expect_released_reactions_fade(const std::vector<std::string>& settings) {
  const auto pushed = [&](const std::string& large_motion) {
    const std::string text = R"(
[solver]
quality = "fast"
large_motion = ")" + large_motion +
                             R"("
[materials.brick]
young_modulus = 5e9
poisson_ratio = 0.15
density = 1900.0
[joints.mortar]
law = "elastic"
normal_stiffness = 20e9
shear_stiffness = 8e9
[wall]
bond = "running"
courses = 4
units_per_course = 2.5
unit = [0.22, 0.0625, 0.1]
zones = [2, 2, 2]
mid_unit_joints = false
unit_material = "brick"
bed_joint = "mortar"
head_joint = "mortar"
beam_joint = "mortar"
[[stage]]
name = "press"
kind = "pressure"
pressure = 0.3e6
[[stage]]
name = "shear"
kind = "shear"
vertical = "pressure"
displacement = 5e-5
velocity = 0.01
[[stage]]
name = "release"
duration = 0.005
ramp_time = 0.01
record_interval = 20
[[stage.force]]
block = "top_beam"
point = [0.275, 0.3, 0.05]
force = [1.0, 0, 0]
[output]
frames = 0
)";
    Simulation run(read_scene_text(text, "pushed.toml", settings));
    Watch seen;
    run.run(seen);
    EXPECT_EQ(seen.promotions, large_motion == "automatic" ? 1 : 0);
    std::erase_if(seen.rows, [](const HistoryRow& row) { return row.stage < 2; });
    return seen.rows;
  };
  const std::vector<HistoryRow> promoted = pushed("automatic"), always = pushed("always");
  ASSERT_EQ(promoted.size(), always.size());
  ASSERT_GT(promoted.size(), 4u);
  const double force = always.front().resistance;
  EXPECT_GT(force, 2.5e3);
  for (std::size_t i = 0; i < promoted.size(); ++i)
    EXPECT_NEAR(promoted[i].resistance, always[i].resistance, 0.01 * force) << "at step " << promoted[i].step;
  const double lowered = always.back().monitor_displacement[1];
  for (std::size_t i = 0; i < promoted.size(); ++i)
    EXPECT_NEAR(promoted[i].monitor_displacement[1], always[i].monitor_displacement[1], 0.01 * std::abs(lowered))
        << "at step " << promoted[i].step;
}

TEST(Promotion, ReactionsOfReleasedSupportsFade) { expect_released_reactions_fade({}); }

// The beam is held along the vertical too, under a weight of its own of 8 kN: the reaction that fades carries that
// weight. It had lost it, so that the weight came at once.
TEST(Promotion, ReactionsOfReleasedSupportsCarryTheWeight) {
  const char* const kDown = "gravity=[0, -9.81, 0]";
  expect_released_reactions_fade({"stage.press." + std::string(kDown), "stage.shear." + std::string(kDown),
                                  "stage.release." + std::string(kDown), "stage.shear.vertical=held",
                                  "wall.beam_density=240000"});
}

}  // namespace
}  // namespace quoin
