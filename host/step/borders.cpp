#include "step/borders.h"

#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "base/ranks.h"
#include "step/actions/ground.h"
#include "step/gather.h"
#include "step/rank_agreement.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

namespace {

// Ranks that evaluate a chunk.
std::vector<int> ranks_of(const Simulation::Impl& s, int chunk) {
  std::vector<int> found;
  each_item_of_chunk(s, chunk, [&](int item) {
    const int rank = s.division.share.rank_of_item[at(item)];
    if (std::find(found.begin(), found.end(), rank) == found.end()) found.push_back(rank);
  });
  return found;
}

void numbers_of(Simulation::Impl& s, std::int64_t key, std::vector<double*>& numbers) {
  if (s.large_motion) return s.large_motion->numbers_of(key, numbers);
  const auto gridpoint = static_cast<std::size_t>(key / 3), n = static_cast<std::size_t>(key % 3);
  numbers.push_back(&s.lattice.displacement[gridpoint + n * kLanes]);
  for (const std::size_t c : {(n + 1) % 3, (n + 2) % 3}) numbers.push_back(&s.lattice.velocity[gridpoint + c * kLanes]);
}

// Visits motion that all ranks receive in every step, of the monitor and of floors: visit(item, addresses of its
// numbers).
void each_watched(Simulation::Impl& s, const std::function<void(int, const std::vector<double*>&)>& visit) {
  const auto of_block = [&](int block) {
    std::vector<double*> numbers;
    if (s.large_motion) {
      s.large_motion->motion_of(block, numbers);
      return visit(s.division.item_by_block[at(block)], numbers);
    }
    if (const int body = s.model.place[at(block)].body; body >= 0) {
      const auto [place, lane] = s.lattice.place[at(body)];
      BodyLanes& lanes = s.lattice.bodies[at(place)];
      for (auto* quantity : {&lanes.displacement, &lanes.velocity}) {
        for (auto& component : *quantity) numbers.push_back(&component[lane]);
      }
    } else {
      s.model.for_each_gridpoint(block, [&](std::size_t offset, double) {
        for (std::size_t c = 0; c < 3; ++c) {
          const std::size_t k = offset + c * kLanes;
          numbers.push_back(&s.lattice.displacement[k]), numbers.push_back(&s.lattice.velocity[k]);
        }
      });
    }
    visit(item_of_block(s, block), numbers);
  };
  std::ranges::for_each(s.monitor.blocks, of_block);
  // Motion of the ground, relative to which ranks measure displacements of their blocks.
  const int ground = ground_block(s);
  if (ground >= 0 && (s.large_motion || s.model.place[at(ground)].body >= 0)) of_block(ground);
  for (const std::vector<int>& floor : s.controls.floors) std::ranges::for_each(floor, of_block);
}

}  // namespace

// Every rank computes what all others read, without messages.
void bind_halo(Simulation::Impl& s) {
  s.parts.halo.clear();
  if (!s.ranks) return;
  const int here = s.ranks->rank();
  BorderKeys<std::int64_t> keys;
  std::set<int> on_border;
  s.rank_load.traffic.points = s.rank_load.traffic.shared_points = 0.0;
  for (const int c : s.division.share.chunks) {
    const std::vector<int> evaluate = ranks_of(s, c);
    s.rank_load.traffic.points += s.division.chunk_cost[at(c)];
    if (evaluate.size() == 1) continue;
    s.rank_load.traffic.shared_points += s.division.chunk_cost[at(c)];
    each_side(s, c, [&](int item, std::int64_t key) {
      if (keys.add(key, s.division.share.rank_of_item[at(item)], here, evaluate)) on_border.insert(item);
    });
  }
  std::map<int, Border> borders;
  const auto border_with = [&](int rank) -> Border& {
    Border& border = borders[rank];
    border.rank = rank;
    return border;
  };
  for (const auto& [rank, of_rank] : keys.to)
    for (const std::int64_t key : of_rank) numbers_of(s, key, border_with(rank).send);
  for (const auto& [rank, of_rank] : keys.from)
    for (const std::int64_t key : of_rank) numbers_of(s, key, border_with(rank).receive);
  each_watched(s, [&](int item, const std::vector<double*>& numbers) {
    const int owner = s.division.share.rank_of_item[at(item)];
    const auto append = [&](std::vector<double*>& list) { list.insert(list.end(), numbers.begin(), numbers.end()); };
    if (owner != here) return append(border_with(owner).receive);
    on_border.insert(item);
    for (int r = 0; r < s.ranks->count(); ++r) {
      if (r != here) append(border_with(r).send);
    }
  });
  for (auto& [rank, border] : borders) s.parts.halo.add(std::move(border));
  s.division.share.border_items = on_border.size();
  std::stable_partition(s.division.share.items.begin(), s.division.share.items.end(),
                        [&](int item) { return on_border.contains(item); });
  s.rank_load.traffic.blocks = 0.0;
  for (const int item : s.division.share.items)
    s.rank_load.traffic.blocks += static_cast<double>(blocks_of_item(s, item).size());
}

