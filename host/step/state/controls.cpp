#include "step/state/controls.h"

#include <algorithm>

namespace quoin {

void Controls::find_loaded_blocks(const Model& model) {
  loaded_blocks.clear(), load_of_group.clear();
  std::vector<int> place(model.groups.size(), -1);
  int count = 0;
  for (std::size_t i = 0; i < model.assembly.bricks.size(); ++i) {
    const Brick& brick = model.assembly.bricks[i];
    if (brick.rigid || brick.body.empty()) continue;
    LoadedBlock& loaded = loaded_blocks.emplace_back();
    loaded.block = static_cast<int>(i);
    model.for_each_gridpoint(loaded.block, [&](std::size_t, double mass) { loaded.mass += mass; });
    int& group = place[static_cast<std::size_t>(model.place[i].group)];
    if (group < 0) group = count++;
  }
  load.assign(static_cast<std::size_t>(count) * kLine, 0.0);
  for (const int group : place) load_of_group.push_back(group < 0 ? nullptr : load.data() + group * kLine);
}

const LoadedBlock* Controls::loaded(int block) const {
  const auto found = std::ranges::lower_bound(loaded_blocks, block, {}, &LoadedBlock::block);
  return found != loaded_blocks.end() && found->block == block ? &*found : nullptr;
}

void Controls::load_brick(const Model& model, int block, const Vec3& force) {
  const Model::BlockPlace& where = model.place[static_cast<std::size_t>(block)];
  const auto first = static_cast<std::size_t>(load_of_group[static_cast<std::size_t>(where.group)] - load.data());
  for (std::size_t c = 0; c < 3; ++c)
    load[first + c * kLanes + static_cast<std::size_t>(where.lane)] = force[c] / loaded(block)->mass;
}

}  // namespace quoin
