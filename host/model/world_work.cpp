// Who does what: contact points in runs for one call of their law, the sides of points that a block fetches, and what
// both cost.
#include "model/world.h"

namespace quoin::blocks {

void World::divide_work() {
  chunks_.clear();
  for (size_t k = 0; k < families_.size(); ++k) {
    for (uint32_t first = 0; first < families_[k].size(); first += kChunk) {
      Chunk& chunk = chunks_.emplace_back();
      chunk.family = int(k), chunk.first = first;
      chunk.count = std::min(kChunk, uint32_t(families_[k].size()) - first);
    }
  }
  bind_columns();

  touch_end_.assign(blocks_.size(), 0);
  for (const Family& f : families_) {
    for (const Point& p : f.point) ++touch_end_[size_t(p.a)], ++touch_end_[size_t(p.b)];
  }
  std::vector<uint32_t> next(blocks_.size(), 0);
  for (size_t i = 0, sum = 0; i < blocks_.size(); ++i) {
    next[i] = uint32_t(sum);
    sum += touch_end_[i];
    touch_end_[i] = uint32_t(sum);
  }
  touches_.resize(touch_end_.empty() ? 0 : touch_end_.back());
  for (size_t k = 0; k < families_.size(); ++k) {
    for (uint32_t i = 0; i < families_[k].size(); ++i) {
      const Point& p = families_[k].point[i];
      touches_[next[size_t(p.a)]++] = {int32_t(k), i, true};
      touches_[next[size_t(p.b)]++] = {int32_t(k), i, false};
    }
  }
  block_sums_.resize(blocks_.size());
  loaded_.resize(blocks_.size(), 0);
  ++divisions_;
}

double World::block_work(int block) const {
  // A zone costs about as much as two sides of contact points, a body as three.
  constexpr double kZone = 2.0, kBody = 3.0;
  const Unit unit = unit_of(block);
  if (unit.block[0] != block) return 0.0;  // goes with the first half
  double work = 0.0;
  for (int i : unit.blocks()) {
    const size_t b = size_t(i);
    work += kBody + kZone * blocks_[b].zone_count + double(touch_end_[b] - (b > 0 ? touch_end_[b - 1] : 0));
  }
  return work;
}

void World::bind_columns() {
  for (Chunk& chunk : chunks_) bind(families_[size_t(chunk.family)], chunk);
}

void World::bind(Family& f, Chunk& chunk) const {
  quoin_batch& batch = chunk.batch;
  batch = {};
  batch.struct_size = sizeof batch;
  batch.count = chunk.count;
  batch.normal_jump = {f.normal_jump.data() + chunk.first, 1};
  for (int k = 0; k < 2; ++k) batch.slip_increment[k] = {f.slip[k].data() + chunk.first, 1};
  for (int k = 0; k < 3; ++k) {
    batch.traction_old[k] = {f.traction[k].data() + chunk.first, 1};
    batch.traction_new[k] = {f.traction[k].data() + chunk.first, 1};
  }
  chunk.state_old.clear(), chunk.state_new.clear();
  for (auto& column : f.state) {
    chunk.state_old.push_back({column.data() + chunk.first, 1});
    chunk.state_new.push_back({column.data() + chunk.first, 1});
  }
  batch.state_old = chunk.state_old.data(), batch.state_new = chunk.state_new.data();
  if (!energy_ || f.stored.empty() || !(f.material->api().capabilities & QUOIN_CAN_ENERGY)) return;
  batch.energy_stored = {f.stored.data() + chunk.first, 1};
  for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) batch.dissipated[k] = {f.dissipated[k].data() + chunk.first, 1};
}

}  // namespace quoin::blocks
