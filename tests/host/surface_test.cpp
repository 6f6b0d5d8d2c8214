// Damage and cracks of joints in files and pictures.
#include "results/surface.h"

#include <gmock/gmock.h>

#include <map>

#include "results/crushed_out.h"
#include "scene/read_scene.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// A joint that opens for the first time carries (1 - damage) of its tensile strength, for any shape of softening.
TEST(Surfaces, DamageIsTheShareOfTheStrengthThatIsLost) {
  const std::vector<PropertySetting> table{{"softening", {}, "table", {}},
                                           {"softening_table", {0.0, 1.0, 0.3, 0.5, 1.0, 0.0}, "", {}}};
  for (const std::vector<PropertySetting>& shape :
       {std::vector<PropertySetting>{}, {{"softening", {}, "exponential", {}}}, table}) {
    JointFamily family = mortar_family();
    family.properties.insert(family.properties.end(), shape.begin(), shape.end());
    const Assembly assembly = brick_grid({2, 1, 1}, {0.11, 0.0625, 0.1}, {2, 1, 1}, family);
    Simulation simulation(bare_scene(), assembly);
    for (int n = 0; n < 12; ++n) lattice_displacement(simulation)[dof(simulation.model(), 1, n, 0)] = 30e-6;
    simulation.advance(1);
    for (const JointPoint& p : Surfaces().joint_points(simulation)) {
      EXPECT_NEAR(p.damage_tension, 1.0 - p.contact.traction[0] / 0.2e6, 1e-9) << shape.size();
      EXPECT_GT(p.damage_tension, 0.1);
      EXPECT_LT(p.damage_tension, 0.9);
    }
  }
}

// A joint that has opened and slid is drawn by the larger of both. Its path is a straight line to (opening, slip), at
// whose end a small part or all of its strength is lost.
TEST(Surfaces, CracksAreNamedByTheLargerOfOpeningAndSlip) {
  const Assembly assembly = brick_grid({2, 1, 1}, {0.11, 0.0625, 0.1}, {2, 1, 1}, mortar_family());
  const auto torn = [&](double opening, double slide) {
    Simulation simulation(bare_scene(), assembly);
    constexpr int kSteps = 50;
    for (int k = 1; k <= kSteps; ++k) {
      for (int n = 0; n < 12; ++n) {
        const double way = slide / kSteps, reached = static_cast<double>(k) / kSteps;
        for (int c = 0; c < 3; ++c) {
          for (int block = 0; block < 2; ++block) {
            lattice_displacement(simulation)[dof(simulation.model(), block, n, c)] = 0.0;
            lattice_velocity(simulation)[dof(simulation.model(), block, n, c)] = 0.0;
          }
        }
        lattice_displacement(simulation)[dof(simulation.model(), 1, n, 0)] = opening * reached;
        lattice_displacement(simulation)[dof(simulation.model(), 1, n, 1)] = slide * reached;
        lattice_velocity(simulation)[dof(simulation.model(), 1, n, 1)] = way / simulation.time_step_report().time_step;
      }
      simulation.advance(1);
    }
    std::vector<JointPoint> points = Surfaces().joint_points(simulation);
    EXPECT_EQ(points.size(), 4u);
    for (const JointPoint& p : points) {
      EXPECT_NEAR(p.opening, opening, 1e-9) << "as it was torn";
      EXPECT_GT(p.slip, 0.5 * slide);
      EXPECT_LT(p.slip, 1.5 * slide);
    }
    return points;
  };
  for (const JointPoint& p : torn(40e-6, 400e-6)) EXPECT_EQ(p.crack, Crack::sliding_begun) << p.damage_shear;
  for (const JointPoint& p : torn(40e-6, 10e-6)) EXPECT_EQ(p.crack, Crack::opening_begun) << p.damage_tension;
  for (const JointPoint& p : torn(0.3e-3, 3e-3)) EXPECT_EQ(p.crack, Crack::slipped);
  for (const JointPoint& p : torn(3e-3, 0.3e-3)) EXPECT_EQ(p.crack, Crack::open);
}

// A dry joint has damage 1 from the start, so pictures show its opening and slip.
TEST(Surfaces, DryJointsAreIntactUntilTheyOpenOrSlide) {
  JointFamily family = mortar_family();
  family.initial_state = "dry";
  const Assembly assembly = brick_grid({2, 1, 1}, {0.11, 0.0625, 0.1}, {2, 1, 1}, family);
  const auto moved = [&](double opening, double slide) {
    Simulation simulation(bare_scene(), assembly);
    for (int n = 0; n < 12; ++n) {
      lattice_displacement(simulation)[dof(simulation.model(), 1, n, 0)] = opening;
      lattice_displacement(simulation)[dof(simulation.model(), 1, n, 1)] = slide;
      lattice_velocity(simulation)[dof(simulation.model(), 1, n, 1)] = slide / simulation.time_step_report().time_step;
    }
    simulation.advance(1);
    std::vector<Crack> cracks;
    for (const JointPoint& p : Surfaces().joint_points(simulation)) cracks.push_back(p.crack);
    return cracks;
  };
  for (const Crack crack : moved(0.0, 0.0)) EXPECT_EQ(crack, Crack::intact);
  for (const Crack crack : moved(-1e-6, 0.0)) EXPECT_EQ(crack, Crack::intact);
  for (const Crack crack : moved(-1e-6, 50e-6)) EXPECT_EQ(crack, Crack::slipped);
  for (const Crack crack : moved(1e-6, 0.0)) EXPECT_EQ(crack, Crack::intact) << "a gap that no eye sees";
  for (const Crack crack : moved(30e-6, 0.0)) EXPECT_EQ(crack, Crack::open);
}

