#include "step/gather.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <span>

#include "base/rank_rows.h"
#include "base/ranks.h"
#include "model/world_parts.h"
#include "step/borders.h"
#include "step/lattice_fields.h"
#include "step/lattice_motion.h"
#include "step/monitor.h"
#include "step/rank_agreement.h"
#include "step/rank_part.h"
#include "step/reactions.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

namespace {

template <class T>
void visit_value(T& value, const VisitMemory& visit) {
  visit(&value, sizeof value);
}

}  // namespace

bool has_all(const Simulation::Impl& s) {
  return s.parts.gathered || (s.parts.gathered_by_first && s.ranks && s.ranks->rank() == 0);
}

void gather(Simulation::Impl& s, Part part, Who who, const RankShare* next) {
  if (!s.parts.divided) who = Who::everybody;
  if (s.parts.gathered || (part == Part::all && who == Who::first && s.parts.gathered_by_first) ||
      (part == Part::row && s.parts.has_row))
    return;
  const auto before = Clock::now();
  if (part == Part::row || part == Part::all) prepare_row(s);
  std::size_t whole = 0;
  const Part asked = part;
  if (s.large_motion && s.parts.divided) {  // the sums then hold all that a row reads
    if (part == Part::all) whole = gather_everything(*s.large_motion, who == Who::everybody);
    part = Part::sums;
  }
  const bool takes_all = part != Part::all || who == Who::everybody || (who == Who::first && s.ranks->rank() == 0);
  if (part == Part::all && takes_all) hold_all(s);
  HeldParts held;
  if (part == Part::all && who == Who::holders) held = held_with(s, next ? *next : s.division.share);
  const auto takes = [&](const std::vector<bool>& of_held, std::size_t i) {
    return takes_all || (!of_held.empty() && of_held[i]);
  };
  RankRows rows(*s.ranks);
  for (int i = 0; i < static_cast<int>(s.division.share.rank_of_item.size()); ++i) {
    const bool wanted = takes(held.items, at(i));
    each_memory_of_item(s, part, i, [&](void* first, std::size_t bytes) {
      rows.add(s.division.share.rank_of_item[at(i)], first, bytes, wanted);
    });
  }
  for (int c = 0; c < static_cast<int>(s.division.share.rank_of_chunk.size()); ++c) {
    const bool wanted = takes(held.chunks, at(c));
    each_memory_of_chunk(s, part, c, [&](void* first, std::size_t bytes) {
      rows.add(s.division.share.rank_of_chunk[at(c)], first, bytes, wanted);
    });
  }
  whole += rows.exchange();
  s.parts.has_row = s.large_motion && s.parts.divided && asked == Part::row;
  s.parts.gathered = asked == Part::all && who == Who::everybody;
  s.parts.gathered_by_first =
      s.parts.gathered_by_first || s.parts.gathered || (asked == Part::all && who == Who::first);
  s.rank_load.traffic.gathers += 1.0;
  s.rank_load.traffic.gathered_bytes += static_cast<double>(whole);
  const double seconds = seconds_since(before);
  s.rank_load.traffic.gathering_seconds += seconds;
  s.timing.phases[Phase::ranks] += seconds;
}

void fetch_for_frame(Simulation::Impl& s) {
  if (!s.parts.divided && !s.scene.output.pieces) return gather(s, Part::all, Who::first);
  if (!s.ranks) return;
  // Where detection has replaced joints, results of a joint read both of its blocks, on any ranks.
  if (!s.parts.divided && s.large_motion && s.large_motion->start_joints.any_replaced()) return gather(s, Part::all);
  const auto before = Clock::now();
  if (s.large_motion)
    exchange_parted_blocks(*s.large_motion);
  else
    receive_whole_borders(s);
  note_waiting(s, before);
}

