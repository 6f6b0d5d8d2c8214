// Initial damage against closed forms of the law: remaining strengths, openings that close without force, cracks that
// separate a wall. Also support settlements, missing units, and runs that continue other runs.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>

#include "base/error.h"
#include "results/checkpoint_file.h"
#include "scene/generate.h"
#include "scene/read_scene.h"
#include "step/results.h"
#include "step/simulation.h"

namespace quoin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kFt = 0.2e6, kFc = 5e6, kGc = 8000.0;  // Pa, J/m2; linear softening
constexpr double kBedArea = 0.22 * 0.1;                 // m2, of one unit

std::string wall_text(int courses, double units, const std::string& more, const std::string& stages) {
  return fmt::format(
      "[materials.brick]\nyoung_modulus = 16.7e9\npoisson_ratio = 0.15\ndensity = 1900.0\n"
      "[joints.mortar]\nlaw = \"fracture_energy\"\nsoftening = \"linear\"\nnormal_stiffness = 82e9\n"
      "shear_stiffness = 36e9\ntensile_strength = {}\ncohesion = 0.3e6\nfriction_angle = 35\n"
      "compressive_strength = {}\nfracture_energy_tension = 15\nfracture_energy_shear = 125\n"
      "fracture_energy_compression = {}\n"
      "[wall]\ncourses = {}\nunits_per_course = {}\nunit = [0.22, 0.0625, 0.1]\nzones = [1, 1, 1]\n"
      "mid_unit_joints = false\nunit_material = \"brick\"\nbed_joint = \"mortar\"\nhead_joint = \"mortar\"\n"
      "beam_joint = \"mortar\"\n{}\n{}",
      kFt, kFc, kGc, courses, units, more, stages);
}

// Returns a stage that moves the top beam vertically by `displacement`, slowly; its horizontal motion is fixed.
std::string moved(double velocity, double displacement) {
  return fmt::format(
      "[[stage]]\nname = \"moved\"\nkind = \"custom\"\nmonitor = \"top_beam\"\ndirection = \"y\"\ndisplacement = {}\n"
      "ramp_time = 0.002\n[[stage.control]]\nbody = \"bottom_beam\"\nvelocity = [0, 0, 0]\n"
      "[[stage.control]]\nbody = \"top_beam\"\nvelocity = [0, {}, 0]\n",
      displacement, velocity);
}

const char* const kFrictional =
    "joints.mortar={law=\"coulomb_slip\",normal_stiffness=82e9,shear_stiffness=36e9,friction_angle=35}";
const char* const kElastic = "joints.mortar={law=\"elastic\",normal_stiffness=82e9,shear_stiffness=36e9}";

// joints: a table in place of that of the mortar; none where empty.
Scene read(const std::string& text, const std::string& kernels = "lattice", const std::string& joints = "") {
  std::vector<std::string> overrides{"solver.kernels=" + kernels};
  if (!joints.empty()) overrides.push_back(joints);
  return read_scene_text(text, "damaged.toml", overrides);
}

struct Rows : Observer {
  std::vector<HistoryRow> rows;
  void on_row(const HistoryRow& row) override { rows.push_back(row); }
};

std::vector<HistoryRow> run(const std::string& text, const std::string& kernels, const std::string& joints = "") {
  Simulation simulation(read(text, kernels, joints), 1);
  Rows rows;
  simulation.run(rows);
  return rows.rows;
}

double largest(const std::vector<HistoryRow>& rows, double sign) {
  double most = 0.0;
  for (const HistoryRow& row : rows) most = std::max(most, sign * row.vertical_force);
  return most;
}

class Damaged : public ::testing::TestWithParam<const char*> {};

// The lower one of two joints has damage xi and strength f(xi) ft. Tolerance 1 %: the beam moves at 5 mm/s.
TEST_P(Damaged, JointHasWhatItsSofteningLeaves) {
  for (const double xi : {0.0, 0.4, 0.8}) {
    const std::string damage = fmt::format("[[damage]]\njoints = \"mortar\"\nto = [1, 0.01, 1]\nxi = {}\n", xi);
    const auto rows = run(wall_text(1, 1, damage, moved(0.005, 1.6e-4)), GetParam());
    EXPECT_NEAR(largest(rows, -1.0), (1.0 - xi) * kFt * kBedArea, 0.01 * kFt * kBedArea) << xi;
  }
}

