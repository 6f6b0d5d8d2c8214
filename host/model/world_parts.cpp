// The part of a shared model that a rank has, and the exchange of blocks and contact points that it lacks.
//
// Arrays have the length of the whole model; they take memory only where a rank works (base/sparse_memory.h). The owner
// of a block has its data that steps change. Owners of both blocks of a pair have its contact points.

#include "model/world_parts.h"

#include <algorithm>

#include "model/block_layout.h"
#include "model/contact_frames.h"
#include "model/fields.h"
#include "model/parted_points.h"
#include "model/placed_blocks.h"
#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

using VisitBytes = std::function<void(void*, size_t)>;

// Start points of the joints whose first block is one of these blocks.
Items start_points_of(const StartJoints& start, int first_block, int end_block) {
  const auto first_of = [&](int block) {
    const auto joint = std::ranges::lower_bound(start.joint, block, {}, [](const StartJoint& j) { return j.pair.a; });
    return joint == start.joint.end() ? start.point.size() : size_t(joint->first);
  };
  return {first_of(first_block), first_of(end_block)};
}

template <class Array>
void release_items(Array& array, size_t first, size_t end) {
  if (!array.empty()) release_part(array, first, end);
}

}  // namespace

// ---- Memory of items ------------------------------------------------------------------------------------------------

Items items_of_blocks(const World& w, Owner owner, size_t first, size_t end) {
  const ModelBlock &from = w.blocks[first], &last = w.blocks[end - 1];
  if (owner == Owner::block) return {first, end};
  if (owner == Owner::gridpoint) return {size_t(from.first_node), size_t(last.first_node + last.node_count)};
  Items bodies{0, 0};
  for (size_t i = first; i < end; ++i) {
    if (w.blocks[i].body < 0) continue;
    if (bodies.end == 0) bodies.first = size_t(w.blocks[i].body);
    bodies.end = size_t(w.blocks[i].body) + 1;
  }
  return bodies;
}

