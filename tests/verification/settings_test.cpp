// Settings that would do nothing, or something else than they say, are refused with the reason. Faults that were found
// from outside: each of these scenes ran before, without a word.

#include "base/error.h"
#include "step/results.h"
#include "step/simulation.h"
#include "support.h"

namespace quoin::verification {
namespace {

const char* const kStone = R"(
[materials.stone]
young_modulus = 1e10
poisson_ratio = 0.2
density = 2000.0
)";
const char* const kDry = R"(
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 1e9
friction_angle = 35.0
)";
const char* const kBlocks = R"(
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-5, -1, -5], size = [40, 1, 10] }
[[block]]
name = "soft"
material = "stone"
rigid = false
divisions = [2, 2, 2]
box = { lower = [0, 0, 0], size = [1, 1, 1] }
[[block]]
name = "stiff"
material = "stone"
box = { lower = [3, 0, 0], size = [1, 1, 1] }
[output]
frames = 0
plots = false
)";
const char* const kStage = "[[stage]]\nduration = 0.1\nramp_time = 0.05\ngravity = [0, -9.81, 0]\n";
const char* const kWall =
    "[[dry_wall]]\nmaterial = \"stone\"\ncourses = 4\nunits_per_course = 4\nunit = [0.4, 0.2, 0.2]\norigin = [9, 0, "
    "0]\n";

quoin::Scene blocks_with(const std::string& more, const std::string& stage = kStage) {
  return scene_of(std::string(kStone) + kDry + kBlocks + more + stage);
}
std::string drive(const std::string& block, const std::string& keys) {
  return std::string(kStage) + "[[stage.velocity]]\nblock = \"" + block + "\"\n" + keys;
}
std::string force(const std::string& block, const std::string& point) {
  return std::string(kStage) + "[[stage.force]]\nblock = \"" + block + "\"\nforce = [1e3, 0, 0]\npoint = " + point +
         "\n";
}
std::string opening(const std::string& keys) {
  return std::string(kWall) + "[[dry_wall.opening]]\nbearing = 0\n" + keys;
}

struct Refused {
  const char* name;
  std::string more, stage;
  const char* reason;  // words of the message
};

void PrintTo(const Refused& of, std::ostream* out) { *out << of.name; }

class Settings : public ::testing::TestWithParam<Refused> {};

TEST_P(Settings, AreRefusedWhereTheyWouldDoNothing) {
  try {
    Simulation of(blocks_with(GetParam().more, GetParam().stage));
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.exit_code, Exit::bad_input);
    EXPECT_NE(std::string(e.what()).find(GetParam().reason), std::string::npos) << e.what();
  }
}

INSTANTIATE_TEST_SUITE_P(
    OfBlocks, Settings,
    ::testing::Values(
        Refused{"SpinOfASoftBlock", "", drive("soft", "velocity = [0, 0, 0]\nomega = [0, 1, 0]\n"),
                "omega is for rigid blocks, and this one deforms"},
        Refused{"FreeRotationOfASoftBlock", "", drive("soft", "velocity = [0.1, \"free\", 0]\nrotation_held = false\n"),
                "rotation_held = false is for rigid blocks"},
        Refused{"SecondVelocity", "",
                drive("stiff", "velocity = [0.1, \"free\", \"free\"]\n") +
                    "[[stage.velocity]]\nblock = \"stiff\"\nvelocity = [\"free\", 0.1, 0]\n",
                "each body once in a stage"},
        Refused{"ForceOnAFixedBlock", "", force("ground", "[0, 0, 0]"), "the force would do nothing"},
        Refused{"ForceOutsideASoftBlock", "", force("soft", "[9, 0.5, 0.5]"), "lies 8 m outside the block"},
        Refused{"PressureOnAFixedBlock", "",
                std::string(kStage) + "[[stage.pressure]]\nblock = \"ground\"\nnormal = [0, 1, 0]\npressure = 1e3\n",
                "the pressure would do nothing"},
        Refused{"CollapseWithoutWeight", "", "[[stage]]\ncollapse = { direction = [1, 0, 0], rate = 1.0 }\n",
                "its force is a share of the weight"},
        Refused{"OpeningFromRightToLeft", opening("from = 1.0\nto = 0.6\nsill = 0\nhead = 0.4\n"), kStage,
                "to = 0.6: allowed: more than from (1 m)"},
        Refused{"OpeningBeyondTheWall", opening("from = 1.0\nto = 5.0\nsill = 0\nhead = 0.4\n"), kStage,
                "at most the length of the wall, 1.6 m"},
        Refused{"OpeningUpsideDown", opening("from = 0.2\nto = 1.0\nsill = 0.6\nhead = 0.2\n"), kStage,
                "head = 0.2: allowed: more than sill (0.6 m)"},
        Refused{"OpeningAboveTheWall", opening("from = 0.2\nto = 1.0\nsill = 0.6\nhead = 1.0\n"), kStage,
                "at most the height of the wall, 0.8 m"},
        Refused{"RuleForNobody", "[[joint_rule]]\nfamily = \"none\"\nbetween = [\"zzz\", \"soft\"]\n", kStage,
                "no block has a name that begins with 'zzz'"},
        Refused{"TwoZonings",
                "[[block]]\nname = \"twice\"\nmaterial = \"stone\"\nrigid = false\ndivisions = [2, 2, 2]\n"
                "zone_edge = 0.3\nbox = { lower = [6, 0, 0], size = [1, 1, 1] }\n",
                kStage, "divisions = [ 2, 2, 2 ]: allowed: not beside zone_edge"},
        Refused{"ToleranceBeyondTheReachOfPoints",
                "[solver]\nkernels = \"general\"\n[contact]\njoint_tolerance = 0.03\n", kStage,
                "joint_tolerance = 0.03 m: allowed: at most 0.0125 m"}),
    [](const auto& of) { return std::string(of.param.name); });