// A crushed toe has strength fcr + (fc - fcr) f(w/wu). Its plastic closure exists from the start, so its traction is 0
// before loading.
TEST_P(Damaged, ToeHasWhatCrushingLeaves) {
  const double wu = 2.0 * kGc / kFc, w = 0.4 * wu;
  const std::string damage = fmt::format("[[damage]]\nto = [1, 0.01, 1]\nstate = {{ w = {} }}\n", w);
  const std::string text = wall_text(1, 1, damage, moved(-0.005, 1.2e-4));
  Simulation simulation(read(text, GetParam()), 1);
  simulation.advance(2);
  for (const ContactPoint& p : contact_points(simulation)) EXPECT_NEAR(p.traction[0], 0.0, 1e-3 * kFc);
  EXPECT_NEAR(largest(run(text, GetParam()), 1.0), 0.6 * kFc * kBedArea, 0.01 * kFc * kBedArea);
}

// A joint with an initial opening closes without force, and then has friction only.
TEST_P(Damaged, OpenJointClosesWithoutForce) {
  const double gap = 1e-4;
  const std::string damage =
      fmt::format("[[damage]]\nfrom = [0, 0.06, 0]\ninitial_state = \"dry\"\nopening = {}\n", gap);
  for (const char* joints : {"", kFrictional}) {
    const auto rows = run(wall_text(1, 1, damage, moved(-0.005, 1.3e-4)), GetParam(), joints);
    const double full = largest(rows, 1.0);
    EXPECT_GT(full, 10e3);
    Simulation simulation(read(wall_text(1, 1, damage, moved(-0.005, 1.3e-4)), GetParam(), joints), 1);
    simulation.advance(1);
    for (const ContactPoint& p : contact_points(simulation)) {
      if (p.position[1] > 0.06) {
        EXPECT_NEAR(p.jump[0], gap, 1e-3 * gap);  // was 0 on the lattice
      }
    }
    for (const HistoryRow& row : rows) {
      if (std::abs(row.displacement) < 0.98 * gap) {
        EXPECT_NEAR(row.vertical_force, 0.0, 1e-9 * full);
      } else if (std::abs(row.displacement) > 1.05 * gap) {
        EXPECT_GT(row.vertical_force, 1e3);
      }
    }
  }
}

// Initial slip s without pressure leaves f(s/su) of the cohesion, su = 2 G2/c: 0.5 at s = su/2.
TEST_P(Damaged, SlipLeavesItsDamage) {
  const double su = 2.0 * 125.0 / 0.3e6;
  const std::string damage = fmt::format("[[damage]]\nslip = {}\n", 0.5 * su);
  Simulation simulation(read(wall_text(1, 1, damage, moved(0.005, 1e-5)), GetParam()), 1);
  const double elastic = 0.3e6 / 36e9;  // m, elastic shear displacement at first slip
  const std::vector<double> xi = law_state(simulation, "xi_s");
  ASSERT_FALSE(xi.empty());
  for (const double x : xi) EXPECT_NEAR(x, 0.5, 2.0 * elastic / su);
}