namespace {

void each_memory_of_block(World& w, int block, const VisitBytes& visit) {
  WorldFields::of_blocks(w, [&](const Field& field, auto& array) {
    const Items items = items_of_blocks(w, field.owner, size_t(block), size_t(block) + 1);
    if (field.known_to_all || array.empty() || items.first == items.end) return;
    visit(&array[items.first], (items.end - items.first) * sizeof array[0]);
  });
  const Items joints = start_points_of(w.start_joints, block, block + 1);
  if (joints.end == joints.first) return;
  visit(&w.start_joints.point[joints.first], (joints.end - joints.first) * sizeof(StartPoint));
  const size_t width = kept_width(w);
  if (!w.start_joints.kept.empty() && width > 0)
    visit(&w.start_joints.kept[joints.first * width],
          (joints.end - joints.first) * width * sizeof w.start_joints.kept[0]);
}

void each_memory_of_points(World& w, int family, size_t first, size_t end, const VisitBytes& visit) {
  WorldFields::of_points(
      [&](const Field& field, auto& column) {
        if (!field.known_to_all && !column.empty()) visit(&column[first], (end - first) * sizeof column[0]);
      },
      w.contacts.families[size_t(family)]);
}

struct Wanted {
  std::vector<bool> block, contact;            // items that are sent
  std::vector<bool> block_here, contact_here;  // whether they are requested here
  std::span<const int> known_by;               // rank that sends each block
  explicit Wanted(const World& world, std::span<const int> known)
      : block(world.blocks.size()),
        contact(world.contacts.list.size()),
        block_here(block),
        contact_here(contact),
        known_by(known) {}
};

// visit(rank, first byte, bytes, whether it is requested here). Consecutive contacts of one rank are sent together,
// array by array, in the same order on all ranks, whatever each rank requests.
template <class Visit>
void each_exchanged_memory(World& w, const Wanted& wanted, Visit visit) {
  for (size_t i = 0; i < w.blocks.size(); ++i) {
    if (!wanted.block[i]) continue;
    each_memory_of_block(w, int(i), [&](void* first, size_t bytes) {
      if (bytes > 0) visit(wanted.known_by[i], first, bytes, bool(wanted.block_here[i]));
    });
  }
  const auto rank_of_contact = [&](size_t i) { return wanted.known_by[size_t(w.contacts.list[i].pair.a)]; };
  // Items of arrays that are sent together, in runs that are requested here or not.
  struct Part {
    size_t items;
    bool here;
  };
  std::vector<Part> parts;
  int rank = 0;
  const auto add = [&](size_t items, bool here) {
    if (parts.empty() || parts.back().here != here) parts.push_back({0, here});
    parts.back().items += items;
  };
  const auto visit_parts = [&](void* first, size_t item_bytes) {
    auto* at = static_cast<std::byte*>(first);
    for (const Part& part : parts) {
      if (part.items > 0) visit(rank, at, part.items * item_bytes, part.here);
      at += part.items * item_bytes;
    }
  };
  for (size_t i = 0; i < w.contacts.list.size(); ++i) {
    if (!wanted.contact[i]) continue;
    const size_t first = i;
    rank = rank_of_contact(i), parts.clear();
    for (; i < w.contacts.list.size() && wanted.contact[i] && rank_of_contact(i) == rank; ++i)
      add(1, wanted.contact_here[i]);
    WorldFields::of_pairs(w, [&](const Field&, auto& array) { visit_parts(&array[first], sizeof array[0]); });
    --i;
  }
  for (size_t k = 0; k < w.contacts.families.size(); ++k) {
    const std::vector<uint32_t>& of_family = w.contacts.of_family[k];
    for (size_t i = 0; i < of_family.size(); ++i) {
      if (!wanted.contact[of_family[i]]) continue;
      const size_t first_of_run = i;
      const Contact& from = w.contacts.list[of_family[i]];
      rank = rank_of_contact(of_family[i]), parts.clear();
      for (; i < of_family.size() && wanted.contact[of_family[i]] && rank_of_contact(of_family[i]) == rank; ++i)
        add(w.contacts.list[of_family[i]].count, wanted.contact_here[of_family[i]]);
      const Contact& last = w.contacts.list[of_family[--i]];
      const size_t points = last.first + last.count - from.first;
      each_memory_of_points(w, int(k), from.first, from.first + points,
                            [&](void* at, size_t bytes) { visit_parts(at, bytes / points); });
      parts.clear();
      for (size_t c = first_of_run; c <= i; ++c) {
        const Contact& contact = w.contacts.list[of_family[c]];
        add(contact.count * size_t(facets_a_point(w, contact)), wanted.contact_here[of_family[c]]);
      }
      if (!w.contacts.facets.empty()) visit_parts(&w.contacts.facets[0] + from.first_facet, sizeof(Facet));
    }
  }
}

size_t exchange(World& w, const Wanted& wanted) {
  RankRows rows(*w.part.ranks);
  each_exchanged_memory(w, wanted,
                        [&](int rank, void* first, size_t bytes, bool here) { rows.add(rank, first, bytes, here); });
  return rows.exchange();
}

}  // namespace

void each_owned_memory(World& w, const VisitOwned& visit) {
  Wanted all(w, w.part.rank_of_block);
  all.block.assign(w.blocks.size(), true), all.contact.assign(w.contacts.list.size(), true);
  each_exchanged_memory(w, all, [&](int rank, void* first, size_t bytes, bool) { visit(rank, first, bytes); });
}

// ---- Which items are exchanged --------------------------------------------------------------------------------------

