#include "step/work_division.h"

#include <algorithm>
#include <functional>
#include <span>

#include "base/ranks.h"
#include "model/world_results.h"
#include "step/borders.h"
#include "step/collect.h"
#include "step/gather.h"
#include "step/rank_part.h"
#include "step/state.h"

namespace quoin {

namespace {

// Position of a block, equal on all ranks.
Vec3 place_in_large_motion(const Simulation::Impl& s, int block) {
  return geometry::array(s.parts.divided ? s.large_motion->part.rough_place[at(block)]
                                         : position_of(*s.large_motion, block));
}

// Own chunks, in the order of the items whose gridpoints their points read. A thread then finds most of these in its
// own cache. In the order of families one thread would have all joints within units.
std::vector<int> chunks_along_items(const Simulation::Impl& s) {
  std::vector<int> place(s.division.item_cost.size(), -1);
  const std::vector<int>& items = s.division.share.items;
  for (std::size_t k = 0; k < items.size(); ++k) place[at(items[k])] = static_cast<int>(k);
  std::vector<double> mean(s.division.chunk_cost.size(), 0.0);
  for (const int chunk : s.division.share.chunks) {
    double sum = 0.0, count = 0.0;
    each_item_of_chunk(s, chunk, [&](int item) {
      if (place[at(item)] >= 0) sum += place[at(item)], count += 1.0;
    });
    mean[at(chunk)] = sum / count;  // an own chunk touches an own item
  }
  std::vector<int> order = s.division.share.chunks;
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return mean[at(a)] < mean[at(b)]; });
  return order;
}

// Binds halo, scratch and the threads' shares to the share of this rank.
void bind_work(Simulation::Impl& s) {
  bind_halo(s);
  // Other ranks have advanced what is own now. Each rank copies velocities in all steps, so that none lags.
  if (s.large_motion && s.ranks) s.large_motion->pieces.motion_is_old = true;
  const auto ends = [&](std::span<const int> pieces, const std::vector<double>& cost) {
    std::vector<double> weight;
    for (const int i : pieces) weight.push_back(cost[at(i)]);
    return shares(weight, s.pool.thread_count());
  };
  s.division.chunk_order = chunks_along_items(s);
  s.division.chunk_end = ends(s.division.chunk_order, s.division.chunk_cost);
  s.division.border_end =
      ends(std::span(s.division.share.items).first(s.division.share.border_items), s.division.item_cost);
  s.division.item_end =
      ends(std::span(s.division.share.items).subspan(s.division.share.border_items), s.division.item_cost);
  s.data.scratch_doubles = kScratchColumns * s.division.largest_group;
  for (int t = static_cast<int>(s.division.scratch.size()); t < s.pool.thread_count(); ++t) {
    s.division.scratch.emplace_back(kUnitBlocks * s.data.scratch_doubles, 0.0);
    s.division.jumps.push_back(std::make_unique<ChunkJumps>());
    s.timing.clocks.emplace_back();
  }
}

// Cost of one side of a contact point, evaluation and memory traffic, in units of the costs of blocks (divide_work).
// Load balancing divides by their sum.
constexpr double kLatticeSide = 60.0, kSideInLargeMotion = 4.0;

// Scales of the axes that bisection tries: all equal, one shortened, one nearly removed (slices).
constexpr Vec3 kScales[] = {{1, 1, 1},    {0.125, 1, 1}, {1, 0.125, 1}, {1, 1, 0.125},
                            {0.01, 1, 1}, {1, 0.01, 1},  {1, 1, 0.01}};

// Items that the contact points of each chunk touch, each once, in the order of the points.
class ChunkItems {
 public:
  void add(int item) {
    const auto begin = items_.begin() + static_cast<std::ptrdiff_t>(end_.empty() ? 0 : end_.back());
    if (begin != items_.end() && (items_.back() == item || std::find(begin, items_.end(), item) != items_.end()))
      return;
    items_.push_back(item);
  }
  void end_chunk() { end_.push_back(items_.size()); }
  std::span<const int> of_chunk(int chunk) const {
    const std::size_t begin = chunk > 0 ? end_[at(chunk) - 1] : 0;
    return std::span(items_).subspan(begin, end_[at(chunk)] - begin);
  }