// Faces that ride up open the joint, free of pressure: v = tan(psi0) sd (x - x^2/2) at x = slip/sd, and no crushing.
// The joint was held shut: it slid a third less under its own pressure, and could crush. In beds the upper block has
// moved along x. The slip was across the wall, but for a joint whose upper block is a in large motion.
TEST_P(Damaged, SlipUnderDilationOpensTheJoint) {
  const double slip = 1e-4, length = 5e-4;
  const std::string joint =
      "joints.mortar={law=\"cyclic_joint\",normal_stiffness=20e9,shear_stiffness=9e9,friction_angle=35,dilation_angle="
      "20,"
      "dilation_length=5e-4,compressive_strength=4e6,fracture_energy_compression=8000}";
  Simulation simulation(
      read(wall_text(2, 1, fmt::format("[[damage]]\nslip = {}\n", slip), moved(0.005, 1e-5)), GetParam(), joint), 1);
  const double x = slip / length, uplift = std::tan(20.0 * std::numbers::pi / 180.0) * length * (x - 0.5 * x * x);
  const std::vector<double> v = law_state(simulation, "v_m"), g_s = law_state(simulation, "g_s"),
                            g_t = law_state(simulation, "g_t"), crushed = law_state(simulation, "l");
  const std::vector<ContactPoint> points = contact_points(simulation);
  ASSERT_FALSE(points.empty());
  // The pressure that is left is that of a thousandth of the uplift.
  for (const ContactPoint& p : points) {
    const auto i = static_cast<std::size_t>(p.index);
    EXPECT_NEAR(std::hypot(g_s[i], g_t[i]), slip, 2e-3 * slip);
    EXPECT_NEAR(v[i], uplift, 3e-3 * uplift);
    EXPECT_EQ(crushed[i], 0.0);
    const double upper = p.normal[1] > 0.0 ? 1.0 : -1.0;
    if (std::abs(p.normal[1]) > 0.9) {
      EXPECT_NEAR(upper * (g_s[i] * p.s[0] + g_t[i] * p.t[0]), slip, 2e-3 * slip);
    }
  }
}

// Joints of a wall of three courses whose units are 0.22 m long, by the middle of their points and whether they are
// damaged.
std::map<std::pair<int, int>, std::tuple<double, double, bool>> joints_of(const Simulation& simulation) {
  std::map<std::pair<int, int>, std::array<double, 4>> sums;  // area, area times x and y; area of damaged points
  const std::vector<double> xi = law_state(simulation, "xi_t");
  for (const ContactPoint& p : contact_points(simulation)) {
    auto& [area, x, y, damaged] = sums[std::minmax(p.block_a, p.block_b)];
    area += p.area, x += p.area * p.position[0], y += p.area * p.position[1];
    damaged += xi[static_cast<std::size_t>(p.index)] == 1.0 ? p.area : 0.0;
  }
  std::map<std::pair<int, int>, std::tuple<double, double, bool>> joints;
  for (const auto& [pair, sum] : sums) {
    EXPECT_TRUE(sum[3] == 0.0 || std::abs(sum[3] - sum[0]) < 1e-12) << "a joint in part";
    joints[pair] = {sum[1] / sum[0], sum[2] / sum[0], sum[3] > 0.0};
  }
  return joints;
}

// Which joints a straight crack follows: those between whose middle and a unit's centre it passes. Courses are 0.0625 m
// high; head joints are at 0.22 m in the first and third, at 0.11 and 0.33 m in the second.
TEST_P(Damaged, ACrackTakesTheJointsBesideTheCentresThatItPasses) {
  const auto cracked = [&](const char* crack, const auto& expected) {
    Simulation simulation(
        read(wall_text(3, 2, fmt::format("[[damage]]\ncrack = {}\n", crack), moved(0.005, 1e-5)), GetParam()), 1);
    const auto joints = joints_of(simulation);
    EXPECT_EQ(joints.size(), 2u + 4u + 4u + 2u + 1u + 2u + 1u) << "beds from below, then head joints";
    for (const auto& [pair, joint] : joints) {
      const auto [x, y, damaged] = joint;
      EXPECT_EQ(damaged, expected(x, y)) << crack << " at " << x << " " << y;
    }
  };
  const auto is = [](double a, double b) { return std::abs(a - b) < 1e-9; };
  // 0.16 m is between the centre at 0.11 m and the head joint at 0.22 m; the bed between them has its middle at 0.165
  // m.
  const auto upright = [&](double x, double y) {
    const bool head_of_second = is(y, 0.09375);
    return is(x, 0.165) || (head_of_second ? is(x, 0.11) : is(x, 0.22) && !is(y, 0.0) && !is(y, 0.1875));
  };
  cracked("[[0.16, -0.1], [0.16, 1]]", upright);
  cracked("[[0.16, 0.09], [0.16, 1], [0.5, 1], [0.5, -1], [0.16, -1], [0.16, 0.09]]", upright);
  // Below the centres of the second course, above those of the first: the bed between them.
  cracked("[[-0.1, 0.09], [1, 0.09]]", [&](double, double y) { return is(y, 0.0625); });
  cracked("[[-0.1, 0.04], [1, 0.04]]", [&](double, double y) { return is(y, 0.0625); });
  cracked("[[-0.1, 0.01], [1, 0.01]]", [&](double, double y) { return is(y, 0.0); });
  cracked("[[-0.1, 0.18], [1, 0.18]]", [&](double, double y) { return is(y, 0.1875); });
  // One that ends at 0.2 m: of the bed, the parts with middles at 0.055 and 0.165 m.
  cracked("[[-0.1, 0.04], [0.2, 0.04]]", [&](double x, double y) { return is(y, 0.0625) && x < 0.2; });
}

