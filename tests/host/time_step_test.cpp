#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "../dry_stone.h"
#include "hwy/highway.h"
#include "hwy/targets.h"
#include "model/motion.h"
#include "scene/read_scene.h"
#include "support.h"

namespace quoin {
namespace {

// Returns bricks between a rigid block below and one above: all kinds of stiffness and inertia.
Assembly sandwich() {
  Assembly assembly = brick_grid({2, 2, 1}, {0.11, 0.0625, 0.1}, {2, 2, 1});
  Brick beam;
  beam.rigid = true;
  beam.size = {0.22, 0.05, 0.1};
  beam.origin = {0.0, -0.05, 0.0};
  beam.body = "bottom_beam";
  assembly.bricks.push_back(beam);
  beam.origin = {0.0, 0.125, 0.0};
  beam.body = "top_beam";
  assembly.bricks.push_back(beam);
  for (int i = 0; i < 2; ++i) {
    assembly.joints.push_back({4, i, 3, 0});
    assembly.joints.push_back({2 + i, 5, 3, 0});
  }
  return assembly;
}

// Eigenvalues of M^-1/2 K M^-1/2 as a dense matrix, 1/s2, ascending, and how many rows have no inertia.
struct DenseModes {
  Eigen::VectorXd lambda;
  int idle = 0;
  double critical_step() const { return 2.0 / std::sqrt(lambda[lambda.size() - 1]); }
};

DenseModes dense_modes(const Model& model, const Inertia& inertia) {
  const int size = model.line_count * kLine + 6 * static_cast<int>(model.bodies.size());
  Eigen::MatrixXd k(size, size);
  std::vector<double> unit(static_cast<std::size_t>(size), 0.0), column;
  for (int i = 0; i < size; ++i) {
    unit[static_cast<std::size_t>(i)] = 1.0;
    apply_undamaged_stiffness(model, unit, &column);
    k.col(i) = Eigen::Map<Eigen::VectorXd>(column.data(), size);
    unit[static_cast<std::size_t>(i)] = 0.0;
  }
  EXPECT_LT((k - k.transpose()).cwiseAbs().maxCoeff(), 1e-13 * k.cwiseAbs().maxCoeff());
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(size);
  for (int i = 0; i < model.line_count * kLine; ++i) {
    if (inertia.node[static_cast<std::size_t>(i)] > 0.0)
      scale[i] = 1.0 / std::sqrt(inertia.node[static_cast<std::size_t>(i)]);
  }
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto base = static_cast<Eigen::Index>(static_cast<std::size_t>(model.line_count * kLine) + 6 * b + c);
      scale[base] = 1.0 / std::sqrt(model.bodies[b].mass);
      scale[base + 3] = 1.0 / std::sqrt(model.bodies[b].inertia[c]);
    }
  }
  const Eigen::MatrixXd scaled = scale.asDiagonal() * k * scale.asDiagonal();
  return {Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues(),
          static_cast<int>((scale.array() == 0.0).count())};
}

TEST(TimeStep, LanczosFindsTheLargestFrequencyOfTheDenseMatrix) {
  const Assembly assembly = sandwich();
  const Model model(assembly, make_materials(assembly));
  Inertia inertia;
  const TimeStepReport report = choose_time_step(model, {}, &inertia);
  const DenseModes dense = dense_modes(model, inertia);
  EXPECT_NEAR(report.critical.value, dense.critical_step(), 1e-7 * report.critical.value);
  EXPECT_LE(report.gershgorin.value, report.critical.value);
  EXPECT_GE(report.nodal.value, report.critical.value);
  EXPECT_DOUBLE_EQ(report.time_step, 0.6 * report.critical.value);
  // A free assembly has exactly 6 rigid motions; degrees of freedom without inertia have eigenvalue 0, too.
  const double largest = dense.lambda[dense.lambda.size() - 1];
  EXPECT_LT(std::abs(dense.lambda[dense.idle + 5]), 1e-9 * largest);
  EXPECT_GT(dense.lambda[dense.idle + 6], 1e-6 * largest);
}

