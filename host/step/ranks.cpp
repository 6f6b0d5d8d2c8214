// One model on several processes: their shares, what they exchange in a step, and what is gathered when
// somebody asks for all of it.
#include "base/ranks.h"

#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>

#include "step/lattice_fields.h"

namespace quoin {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Cost of one side of a contact point, evaluation and memory traffic, in units of the costs of blocks
// (partition_work). Load balancing divides by their sum.
constexpr double kLatticeSide = 60.0, kSideInLargeMotion = 4.0;

// Scales of the axes that bisection tries: all equal, one shortened, one nearly removed (slices).
constexpr Vec3 kScales[] = {{1, 1, 1},    {0.125, 1, 1}, {1, 0.125, 1}, {1, 1, 0.125},
                            {0.01, 1, 1}, {1, 0.01, 1},  {1, 1, 0.01}};

// Items that the contact points of chunks touch, each once: first the first one of the chunk.
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

// How many contact points are evaluated once more than by one process, in chunks that more than one rank evaluates.
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

template <class T>
void visit_value(T& value, const VisitMemory& visit) {
  visit(&value, sizeof value);
}

}  // namespace

void Simulation::Impl::begin_with_ranks() {
  sparse_memory_wanted = true;
  if (const char* costly = std::getenv("QUOIN_DEAR_BLOCKS")) {
    costly_blocks.emplace();
    if (std::sscanf(costly, "%dx%lf", &costly_blocks->count, &costly_blocks->times) != 2)
      throw Error(Exit::usage, "QUOIN_DEAR_BLOCKS, for tests: BLOCKSxTIMES, such as 20x4");
  }
}

// Before anything is asked for that only ranks with the same model can exchange.
void Simulation::Impl::agree_on_model() const {
  double here[] = {static_cast<double>(large_motion ? large_motion->block_count() : long(model.assembly.bricks.size())),
                   static_cast<double>(contact_point_count()),
                   data.time_step,
                   0,
                   0,
                   0};
  for (std::size_t i = 0; i < 3; ++i) here[3 + i] = -here[i];
  ranks->largest(here);
  for (std::size_t i = 0; i < 3; ++i) {
    if (here[i] != -here[3 + i])
      throw Error(Exit::bad_input,
                  "the ranks have different models: the same program, scene and laws must be found by all of them");
  }
}

bool Simulation::owns_block(int block) const {
  const Impl& s = *impl_;
  if (!s.ranks) return true;
  return s.share.owns_item(s.large_motion ? s.item_by_block[at(block)] : s.item_of_block(block), s.ranks->rank());
}
bool Simulation::ranks_together() const { return impl_->together; }
const std::vector<RankTraffic>& Simulation::rank_traffic() const { return impl_->traffic_of_all; }

// ---- Who does what -------------------------------------------------------------------------------------------------

int Simulation::Impl::item_of_block(int block) const {
  const Model::BlockPlace& where = model.place[at(block)];
  if (where.body < 0) return unit_of_group[at(where.group)];
  return static_cast<int>(model.unit_groups.size()) + body_place[at(where.body)].first;
}

std::vector<int> Simulation::Impl::blocks_of_item(int item) const {
  std::vector<int> blocks;
  if (large_motion) {
    const auto of_piece = large_motion->blocks_of_piece(item);
    return {of_piece.begin(), of_piece.end()};
  }
  auto i = at(item);
  if (i < model.unit_groups.size()) {
    const UnitGroup& unit = model.unit_groups[i];
    for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g) {
      const BlockGroup& group = model.groups[at(g)];
      blocks.insert(blocks.end(), group.block.begin(), group.block.begin() + group.block_count);
    }
    return blocks;
  }
  for (const int body : bodies_of_item(item)) blocks.push_back(model.bodies[at(body)].block);
  return blocks;
}

std::vector<int> Simulation::Impl::bodies_of_item(int item) const {
  auto i = at(item);
  if (large_motion || i < model.unit_groups.size()) return {};
  i -= model.unit_groups.size();
  if (i >= model.body_groups.size()) return {model.lone_bodies[i - model.body_groups.size()]};
  const BodyGroup& group = model.body_groups[i];
  return {group.body.begin(), group.body.begin() + group.body_count};
}