// Returns true if all blocks are connected by joints with at least one point that is not fully softened.
bool hangs_together(const Simulation& simulation, double end) {
  const std::vector<ContactPoint> points = contact_points(simulation);
  const std::vector<double> xi = law_state(simulation, "xi_t");
  std::vector<int> leader(static_cast<std::size_t>(simulation.block_count()));
  std::iota(leader.begin(), leader.end(), 0);
  const auto find = [&](int b) {
    while (leader[static_cast<std::size_t>(b)] != b) b = leader[static_cast<std::size_t>(b)];
    return b;
  };
  for (const ContactPoint& p : points)
    if (xi[static_cast<std::size_t>(p.index)] < end)
      leader[static_cast<std::size_t>(find(p.block_a))] = find(p.block_b);
  const auto [lowest, highest] = std::minmax_element(
      points.begin(), points.end(), [](const auto& p, const auto& q) { return p.position[1] < q.position[1]; });
  return find(lowest->block_a) == find(highest->block_a);
}

// A crack from side to side separates the wall for any course of the crack; one that ends inside the wall does not. The
// separated part carries no tension once it moves with the beam; the tolerance for vibration is 1e-3 of the strength.
TEST_P(Damaged, WallThatIsCutCarriesNoTension) {
  const std::string through = "[[damage]]\ncrack = [[-0.01, 0.03], [0.2, 0.11], [0.45, 0.22]]\n";
  const std::string half = "[[damage]]\ncrack = [[-0.01, 0.03], [0.2, 0.11]]\n";
  const auto wall = [&](const std::string& damage) { return wall_text(4, 2, damage, moved(0.005, 4e-5)); };
  const double sound = largest(run(wall(""), GetParam()), -1.0);
  EXPECT_GT(sound, 0.9 * kFt * 2 * kBedArea);
  auto parted = run(wall(through), GetParam());
  std::erase_if(parted, [](const HistoryRow& row) { return row.displacement < 2e-5; });
  ASSERT_FALSE(parted.empty());
  EXPECT_LT(largest(parted, -1.0), 1e-3 * sound);
  EXPECT_FALSE(hangs_together(Simulation(read(wall(through), GetParam()), 1), 1.0));
  EXPECT_TRUE(hangs_together(Simulation(read(wall(half), GetParam()), 1), 1.0));
}

INSTANTIATE_TEST_SUITE_P(BothKinds, Damaged, ::testing::Values("lattice", "general"));

// A crack follows the joints around units unless through_units is true.
TEST(Damage, CrackGoesRoundUnits) {
  const auto broken = [](const std::string& keys) {
    const std::string damage = "[[damage]]\ncrack = [[0.16, -0.1], [0.17, 1]]\n" + keys;
    const std::string text = wall_text(3, 2, "unit_joint = \"mortar\"\n" + damage, moved(0.005, 1e-5));
    Scene scene = read_scene_text(text, "damaged.toml", {"wall.mid_unit_joints=true"});
    Simulation simulation(std::move(scene), 1);
    const std::vector<ContactPoint> points = contact_points(simulation);
    const std::vector<double> xi = law_state(simulation, "xi_t");
    long inside_units = 0;
    for (const ContactPoint& p : points) {
      const auto& bricks = simulation.assembly().bricks;
      const int a = bricks[static_cast<std::size_t>(p.block_a)].unit;
      const int b = bricks[static_cast<std::size_t>(p.block_b)].unit;
      if (xi[static_cast<std::size_t>(p.index)] > 0.0 && a >= 0 && a == b) ++inside_units;
    }
    return inside_units;
  };
  EXPECT_EQ(broken(""), 0);
  EXPECT_GT(broken("through_units = true\n"), 0);
}

