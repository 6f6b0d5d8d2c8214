#include "scene/actions/actions.h"

#include "base/error.h"
#include "scene/actions/action.h"

namespace quoin {

// `pressure` as a number is the key of a stage of kind pressure.
bool has_actions(const reader::Table& t) {
  return std::ranges::any_of(kStageActions, [&](const StageAction& action) {
    const toml::node* node = t.toml().get(action.key);
    return node && !node->is_number();
  });
}

void read_actions(reader::Table& t, Stage& stage, const std::string& folder, const std::vector<std::string>& names) {
  for (const StageAction& action : kStageActions) action.read(t, stage, folder, names);
  const char* const grows = stage.ground        ? "ground_motion"
                            : stage.collapse    ? "collapse"
                            : stage.moving_load ? "moving_load"
                                                : nullptr;
  if (grows && stage.equilibrium_ratio)
    t.refuse("equilibrium_ratio", fmt::format("none with {}: blocks are near equilibrium before it acts, and the stage "
                                              "would end; give a stage after it equilibrium_ratio",
                                              grows));
}

void refuse_on_fixed(const blocks::Block& block, const char* load, const Source& source) {
  if (!block.fixed) return;
  throw Error(Exit::bad_input, fmt::format("{0}: {1} on block '{2}': the block is fixed, so that the {1} would do "
                                           "nothing; remove it",
                                           source.text, load, block.name));
}

void refuse_on_driven(const blocks::Block& block, const Vec3& along, const char* load, const Stage& stage) {
  const auto control = std::ranges::find(stage.controls, block.name, &BodyControl::body);
  if (control == stage.controls.end() || control->may_turn) return;
  constexpr double kAcross = 1e-9;  // share of the load below which a component is rounding
  const double size = norm(geometry::vector(along));
  for (std::size_t c = 0; c < 3; ++c) {
    if (control->kind[c] == DofKind::free || std::abs(along[c]) <= kAcross * size) continue;
    throw Error(Exit::bad_input,
                fmt::format("{}: {} on block '{}': it acts along {}, where the stage prescribes the block's velocity, "
                            "so that it would do nothing; remove it, or make that component \"free\"",
                            stage.source.text, load, block.name, "xyz"[c]));
  }
}

namespace {

// The velocity of a deformable block is that of all its gridpoints, so it cannot turn as it moves.
void check_velocities(const Stage& stage, const blocks::Assembly& assembly) {
  for (const BodyControl& control : stage.controls) {
    const bool moves = std::ranges::find(control.kind, DofKind::velocity) != control.kind.end();
    if (control.omega == Vec3{} && !(control.may_turn && moves)) continue;
    const bool deforms = std::ranges::any_of(
        assembly.blocks, [&](const blocks::Block& b) { return b.name == control.body && !b.rigid; });
    if (!deforms) continue;
    throw Error(
        Exit::bad_input,
        fmt::format("{}: velocity of block '{}': {} is for rigid blocks, and this one deforms: all its "
                    "gridpoints move with the velocity; remove it, or make the block rigid",
                    stage.source.text, control.body, control.omega == Vec3{} ? "rotation_held = false" : "omega"));
  }
}

}  // namespace

void check_stages(const Scene& scene, const blocks::Assembly& assembly) {
  for (const Stage& stage : scene.stages) {
    check_velocities(stage, assembly);
    for (const StageAction& action : kStageActions) {
      if (action.check) action.check(stage, assembly);
    }
  }
}

std::string beyond_lattice(const Stage& stage) {
  for (const StageAction& action : kStageActions) {
    if (action.acts(stage)) return action.has;
  }
  return "";
}

std::string leaves_lattice(const Scene& scene, std::size_t stage) {
  Stage others = scene.stages[stage];
  const bool shakes = others.ground.has_value();
  others.ground.reset();
  if (std::string acts = beyond_lattice(others); !acts.empty()) return acts;
  if (!damping_of(scene.solver_in(stage)).has_maxwell()) return "";
  return shakes ? "moves the ground under maxwell_damping" : "has maxwell_damping";
}

std::vector<std::string> action_texts(const Stage& stage) {
  std::vector<std::string> texts;
  for (const StageAction& action : kStageActions) {
    if (action.acts(stage)) texts.push_back(action.text(stage));
  }
  return texts;
}

}  // namespace quoin