// Blocks with two planes of symmetry have their modes in pairs. The iteration then has rounding errors where it is
// complete, and steps were up to 43 times too long.
TEST(TimeStep, IsThatOfTheDenseMatrixForBlocksWithEqualModes) {
  const std::string stone = dry_stone(35) + R"([[stage]]
gravity = [0, -9.81, 0]
duration = 0.1
)";
  const auto block = [](const std::string& lower, const std::string& size, const std::string& more = "") {
    return fmt::format("[[block]]\nmaterial = \"stone\"\nbox = {{ lower = [{}], size = [{}] }}\n{}\n", lower, size,
                       more);
  };
  const std::string fixed = "fixed = true", zones = "rigid = false\ndivisions = [1, 1, 1]";
  const std::string cube = stone + block("-1, -0.5, -1", "3, 0.5, 3", fixed) + block("0, 0, 0", "1, 1, 1");
  const std::string slabs =
      stone + block("0, -0.2, 0", "2, 0.2, 2", fixed) + block("0, 0, 0", "2, 0.2, 2") + block("0, 0.2, 0", "2, 0.2, 2");
  const std::string deformable =
      stone + block("0, -0.1, 0", "1, 0.1, 0.2", fixed) + block("0, 0, 0", "1, 0.25, 0.2", zones);
  const auto stiff = [](const char* normal, const char* shear) {
    return std::vector<std::string>{fmt::format("joints.dry.normal_stiffness={}", normal),
                                    fmt::format("joints.dry.shear_stiffness={}", shear),
                                    "materials.stone.young_modulus=10e9", "materials.stone.poisson_ratio=0.2"};
  };
  for (const auto& [text, joints] :
       {std::pair{cube, stiff("1e9", "0.4e9")}, {slabs, stiff("1e10", "1e10")}, {deformable, stiff("1e9", "0.1e9")}}) {
    Motion motion = choose_motion(read_scene_text(text, "scene.toml", joints));
    const Model model(motion.bricks, make_materials(motion.bricks));
    Inertia inertia;
    const TimeStepReport report = choose_time_step(model, motion.scene.solver, &inertia);
    EXPECT_NEAR(report.critical.value, dense_modes(model, inertia).critical_step(), 1e-7 * report.critical.value);
    EXPECT_LE(report.critical.value, report.nodal.value);
  }
}

TEST(TimeStep, SingleBlockAgreesWithAnIndependentEigenSolution) {
  const Assembly assembly = brick_grid({1, 1, 1}, {0.11, 0.0625, 0.1}, {4, 2, 2});
  const Model model(assembly, make_materials(assembly));
  Inertia inertia;
  const TimeStepReport report = choose_time_step(model, {}, &inertia);
  const Eigen::MatrixXd k = dense_stiffness(assembly.bricks[0], brick_material());
  const Eigen::MatrixXd m = dense_mass(assembly.bricks[0], brick_material()).asDiagonal();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(k, m, Eigen::EigenvaluesOnly);
  EXPECT_NEAR(report.critical.value, 2.0 / std::sqrt(solver.eigenvalues().maxCoeff()), 1e-7 * report.critical.value);
}

TEST(TimeStep, StableJustBelowTheLimitUnstableJustAbove) {
  EXPECT_LT(largest_after(bare_scene(0.98), sandwich(), 3000), 1e-3);
  EXPECT_GT(largest_after(bare_scene(1.02), sandwich(), 3000), 1e3);
}

// The place where a limit is set, "rigid block 5 ..." or "block 3, gridpoint 7 ...", belongs to the block of that
// number.
TEST(TimeStep, PlacesOfLimitsAreThoseOfTheBlocksTheyName) {
  Assembly rigid = brick_grid({3, 2, 1}, {0.2, 0.1, 0.15}, {1, 1, 1});
  for (Brick& brick : rigid.bricks) brick.rigid = true;
  rigid.bricks.back().body = "named";
  int bodies = 0, blocks = 0;
  for (const Assembly& assembly : {rigid, sandwich(), brick_grid({2, 3, 1}, {0.11, 0.0625, 0.1}, {2, 1, 1})}) {
    const Model model(assembly, make_materials(assembly));
    Inertia inertia;
    const TimeStepReport report = choose_time_step(model, {}, &inertia, Limits::all);
    for (const TimeStepLimit* limit : {&report.critical, &report.gershgorin, &report.nodal}) {
      int block = -1, gridpoint = -1;
      if (std::sscanf(limit->where.c_str(), "rigid block %d", &block) == 1) {
        const Brick& b = assembly.bricks.at(static_cast<std::size_t>(block));
        EXPECT_TRUE(b.rigid);
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(limit->position[c], b.origin[c] + b.size[c] / 2, 1e-12);
        EXPECT_NE(limit->where.find("joint family '"), std::string::npos) << limit->where;
        ++bodies;
      } else {
        ASSERT_EQ(std::sscanf(limit->where.c_str(), "block %d, gridpoint %d", &block, &gridpoint), 2) << limit->where;
        const Brick& b = assembly.bricks.at(static_cast<std::size_t>(block));
        const int nx = b.zones[0] + 1, ny = b.zones[1] + 1;
        const int place[3] = {gridpoint % nx, gridpoint / nx % ny, gridpoint / (nx * ny)};
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(limit->position[c], b.origin[c] + b.size[c] * place[c] / b.zones[c], 1e-12) << limit->where;
        ++blocks;
      }
    }
  }
  EXPECT_GE(bodies, 3);
  EXPECT_GE(blocks, 3);
}