 private:
  std::vector<int> items_;
  std::vector<std::size_t> end_;
};

// Number of contact points that ranks evaluate in addition to one process, in chunks at borders.
long points_between(const std::vector<int>& rank_of_item, const ChunkItems& touched,
                    const std::vector<double>& chunk_points) {
  long again = 0;
  std::vector<int> evaluate;
  for (std::size_t c = 0; c < chunk_points.size(); ++c) {
    evaluate.clear();
    for (const int item : touched.of_chunk(static_cast<int>(c))) {
      const int rank = rank_of_item[at(item)];
      if (std::find(evaluate.begin(), evaluate.end(), rank) == evaluate.end()) evaluate.push_back(rank);
    }
    again += static_cast<long>(evaluate.size() - 1) * static_cast<long>(chunk_points[c]);
  }
  return again;
}

}  // namespace

std::vector<int> rank_by_block(const Simulation::Impl& s) {
  std::vector<int> rank;
  for (const int item : s.division.item_by_block) rank.push_back(s.division.share.rank_of_item[at(item)]);
  return rank;
}

bool owns_block(const Simulation::Impl& s, int block) {
  if (!s.ranks) return true;
  return s.division.share.owns_item(s.large_motion ? s.division.item_by_block[at(block)] : item_of_block(s, block),
                                    s.ranks->rank());
}

int item_of_block(const Simulation::Impl& s, int block) {
  const Model::BlockPlace& where = s.model.place[at(block)];
  if (where.body < 0) return s.division.unit_of_group[at(where.group)];
  return static_cast<int>(s.model.unit_groups.size()) + s.lattice.place[at(where.body)].first;
}

std::vector<int> blocks_of_item(const Simulation::Impl& s, int item) {
  std::vector<int> blocks;
  if (s.large_motion) {
    const auto of_piece = s.large_motion->pieces.blocks_of(item);
    return {of_piece.begin(), of_piece.end()};
  }
  auto i = at(item);
  if (i < s.model.unit_groups.size()) {
    const UnitGroup& unit = s.model.unit_groups[i];
    for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g) {
      const BlockGroup& group = s.model.groups[at(g)];
      blocks.insert(blocks.end(), group.block.begin(), group.block.begin() + group.block_count);
    }
    return blocks;
  }
  for (const int body : bodies_of_item(s, item)) blocks.push_back(s.model.bodies[at(body)].block);
  return blocks;
}

std::vector<int> bodies_of_item(const Simulation::Impl& s, int item) {
  auto i = at(item);
  if (s.large_motion || i < s.model.unit_groups.size()) return {};
  i -= s.model.unit_groups.size();
  if (i >= s.model.body_groups.size()) return {s.model.lone_bodies[i - s.model.body_groups.size()]};
  const BodyGroup& group = s.model.body_groups[i];
  return {group.body.begin(), group.body.begin() + group.body_count};
}

std::vector<double> estimated_costs(const Simulation::Impl& s) {
  std::vector<double> cost = s.division.item_cost;
  for (int c = 0; c < static_cast<int>(s.division.chunk_cost.size()); ++c)
    each_item_of_chunk(s, c, [&](int item) { cost[at(item)] += s.large_motion ? kSideInLargeMotion : kLatticeSide; });
  return cost;
}