void each_memory_of_item(Simulation::Impl& s, Part part, int item, const VisitMemory& visit) {
  if (s.large_motion) {
    s.large_motion->each_memory_of_piece(part, item, visit);
    for (std::size_t i = 0;
         s.parts.divided && part != Part::motion && i < s.reactions.restrained_of_item[at(item)].size(); ++i)
      visit_value(s.reactions.wrench[at(s.reactions.restrained_of_item[at(item)][i])], visit);
    return;
  }
  visit_value(s.division.measured[at(item)], visit);
  if (part == Part::sums) return;
  for (const int b : blocks_of_item(s, item)) visit_value(s.small_motion.whole_motions[at(b)], visit);
  const auto i = at(item) - s.model.unit_groups.size();
  const bool of_bodies = at(item) >= s.model.unit_groups.size();
  if (of_bodies) {
    BodyLanes& lanes = s.lattice.bodies[i];
    for (auto* quantity : {&lanes.displacement, &lanes.rotation, &lanes.velocity, &lanes.spin})
      visit(quantity, sizeof *quantity);
    for (const int b : bodies_of_item(s, item)) visit_value(s.reactions.wrench[at(s.model.bodies[at(b)].block)], visit);
  }
  if (part != Part::all) return;
  const auto each_gridpoint_field = [&](const auto& of_field) {
    each_lattice_field(s.lattice, [&](const Field& field, auto& array, int) {
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
    const UnitGroup& unit = s.model.unit_groups[at(item)];
    for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g) {
      const BlockGroup& group = s.model.groups[at(g)];
      lines(group.first_line, at(s.model.templates[at(group.brick_template)].node_count));
    }
  } else if (i < s.model.body_groups.size()) {
    const BodyGroup& group = s.model.body_groups[i];
    lines(group.first_line, at(s.model.body_slots[at(group.slots)].slot_count()));
  } else {
    for (const std::int32_t slave : s.model.bodies[at(s.model.lone_bodies[i - s.model.body_groups.size()])].slave) {
      each_gridpoint_field([&](LaneVector<double>& array) {
        for (std::size_t c = 0; c < 3; ++c) visit_value(array[at(slave) + c * kLanes], visit);
      });
    }
  }
}

void each_memory_of_chunk(Simulation::Impl& s, Part part, int chunk, const VisitMemory& visit) {
  if (s.large_motion) return s.large_motion->each_memory_of_chunk(part, chunk, visit);
  visit_value(s.contacts.sums[at(chunk)], visit);
  s.contacts.calls[at(chunk)].each_result(visit);
  if (part != Part::all) return;
  const ContactChunk& c = s.model.chunks[at(chunk)];
  const auto first = at(c.first_point), count = at(c.point_count);
  each_lattice_field(s.lattice, [&](const Field& field, auto& array, int family) {
    if (field.owner != Owner::contact_point || array.empty() || (family >= 0 && family != c.family)) return;
    const std::size_t bytes = count * sizeof array[0];
    if (family < 0) return visit(array.data() + first, bytes);
    const ContactFamily& of = s.model.families[at(family)];
    for (std::size_t begin = 0; begin < array.size(); begin += at(of.point_count))
      visit(array.data() + begin + (first - at(of.first_point)), bytes);
  });
}

void prepare_row(Simulation::Impl& s) {
  if (s.large_motion && s.parts.divided) {
    s.large_motion->scan_for_row(s.division.share.chunks, s.division.share.items);
    std::vector<int> own;
    for (const int item : s.division.share.items) {
      const std::vector<int>& some = s.reactions.restrained_of_item[at(item)];
      own.insert(own.end(), some.begin(), some.end());
    }
    const std::vector<JointWrench> wrenches = sum_large_motion_wrenches(s, own);
    for (std::size_t i = 0; i < own.size(); ++i) s.reactions.wrench[at(own[i])] = wrenches[i];
  }
  if (s.large_motion) return;
  s.small_motion.whole_motions.resize(s.model.assembly.bricks.size());
  for (const int item : s.division.share.items) {
    for (const int b : blocks_of_item(s, item)) {
      s.small_motion.whole_motions[at(b)] = whole_motion_of(s, at(b));
      if (s.model.place[at(b)].body >= 0) s.reactions.wrench[at(b)] = sum_joint_wrench(s, b);
    }
  }
  for (const int c : s.division.share.chunks) s.contacts.sums[at(c)].on_monitor = sum_on_monitor(s, c);
}

void give_array(Simulation::Impl& s, const void* array, std::size_t whole, const Simulation::TakeBytes& take) {
  struct Stretch {
    std::size_t begin, end;  // bytes from the beginning of the array
    int rank;
  };
  std::vector<Stretch> stretches;
  const auto* const first = static_cast<const std::uint8_t*>(array);
  const auto note = [&](int rank, const void* memory, std::size_t bytes) {
    const auto* const from = static_cast<const std::uint8_t*>(memory);
    if (from < first || from >= first + whole) return;
    const auto begin = static_cast<std::size_t>(from - first);
    if (!stretches.empty() && stretches.back().rank == rank && stretches.back().end == begin)
      stretches.back().end += bytes;
    else
      stretches.push_back({begin, begin + bytes, rank});
  };
  const auto note_of = [&](int rank) {
    return [&note, rank](const void* memory, std::size_t bytes) { note(rank, memory, bytes); };
  };
  if (s.large_motion) each_owned_memory(*s.large_motion, note);
  for (std::size_t i = 0; !s.large_motion && i < s.division.share.rank_of_item.size(); ++i)
    each_memory_of_item(s, Part::all, static_cast<int>(i), note_of(s.division.share.rank_of_item[i]));
  for (std::size_t c = 0; !s.large_motion && c < s.division.share.rank_of_chunk.size(); ++c)
    each_memory_of_chunk(s, Part::all, static_cast<int>(c), note_of(s.division.share.rank_of_chunk[c]));
  std::sort(stretches.begin(), stretches.end(), [](const Stretch& x, const Stretch& y) { return x.begin < y.begin; });

  const int here = s.ranks->rank();
  std::vector<std::size_t> sizes(at(s.ranks->count()));
  std::vector<std::uint8_t> own, all, piece;
  auto next = stretches.begin();
  for (std::size_t begin = 0; begin < whole; begin += kGatherBuffer) {
    const std::size_t end = std::min(begin + kGatherBuffer, whole);
    while (next != stretches.end() && next->end <= begin) ++next;
    const auto each_here = [&](const auto& visit) {
      for (auto i = next; i != stretches.end() && i->begin < end; ++i)
        visit(i->rank, std::max(i->begin, begin), std::min(i->end, end));
    };
    std::fill(sizes.begin(), sizes.end(), 0);
    own.clear();
    each_here([&](int rank, std::size_t from, std::size_t to) {
      sizes[at(rank)] += to - from;
      if (rank == here) own.insert(own.end(), first + from, first + to);
    });
    all.resize(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}));
    s.ranks->gather(std::as_bytes(std::span(own)), sizes, std::as_writable_bytes(std::span(all)));
    if (here != 0) continue;
    piece.assign(first + begin, first + end);
    std::vector<std::size_t> place(sizes.size());
    std::exclusive_scan(sizes.begin(), sizes.end(), place.begin(), std::size_t{0});
    each_here([&](int rank, std::size_t from, std::size_t to) {
      std::memcpy(piece.data() + (from - begin), all.data() + place[at(rank)], to - from);
      place[at(rank)] += to - from;
    });
    take(piece);
  }
}

}  // namespace quoin