std::vector<double> Simulation::Impl::estimated_costs() const {
  std::vector<double> cost = item_cost;
  for (int c = 0; c < static_cast<int>(chunk_cost.size()); ++c)
    each_item(c, [&](int item) { cost[at(item)] += large_motion ? kSideInLargeMotion : kLatticeSide; });
  return cost;
}

Vec3 Simulation::Impl::place_in_large_motion(int block) const {
  return geometry::array(in_parts ? large_motion->part.rough_place[static_cast<std::size_t>(block)]
                                  : large_motion->position(block));
}

RankShare Simulation::Impl::share_of_this_rank() const {
  const int chunks = static_cast<int>(chunk_cost.size()), items = static_cast<int>(item_cost.size());
  if (!ranks) return whole_share(chunks, items);
  std::vector<double> cost = estimated_costs();
  for (int i = 0; i < items && !measured_over_estimated.empty(); ++i) {
    const std::vector<int> blocks = blocks_of_item(i);
    double sum = 0.0;
    for (const int b : blocks) sum += measured_over_estimated[at(b)];
    cost[at(i)] *= sum / static_cast<double>(blocks.size());
  }
  // The blocks of an item on the lattice lie in eight places of the assembly. Their mean or the first may stand better
  // for all. Chunks of contact points are long along courses, so it may be better to cut as if one side were shorter.
  // What leaves the fewest points on borders is taken, by all ranks in the same way.
  std::vector<Vec3> mean, first;
  for (int i = 0; i < items; ++i) {
    mean.emplace_back();
    const std::vector<int> blocks = blocks_of_item(i);
    for (const int b : blocks) {
      const Vec3 centre = large_motion ? place_in_large_motion(b) : centre_of(model.assembly.bricks[at(b)]);
      for (std::size_t c = 0; c < 3; ++c) mean.back()[c] += centre[c] / static_cast<double>(blocks.size());
      if (b == blocks.front()) first.push_back(centre);
    }
  }
  ChunkItems touched;
  for (int c = 0; c < chunks; ++c) {
    each_item(c, [&](int item) { touched.add(item); });
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
      std::vector<int> ranks_so = bisect(place, cost, ranks->count());
      const long points = points_between(ranks_so, touched, chunk_cost);
      if (fewest >= 0 && points >= fewest) continue;
      fewest = points;
      of_rank.rank_of_item = std::move(ranks_so);
    }
  }
  of_rank.cost_of_rank.assign(at(ranks->count()), 0.0);
  of_rank.rank_of_chunk.assign(at(chunks), -1);
  for (int c = 0; c < chunks; ++c) {
    const std::span<const int> items_of_chunk = touched.of_chunk(c);
    of_rank.rank_of_chunk[at(c)] = of_rank.rank_of_item[at(items_of_chunk.front())];
    if (std::any_of(items_of_chunk.begin(), items_of_chunk.end(),
                    [&](int item) { return of_rank.owns_item(item, ranks->rank()); }))
      of_rank.chunks.push_back(c);
  }
  for (int i = 0; i < items; ++i) {
    if (of_rank.owns_item(i, ranks->rank())) of_rank.items.push_back(i);
    of_rank.cost_of_rank[at(of_rank.rank_of_item[at(i)])] += cost[at(i)];
  }
  return of_rank;
}

namespace {

// Of sides: what goes to other ranks and comes from them.
struct BorderKeys {
  std::map<int, std::set<std::int64_t>> to, from;
};

}  // namespace

std::vector<int> Simulation::Impl::ranks_of(int chunk) const {
  std::vector<int> found;
  each_item(chunk, [&](int item) {
    const int rank = share.rank_of_item[at(item)];
    if (std::find(found.begin(), found.end(), rank) == found.end()) found.push_back(rank);
  });
  return found;
}