TEST(Settings, OfTheSameKindThatActAreAccepted) {
  EXPECT_NO_THROW(Simulation(blocks_with("", drive("stiff", "velocity = [0, 0, 0]\nomega = [0, 1, 0]\n"))));
  EXPECT_NO_THROW(Simulation(blocks_with("", drive("soft", "velocity = [0.1, \"free\", 0]\n"))));
  EXPECT_NO_THROW(Simulation(blocks_with("", force("soft", "[1, 1, 0.5]"))));     // on an edge
  EXPECT_NO_THROW(Simulation(blocks_with("", force("stiff", "[9, 0.5, 0.5]"))));  // an arm of a rigid block
  EXPECT_NO_THROW(Simulation(blocks_with(opening("from = 0.4\nto = 1.6\nsill = 0\nhead = 0.8\n"))));
}

std::vector<Warning> warnings_of(Simulation& run, const std::string& about) {
  Observer nobody;
  run.run(nobody);
  std::vector<Warning> found;
  for (const Warning& w : run.outcome().warnings) {
    if (w.about == about) found.push_back(w);
  }
  return found;
}

// A block rests 5 mm above the ground, without weight. A law that holds tension pulls it down.
TEST(Settings, LawsThatPullBlocksOverAGapAreNamed) {
  const auto scene = [&](const std::string& joint) {
    return scene_of(std::string(kStone) + joint + R"(
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-5, -1, -5], size = [40, 1, 10] }
[[block]]
name = "above"
material = "stone"
box = { lower = [0, 0.005, 0], size = [1, 1, 1] }
[[stage]]
duration = 0.05
record_interval = 10
[output]
frames = 0
plots = false
)");
  };
  Simulation elastic(scene("[joints.glue]\nlaw = \"elastic\"\nnormal_stiffness = 1e9\nshear_stiffness = 1e9\n"));
  const std::vector<Warning> found = warnings_of(elastic, "tension_in_new_contacts");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].text.find("joints 'glue' pull blocks towards each other"), std::string::npos) << found[0].text;
  Simulation dry(scene(kDry));
  EXPECT_TRUE(warnings_of(dry, "tension_in_new_contacts").empty());
  const Vec3 moved = block_displacement(dry, 1)[0];
  EXPECT_LT(norm(geometry::vector(moved)), 1e-12);
}

// At rest energies are rounding, which need not balance.
TEST(Settings, RoundingIsNoEnergyThatIsMissing) {
  Simulation rest(blocks_with("", "[[stage]]\nduration = 0.02\nrecord_interval = 5\n"));
  EXPECT_TRUE(warnings_of(rest, "energy_balance").empty());
}

// 2/omega_max is not stable with local damping: eq. 1 adds gamma times the force. Limit: 1/sqrt(1 + gamma) = 0.745.
TEST(Settings, AStepTooLongForLocalDampingIsNamed) {
  for (const double fraction : {0.6, 0.8}) {
    quoin::Scene scene = blocks_with("");
    scene.solver.damping = DampingKind::local, scene.solver.local_damping = 0.8;
    scene.solver.time_step_fraction = fraction;
    EXPECT_EQ(Simulation(scene).time_step_report().warning().empty(), fraction < 0.745) << fraction;
  }
}

// A rigid block on a plane slides by a stage of velocity, and is then pushed to collapse. The displacement of collapse
// counts from its stage: the multiplier is tan(35 deg) = 0.70, as for the block that has not been moved.
TEST(Settings, DisplacementOfCollapseCountsFromItsStage) {
  const auto multiplier = [&](const std::string& before) {
    Simulation run(blocks_with("", std::string(kStage) + before +
                                       "[[stage]]\nname = \"push\"\ngravity = [0, -9.81, 0]\n"
                                       "collapse = { direction = [1, 0, 0], rate = 0.1, displacement = 0.0005 }\n"));
    Observer nobody;
    run.run(nobody);
    return run.outcome().collapse_multiplier.value_or(0.0);
  };
  const double fresh = multiplier("");
  // While it grows by rate t, the block moves by 0.2 g rate t^3/6 = 0.5 mm with local damping: t = 0.25 s.
  EXPECT_NEAR(fresh, std::tan(35.0 * pi / 180.0) + 0.025, 0.01);
  const double moved = multiplier(
      "[[stage]]\nname = \"slide\"\nduration = 0.2\ngravity = [0, -9.81, 0]\n[[stage.velocity]]\nblock = \"stiff\"\n"
      "velocity = [0.1, \"free\", 0]\n[[stage]]\nname = \"stop\"\nduration = 0.2\ngravity = [0, -9.81, 0]\n");
  EXPECT_NEAR(moved, fresh, 0.005);
}