RankShare share_of_this_rank(const Simulation::Impl& s) {
  const int chunks = static_cast<int>(s.division.chunk_cost.size()),
            items = static_cast<int>(s.division.item_cost.size());
  if (!s.ranks) return whole_share(chunks, items);
  std::vector<double> cost = estimated_costs(s);
  for (int i = 0; i < items && !s.rank_load.measured_over_estimated.empty(); ++i) {
    const std::vector<int> blocks = blocks_of_item(s, i);
    double sum = 0.0;
    for (const int b : blocks) sum += s.rank_load.measured_over_estimated[at(b)];
    cost[at(i)] *= sum / static_cast<double>(blocks.size());
  }
  // An item on the lattice has blocks at eight places of the assembly: their mean, or the first, represents it. Chunks
  // are long along courses, so a bisection with one axis shortened may be better. The candidate with the fewest points
  // at borders is used, the same on all ranks.
  std::vector<Vec3> mean, first;
  for (int i = 0; i < items; ++i) {
    mean.emplace_back();
    const std::vector<int> blocks = blocks_of_item(s, i);
    for (const int b : blocks) {
      const Vec3 centre = s.large_motion ? place_in_large_motion(s, b) : centre_of(s.model.assembly.bricks[at(b)]);
      mean.back() += centre / static_cast<double>(blocks.size());
      if (b == blocks.front()) first.push_back(centre);
    }
  }
  ChunkItems touched;
  for (int c = 0; c < chunks; ++c) {
    each_item_of_chunk(s, c, [&](int item) { touched.add(item); });
    touched.end_chunk();
  }
  RankShare of_rank;
  long fewest = -1;
  for (const std::vector<Vec3>* candidate : {&mean, &first}) {
    for (const Vec3& scale : kScales) {
      std::vector<Vec3> place = *candidate;
      for (Vec3& p : place) {
        for (std::size_t c = 0; c < 3; ++c) p[c] *= scale[c];
      }
      std::vector<int> ranks_so = bisect(place, cost, s.ranks->count());
      const long points = points_between(ranks_so, touched, s.division.chunk_cost);
      if (fewest >= 0 && points >= fewest) continue;
      fewest = points;
      of_rank.rank_of_item = std::move(ranks_so);
    }
  }
  of_rank.cost_of_rank.assign(at(s.ranks->count()), 0.0);
  of_rank.rank_of_chunk.assign(at(chunks), -1);
  for (int c = 0; c < chunks; ++c) {
    const std::span<const int> items_of_chunk = touched.of_chunk(c);
    of_rank.rank_of_chunk[at(c)] = of_rank.rank_of_item[at(items_of_chunk.front())];
    if (std::any_of(items_of_chunk.begin(), items_of_chunk.end(),
                    [&](int item) { return of_rank.owns_item(item, s.ranks->rank()); }))
      of_rank.chunks.push_back(c);
  }
  for (int i = 0; i < items; ++i) {
    if (of_rank.owns_item(i, s.ranks->rank())) of_rank.items.push_back(i);
    of_rank.cost_of_rank[at(of_rank.rank_of_item[at(i)])] += cost[at(i)];
  }
  return of_rank;
}

// On the lattice a key is a gridpoint and the axis of the joint: its points read displacements along that axis and
// velocities across it.
void each_side(const Simulation::Impl& s, int chunk, const std::function<void(int, std::int64_t)>& visit) {
  if (s.large_motion) {
    s.large_motion->each_side(chunk,
                              [&](int block, std::int64_t key) { visit(s.division.item_by_block[at(block)], key); });
    return;
  }
  const ContactChunk& c = s.model.chunks[at(chunk)];
  for (int i = c.first_point; i < c.first_point + c.point_count; ++i) {
    const Model::Sides sides = s.model.sides_of(i);
    visit(item_of_block(s, sides.a), std::int64_t{s.model.node_a[at(i)]} * 3 + c.axis);
    visit(item_of_block(s, sides.b), std::int64_t{s.model.node_b[at(i)]} * 3 + c.axis);
  }
}

void each_item_of_chunk(const Simulation::Impl& s, int chunk, const std::function<void(int)>& visit) {
  if (s.large_motion)
    return each_block_of_chunk(*s.large_motion, chunk, [&](int block) { visit(s.division.item_by_block[at(block)]); });
  each_side(s, chunk, [&](int item, std::int64_t) { visit(item); });
}