// Every rank finds out for all others what they need, so that nobody has to ask.
void Simulation::Impl::bind_halo() {
  halo.clear();
  if (!ranks) return;
  const int here = ranks->rank();
  BorderKeys keys;
  std::set<int> on_border;
  traffic.points = traffic.shared_points = 0.0;
  for (const int c : share.chunks) {
    const std::vector<int> evaluate = ranks_of(c);
    traffic.points += chunk_cost[at(c)];
    if (evaluate.size() == 1) continue;
    traffic.shared_points += chunk_cost[at(c)];
    each_side(c, [&](int item, std::int64_t key) {
      const int owner = share.rank_of_item[at(item)];
      if (owner != here) {
        keys.from[owner].insert(key);
        return;
      }
      on_border.insert(item);
      for (const int r : evaluate) {
        if (r != here) keys.to[r].insert(key);
      }
    });
  }
  std::map<int, Border> borders;
  const auto border_with = [&](int rank) -> Border& {
    Border& border = borders[rank];
    border.rank = rank;
    return border;
  };
  for (const auto& [rank, of_rank] : keys.to)
    for (const std::int64_t key : of_rank) numbers_of(key, border_with(rank).send);
  for (const auto& [rank, of_rank] : keys.from)
    for (const std::int64_t key : of_rank) numbers_of(key, border_with(rank).receive);
  each_watched([&](int item, const std::vector<double*>& numbers) {
    const int owner = share.rank_of_item[at(item)];
    const auto append = [&](std::vector<double*>& list) { list.insert(list.end(), numbers.begin(), numbers.end()); };
    if (owner != here) return append(border_with(owner).receive);
    on_border.insert(item);
    for (int r = 0; r < ranks->count(); ++r) {
      if (r != here) append(border_with(r).send);
    }
  });
  for (auto& [rank, border] : borders) halo.add(std::move(border));
  share.border_items = on_border.size();
  std::stable_partition(share.items.begin(), share.items.end(), [&](int item) { return on_border.contains(item); });
  traffic.blocks = 0.0;
  for (const int item : share.items) traffic.blocks += static_cast<double>(blocks_of_item(item).size());
}

Halo Simulation::Impl::halo_on_borders(const SideNumbers& numbers_of_side) {
  const int here = ranks->rank();
  using Side = std::pair<int, std::int32_t>;  // block, gridpoint; of a rigid block none
  std::map<int, std::set<Side>> to, from;
  for (const int c : share.chunks) {
    const std::vector<int> evaluate = ranks_of(c);
    if (evaluate.size() == 1) continue;
    const ContactChunk& chunk = model.chunks[at(c)];
    for (std::int32_t p = chunk.first_point; p < chunk.first_point + chunk.point_count; ++p) {
      const Model::Sides sides = model.sides_of(p);
      for (const auto& [block, gridpoint] : {Side(sides.a, model.node_a[at(p)]), Side(sides.b, model.node_b[at(p)])}) {
        const Side side(block, model.place[at(block)].body < 0 ? gridpoint : -1);
        const int owner = share.rank_of_item[at(item_of_block(block))];
        if (owner != here) {
          from[owner].insert(side);
          continue;
        }
        for (const int r : evaluate) {
          if (r != here) to[r].insert(side);
        }
      }
    }
  }
  Halo found;
  for (int r = 0; r < ranks->count(); ++r) {
    Border border{r, {}, {}, {}, {}};
    for (const auto& [block, gridpoint] : to[r]) numbers_of_side(block, gridpoint, border.send);
    for (const auto& [block, gridpoint] : from[r]) numbers_of_side(block, gridpoint, border.receive);
    found.add(std::move(border));
  }
  return found;
}

void Simulation::Impl::receive_whole_borders() {
  Halo border = halo_on_borders([&](int block, std::int32_t gridpoint, std::vector<double*>& numbers) {
    const int body = model.place[at(block)].body;
    for (std::size_t c = 0; c < 3; ++c) {
      if (body < 0) {
        numbers.push_back(&displacement[at(gridpoint) + c * kLanes]);
        numbers.push_back(&velocity[at(gridpoint) + c * kLanes]);
        continue;
      }
      const auto [place, lane] = body_place[at(body)];
      BodyLanes& lanes = body_lanes[at(place)];
      for (auto* quantity : {&lanes.displacement, &lanes.rotation, &lanes.velocity, &lanes.spin})
        numbers.push_back(&(*quantity)[c][lane]);
    }
  });
  border.send(*ranks);
  border.receive(*ranks);
}