// Forces on the four units of a top course, by their place along the wall, N. Dry joints release them: they fly freely,
// and central differences move their 4 kg from rest by F/m t (t + dt)/2.
std::vector<Vec3> forces_on_course(const std::string& load) {
  Simulation run(scene_of(std::string(kStone) + kDry + R"(
[wall]
bond = "stack"
courses = 2
units_per_course = 4
unit = [0.2, 0.1, 0.1]
rigid_units = true
mid_unit_joints = false
unit_material = "stone"
bed_joint = "dry"
head_joint = "dry"
beam_joint = "dry"
top_beam = false
[solver]
damping = "none"
[output]
frames = 0
plots = false
[[stage]]
name = "load"
duration = 0.01
)" + load));
  Observer nobody;
  run.run(nobody);
  const std::vector<blocks::Block>& all = run.large_motion()->assembly.blocks;
  std::vector<std::size_t> course;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].name == "top_course") course.push_back(i);
  }
  std::ranges::sort(course, {}, [&](std::size_t i) { return all[i].position.x; });
  const double moved_by = 0.5 * run.time() * (run.time() + run.time_step_report().time_step) / 4.0;  // m/N
  std::vector<Vec3> forces;
  for (const std::size_t i : course) {
    Vec3& force = forces.emplace_back(block_displacement(run, static_cast<int>(i)).front());
    for (double& component : force) component /= moved_by;
  }
  return forces;
}

// A course is a name of several blocks. A pressure acts on all faces that lie outermost, a force on the unit at its
// point. Tolerance: rounding of places of 1 m over ways of 0.1 mm.
TEST(Settings, LoadsOnACourseActOnTheUnitsThatAreMeant) {
  constexpr double kTolerance = 1e-9;  // N
  const auto pressure = [](const std::string& normal) {
    return "[[stage.pressure]]\nblock = \"top_course\"\npressure = -1e3\nnormal = " + normal + "\n";
  };
  const auto up = forces_on_course(pressure("[0, 1, 0]"));
  const auto along = forces_on_course(pressure("[1, 0, 0]"));
  const auto lifted =
      forces_on_course("[[stage.force]]\nblock = \"top_course\"\npoint = [0.5, 0.2, 0.05]\nforce = [0, 20, 0]\n");
  ASSERT_EQ(up.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(up[i][1], 20.0, kTolerance) << i;
    EXPECT_NEAR(along[i][0], i == 3 ? 10.0 : 0.0, kTolerance) << i;
    EXPECT_NEAR(lifted[i][1], i == 2 ? 20.0 : 0.0, kTolerance) << i;
  }
}

// A stage of kind pressure holds the lower beam, which a shake before it has left elsewhere. Displacements of the
// ground and moments about its base stay those of the ground. The ramp stops what velocity there is.
TEST(Settings, TheGroundStaysWhereAShakeHasLeftIt) {
  struct Rows : Observer {
    std::vector<HistoryRow> all;
    void on_row(const HistoryRow& row) override { all.push_back(row); }
  };
  for (const char* motion : {"never", "always"}) {
    Simulation run(scene_of(std::string(kStone) + kDry + R"(
[wall]
courses = 2
units_per_course = 1.5
unit = [0.2, 0.1, 0.1]
zones = [2, 2, 2]
mid_unit_joints = false
unit_material = "stone"
bed_joint = "dry"
head_joint = "dry"
beam_joint = "dry"
[solver]
quality = "fast"
large_motion = ")" + motion +
                            R"("
[[stage]]
name = "press"
kind = "pressure"
pressure = 0.1e6
duration = 0.005
[[stage]]
name = "shake"
duration = 0.12
ground_motion = { direction = [1, 0, 0], pulse = { shape = "sine", amplitude = 20.0, period = 0.1 } }
[[stage]]
name = "hold"
kind = "pressure"
pressure = 0.1e6
duration = 0.01
[output]
frames = 0
plots = false
)"));
    Rows rows;
    run.run(rows);
    double shaken = 0.0, held = 0.0, moment = 0.0;
    for (const HistoryRow& row : rows.all) {
      if (row.stage == 1) shaken = row.ground_displacement[0];
      if (row.stage == 2) held = row.ground_displacement[0], moment = row.overturning_moment[2];
    }
    EXPECT_NEAR(shaken, 20.0 * 0.1 * 0.1 / (2.0 * pi), 1e-3) << motion;  // of a sine of this period
    EXPECT_NEAR(held, shaken, 1e-3 * shaken) << motion;
    // 3 kN about the place of the base at the start would be 95 N m. What is left of the shake is less.
    EXPECT_LT(std::abs(moment), 30.0) << motion;
  }
}

}  // namespace
}  // namespace quoin::verification