namespace {

// Items that some ranks lack, and whether this rank does.
struct Need {
  std::vector<bool>& sent;
  std::vector<bool>& here;
  int this_rank;
  void add(size_t item, int rank, bool knows) {
    if (knows) return;
    sent[item] = true;
    if (rank == this_rank) here[item] = true;
  }
};

// Releases arrays of consecutive blocks: those that change in a run, and those that lay_out makes.
void release_blocks(World& w, size_t first, size_t end) {
  WorldFields::of_blocks(w, [&](const Field& field, auto& array) {
    const Items items = items_of_blocks(w, field.owner, first, end);
    if constexpr (requires { release_part(array, items.first, items.end); }) {
      if (!field.known_to_all) release_items(array, items.first, items.end);
    }
  });
  const ModelBlock &from = w.blocks[first], &last = w.blocks[end - 1];
  const Items nodes = items_of_blocks(w, Owner::gridpoint, first, end),
              joints = start_points_of(w.start_joints, int(first), int(end));
  const auto release_nodes = [&](auto&... field) { (release_items(field, nodes.first, nodes.end), ...); };
  release_nodes(w.nodes.reference, w.nodes.anchor, w.nodes.mass, w.nodes.weight_mass, w.nodes.support);
  for (auto* field : {&w.shapes.corner, &w.shapes.placed_corner})
    release_items(*field, from.first_corner, last.first_corner + last.shape->vertices.size());
  for (auto* field : {&w.shapes.normal, &w.shapes.placed_normal})
    release_items(*field, from.first_normal, last.first_normal + last.shape->normals.size());
  release_items(w.poses.start, first, end);
  release_items(w.start_joints.point, joints.first, joints.end);
  release_items(w.start_joints.kept, joints.first * kept_width(w), joints.end * kept_width(w));
  for (size_t i = first; i < end; ++i) {
    w.part.laid_out[i] = false;
    std::vector<geometry::Zoning::SurfaceTriangle>().swap(w.blocks[i].surface);
  }
}

void release_points(World& w, size_t family, const std::vector<bool>& contact_stays) {
  Family& f = w.contacts.families[family];
  const std::vector<uint32_t>& of_family = w.contacts.of_family[family];
  for (size_t i = 0; i < of_family.size(); ++i) {
    if (contact_stays[of_family[i]]) continue;
    const Contact& from = w.contacts.list[of_family[i]];
    while (i + 1 < of_family.size() && !contact_stays[of_family[i + 1]]) ++i;
    const Contact& last = w.contacts.list[of_family[i]];
    each_memory_of_points(w, int(family), from.first, last.first + last.count, [](void* first, size_t bytes) {
      release_memory(std::span(static_cast<std::byte*>(first), bytes));
    });
    for (auto* column : {&f.arm[0], &f.arm[1], &f.arm[2], &f.offset, &f.area})
      release_items(*column, from.first, last.first + last.count);
    release_items(w.contacts.facets, from.first_facet, last.first_facet + last.count * size_t(facets_a_point(w, last)));
  }
}

}  // namespace

void hold_blocks(World& w, std::vector<int> rank_of_block, std::span<const int> known) {
  take_back_facets(w);
  const std::vector<int> before = std::exchange(w.part.rank_of_block, std::move(rank_of_block));
  const int here = w.part.ranks->rank();
  Wanted wanted(w, before);
  Need of_blocks{wanted.block, wanted.block_here, here}, of_contacts{wanted.contact, wanted.contact_here, here};
  std::vector<bool> stays(w.blocks.size()), contact_stays(w.contacts.list.size());
  const auto need_block = [&](int block, int rank) {
    if (rank == here) stays[size_t(block)] = true;
    of_blocks.add(size_t(block), rank, before[size_t(block)] == rank);
  };
  const auto need_contact = [&](size_t i, int rank) {
    const auto [a, b] = w.contacts.list[i].pair;
    if (rank == here) contact_stays[i] = true;
    of_contacts.add(i, rank, before[size_t(a)] == rank || before[size_t(b)] == rank);
  };
  for (int b = 0; b < w.block_count(); ++b) need_block(b, w.part.rank_of_block[size_t(b)]);
  for (size_t i = 0; i < w.contacts.list.size(); ++i) {
    const auto [a, b] = w.contacts.list[i].pair;
    for (const int rank : {w.part.rank_of_block[size_t(a)], w.part.rank_of_block[size_t(b)]})
      need_block(a, rank), need_block(b, rank), need_contact(i, rank);
  }
  std::vector<int> evaluate;
  for (int c = 0; c < w.chunk_count(); ++c) {
    evaluate.clear();
    each_contact_of_chunk(w, c, [&](size_t i) {
      for (const int block : {w.contacts.list[i].pair.a, w.contacts.list[i].pair.b}) {
        const int rank = w.part.rank_of_block[size_t(block)];
        if (std::ranges::find(evaluate, rank) == evaluate.end()) evaluate.push_back(rank);
      }
    });
    if (evaluate.size() == 1) continue;
    each_contact_of_chunk(w, c, [&](size_t i) {
      for (const int rank : evaluate) {
        need_contact(i, rank);
        need_block(w.contacts.list[i].pair.a, rank), need_block(w.contacts.list[i].pair.b, rank);
      }
    });
  }
  for (const int block : known) {
    for (int r = 0; r < w.part.ranks->count(); ++r) need_block(block, r);
  }
  for (int b = 0; b < w.block_count(); ++b) {
    if (stays[size_t(b)]) lay_out(w, b);
  }
  exchange(w, wanted);

  each_row(stays, false, [&](size_t first, size_t end) { release_blocks(w, first, end); });
  each_row(contact_stays, false, [&](size_t first, size_t end) {
    WorldFields::of_pairs(w, [&](const Field&, auto& array) { release_part(array, first, end); });
  });
  for (size_t k = 0; k < w.contacts.families.size(); ++k) release_points(w, k, contact_stays);
  bind_work(w);
  bind_neighbours(w);
}

