#include "step/state/controls.h"

#include <algorithm>

#include "step/state/actions.h"

namespace quoin {

void Controls::find_loaded_blocks(const Model& model) {
  loaded_blocks.clear(), load_of_group.clear(), load_ramps.clear();
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
  load_ramps.resize(loaded_blocks.size());
}

std::size_t Controls::loaded(int block) const {
  const auto found = std::ranges::lower_bound(loaded_blocks, block, {}, &LoadedBlock::block);
  return static_cast<std::size_t>(found - loaded_blocks.begin());
}

void Controls::apply_load(const Model& model, std::size_t loaded) {
  const LoadedBlock& block = loaded_blocks[loaded];
  const Model::BlockPlace& where = model.place[static_cast<std::size_t>(block.block)];
  const auto first = static_cast<std::size_t>(load_of_group[static_cast<std::size_t>(where.group)] - load.data());
  for (std::size_t c = 0; c < 3; ++c)
    load[first + c * kLanes + static_cast<std::size_t>(where.lane)] = load_ramps[loaded].now[c] / block.mass;
}

int Controls::ground_body() const {
  int found = -1, highest = 0;
  for (std::size_t b = 0; b < ramps.size(); ++b) {
    const int rank = ground_rank(ramps[b].of_ground, ramps[b].motion);
    if (rank > highest) highest = rank, found = static_cast<int>(b);
  }
  return found;
}

}  // namespace quoin