Halo halo_on_borders(Simulation::Impl& s, const SideNumbers& numbers_of_side) {
  const int here = s.ranks->rank();
  using Side = std::pair<int, std::int32_t>;  // block, gridpoint; -1: a rigid block
  BorderKeys<Side> keys;
  for (const int c : s.division.share.chunks) {
    const std::vector<int> evaluate = ranks_of(s, c);
    if (evaluate.size() == 1) continue;
    const ContactChunk& chunk = s.model.chunks[at(c)];
    for (std::int32_t p = chunk.first_point; p < chunk.first_point + chunk.point_count; ++p) {
      const Model::Sides sides = s.model.sides_of(p);
      for (const auto& [block, gridpoint] :
           {Side(sides.a, s.model.node_a[at(p)]), Side(sides.b, s.model.node_b[at(p)])}) {
        const Side side(block, s.model.place[at(block)].body < 0 ? gridpoint : -1);
        keys.add(side, s.division.share.rank_of_item[at(item_of_block(s, block))], here, evaluate);
      }
    }
  }
  return keys.halo(s.ranks->count(), [&](const Side& side, std::vector<double*>& numbers) {
    numbers_of_side(side.first, side.second, numbers);
  });
}

void receive_whole_borders(Simulation::Impl& s) {
  Halo border = halo_on_borders(s, [&](int block, std::int32_t gridpoint, std::vector<double*>& numbers) {
    const int body = s.model.place[at(block)].body;
    for (std::size_t c = 0; c < 3; ++c) {
      if (body < 0) {
        numbers.push_back(&s.lattice.displacement[at(gridpoint) + c * kLanes]);
        numbers.push_back(&s.lattice.velocity[at(gridpoint) + c * kLanes]);
        continue;
      }
      const auto [place, lane] = s.lattice.place[at(body)];
      BodyLanes& lanes = s.lattice.bodies[at(place)];
      for (auto* quantity : {&lanes.displacement, &lanes.rotation, &lanes.velocity, &lanes.spin})
        numbers.push_back(&(*quantity)[c][lane]);
    }
  });
  border.send(*s.ranks);
  border.receive(*s.ranks);
}

void send_motion(Simulation::Impl& s) { s.parts.halo.send(*s.ranks); }

void receive_motion(Simulation::Impl& s, bool measure_step) {
  const auto before = Clock::now();
  s.parts.halo.receive(*s.ranks);
  s.rank_load.traffic.steps += 1.0;
  s.rank_load.traffic.halo_bytes += static_cast<double>(s.parts.halo.bytes());
  s.rank_load.traffic.halo_messages += static_cast<double>(s.parts.halo.messages());
  s.rank_load.window.estimated.resize(s.division.share.cost_of_rank.size(), 0.0);
  for (std::size_t r = 0; r < s.division.share.cost_of_rank.size(); ++r)
    s.rank_load.window.estimated[r] += s.division.share.cost_of_rank[r];
  note_waiting(s, before);
  bool deviates = s.large_motion && s.large_motion->has_deviating(s.division.share.items),
       leaves = s.large_motion && s.large_motion->leaves_frame(s.division.share.items);
  if (s.large_motion)
    s.agreed.failed =
        agree(s, s.large_motion->in_trouble(s.division.share.chunks, s.division.share.items), &deviates, &leaves);
  if (deviates || leaves) s.large_motion->pieces.needs_check.assign(s.large_motion->pieces.all.size(), 1);
  if (s.large_motion && s.parts.divided) {
    if (deviates) s.large_motion->checks.any_deviates = true;
    if (measure_step)
      gather(s, Part::row);
    else if (s.energy.wanted || leaves || s.agreed.failed)
      gather(s, Part::sums);
    return;
  }
  if (leaves) gather(s, Part::all);
  if (measure_step || (s.large_motion && s.energy.wanted))
    gather(s, s.large_motion ? Part::row : Part::sums);
  else if (s.large_motion && (deviates || checks_motion(*s.large_motion)))
    gather(s, Part::motion);
}

}  // namespace quoin