// On the lattice a key is a gridpoint and the axis of the joint: its points read displacements along that and
// velocities across.
void Simulation::Impl::each_side(int chunk, const std::function<void(int, std::int64_t)>& visit) const {
  if (large_motion) {
    large_motion->each_side(chunk, [&](int block, std::int64_t key) { visit(item_by_block[at(block)], key); });
    return;
  }
  const ContactChunk& c = model.chunks[at(chunk)];
  for (int i = c.first_point; i < c.first_point + c.point_count; ++i) {
    const Model::Sides sides = model.sides_of(i);
    visit(item_of_block(sides.a), std::int64_t{model.node_a[at(i)]} * 3 + c.axis);
    visit(item_of_block(sides.b), std::int64_t{model.node_b[at(i)]} * 3 + c.axis);
  }
}

void Simulation::Impl::each_item(int chunk, const std::function<void(int)>& visit) const {
  if (large_motion) {
    large_motion->each_block_of_chunk(chunk, [&](int block) { visit(item_by_block[at(block)]); });
    return;
  }
  const ContactChunk& c = model.chunks[at(chunk)];
  for (int i = c.first_point; i < c.first_point + c.point_count; ++i) {
    const Model::Sides sides = model.sides_of(i);
    visit(item_of_block(sides.a)), visit(item_of_block(sides.b));
  }
}

void Simulation::Impl::numbers_of(std::int64_t key, std::vector<double*>& numbers) {
  if (large_motion) return large_motion->numbers_of(key, numbers);
  const auto gridpoint = static_cast<std::size_t>(key / 3), n = static_cast<std::size_t>(key % 3);
  numbers.push_back(&displacement[gridpoint + n * kLanes]);
  for (const std::size_t c : {(n + 1) % 3, (n + 2) % 3}) numbers.push_back(&velocity[gridpoint + c * kLanes]);
}

void Simulation::Impl::each_watched(const std::function<void(int, const std::vector<double*>&)>& visit) {
  const auto of_large_motion = [&](const std::vector<int>& blocks) {
    for (const int block : blocks) {
      std::vector<double*> numbers;
      large_motion->motion_of(block, numbers);
      visit(item_by_block[at(block)], numbers);
    }
  };
  const auto of_bodies = [&](const std::vector<int>& bodies) {
    for (const int body : bodies) {
      const auto [place, lane] = body_place[at(body)];
      BodyLanes& lanes = body_lanes[at(place)];
      std::vector<double*> numbers;
      for (auto* quantity : {&lanes.displacement, &lanes.velocity}) {
        for (auto& component : *quantity) numbers.push_back(&component[lane]);
      }
      visit(static_cast<int>(model.unit_groups.size()) + place, numbers);
    }
  };
  const auto of_loaded = [&](int i, int components) {
    const int block = loaded_blocks[at(i)].block;
    std::vector<double*> numbers;
    model.for_each_gridpoint(block, [&](std::size_t offset, double) {
      for (std::size_t c = 0; c < at(components); ++c) {
        const std::size_t k = offset + c * kLanes;
        numbers.push_back(&displacement[k]), numbers.push_back(&velocity[k]);
      }
    });
    visit(item_of_block(block), numbers);
  };
  if (large_motion)
    of_large_motion(monitor_blocks);
  else
    of_bodies(monitor);
  // Against which ranks look at how their blocks have moved.
  if (const int ground = large_motion ? -1 : ground_body(); ground >= 0) of_bodies({ground});
  for (const int i : monitor_loaded) of_loaded(i, 3);
  for (const Floor& floor : whiffletree) {
    if (large_motion) of_large_motion(floor.large_motion);
    of_bodies(floor.bodies);
    for (const int i : floor.loaded) of_loaded(i, 1);  // along x
  }
}

// ---- In a step -----------------------------------------------------------------------------------------------------

void Simulation::Impl::send_motion() { halo.send(*ranks); }