// With F opposite to v in all steps a mode is (1 + gamma) times as stiff: its limit is 1/sqrt(1 + gamma) of the
// undamped one.
TEST(TimeStep, WarnsAboveTheQuietStepOfLocalDamping) {
  const Assembly assembly = sandwich();
  const Model model(assembly, make_materials(assembly));
  for (const auto& [gamma, fraction, warned] :
       {std::tuple{0.8, 0.74, false}, {0.8, 0.76, true}, {0.5, 0.81, false}, {0.5, 0.83, true}}) {
    SolverSettings settings;
    settings.local_damping = gamma;
    settings.time_step_fraction = fraction;
    Inertia inertia;
    EXPECT_EQ(!choose_time_step(model, settings, &inertia).warning().empty(), warned) << gamma << " " << fraction;
  }
}

// Viscous damping by the velocity half a step before has the limit 2/omega (sqrt(1 + xi^2) - xi), with
// xi = alpha/(2 omega) + beta omega/2.
TEST(TimeStep, ViscousDampingShortensItByItsRatio) {
  const Assembly assembly = sandwich();
  const Model model(assembly, make_materials(assembly));
  Inertia plain;
  const double omega = 2.0 / choose_time_step(model, {}, &plain).critical.value;
  for (const auto& [alpha, beta] : {std::pair{0.6 * omega, 0.0}, {0.0, 0.5 / omega}, {0.2 * omega, 0.8 / omega}}) {
    SolverSettings settings;
    settings.damping = DampingKind::viscous;
    settings.mass_damping = alpha, settings.stiffness_damping = beta;
    Inertia inertia;
    const double xi = alpha / (2 * omega) + beta * omega / 2;
    EXPECT_NEAR(choose_time_step(model, settings, &inertia).time_step,
                settings.time_step_fraction * 2 / omega * (std::sqrt(1 + xi * xi) - xi), 1e-12 / omega)
        << alpha << " " << beta;
  }
}

// Eq. 3 with the diagonal of K, computed column by column. Gridpoints set the step here; that of rigid bodies is
// longer.
TEST(TimeStep, NodalStepIsEquation3WithTheDiagonalOfTheStiffness) {
  const Assembly assembly = sandwich();
  const Model model(assembly, make_materials(assembly));
  SolverSettings settings;
  settings.critical_time_step = CriticalTimeStep::nodal;
  Inertia inertia;
  const TimeStepReport report = choose_time_step(model, settings, &inertia, Limits::all);
  const auto gridpoints = static_cast<std::size_t>(model.line_count * kLine);
  std::vector<double> unit(gridpoints + 6 * model.bodies.size(), 0.0), column;
  double shortest = std::numeric_limits<double>::infinity();
  std::vector<double> diagonal(gridpoints);
  for (std::size_t i = 0; i < gridpoints; ++i) {
    unit[i] = 1.0;
    apply_undamaged_stiffness(model, unit, &column);
    unit[i] = 0.0;
    diagonal[i] = column[i];
    if (inertia.node[i] > 0.0 && column[i] > 0.0)
      shortest = std::min(shortest, 2.0 * std::sqrt(inertia.node[i] / column[i]));
  }
  EXPECT_NEAR(report.nodal.value, shortest, 1e-12 * shortest);  // sums in another order
  // The report has the gridpoint and the share of joints in its stiffness. Gridpoints that are equal by symmetry differ
  // by rounding.
  bool found = false;
  for (const BlockGroup& group : model.groups) {
    for (int line = group.first_line; line < group.first_line + model.templates[0].node_count; ++line) {
      for (int k = 0; k < 3 * group.block_count; ++k) {
        const int lane = k / 3, component = k % 3, block = group.block[size_t(lane)], node = line - group.first_line;
        const auto dof = size_t(line * kLine + component * kLanes + lane);
        if (std::abs(2.0 * std::sqrt(inertia.node[dof] / diagonal[dof]) - shortest) > 1e-9 * shortest) continue;
        const int row = 3 * node + component;
        const double zones = dense_stiffness(assembly.bricks[size_t(block)], brick_material())(row, row);
        found = found || (report.nodal.position == model.gridpoint_position(block, node) &&
                          report.nodal.where ==
                              fmt::format("block {}, gridpoint {}, joint family '{}' has {:.0f} % of its "
                                          "stiffness",
                                          block, node, model.families[0].name, 100 * (1 - zones / diagonal[dof])));
      }
    }
  }
  EXPECT_TRUE(found) << report.nodal.where;
  EXPECT_DOUBLE_EQ(report.time_step, settings.time_step_fraction * report.nodal.value);
  Inertia of_run;
  EXPECT_EQ(choose_time_step(model, settings, &of_run, Limits::critical).time_step, report.time_step);
  EXPECT_GT(report.nodal.value, 1.02 * report.critical.value);
  settings.time_step_fraction = 1.0;
  Inertia again;
  EXPECT_NE(choose_time_step(model, settings, &again).warning().find("unstable"), std::string::npos);
}

