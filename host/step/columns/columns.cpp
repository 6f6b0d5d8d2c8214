#include "step/columns/columns.h"

#include "base/registry.h"
#include "step/state.h"

namespace quoin {

QUOIN_REGISTRY(ColumnGroup, kColumnGroups, kMemberColumns, kDamageColumns);

std::vector<std::string> added_columns(const Scene& scene) {
  std::vector<std::string> all;
  for (const ColumnGroup& group : kColumnGroups) {
    const std::vector<std::string> names = group.names(scene);
    all.insert(all.end(), names.begin(), names.end());
  }
  return all;
}

std::vector<double> added_values(const Simulation::Impl& run) {
  std::vector<double> all;
  for (const ColumnGroup& group : kColumnGroups) {
    const std::size_t count = all.size() + group.names(run.scene).size();
    const std::vector<double> values = group.values(run);
    all.insert(all.end(), values.begin(), values.end());
    all.resize(count, std::nan(""));
  }
  return all;
}

}  // namespace quoin