// The sides of a joint between rigid blocks move with the blocks, also where the joint ends inside a face. Half of the
// upper block overhangs, so it rotates.
TEST(Surfaces, JointsOfRigidBlocksMoveWithTheirBlocks) {
  const Vec3 size{0.4, 0.2, 0.3};
  Assembly assembly = brick_grid({1, 2, 1}, size, {1, 1, 1});
  for (Brick& brick : assembly.bricks) brick.rigid = true;
  assembly.bricks[0].body = "base";
  assembly.bricks[1].origin[0] = 0.2;
  Scene scene = bare_scene(0.8);
  Stage stage;
  stage.duration = 1.0;
  stage.gravity = {3.0, -9.81, 1.0};
  BodyControl base;
  base.body = "base";
  stage.controls = {base};
  scene.stages = {stage};
  Simulation simulation(scene, assembly, 1);
  simulation.advance(100);
  const std::vector<Vec3> corner = block_displacement(simulation, 1);  // x fastest
  ASSERT_GT(std::abs(corner[1][1] - corner[0][1]), 1e-9) << "it turns";
  const auto points = Surfaces().joint_points(simulation);
  ASSERT_EQ(points.size(), 17u);  // a joint with tensile strength
  for (const JointPoint& p : points) {
    ASSERT_EQ(p.contact.block_b, 1);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(p.side_a[c], 0.0);
      double moved = corner[0][c];  // small rotations: linear along each axis
      for (std::size_t k = 0; k < 3; ++k)
        moved += (corner[std::size_t{1} << k][c] - corner[0][c]) *
                 (p.contact.position[k] - assembly.bricks[1].origin[k]) / size[k];
      EXPECT_NEAR(p.side_b[c], moved, 1e-12 * std::abs(corner[0][1])) << c;
    }
  }
}

// The shipped arch stands with all joints closed, and collapses with four hinges. The run stops before the hinges open
// beyond the distance of contact detection.
TEST(Surfaces, ADryArchShowsItsHinges) {
  struct Recorder : Observer {
    std::vector<std::map<std::pair<int, int>, Crack>> worst;  // by stage and joint
    void on_stage_end(const Simulation& simulation, int, const HistoryRow&) override {
      auto& joints = worst.emplace_back();
      for (const JointPoint& p : Surfaces().joint_points(simulation)) {
        Crack& crack = joints[std::minmax(p.contact.block_a, p.contact.block_b)];
        crack = std::max(crack, p.crack);
      }
    }
  } recorder;
  Scene scene = read_scene(QUOIN_SCENES "/arch.toml");
  scene.stages[1].collapse->displacement = 0.2;
  Simulation simulation(scene);
  simulation.run(recorder);
  for (const auto& [joint, crack] : recorder.worst.at(0)) EXPECT_EQ(crack, Crack::intact);
  long open = 0, slipped = 0;
  for (const auto& [joint, crack] : recorder.worst.at(1)) {
    open += crack == Crack::open ? 1 : 0;
    slipped += crack == Crack::slipped ? 1 : 0;
  }
  EXPECT_EQ(open, 4);
  EXPECT_EQ(slipped, 0);
}

TEST(CrushedOut, WarningCountsItsPoints) {
  EXPECT_EQ(CrushedOut{}.warning(), "");
  CrushedOut found;
  found.points = 1, found.overlap = 1.25e-3;
  EXPECT_THAT(found.warning(), StartsWith("1 contact point is crushed out: it carries no more than"));
  EXPECT_THAT(found.warning(), HasSubstr("overlap there by up to 1.25 mm;"));
  found.points = 2;
  EXPECT_THAT(found.warning(), StartsWith("2 contact points are crushed out: they carry no more than"));
}

// The damage of the brittle law is 0 or 1; that of a law without failure is 0.
TEST(Surfaces, DamageOfLawsWithoutSofteningIsAllOrNothing) {
  for (const char* law : {"coulomb_slip", "elastic"}) {
    JointFamily family = elastic_family();
    family.law = law;
    if (family.law == "coulomb_slip") {
      for (const auto& [id, value] : {std::pair{"tensile_strength", 0.2e6}, {"cohesion", 0.3e6}})
        family.properties.push_back({id, {value}, "", {}});
    }
    const Assembly assembly = brick_grid({2, 1, 1}, {0.11, 0.0625, 0.1}, {2, 1, 1}, family);
    Simulation simulation(bare_scene(), assembly);
    for (int n = 0; n < 12; ++n) lattice_displacement(simulation)[dof(simulation.model(), 1, n, 0)] = 30e-6;
    simulation.advance(1);
    const auto damage = damage_of_points(simulation);
    const double expected = family.law == "coulomb_slip" ? 1.0 : 0.0;
    ASSERT_GT(simulation.point_count(), 0);
    for (std::size_t i = 0; i < damage[0].size(); ++i) {
      EXPECT_EQ(damage[QUOIN_DAMAGE_TENSION][i], expected) << law;
      EXPECT_EQ(damage[QUOIN_DAMAGE_COHESION][i], expected) << law;
      EXPECT_EQ(damage[QUOIN_DAMAGE_CRUSHING][i], 0.0) << law;
    }
  }
}

}  // namespace
}  // namespace quoin