void Simulation::Impl::receive_motion(bool measure_step) {
  const auto before = Clock::now();
  halo.receive(*ranks);
  traffic.steps += 1.0;
  traffic.halo_bytes += static_cast<double>(halo.bytes());
  traffic.halo_messages += static_cast<double>(halo.messages());
  window.estimated.resize(share.cost_of_rank.size(), 0.0);
  for (std::size_t r = 0; r < share.cost_of_rank.size(); ++r) window.estimated[r] += share.cost_of_rank[r];
  const double seconds = seconds_since(before);
  traffic.waiting_seconds += seconds;
  times[Phase::ranks] += seconds;
  bool deviates = large_motion && large_motion->has_deviating(share.items),
       leaves = large_motion && large_motion->leaves_frame(share.items);
  if (large_motion) ranks_failed = agree(large_motion->in_trouble(share.chunks, share.items), &deviates, &leaves);
  if (large_motion && in_parts) {
    if (deviates) large_motion->mark_deviation();
    if (measure_step)
      gather(Part::row);
    else if (want_energy || leaves || ranks_failed)
      gather(Part::sums);
    return;
  }
  if (leaves) gather(Part::all);
  if (measure_step || (large_motion && want_energy))
    gather(large_motion ? Part::row : Part::sums);
  else if (large_motion && (deviates || large_motion->checks_motion()))
    gather(Part::motion);
}

bool Simulation::Impl::agree(bool trouble, bool* deviates, bool* leaves_frame) {
  const auto before = Clock::now();
  double wanted[] = {trouble ? 1.0 : 0.0, stop_wanted ? 1.0 : 0.0, deviates && *deviates ? 1.0 : 0.0,
                     leaves_frame && *leaves_frame ? 1.0 : 0.0};
  ranks->largest(wanted);
  const double seconds = seconds_since(before);
  traffic.waiting_seconds += seconds;
  times[Phase::ranks] += seconds;
  stop_agreed = stop_agreed || wanted[1] > 0.0;
  if (deviates) *deviates = wanted[2] > 0.0;
  if (leaves_frame) *leaves_frame = wanted[3] > 0.0;
  if (wanted[0] > 0.0) gather(Part::all, Who::first);
  return wanted[0] > 0.0;
}

bool Simulation::Impl::any_rank(bool here) {
  if (!ranks) return here;
  double wanted[] = {here ? 1.0 : 0.0};
  ranks->largest(wanted);
  return wanted[0] > 0.0;
}

double Simulation::Impl::largest_of_ranks(double here) const {
  double largest[] = {here};
  ranks->largest(largest);
  return largest[0];
}

// ---- Who does what, by what it has taken ---------------------------------------------------------------------------

void Simulation::Impl::balance_ranks() {
  if (!ranks || ++window.steps < RankBalance::kWindow) return;
  const double own = costly_blocks ? pretended_seconds() : traffic.own_seconds - window.seconds_before;
  const std::vector<double> seconds = of_all_ranks(*ranks, own);
  const bool worth = balance.is_worth_dividing(seconds, window.estimated);
  traffic.uneven = most_over_mean(seconds);
  if (worth) repartition();
  window = {0, traffic.own_seconds, {}};
}

// What blocks cost is what their rank has taken for them, whichever of them it was that took more than estimated.
void Simulation::Impl::repartition() {
  const auto before = Clock::now();
  if (!in_parts) gather(Part::all);
  const std::vector<double> of_rank = balance.measured_over_estimated();
  measured_over_estimated.resize(large_motion ? at(large_motion->block_count()) : model.assembly.bricks.size(), 1.0);
  for (int item = 0; item < static_cast<int>(share.rank_of_item.size()); ++item) {
    for (const int b : blocks_of_item(item))
      measured_over_estimated[at(b)] *= of_rank[at(share.rank_of_item[at(item)])];
  }
  const std::vector<int> before_it = share.rank_of_item;
  if (in_parts && !large_motion) {
    const RankShare next = share_of_this_rank();
    gather(Part::all, Who::holders, &next);
  }
  partition_work();
  rest_known = false;                     // of the bodies of others it was not
  if (share.rank_of_item != before_it) {  // else items are too large for anything better
    if (traffic.repartitions == 0.0) traffic.uneven_before = traffic.uneven;
    traffic.repartitions += 1.0;
  }
  double took[] = {seconds_since(before)};
  ranks->largest(took);
  balance.divided(costly_blocks ? 0.0 : took[0]);
}

