#include "scene/actions/actions.h"

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
}

std::string beyond_lattice(const Stage& stage) {
  for (const StageAction& action : kStageActions) {
    if (action.acts(stage)) return action.has;
  }
  return "";
}

std::vector<std::string> action_texts(const Stage& stage) {
  std::vector<std::string> texts;
  for (const StageAction& action : kStageActions) {
    if (action.acts(stage)) texts.push_back(action.text(stage));
  }
  return texts;
}

}  // namespace quoin
