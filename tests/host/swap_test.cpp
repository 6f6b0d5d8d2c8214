// Law swaps in a loaded wall. Traction is continuous, states are converted by id, and the energy jump is reported; or
// the swap is refused with the reason.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "step/law_swap.h"
#include "step/results.h"
#include "step/simulation.h"
#include "support.h"

namespace quoin {
namespace {

struct SwapRecorder : Observer {
  std::vector<LawSwap> swaps;
  std::vector<std::vector<ContactPoint>> at_begin, at_end;
  std::vector<std::vector<double>> xi_at_begin, xi_at_end;
  void on_stage_begin(const Simulation& simulation, int) override {
    at_begin.push_back(contact_points(simulation));
    xi_at_begin.push_back(law_state(simulation, "xi_t"));
  }
  void on_stage_end(const Simulation& simulation, int, const HistoryRow&) override {
    at_end.push_back(contact_points(simulation));
    xi_at_end.push_back(law_state(simulation, "xi_t"));
  }
  void on_law_swap(const LawSwap& swap) override { swaps.push_back(swap); }
};

// Returns a small wall, pressed and sheared, whose mortar joints have law swaps. swaps[k]: the new law in stage k;
// empty: no swap.
Scene swapped_wall(const std::string& first_law, const std::vector<std::string>& swaps, double shear) {
  Scene scene = wall_scene(4, 2.5);
  JointFamily& mortar = scene.joints["mortar"];
  mortar.law = first_law;
  if (first_law == "elastic") {  // which refuses properties of other laws
    std::erase_if(mortar.properties,
                  [](const PropertySetting& p) { return p.id.find("stiffness") == std::string::npos; });
  }
  for (std::size_t k = 0; k < swaps.size(); ++k) {
    Stage stage;
    stage.name = "stage " + std::to_string(k);
    BodyControl bottom, top;
    bottom.body = "bottom_beam";
    top.body = stage.monitor = "top_beam";
    if (k == 0) {
      top.kind[1] = DofKind::free;
      top.force[1] = -0.3e6 * 0.55 * 0.1;
      stage.equilibrium_ratio = 1e-3;
    } else {
      top.velocity[0] = 0.05;
      stage.displacement = shear;
    }
    stage.controls = {bottom, top};
    if (!swaps[k].empty()) stage.law_swaps["mortar"] = swaps[k];
    scene.stages.push_back(stage);
  }
  return scene;
}

TEST(LawSwap, TractionIsContinuousThroughElasticSofteningAndBrittle) {
  Scene scene = swapped_wall("fracture_energy", {"", "elastic", "fracture_energy", "coulomb_slip"}, 2e-5);
  Simulation simulation(scene, assemble(scene), 1);
  SwapRecorder recorder;
  simulation.run(recorder);
  ASSERT_EQ(recorder.at_begin.size(), 4u);
  ASSERT_EQ(recorder.swaps.size(), 3u);
  for (std::size_t stage = 1; stage < 4; ++stage) {
    const auto& before = recorder.at_end[stage - 1];
    const auto& after = recorder.at_begin[stage];
    double largest = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(before[i].traction[k], after[i].traction[k]);
        largest = std::max(largest, std::abs(before[i].traction[k]));
      }
    }
    EXPECT_GT(largest, 1e5) << "the wall carries no load: nothing is tested";
  }
  for (const LawSwap& swap : recorder.swaps) {
    // All joints are elastic here, and the three laws have equal kn and ks: the energy does not change.
    EXPECT_GT(swap.stored_before, 0.0);
    EXPECT_LT(std::abs(swap.energy_jump), 1e-9 * swap.stored_before);
    EXPECT_EQ(swap.limited, 0);
  }
}