double Simulation::Impl::pretended_seconds() const {
  const std::vector<double> cost = estimated_costs();
  double sum = 0.0;
  for (const int item : share.items) {
    const std::vector<int> blocks = blocks_of_item(item);
    const auto costly = std::count_if(blocks.begin(), blocks.end(), [&](int b) { return b < costly_blocks->count; });
    const double part = static_cast<double>(costly) / static_cast<double>(blocks.size());
    sum += cost[at(item)] * (1.0 + (costly_blocks->times - 1.0) * part);
  }
  return sum * static_cast<double>(window.steps);
}

// ---- All of it -----------------------------------------------------------------------------------------------------

bool Simulation::Impl::has_all() const { return gathered || (gathered_by_first && ranks && ranks->rank() == 0); }

void Simulation::Impl::gather(Part part, Who who, const RankShare* next) {
  if (!in_parts) who = Who::everybody;
  if (gathered || (part == Part::all && who == Who::first && gathered_by_first) || (part == Part::row && has_row))
    return;
  const auto before = Clock::now();
  if (part == Part::row || part == Part::all) prepare_row();
  std::size_t whole = 0;
  const Part asked = part;
  if (large_motion && in_parts) {  // whose sums say what a row takes of blocks and contact points
    if (part == Part::all) whole = large_motion->gather_everything(who == Who::everybody);
    part = Part::sums;
  }
  const bool takes_all = part != Part::all || who == Who::everybody || (who == Who::first && ranks->rank() == 0);
  if (part == Part::all && takes_all) hold_all();
  Held held;
  if (part == Part::all && who == Who::holders) held = held_with(next ? *next : share);
  const auto takes = [&](const std::vector<bool>& of_held, std::size_t i) {
    return takes_all || (!of_held.empty() && of_held[i]);
  };
  RankRows rows(*ranks);
  for (int i = 0; i < static_cast<int>(share.rank_of_item.size()); ++i) {
    const bool wanted = takes(held.items, at(i));
    each_memory_of_item(
        part, i, [&](void* first, std::size_t bytes) { rows.add(share.rank_of_item[at(i)], first, bytes, wanted); });
  }
  for (int c = 0; c < static_cast<int>(share.rank_of_chunk.size()); ++c) {
    const bool wanted = takes(held.chunks, at(c));
    each_memory_of_chunk(
        part, c, [&](void* first, std::size_t bytes) { rows.add(share.rank_of_chunk[at(c)], first, bytes, wanted); });
  }
  whole += rows.exchange();
  has_row = large_motion && in_parts && asked == Part::row;
  gathered = asked == Part::all && who == Who::everybody;
  gathered_by_first = gathered_by_first || gathered || (asked == Part::all && who == Who::first);
  traffic.gathers += 1.0;
  traffic.gathered_bytes += static_cast<double>(whole);
  const double seconds = seconds_since(before);
  traffic.gathering_seconds += seconds;
  times[Phase::ranks] += seconds;
}

void Simulation::Impl::fetch_for_frame() {
  if (!in_parts && !scene.output.pieces) return gather(Part::all, Who::first);
  if (!ranks) return;
  // What was a joint shows how far its blocks are apart, wherever they are.
  if (!in_parts && large_motion && large_motion->has_replaced_points()) return gather(Part::all);
  const auto before = Clock::now();
  if (large_motion)
    large_motion->exchange_parted_blocks();
  else
    receive_whole_borders();
  const double seconds = seconds_since(before);
  traffic.waiting_seconds += seconds;
  times[Phase::ranks] += seconds;
}