std::string fault_of(const std::string& damage, const std::string& joints = "") {
  try {
    Simulation simulation(read(wall_text(1, 1, damage, moved(0.005, 1e-5)), "lattice", joints), 1);
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::bad_input);
    return error.what();
  }
  return "";
}

TEST(Damage, WhatCannotBeIsRefusedWithItsPlaceAndReason) {
  EXPECT_THAT(fault_of("[[damage]]\nstate = { omega = 1 }\n"), HasSubstr("has no such state; it has: xi_t, xi_s, w"));
  EXPECT_THAT(fault_of("[[damage]]\nstate = { w = -1 }\n"), HasSubstr("allows 0 to"));
  EXPECT_THAT(fault_of("[[damage]]\nfrom = [5, 0, 0]\n"), HasSubstr("no contact point of its joints lies there"));
  EXPECT_THAT(fault_of("[[damage]]\nxi = 0.1\nopening = 1e-4\n"), HasSubstr("give initial_state = \"dry\""));
  // A later entry without an opening had closed the joint again, in silence.
  EXPECT_THAT(fault_of("[[damage]]\ninitial_state = \"dry\"\nopening = 1e-4\n[[damage]]\ninitial_state = \"bonded\"\n"),
              AllOf(HasSubstr("damage.1: opening = 0.0001 m"), HasSubstr("cannot stand open"),
                    HasSubstr("damage.2 changes it later")));
  EXPECT_THAT(fault_of("[[damage]]\nopening = 1e-4\n", kElastic), HasSubstr("law elastic, which carries tension in"));
  EXPECT_THAT(fault_of("[[damage]]\nxi = 0.1\n", kElastic), HasSubstr("has no softening variable xi"));
  EXPECT_THAT(fault_of("[[damage]]\ninitial_state = \"wet\"\n"), HasSubstr("wet"));
  EXPECT_THAT(fault_of("[[damage]]\ncrack = [[0, 0]]\n"), HasSubstr("2 or more points"));
  EXPECT_THAT(fault_of("[[damage]]\njoints = \"morter\"\n"), HasSubstr("did you mean 'mortar'"));
  EXPECT_THAT(fault_of("[[damage]]\nfrom = [0, 1, 0]\nto = [1, 0, 1]\n"), HasSubstr("not below from"));
  EXPECT_THAT(fault_of("[[damage]]\nalong = \"z\"\n"), HasSubstr("only with a crack"));
}

// One part of the support settles by 0.02 mm under a wall with constant load. This part carries less than before; the
// sum of both does not change (equilibrium).
TEST(Damage, SupportThatSettlesCarriesLess) {
  const std::string stages =
      "[[stage]]\nname = \"load\"\nkind = \"pressure\"\npressure = 0.3e6\n"
      "[[stage]]\nname = \"settlement\"\nkind = \"custom\"\nduration = 0.02\nmonitor = \"bottom_beam_2\"\n"
      "[[stage.control]]\nbody = \"bottom_beam_1\"\nvelocity = [0, 0, 0]\n"
      "[[stage.control]]\nbody = \"bottom_beam_2\"\nvelocity = [0, -0.001, 0]\n"
      "[[stage.control]]\nbody = \"top_beam\"\nvelocity = [0, \"free\", 0]\nforce = [0, -13200, 0]\n"
      "[[stage]]\nname = \"rest\"\nkind = \"custom\"\nequilibrium_ratio = 1e-3\nmonitor = \"bottom_beam_2\"\n"
      "[[stage.control]]\nbody = \"bottom_beam_1\"\nvelocity = [0, 0, 0]\n"
      "[[stage.control]]\nbody = \"bottom_beam_2\"\nvelocity = [0, 0, 0]\n"
      "[[stage.control]]\nbody = \"top_beam\"\nvelocity = [0, \"free\", 0]\nforce = [0, -13200, 0]\n";
  Simulation simulation(read(wall_text(4, 2, "bottom_beam_cuts = [2]\n", stages)), 1);
  Rows rows;
  const auto carried = [&](const std::string& part) {  // vertical force on a part of the support, N
    const auto& bricks = simulation.assembly().bricks;
    double force = 0.0;
    for (const ContactPoint& p : contact_points(simulation))
      for (const int b : {p.block_a, p.block_b})
        if (bricks[static_cast<std::size_t>(b)].body.starts_with(part)) force -= p.traction[0] * p.area;
    return force;
  };
  simulation.run_stage(rows);
  EXPECT_NEAR(carried("bottom_beam_2"), 6600.0, 0.02 * 6600.0);
  EXPECT_NEAR(carried("bottom_beam"), 13200.0, 0.01 * 13200.0);
  simulation.run(rows);
  EXPECT_NEAR(rows.rows.back().monitor_displacement[1], -0.02e-3, 2e-6);
  EXPECT_LT(carried("bottom_beam_2"), 5500.0);
  EXPECT_NEAR(carried("bottom_beam"), 13200.0, 0.01 * 13200.0);
}