// The first step with the new law. An open, softened joint has a secant stiffness far below kn. Without a normal shift
// at the swap its traction would jump to the tensile strength. The second swap adds to the shift of the first.
TEST(LawSwap, FirstStepAfterTheSwapChangesLittle) {
  Scene scene = swapped_wall("fracture_energy", {"", "", "coulomb_slip", "elastic"}, 4e-4);
  for (const std::size_t k : {2u, 3u}) {
    scene.stages[k].displacement.reset();
    scene.stages[k].duration = 1e-9;  // one step
  }
  Simulation simulation(scene, assemble(scene), 1);
  SwapRecorder recorder;
  simulation.run(recorder);
  ASSERT_EQ(recorder.swaps.size(), 2u);
  EXPECT_GT(recorder.swaps[0].limited, 0) << "no joint has softened: nothing is tested";
  for (const std::size_t stage : {2u, 3u}) {
    const auto& before = recorder.at_end[stage - 1];
    const auto& after = recorder.at_end[stage];
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (simulation.assembly().families[static_cast<std::size_t>(before[i].family)].name != "mortar") continue;
      // kn times the opening in a step of 2.5 us of gridpoints with up to 0.2 m/s (the beam has 0.05 m/s).
      EXPECT_NEAR(before[i].traction[0], after[i].traction[0], kNormal * 5e-7) << stage;
    }
  }
}

TEST(LawSwap, HistoryGoesOverById) {
  Scene scene = swapped_wall("fracture_energy", {"", "", "fracture_energy"}, 4e-4);
  Simulation simulation(scene, assemble(scene), 1);
  SwapRecorder recorder;
  simulation.run(recorder);
  double damaged = 0.0;
  ASSERT_EQ(recorder.xi_at_end[1].size(), recorder.xi_at_begin[2].size());
  for (std::size_t i = 0; i < recorder.xi_at_end[1].size(); ++i) {
    if (std::isnan(recorder.xi_at_end[1][i])) continue;  // elastic unit joints have no xi
    EXPECT_EQ(recorder.xi_at_end[1][i], recorder.xi_at_begin[2][i]);
    damaged += recorder.xi_at_end[1][i] > 0.0 ? 1.0 : 0.0;
  }
  EXPECT_GT(damaged, 0.0) << "nothing has softened: nothing is tested";
}

TEST(LawSwap, RefusedWhereTheTractionIsOutsideTheStrength) {
  Scene scene = swapped_wall("elastic", {"", "", "fracture_energy"}, 2e-3);
  Simulation simulation(scene, assemble(scene), 1);
  SwapRecorder recorder;
  try {
    simulation.run(recorder);
    FAIL() << "strengths of 0 took over a loaded wall";
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, Exit::law_refused);
    EXPECT_NE(std::string(error.what()).find("outside the strength"), std::string::npos) << error.what();
  }
}

// An open joint of a law without states carries nothing. It has no bond under the next law, and keeps its width. The
// gap was closed without a word, so the block above stopped in the air. `elastic`, without states, stands for that law.
TEST(LawSwap, AGapStaysOpenFromALawWithoutStates) {
  const Scene scene = wall_scene(2, 2.0);
  const JointFamily& mortar = scene.joints.at("mortar");
  const auto from = successor(mortar, "elastic");
  const double opening[] = {0.007, -1e-6}, zero[] = {0.0, 0.0}, pressed[] = {-1e5, 0.0}, area[] = {1.0, 1.0};
  const double sigma[] = {zero[0], pressed[0]};
  const FamilyColumns points{{2, opening, {sigma, zero, zero}, {}, {}}, area};
  for (const auto& [law, state] :
       {std::pair("coulomb_slip", "failed"), std::pair("fracture_energy", "xi_t"), std::pair("cyclic_joint", "xi")}) {
    const auto to = successor(mortar, law);
    const MigratedFamily migrated = migrate(mortar, *from, *to, points);
    EXPECT_NEAR(migrated.opening_shift[0], 0.0, 1e-15) << law;
    std::size_t column = 0;
    while (std::string(to->api().states[column]->id) != state) ++column;
    EXPECT_GE(migrated.state[2 * column], 1.0) << law << ": the gap is without bond";
    EXPECT_EQ(migrated.state[2 * column + 1], 0.0) << law << ": the pressed point is not";
  }
  EXPECT_EQ(migrate(mortar, *from, *from, points).sums(0, 2).limited, 1) << "elastic has no open joints";
}

}  // namespace
}  // namespace quoin