void exchange_blocks(World& w, std::span<const int> chosen) {
  Wanted wanted(w, w.part.rank_of_block);
  for (const int b : chosen) {
    lay_out(w, b);
    wanted.block[size_t(b)] = true, wanted.block_here[size_t(b)] = !w.part.owns(b);
  }
  exchange(w, wanted);
}

void exchange_joints(World& w, std::span<const int> of_blocks) {
  Wanted wanted(w, w.part.rank_of_block);
  std::vector<bool> asked(w.blocks.size());
  for (const int b : of_blocks) asked[size_t(b)] = true;
  for (size_t i = 0; i < w.contacts.list.size(); ++i) {
    const Contact& c = w.contacts.list[i];
    if (c.count == 0 || !(asked[size_t(c.pair.a)] || asked[size_t(c.pair.b)])) continue;
    wanted.contact[i] = true, wanted.contact_here[i] = !w.part.owns(c.pair);
    for (const int b : {c.pair.a, c.pair.b}) {
      lay_out(w, b);
      wanted.block[size_t(b)] = true, wanted.block_here[size_t(b)] = !w.part.owns(b);
    }
  }
  exchange(w, wanted);
}

// The owner of a joint's first block may lack the second block, or have only the parts of it that it touches.
void exchange_parted_blocks(World& w) {
  if (!w.part.ranks || !w.start_joints.any_replaced()) return;
  Wanted wanted(w, w.part.rank_of_block);
  Need need{wanted.block, wanted.block_here, w.part.ranks->rank()};
  for (const StartJoint& joint : w.start_joints.joint) {
    const int rank_a = w.part.rank_of_block[size_t(joint.pair.a)], rank_b = w.part.rank_of_block[size_t(joint.pair.b)];
    need.add(size_t(joint.pair.b), rank_a, rank_a == rank_b);
  }
  for (int b = 0; b < w.block_count(); ++b) {
    if (wanted.block_here[size_t(b)]) lay_out(w, b);
  }
  exchange(w, wanted);
}

size_t gather_everything(World& w, bool to_all) {
  take_back_facets(w);
  Wanted wanted(w, w.part.rank_of_block);
  const bool here = to_all || w.part.ranks->rank() == 0;
  for (int b = 0; b < w.block_count(); ++b) {
    if (here) lay_out(w, b);
    wanted.block[size_t(b)] = true, wanted.block_here[size_t(b)] = here && !w.part.owns(b);
  }
  for (size_t i = 0; i < w.contacts.list.size(); ++i)
    wanted.contact[i] = true, wanted.contact_here[i] = here && !w.part.owns(w.contacts.list[i].pair);
  const size_t bytes = exchange(w, wanted);
  for (Chunk& chunk : w.chunks.all) {
    if (here) pack(w, chunk), bind(w, w.contacts.families[size_t(chunk.family)], chunk);
  }
  return bytes;
}