TEST(Damage, UnitsAreMissingOrReplaced) {
  const std::string other = "[materials.other]\nyoung_modulus = 1e9\npoisson_ratio = 0.2\ndensity = 1000\n";
  const std::string changed =
      "[[wall.changed]]\ncourse = 1\nhalf_unit = 2\nmissing = true\n[[wall.changed]]\ncourse = 2\nhalf_unit = 1\n"
      "material = \"other\"\n";
  const auto bricks = [&](const std::string& keys) {
    return assemble(read(other + wall_text(3, 2, keys, moved(0.005, 1e-5))));
  };
  const Assembly sound = bricks(""), hurt = bricks(changed);
  EXPECT_EQ(hurt.bricks.size() + 1, sound.bricks.size());
  EXPECT_LT(hurt.joints.size(), sound.joints.size());
  double replaced = 0.0;
  for (const Brick& b : hurt.bricks) {
    const double middle = b.origin[0] + b.size[0] / 2;
    EXPECT_FALSE(b.course == 1 && std::abs(middle - 0.22) < 0.01);
    if (hurt.materials[static_cast<std::size_t>(b.material)].name == "other") replaced += b.size[0];
  }
  EXPECT_NEAR(replaced, 0.22, 1e-9);
  EXPECT_THROW(bricks("[[wall.changed]]\ncourse = 1\nhalf_unit = 0\n"), Error);
}

// A run that continues another one is bitwise identical to one run of all stages.
TEST(Damage, RunBeginsWhereAnotherHasEnded) {
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("quoin_damage_{}", getpid());
  std::filesystem::create_directories(folder);
  const std::string load = "[[stage]]\nname = \"load\"\nkind = \"pressure\"\npressure = 0.3e6\n";
  const std::string shear = "[[stage]]\nname = \"shear\"\nkind = \"shear\"\nvelocity = 0.05\ndisplacement = 1e-4\n";
  const auto settings = [&](bool start) {
    return start ? std::vector<std::string>{fmt::format("start=\"{}\"", folder.string())} : std::vector<std::string>{};
  };
  const auto rows_of = [&](const std::string& stages, bool start) {
    Simulation simulation(read_scene_text(wall_text(2, 2, "", stages), "damaged.toml", settings(start)), 1);
    take_start(&simulation);
    Rows rows;
    simulation.run(rows);
    if (!start) write_end_state(folder, simulation, provenance_of(simulation, {}));
    return rows.rows;
  };
  const auto whole = rows_of(load + shear, false);
  EXPECT_THROW(rows_of(load + shear, true), Error);  // no stage is left
  rows_of(load, false);
  const auto rest = rows_of(load + shear, true);
  ASSERT_FALSE(rest.empty());
  EXPECT_EQ(rest.front().stage, 1);
  EXPECT_EQ(rest.back().resistance, whole.back().resistance);
  EXPECT_EQ(rest.back().step, whole.back().step);
  EXPECT_THROW(rows_of(shear, true), Error);  // another first stage
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace quoin
