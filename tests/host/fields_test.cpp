// The tables of fields (host/model/fields.h, host/step/lattice_fields.h) contain every array that changes in a run.
#include "model/fields.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "scene/read_scene.h"
#include "step/large_motion.h"
#include "support.h"

namespace quoin {
namespace {

using Overrides = std::vector<std::string>;

struct Case {
  const char* name;
  std::string scene;
  Overrides overrides;
  long steps;  // steps of the last stage before the state is saved
};

void PrintTo(const Case& of, std::ostream* out) { *out << of.name; }

const std::string kSmallWall = QUOIN_HOST_TESTS "/../cli/small_wall.toml";

Overrides weak_wall(Overrides more) {
  more.insert(more.end(), {"wall.courses=3", "wall.units_per_course=2", "joints.mortar.tensile_strength=3e4",
                           "joints.mortar.cohesion=5e4", "stage.precompression.duration=0.002",
                           "stage.shear.velocity=0.2", "stage.shear.ramp_time=0.0005", "output.energy=true"});
  return more;
}

class Fields : public ::testing::TestWithParam<Case> {
 protected:
  static Scene scene() { return read_scene(GetParam().scene, GetParam().overrides); }
  // Runs all stages but the last one, and `steps` steps of the last one.
  static void go(Simulation& simulation, long steps) {
    Observer nobody;
    for (std::size_t s = 1; s < simulation.scene().stages.size(); ++s) simulation.run_stage(nobody);
    simulation.run_stage(nobody, steps);
  }
  static std::vector<double> numbers_of(Simulation& simulation) {
    const HistoryRow row = simulation.measure();
    std::vector<double> numbers{row.displacement,     row.resistance, row.vertical_force,
                                row.unbalanced_ratio, row.multiplier, row.joint_force[0]};
    if (row.energies) numbers.insert(numbers.end(), {row.energies->external, row.energies->damping});
    return numbers;
  }
};

// A state is restored into a simulation at another step, whose arrays have other values. Its state and all later steps
// are then bitwise identical to those of the first one. An array that is missing in the tables would keep its values.
TEST_P(Fields, AreAllThatARunGoesOnFrom) {
  Simulation first(scene(), 1), other(scene(), 1);
  go(first, GetParam().steps);
  go(other, GetParam().steps / 2 + 7);
  ASSERT_NE(other.hash(), first.hash());
  const std::vector<std::uint8_t> state = first.save();
  other.restore(state);
  // Bodies of the lattice also have values imposed by controls, which every step sets again.
  EXPECT_TRUE(!first.large_motion() || other.save() == state);
  EXPECT_EQ(other.hash(), first.hash());
  Observer nobody;
  for (const long steps : {1, 3, 60}) {
    first.run_stage(nobody, steps), other.run_stage(nobody, steps);
    EXPECT_EQ(other.hash(), first.hash()) << steps;
  }
  first.advance(1), other.advance(1);
  EXPECT_EQ(numbers_of(other), numbers_of(first));
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, Fields,
    ::testing::Values(
        Case{"Lattice", kSmallWall, weak_wall({}), 60},
        Case{"LatticeWithStiffnessDamping", kSmallWall,
             weak_wall({"solver.damping=viscous", "solver.stiffness_damping=1e-6"}), 60},
        Case{"LatticeOnGround", QUOIN_HOST_TESTS "/shaken_wall.toml", {"stage.shake.ground_motion.scale=1.5"}, 60},
        Case{"LatticeAfterASwap", kSmallWall, weak_wall({"stage.shear.law=coulomb_slip"}), 60},
        Case{"General", kSmallWall, weak_wall({"solver.kernels=general"}), 60},
        Case{"GeneralWithStiffnessDamping", kSmallWall,
             weak_wall({"solver.kernels=general", "solver.damping=viscous", "solver.stiffness_damping=1e-6"}), 60},
        Case{"GeneralWithScatter", kSmallWall,
             weak_wall({"solver.kernels=general",
                        "joints.mortar.cohesion={distribution='lognormal', mean=5e4, cov=0.3}"}),
             60},
        Case{"Promoted", kSmallWall, weak_wall({"solver.rotation_bound=1e-5"}), 60},
        Case{"HalvesThatPart",
             QUOIN_HOST_TESTS "/halves_part.toml",
             {"solver.large_motion=always", "output.energy=true"},
             60},
        Case{"RigidBlocksThatAreDetected",
             QUOIN_SCENES "/mixed.toml",
             {"output.energy=true", "stage.weight.gravity=[20.0, -9.81, 0.0]", "stage.weight.duration=0.05"},
             1200}),
    [](const auto& of) { return std::string(of.param.name); });

// A column of contact points that is missing in the table makes a family larger than the sum of its table.
TEST(Fields, OfContactPointsAreAllInTheTable) {
  blocks::Family family;
  std::map<std::string, int> arrays;
  blocks::WorldFields::of_points([&](const Field& field, auto&) { ++arrays[field.name]; }, family);
  int named = 0;
  for (const auto& [name, count] : arrays) named += count;
  constexpr int kFoundFromPoints = 5;  // arms, offsets and area, which steps do not change
  const std::size_t rest = sizeof family.material + sizeof family.initial + sizeof family.dry + sizeof family.kn +
                           sizeof family.ks + sizeof family.state + sizeof family.columns;
  EXPECT_EQ(sizeof family, rest + static_cast<std::size_t>(named + kFoundFromPoints) * sizeof(LaneVector<double>))
      << "a new column of blocks::Family belongs into WorldFields::of_points";
  EXPECT_EQ(arrays["traction"], 3);
}

}  // namespace
}  // namespace quoin