void refresh_blocks(World& w, std::span<const double> chosen) {
  if (!w.part.ranks) return;
  Wanted wanted(w, w.part.rank_of_block);
  for (size_t b = 0; b < w.blocks.size(); ++b) {
    wanted.block[b] = chosen[b] != 0.0;
    wanted.block_here[b] = wanted.block[b] && w.part.laid_out[b] && !w.part.owns(int(b));
  }
  exchange(w, wanted);
}

// ---- Blocks close to those of other ranks --------------------------------------------------------------------------

void receive_new_neighbours(World& w, const std::vector<geometry::Pair>& pairs) {
  if (!w.part.ranks) return;
  Wanted wanted(w, w.part.rank_of_block);
  Need need{wanted.block, wanted.block_here, w.part.ranks->rank()};
  for (const auto& [a, b] : pairs) {
    const int rank_a = w.part.rank_of_block[size_t(a)], rank_b = w.part.rank_of_block[size_t(b)];
    if (rank_a == rank_b) continue;
    need.add(size_t(a), rank_b, false), need.add(size_t(b), rank_a, false);
  }
  for (int b = 0; b < w.block_count(); ++b) {
    if (wanted.block_here[size_t(b)]) lay_out(w, b);
  }
  exchange(w, wanted);
  place_blocks(w);
}

void bind_neighbours(World& w) {
  w.part.neighbours.clear();
  if (!w.part.ranks) return;
  const int here = w.part.ranks->rank();
  w.part.deviating.resize(w.blocks.size(), 0.0);
  std::map<int, std::pair<std::vector<int>, std::vector<int>>> with;  // by rank: blocks sent to it, and blocks received
  for (const Contact& c : w.contacts.list) {
    const auto [a, b] = c.pair;
    const int rank_a = w.part.rank_of_block[size_t(a)], rank_b = w.part.rank_of_block[size_t(b)];
    if (rank_a == rank_b || !w.part.owns(c.pair)) continue;
    const bool own = rank_a == here;
    auto& [to, from] = with[own ? rank_b : rank_a];
    to.push_back(own ? a : b), from.push_back(own ? b : a);
  }
  const auto numbers_of = [&](std::vector<int>& list, std::vector<double*>& numbers) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
    const auto add = [&](Vector& v) { numbers.insert(numbers.end(), {&v.x, &v.y, &v.z}); };
    for (const int block : list) {
      const ModelBlock& b = w.blocks[size_t(block)];
      if (b.body >= 0) {
        Body& body = w.bodies[size_t(b.body)];
        for (Vector* v : {&body.x, &body.v, &body.omega}) add(*v);
        for (Vector& row : body.r.row) add(row);
        for (Vector& row : body.transposed_r.row) add(row);
        numbers.push_back(&w.part.deviating[size_t(block)]);
      }
      for (int n = b.first_node; n < b.first_node + b.node_count; ++n) add(w.nodes.x[size_t(n)]);
      const size_t corners = b.body < 0 ? b.shape->vertices.size() : 0;
      for (Vector& v : std::span(w.nodes.v).subspan(size_t(b.first_node), corners)) add(v);
    }
  };
  for (auto& [rank, blocks] : with) {
    Border border{rank, {}, {}, {}, {}};
    numbers_of(blocks.first, border.send), numbers_of(blocks.second, border.receive);
    w.part.neighbours.add(std::move(border));
  }
}

void receive_neighbours(World& w) {
  if (!w.part.ranks) return;
  for (size_t i = 0; i < w.blocks.size(); ++i)
    w.part.deviating[i] = w.part.owns(int(i)) && w.step_sums.of_block[i].deviates ? 1.0 : 0.0;
  w.part.neighbours.send(*w.part.ranks);
  w.part.neighbours.receive(*w.part.ranks);
  for (size_t i = 0; i < w.blocks.size(); ++i) {
    if (!w.part.owns(int(i))) w.step_sums.of_block[i].deviates = w.part.deviating[i] > 0.0;
  }
}

}  // namespace quoin::blocks
