// Long runs and sudden events: energy of a free vibration, removal of a support, joints of different stiffness.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>

#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

// Removes rigid motion, since in a block that drifts, a large displacement reduces the digits for deformation.
void take_away_drift(Simulation* simulation) {
  const Model& model = simulation->model();
  Vec3 momentum{};
  const auto component = [](std::size_t i) { return i % kLine / kLanes; };
  for (std::size_t i = 0; i < lattice_velocity(*simulation).size(); ++i)
    momentum[component(i)] += model.node_mass[i] * lattice_velocity(*simulation)[i];
  for (std::size_t i = 0; i < lattice_velocity(*simulation).size(); ++i) {
    if (model.node_mass[i] > 0.0) lattice_velocity(*simulation)[i] -= momentum[component(i)] / model.total_mass();
  }
}

// Returns the relative change of energy of two units of two halves in free vibration. Central differences conserve the
// energy of Energies, so only rounding changes it.
double energy_drift(long steps, double deformation_inertia, double unit_inertia) {
  Scene scene = bare_scene(0.9);
  scene.solver.deformation_inertia = deformation_inertia;
  scene.solver.unit_inertia = unit_inertia;
  scene.output.energy = true;
  Simulation simulation(scene, in_units(brick_grid({2, 2, 1}, {0.11, 0.0625, 0.1}, {2, 1, 1})), 1);
  random_velocities(&simulation, 3);
  take_away_drift(&simulation);
  simulation.advance(1);
  const double start = simulation.measure().energies->balance_error();
  EXPECT_GT(start, 0.0);
  double largest = 0.0, strain = 0.0;
  for (int part = 0; part < 100; ++part) {
    simulation.advance(steps / 100);
    largest = std::max(largest, std::abs(simulation.measure().energies->balance_error() / start - 1.0));
    strain = std::max(strain, simulation.measure().energies->strain);
  }
  EXPECT_GT(strain, 0.01 * start);  // the units vibrate
  std::printf("energy drift %.2g of the energy in %ld steps\n", largest, steps);
  return largest;
}

// The tolerance is for rounding; a wrong inertia changes the energy by 1e-2.
TEST(Endurance, FreeVibrationKeepsItsEnergy) {
  EXPECT_LT(energy_drift(100000, 1.0, 1.0), 5e-8);
  EXPECT_LT(energy_drift(100000, 64.0, 16.0), 5e-7);
}
TEST(Endurance, DISABLED_FreeVibrationOfTenMillionSteps) {
  EXPECT_LT(energy_drift(10000000, 1.0, 1.0), 5e-6);
  EXPECT_LT(energy_drift(10000000, 64.0, 16.0), 5e-5);
}

// Joints with different stiffness from 1e9 to 1e13 Pa/m: the critical time step is still the limit of stability.
TEST(Endurance, JointsThatAllDifferAreStableJustBelowTheLimit) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<> exponent(9.0, 13.0);
  for (int sample = 0; sample < 3; ++sample) {
    Assembly assembly = brick_grid({3, 3, 1}, {0.11, 0.0625, 0.1}, {2, 1, 1});
    assembly.families.clear();
    for (Joint& joint : assembly.joints) {
      joint.family = static_cast<int>(assembly.families.size());
      assembly.families.push_back(elastic_family(std::pow(10.0, exponent(random)), std::pow(10.0, exponent(random))));
      assembly.families.back().name = "joint " + std::to_string(joint.family);
    }
    EXPECT_LT(largest_after(bare_scene(0.98), assembly, 5000), 1e-3);
    EXPECT_GT(largest_after(bare_scene(1.02), assembly, 5000), 1e3);
  }
}

// A wall under its weight whose bottom beam is released abruptly. Its momentum is M g t, independent of vibrations and
// cracks inside, and the energies balance.
TEST(Endurance, AWallWhoseSupportGoesAwayFalls) {
  Scene scene = wall_scene(3, 2);
  scene.solver = bare_scene(0.6).solver;
  scene.output.energy = true;
  Stage stand;
  stand.name = "stand";
  stand.gravity = {0.0, -9.81, 0.0};
  stand.ramp_time = 1e-3;
  stand.duration = 2e-3;
  BodyControl bottom;
  bottom.body = "bottom_beam";
  stand.controls = {bottom};
  Stage fall = stand;
  fall.name = "fall";
  fall.controls.clear();
  fall.ramp_time = 0.0;
  fall.duration = 2e-3;
  scene.stages = {stand};
  const auto momentum = [](const Simulation& s) {
    const Model& model = s.model();
    double sum = 0.0;
    for (std::size_t b = 0; b < model.assembly.bricks.size(); ++b) {
      const auto velocity = block_velocity(s, static_cast<int>(b));
      const Model::BlockPlace& place = model.place[b];
      for (std::size_t n = 0; n < velocity.size(); ++n) {
        const double mass = place.body >= 0 ? model.bodies[static_cast<std::size_t>(place.body)].mass / 8.0
                                            : model.node_mass[dof(model, static_cast<int>(b), static_cast<int>(n), 1)];
        sum += mass * velocity[n][1];
      }
    }
    return sum;
  };
  scene.stages = {stand, fall};
  struct AtEnd : Observer {
    std::vector<double> momentum, time, imbalance;
    std::function<double(const Simulation&)> measure;
    void on_stage_end(const Simulation& s, int, const HistoryRow& row) override {
      momentum.push_back(measure(s));
      time.push_back(s.time());
      imbalance.push_back(row.energies->balance_error() / row.energies->external);
    }
  } end;
  end.measure = momentum;
  Simulation simulation(scene, assemble(scene), 1);
  simulation.run(end);
  ASSERT_EQ(end.momentum.size(), 2u);
  const double weight = 9.81 * simulation.model().total_mass();
  EXPECT_NEAR((end.momentum[1] - end.momentum[0]) / (end.time[1] - end.time[0]), -weight, 1e-9 * weight);
  EXPECT_LT(std::abs(end.imbalance[1]), 1e-6);
}

}  // namespace
}  // namespace quoin