std::vector<int> chunks_here(const Simulation::Impl& s) {
  return s.parts.holds_all ? whole_share(static_cast<int>(s.model.chunks.size()), 0).chunks : s.division.share.chunks;
}

std::vector<int> chunks_with_results(const Simulation::Impl& s) {
  if (!has_all(s) && (s.parts.divided || !s.large_motion)) return s.division.share.chunks;
  return whole_share(s.large_motion ? s.large_motion->chunk_count() : static_cast<int>(s.model.chunks.size()), 0)
      .chunks;
}

PointRange points_of_chunk(const Simulation::Impl& s, int chunk) {
  if (!s.large_motion) {
    const ContactChunk& c = s.model.chunks[at(chunk)];
    return {c.first_point, c.first_point + c.point_count};
  }
  const blocks::Chunk& c = s.large_motion->chunks.all[at(chunk)];
  std::size_t first = c.first;
  for (int f = 0; f < c.family; ++f) first += s.large_motion->contacts.families[at(f)].size();
  return {static_cast<std::int32_t>(first), static_cast<std::int32_t>(first + c.count)};
}

void partition_work(Simulation::Impl& s) {
  divide_work(s);
  hold_part(s);
  bind_work(s);
}

void divide_work(Simulation::Impl& s) {
  s.division.chunk_cost.clear(), s.division.item_cost.clear(), s.division.unit_of_group.clear();
  for (const ContactChunk& chunk : s.model.chunks) s.division.chunk_cost.push_back(chunk.point_count);
  for (int c = 0; s.large_motion && c < s.large_motion->chunk_count(); ++c)
    s.division.chunk_cost.push_back(s.large_motion->chunks.all[at(c)].count);

  // In coefficients of a group's stiffness: a contact point of a lone body costs about 20, eight of a body group 12.
  constexpr double kBodyPoint = 20.0, kBodySlot = 12.0;
  s.division.largest_group = 0;
  for (const UnitGroup& unit : s.model.unit_groups) {
    s.division.item_cost.push_back(0.0);
    for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g) {
      s.division.unit_of_group.push_back(static_cast<int>(s.division.item_cost.size()) - 1);
      const BlockGroup& group = s.model.groups[at(g)];
      const BrickTemplate& shape = s.model.templates[at(group.brick_template)];
      s.division.item_cost.back() += static_cast<double>(shape.stiffness.coefficient.size());
      s.division.largest_group = std::max(s.division.largest_group, at(shape.node_count) * kLine);
    }
  }
  for (const BodyGroup& group : s.model.body_groups)
    s.division.item_cost.push_back(kBodySlot * (s.model.body_slots[at(group.slots)].slot_count() + 8.0));
  for (const int b : s.model.lone_bodies)
    s.division.item_cost.push_back(kBodyPoint * (static_cast<double>(s.model.bodies[at(b)].point.size()) + 2.0));
  for (int p = 0; s.large_motion && p < s.large_motion->piece_count(); ++p)
    s.division.item_cost.push_back(piece_work(*s.large_motion, p));
  s.division.item_by_block.assign(s.large_motion ? at(s.large_motion->block_count()) : 0, -1);
  for (int p = 0; s.large_motion && p < s.large_motion->piece_count(); ++p) {
    for (const std::int32_t block : s.large_motion->pieces.blocks_of(p)) s.division.item_by_block[at(block)] = p;
  }
  s.reactions.restrained_of_item.assign(s.division.item_cost.size(), {});
  for (const int block : s.reactions.restrained_blocks) {
    const int item = s.large_motion ? s.division.item_by_block[at(block)] : -1;
    if (item >= 0) s.reactions.restrained_of_item[at(item)].push_back(block);
  }
  s.division.share = share_of_this_rank(s);
}

}  // namespace quoin