TEST(TimeStep, NodalStepIsUnstableForBricksOfSeveralZones) {
  Scene scene = bare_scene(1.0);
  EXPECT_LT(largest_after(bare_scene(0.98), sandwich(), 3000), 1e-3);
  scene.solver.critical_time_step = CriticalTimeStep::nodal;
  EXPECT_GT(largest_after(scene, sandwich(), 3000), 1e3);
}

TimeStepReport step_of_a_wall(int courses, double units) {
  SolverSettings settings;  // the inertia of quality standard
  settings.deformation_inertia = 64.0;
  settings.unit_inertia = 16.0;
  Assembly assembly = assemble(wall_scene(courses, units));
  auto materials = make_materials(assembly);
  const Model model(std::move(assembly), std::move(materials));
  Inertia inertia;
  return choose_time_step(model, settings, &inertia, Limits::critical);
}

// The cost of a product is proportional to the number of blocks. The number of products may grow at most like the
// length of the wall, which modes 1/length^2 apart need. The value is accurate to 1e-7.
TEST(TimeStep, StepsOfLanczosGrowSlowerThanTheLengthOfTheWall) {
  const TimeStepReport small = step_of_a_wall(16, 5), large = step_of_a_wall(32, 10), larger = step_of_a_wall(64, 20);
  std::printf("Lanczos steps %d, %d, %d, critical step %.10g, %.10g, %.10g s\n", small.lanczos_steps,
              large.lanczos_steps, larger.lanczos_steps, small.critical.value, large.critical.value,
              larger.critical.value);
  EXPECT_LT(larger.lanczos_steps, 4 * small.lanczos_steps) << "16 times the blocks, 4 times as long";
  EXPECT_LT(larger.lanczos_steps, 600) << "stopped by the limit, not settled";
  // Fixed edges raise the wave number of a mode by 1/length^2: a quarter of the difference at twice the length.
  EXPECT_LE(larger.critical.value, large.critical.value * (1 + 1e-6));
  EXPECT_LT(large.critical.value - larger.critical.value, 0.5 * (small.critical.value - large.critical.value));
}

TEST(TimeStep, HasTheSameBitsOnEveryInstructionSet) {
  const TimeStepReport usual = step_of_a_wall(4, 2.5);
  const std::int64_t supported = hwy::SupportedTargets();
  for (std::int64_t target = 1; target != 0 && target <= supported; target <<= 1) {
    if ((supported & target) == 0) continue;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_EQ(step_of_a_wall(4, 2.5).critical.value, usual.critical.value) << hwy::TargetName(target);
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
}

TEST(TimeStep, MassScalingIsReported) {
  const Assembly assembly = sandwich();
  const Model model(assembly, make_materials(assembly));
  Inertia inertia;
  SolverSettings settings;
  settings.mass_scaling = 4.0;
  const TimeStepReport scaled = choose_time_step(model, settings, &inertia);
  Inertia plain_inertia;
  const TimeStepReport plain = choose_time_step(model, {}, &plain_inertia);
  EXPECT_NEAR(scaled.time_step, 2.0 * plain.time_step, 1e-6 * plain.time_step);
  EXPECT_NEAR(scaled.added_mass, 3.0 * model.total_mass(), 1e-9);
  EXPECT_EQ(plain.added_mass, 0.0);

  SolverSettings selective;
  selective.selective_time_step = 1.3 * plain.time_step;
  Inertia raised;
  const TimeStepReport some = choose_time_step(model, selective, &raised);
  EXPECT_EQ(some.time_step, selective.selective_time_step);
  EXPECT_GT(some.added_mass, 0.0);
  EXPECT_GE(some.critical.value * selective.time_step_fraction, some.time_step * (1 - 1e-9));
  for (std::size_t i = 0; i < raised.node.size(); ++i) EXPECT_GE(raised.node[i], model.node_mass[i]);
  // Inertia is not larger than row sums require: the stiffest row has exactly the requested step.
  const double wanted = selective.selective_time_step / selective.time_step_fraction;
  EXPECT_NEAR(some.gershgorin.value, wanted, 1e-12 * wanted);
}

}  // namespace
}  // namespace quoin
