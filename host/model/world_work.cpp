// Who does what: contact points in runs for one call of their law, the sides of points that a block fetches, and what
// both cost.
#include "model/world.h"

namespace quoin::blocks {

namespace {

// Sides of something, counted and then filled in block after block.
template <class Side, class ForEach>
void by_block(size_t blocks, std::vector<Side>& sides, std::vector<uint32_t>& end, ForEach for_each) {
  end.assign(blocks, 0);
  for_each([&](int block, const Side&) { ++end[size_t(block)]; });
  std::vector<uint32_t> next(blocks, 0);
  for (size_t i = 0, sum = 0; i < blocks; ++i) {
    next[i] = uint32_t(sum);
    sum += end[i];
    end[i] = uint32_t(sum);
  }
  sides.resize(end.empty() ? 0 : end.back());
  for_each([&](int block, const Side& side) { sides[next[size_t(block)]++] = side; });
}

bool same(const Vector& a, const Vector& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

}  // namespace

void World::divide_work() {
  for (Family& f : families_) pack(f);
  divide_points();
  bind_columns();
  divide_sides();
  divide_bodies();
  block_sums_.resize(blocks_.size());
  loaded_.resize(blocks_.size(), 0);
  ++divisions_;
}

void World::pack(Family& f) {
  for (auto& column : f.arm) column.resize(f.size());
  f.offset.resize(f.size()), f.area.resize(f.size());
  for (size_t i = 0; i < f.size(); ++i) {
    const Point& p = f.point[i];
    for (int c = 0; c < 3; ++c) f.arm[c][i] = p.arm[c];
    f.offset[i] = p.offset, f.area[i] = p.area;
  }
}

void World::divide_points() {
  chunks_.clear();
  for (size_t k = 0; k < families_.size(); ++k) {
    const Family& f = families_[k];
    for (uint32_t first = 0; first < f.size(); first += kChunk) {
      Chunk& chunk = chunks_.emplace_back();
      chunk.family = int(k), chunk.first = first;
      chunk.count = std::min(kChunk, uint32_t(f.size()) - first);
      for (uint32_t i = first; i < first + chunk.count; ++i) {
        const Point& p = f.point[i];
        if (p.facet_a >= 0 || p.facet_b >= 0) {
          chunk.others.push_back(i);
          continue;
        }
        const int32_t a = blocks_[size_t(p.a)].body, b = blocks_[size_t(p.b)].body;
        const RigidPair* last = chunk.pairs.empty() ? nullptr : &chunk.pairs.back();
        const bool goes_on = last && last->a == a && last->b == b && last->first + last->count == i &&
                             same(last->axis[0], p.n) && same(last->axis[1], p.s);
        if (goes_on)
          ++chunk.pairs.back().count;
        else
          chunk.pairs.push_back({a, b, i, 1, {p.n, p.s, p.t}, {}, {}, {}, {}});
      }
    }
  }
}

void World::divide_sides() {
  by_block(blocks_.size(), touches_, touch_end_, [&](const auto& visit) {
    for (const Chunk& chunk : chunks_) {
      for (const uint32_t i : chunk.others) {
        const Point& p = families_[size_t(chunk.family)].point[i];
        visit(p.a, Touch{chunk.family, i, true});
        visit(p.b, Touch{chunk.family, i, false});
      }
    }
  });
  by_block(blocks_.size(), pair_touches_, pair_touch_end_, [&](const auto& visit) {
    for (const Chunk& chunk : chunks_) {
      for (const RigidPair& pair : chunk.pairs) {
        const Point& p = families_[size_t(chunk.family)].point[pair.first];
        visit(p.a, PairTouch{&pair, true});
        visit(p.b, PairTouch{&pair, false});
      }
    }
  });
}

// Rigid blocks that follow each other, as many as a vector takes.
void World::divide_bodies() {
  bodies_with_.assign(blocks_.size(), 0);
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (blocks_[i].body < 0) continue;
    const size_t first = i;
    while (i + 1 < blocks_.size() && i + 1 - first < kBodies && blocks_[i + 1].body >= 0) ++i;
    bodies_with_[first] = uint8_t(i + 1 - first);
  }
}

double World::block_work(int block) const {
  // A zone costs about as much as two sides of contact points, a body as three, a pair of them as one.
  constexpr double kZone = 2.0, kBody = 3.0;
  const auto sides = [](const std::vector<uint32_t>& end, size_t b) {
    return double(end[b] - (b > 0 ? end[b - 1] : 0));
  };
  double work = 0.0;
  if (blocks_[size_t(block)].body >= 0) {
    for (int i = block; i < block + bodies_with(block); ++i)
      work += kBody + sides(touch_end_, size_t(i)) + sides(pair_touch_end_, size_t(i));
    return work;
  }
  const Unit unit = unit_of(block);
  if (unit.block[0] != block) return 0.0;  // goes with the first half
  for (int i : unit.blocks()) work += kZone * blocks_[size_t(i)].zone_count + sides(touch_end_, size_t(i));
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
  chunk.properties = batch_columns(f.columns, *f.material, chunk.first);
  batch.property_column_count = chunk.properties.size(), batch.property_columns = chunk.properties.data();
  if (!energy_ || f.stored.empty() || !(f.material->api().capabilities & QUOIN_CAN_ENERGY)) return;
  batch.energy_stored = {f.stored.data() + chunk.first, 1};
  for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) batch.dissipated[k] = {f.dissipated[k].data() + chunk.first, 1};
}

}  // namespace quoin::blocks
