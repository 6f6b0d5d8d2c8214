// Scenes of faults that testers found from outside, and the rows of their runs.
#pragma once

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "step/results.h"
#include "step/simulation.h"
#include "support.h"

namespace quoin::verification {

inline const std::string kStone = R"(
[materials.stone]
young_modulus = 1e10
poisson_ratio = 0.2
density = 2000.0
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 5e8
friction_angle = 35.0
[output]
frames = 0
plots = false
energy = true
)";
inline const std::string kCube = R"(
[[block]]
name = "cube"
material = "stone"
box = { lower = [0, 0, 0], size = [1, 1, 1] }
)";
inline const std::string kBase = R"(
[[block]]
name = "base"
material = "stone"
fixed = true
box = { lower = [-3, -1, 0], size = [6, 1, 1] }
)";
// All joints without friction.
inline const std::string kSmooth = R"(
[joints.smooth]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 5e8
friction_angle = 0
[[joint_rule]]
family = "smooth"
)";
inline constexpr double kWeightOfCube = 2000.0 * gravity;  // N

inline std::string wall(const std::string& more) {
  return R"(
[wall]
courses = 3
units_per_course = 2
unit = [0.2, 0.1, 0.1]
mid_unit_joints = false
unit_material = "stone"
bed_joint = "dry"
head_joint = "dry"
beam_joint = "dry"
)" + more;
}

struct Rows : Observer {
  std::vector<HistoryRow> all;
  std::vector<std::string> warned_of;  // as in Warning::about
  bool goes_over = false;              // to large motion in mid-run
  void on_row(const HistoryRow& row) override { all.push_back(row); }
  void on_promotion(const Simulation&) override { goes_over = true; }
  void on_warning(const Warning& warning) override { warned_of.emplace_back(warning.about); }
  std::vector<HistoryRow> of_stage(int stage) const {
    std::vector<HistoryRow> found;
    std::ranges::copy_if(all, std::back_inserter(found), [&](const HistoryRow& row) { return row.stage == stage; });
    return found;
  }
};

// Rows of a run; run: null, or what comes out of it.
inline Rows rows_of(const std::string& scene, std::unique_ptr<Simulation>* run = nullptr) {
  auto simulation = std::make_unique<Simulation>(scene_of(kStone + scene));
  Rows rows;
  simulation->run(rows);
  if (run) *run = std::move(simulation);
  return rows;
}

template <class Act>
void expect_error(Exit exit_code, const std::string& reason, const Act& act) {
  try {
    act();
    ADD_FAILURE() << "accepted: " << reason;
  } catch (const Error& e) {
    EXPECT_EQ(e.exit_code, exit_code);
    EXPECT_NE(std::string(e.what()).find(reason), std::string::npos) << e.what();
  }
}

// Refused before the run. top: keys ahead of all tables.
inline void expect_refused(const std::string& scene, const std::string& reason, const std::string& top = "") {
  expect_error(Exit::bad_input, reason, [&] { Simulation of(scene_of(top + kStone + scene)); });
}

}  // namespace quoin::verification