void Simulation::Impl::each_memory_of_item(Part part, int item, const VisitMemory& visit) {
  if (large_motion) {
    large_motion->each_memory_of_piece(part, item, visit);
    for (std::size_t i = 0; in_parts && part != Part::motion && i < restrained_of_item[at(item)].size(); ++i)
      visit_value(block_wrench[at(restrained_of_item[at(item)][i])], visit);
    return;
  }
  visit_value(measured[at(item)], visit);
  if (part == Part::sums) return;
  for (const int b : blocks_of_item(item)) visit_value(whole_motions[at(b)], visit);
  const auto i = at(item) - model.unit_groups.size();
  const bool of_bodies = at(item) >= model.unit_groups.size();
  if (of_bodies) {
    BodyLanes& lanes = body_lanes[i];
    for (auto* quantity : {&lanes.displacement, &lanes.rotation, &lanes.velocity, &lanes.spin})
      visit(quantity, sizeof *quantity);
    for (const int b : bodies_of_item(item)) visit_value(body_wrench[at(b)], visit);
  }
  if (part != Part::all) return;
  const auto each_gridpoint_field = [&](const auto& of_field) {
    each_lattice_field(*this, [&](const Field& field, auto& array, int) {
      if constexpr (std::is_same_v<decltype(array), LaneVector<double>&>) {
        if (field.owner == Owner::gridpoint) of_field(array);
      }
    });
  };
  const auto lines = [&](std::int32_t first, std::size_t count) {
    each_gridpoint_field(
        [&](LaneVector<double>& array) { visit(array.data() + at(first) * kLine, count * kLine * sizeof(double)); });
  };
  if (!of_bodies) {
    const UnitGroup& unit = model.unit_groups[at(item)];
    for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g) {
      const BlockGroup& group = model.groups[at(g)];
      lines(group.first_line, at(model.templates[at(group.brick_template)].node_count));
    }
  } else if (i < model.body_groups.size()) {
    const BodyGroup& group = model.body_groups[i];
    lines(group.first_line, at(model.body_slots[at(group.slots)].slot_count()));
  } else {
    for (const std::int32_t slave : model.bodies[at(model.lone_bodies[i - model.body_groups.size()])].slave) {
      each_gridpoint_field([&](LaneVector<double>& array) {
        for (std::size_t c = 0; c < 3; ++c) visit_value(array[at(slave) + c * kLanes], visit);
      });
    }
  }
}

void Simulation::Impl::each_memory_of_chunk(Part part, int chunk, const VisitMemory& visit) {
  if (large_motion) return large_motion->each_memory_of_chunk(part, chunk, visit);
  LawCall& call = calls[at(chunk)];
  visit_value(call.force_sum, visit);
  visit_value(call.deepest, visit);
  visit_value(call.deepest_point, visit);
  visit_value(call.crushed_out, visit);
  visit_value(call.stored, visit);
  visit_value(call.dissipated, visit);
  visit_value(call.damping, visit);
  visit_value(call.on_monitor, visit);
  if (part != Part::all) return;
  const ContactChunk& c = model.chunks[at(chunk)];
  const auto first = at(c.first_point), count = at(c.point_count);
  each_lattice_field(*this, [&](const Field& field, auto& array, int family) {
    if (field.owner != Owner::contact_point || array.empty() || (family >= 0 && family != c.family)) return;
    const std::size_t bytes = count * sizeof array[0];
    if (family < 0) return visit(array.data() + first, bytes);
    const ContactFamily& of = model.families[at(family)];
    for (std::size_t begin = 0; begin < array.size(); begin += at(of.point_count))
      visit(array.data() + begin + (first - at(of.first_point)), bytes);
  });
  visit_value(call.failed, visit);
  visit_value(call.status, visit);
  visit_value(call.batch.failed_count, visit);
}

void Simulation::Impl::prepare_row() {
  if (large_motion && in_parts) {
    large_motion->scan_for_row(share.chunks, share.items);
    std::vector<int> own;
    for (const int item : share.items) {
      const std::vector<int>& some = restrained_of_item[at(item)];
      own.insert(own.end(), some.begin(), some.end());
    }
    const std::vector<JointWrench> wrenches = sum_large_motion_wrenches(own);
    for (std::size_t i = 0; i < own.size(); ++i) block_wrench[at(own[i])] = wrenches[i];
  }
  if (large_motion) return;
  whole_motions.resize(model.assembly.bricks.size());
  body_wrench.resize(model.bodies.size());
  for (const int item : share.items) {
    for (const int b : blocks_of_item(item)) whole_motions[at(b)] = whole_motion_of(at(b));
    for (const int b : bodies_of_item(item)) body_wrench[at(b)] = sum_joint_wrench(b);
  }
  for (const int c : share.chunks) calls[at(c)].on_monitor = sum_on_monitor(c);
}

void Simulation::Impl::collect_traffic() {
  if (!ranks) return;
  traffic.step_seconds = seconds_since(run_start);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  traffic.peak_memory = 1024.0 * static_cast<double>(usage.ru_maxrss);
  traffic_of_all = of_all_ranks(*ranks, traffic);
}

}  // namespace quoin
