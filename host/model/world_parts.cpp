// A model that several processes share: what each of them has of it, and how it gets what it did not have.
//
// Arrays have the numbers of the whole model; memory they have where a rank works (base/sparse_memory.h). What steps
// change of a block is known to its owner; contact points to the owners of both blocks of their pair.
#include <algorithm>

#include "model/fields.h"
#include "model/world.h"

namespace quoin::blocks {

namespace {

template <class Array>
void forget_items(Array& array, size_t first, size_t end) {
  if (!array.empty()) forget_part(array, first, end);
}

}  // namespace

template <class Memory>
void World::gather_by_block(Memory& values) const {
  all_gather(part_.ranks, std::span(values), [&](size_t block) { return part_.rank_of_block[block]; });
}
template void World::gather_by_block(std::vector<double>&) const;
template void World::gather_by_block(std::vector<geometry::Box>&) const;

bool World::any(bool here) const { return largest(here ? 1.0 : 0.0) > 0.0; }

double World::largest(double here) const {
  if (part_.ranks) part_.ranks->largest({&here, 1});
  return here;
}

// The fault of the first rank that has one.
void World::fail_together(const std::optional<Error>& here) const {
  if (!part_.ranks) {
    if (here) throw *here;
    return;
  }
  const double first = -largest(here ? -double(part_.ranks->rank()) : -double(part_.ranks->count()));
  const int rank = int(first);
  if (rank == part_.ranks->count()) return;
  const bool mine = rank == part_.ranks->rank();
  const std::string text = mine ? here->what() : "";
  const auto length = size_t(largest(double(text.size())));
  const int code = int(largest(mine ? double(here->exit_code) : 0.0));
  std::vector<size_t> sizes(size_t(part_.ranks->count()), 0);
  sizes[size_t(rank)] = length;
  std::string received(length, ' ');
  part_.ranks->gather(std::as_bytes(std::span(text)), sizes, std::as_writable_bytes(std::span(received)));
  throw Error(Exit(code), received);
}

// ---- What can be exchanged ------------------------------------------------------------------------------------------

World::Items World::items_of_blocks(Owner owner, size_t first, size_t end) const {
  const ModelBlock &from = blocks_[first], &last = blocks_[end - 1];
  if (owner == Owner::block) return {first, end};
  if (owner == Owner::gridpoint) return {size_t(from.first_node), size_t(last.first_node + last.node_count)};
  Items bodies{0, 0};
  for (size_t i = first; i < end; ++i) {
    if (blocks_[i].body < 0) continue;
    if (bodies.end == 0) bodies.first = size_t(blocks_[i].body);
    bodies.end = size_t(blocks_[i].body) + 1;
  }
  return bodies;
}

void World::each_memory_of_block(int block, const VisitBytes& visit) {
  WorldFields::of_blocks(*this, [&](const Field& field, auto& array) {
    const Items items = items_of_blocks(field.owner, size_t(block), size_t(block) + 1);
    if (field.known_to_all || array.empty() || items.first == items.end) return;
    visit(&array[items.first], (items.end - items.first) * sizeof array[0]);
  });
  const Items joints = start_points_of(block, block + 1);
  if (joints.end == joints.first) return;
  visit(&start_joints_.point[joints.first], (joints.end - joints.first) * sizeof(StartPoint));
  const size_t width = kept_width();
  if (!start_joints_.kept.empty() && width > 0)
    visit(&start_joints_.kept[joints.first * width],
          (joints.end - joints.first) * width * sizeof start_joints_.kept[0]);
}

World::Items World::start_points_of(int first_block, int end_block) const {
  const auto first_of = [&](int block) {
    const auto joint =
        std::ranges::lower_bound(start_joints_.joint, block, {}, [](const StartJoint& j) { return j.pair.a; });
    return joint == start_joints_.joint.end() ? start_joints_.point.size() : size_t(joint->first);
  };
  return {first_of(first_block), first_of(end_block)};
}

void World::each_memory_of_points(int family, size_t first, size_t end, const VisitBytes& visit) {
  WorldFields::of_points(
      [&](const Field& field, auto& column) {
        if (!field.known_to_all && !column.empty()) visit(&column[first], (end - first) * sizeof column[0]);
      },
      contacts_.families[size_t(family)]);
}

struct World::Wanted {
  std::vector<bool> block, contact;            // that are sent
  std::vector<bool> block_here, contact_here;  // asked for here
  std::span<const int> known_by;               // rank of each block
  explicit Wanted(const World& world, std::span<const int> known)
      : block(world.blocks_.size()),
        contact(world.contacts_.list.size()),
        block_here(block),
        contact_here(contact),
        known_by(known) {}
};

// visit(rank, first byte, bytes, whether it is asked for here). Neighbouring contacts of one rank go together, array by
// array, in the same order on all ranks, whatever each of them asks for.
template <class Visit>
void World::each_exchanged_memory(const Wanted& w, Visit visit) {
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (!w.block[i]) continue;
    each_memory_of_block(int(i), [&](void* first, size_t bytes) {
      if (bytes > 0) visit(w.known_by[i], first, bytes, bool(w.block_here[i]));
    });
  }
  const auto rank_of_contact = [&](size_t i) { return w.known_by[size_t(contacts_.list[i].pair.a)]; };
  // Items of arrays that go together, from some item on: how many of them are asked for here, or not, in turn.
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
  for (size_t i = 0; i < contacts_.list.size(); ++i) {
    if (!w.contact[i]) continue;
    const size_t first = i;
    rank = rank_of_contact(i), parts.clear();
    for (; i < contacts_.list.size() && w.contact[i] && rank_of_contact(i) == rank; ++i) add(1, w.contact_here[i]);
    WorldFields::of_pairs(*this, [&](const Field&, auto& array) { visit_parts(&array[first], sizeof array[0]); });
    --i;
  }
  for (size_t k = 0; k < contacts_.families.size(); ++k) {
    const std::vector<uint32_t>& of_family = contacts_.of_family[k];
    for (size_t i = 0; i < of_family.size(); ++i) {
      if (!w.contact[of_family[i]]) continue;
      const size_t first_of_run = i;
      const Contact& from = contacts_.list[of_family[i]];
      rank = rank_of_contact(of_family[i]), parts.clear();
      for (; i < of_family.size() && w.contact[of_family[i]] && rank_of_contact(of_family[i]) == rank; ++i)
        add(contacts_.list[of_family[i]].count, w.contact_here[of_family[i]]);
      const Contact& last = contacts_.list[of_family[--i]];
      const size_t points = last.first + last.count - from.first;
      each_memory_of_points(int(k), from.first, from.first + points,
                            [&](void* at, size_t bytes) { visit_parts(at, bytes / points); });
      parts.clear();
      for (size_t c = first_of_run; c <= i; ++c) {
        const Contact& contact = contacts_.list[of_family[c]];
        add(contact.count * size_t(facets_a_point(contact)), w.contact_here[of_family[c]]);
      }
      if (!contacts_.facets.empty()) visit_parts(&contacts_.facets[0] + from.first_facet, sizeof(Facet));
    }
  }
}

size_t World::exchange(const Wanted& wanted) {
  RankRows rows(*part_.ranks);
  each_exchanged_memory(wanted,
                        [&](int rank, void* first, size_t bytes, bool here) { rows.add(rank, first, bytes, here); });
  return rows.exchange();
}

void World::each_owned_memory(const VisitOwned& visit) {
  Wanted all(*this, part_.rank_of_block);
  all.block.assign(blocks_.size(), true), all.contact.assign(contacts_.list.size(), true);
  each_exchanged_memory(all, [&](int rank, void* first, size_t bytes, bool) { visit(rank, first, bytes); });
}

// ---- Which items are exchanged --------------------------------------------------------------------------------------

namespace {

// Items that some ranks lack, and whether this one does.
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

}  // namespace

void World::hold(std::vector<int> rank_of_block, std::span<const int> known) {
  take_back_facets();
  const std::vector<int> before = std::exchange(part_.rank_of_block, std::move(rank_of_block));
  const int here = part_.ranks->rank();
  Wanted wanted(*this, before);
  Need of_blocks{wanted.block, wanted.block_here, here}, of_contacts{wanted.contact, wanted.contact_here, here};
  std::vector<bool> stays(blocks_.size()), contact_stays(contacts_.list.size());
  const auto need_block = [&](int block, int rank) {
    if (rank == here) stays[size_t(block)] = true;
    of_blocks.add(size_t(block), rank, before[size_t(block)] == rank);
  };
  const auto need_contact = [&](size_t i, int rank) {
    const auto [a, b] = contacts_.list[i].pair;
    if (rank == here) contact_stays[i] = true;
    of_contacts.add(i, rank, before[size_t(a)] == rank || before[size_t(b)] == rank);
  };
  for (int b = 0; b < block_count(); ++b) need_block(b, part_.rank_of_block[size_t(b)]);
  for (size_t i = 0; i < contacts_.list.size(); ++i) {
    const auto [a, b] = contacts_.list[i].pair;
    for (const int rank : {part_.rank_of_block[size_t(a)], part_.rank_of_block[size_t(b)]})
      need_block(a, rank), need_block(b, rank), need_contact(i, rank);
  }
  std::vector<int> evaluate;
  for (int c = 0; c < chunk_count(); ++c) {
    evaluate.clear();
    each_contact_of_chunk(c, [&](size_t i) {
      for (const int block : {contacts_.list[i].pair.a, contacts_.list[i].pair.b}) {
        const int rank = part_.rank_of_block[size_t(block)];
        if (std::ranges::find(evaluate, rank) == evaluate.end()) evaluate.push_back(rank);
      }
    });
    if (evaluate.size() == 1) continue;
    each_contact_of_chunk(c, [&](size_t i) {
      for (const int rank : evaluate) {
        need_contact(i, rank);
        need_block(contacts_.list[i].pair.a, rank), need_block(contacts_.list[i].pair.b, rank);
      }
    });
  }
  for (const int block : known) {
    for (int r = 0; r < part_.ranks->count(); ++r) need_block(block, r);
  }
  for (int b = 0; b < block_count(); ++b) {
    if (stays[size_t(b)]) lay_out(b);
  }
  exchange(wanted);

  each_row(stays, false, [&](size_t first, size_t end) { forget_blocks(first, end); });
  each_row(contact_stays, false, [&](size_t first, size_t end) {
    WorldFields::of_pairs(*this, [&](const Field&, auto& array) { forget_part(array, first, end); });
  });
  for (size_t k = 0; k < contacts_.families.size(); ++k) forget_points(k, contact_stays);
  bind_work();
  bind_neighbours();
}

void World::forget_points(size_t family, const std::vector<bool>& contact_stays) {
  Family& f = contacts_.families[family];
  const std::vector<uint32_t>& of_family = contacts_.of_family[family];
  for (size_t i = 0; i < of_family.size(); ++i) {
    if (contact_stays[of_family[i]]) continue;
    const Contact& from = contacts_.list[of_family[i]];
    while (i + 1 < of_family.size() && !contact_stays[of_family[i + 1]]) ++i;
    const Contact& last = contacts_.list[of_family[i]];
    each_memory_of_points(int(family), from.first, last.first + last.count,
                          [](void* first, size_t bytes) { forget(std::span(static_cast<std::byte*>(first), bytes)); });
    for (auto* column : {&f.arm[0], &f.arm[1], &f.arm[2], &f.offset, &f.area})
      forget_items(*column, from.first, last.first + last.count);
    forget_items(contacts_.facets, from.first_facet, last.first_facet + last.count * size_t(facets_a_point(last)));
  }
}

// Of a row of blocks: what changes in a run, and what lay_out makes.
void World::forget_blocks(size_t first, size_t end) {
  WorldFields::of_blocks(*this, [&](const Field& field, auto& array) {
    const Items items = items_of_blocks(field.owner, first, end);
    if constexpr (requires { forget_part(array, items.first, items.end); }) {
      if (!field.known_to_all) forget_items(array, items.first, items.end);
    }
  });
  const ModelBlock &from = blocks_[first], &last = blocks_[end - 1];
  const Items nodes = items_of_blocks(Owner::gridpoint, first, end), joints = start_points_of(int(first), int(end));
  const auto forget_nodes = [&](auto&... field) { (forget_items(field, nodes.first, nodes.end), ...); };
  forget_nodes(nodes_.reference, nodes_.anchor, nodes_.mass, nodes_.weight_mass, nodes_.support);
  for (auto* field : {&shapes_.corner, &shapes_.placed_corner})
    forget_items(*field, from.first_corner, last.first_corner + last.shape->vertices.size());
  for (auto* field : {&shapes_.normal, &shapes_.placed_normal})
    forget_items(*field, from.first_normal, last.first_normal + last.shape->normals.size());
  forget_items(poses_.start, first, end);
  forget_items(start_joints_.point, joints.first, joints.end);
  forget_items(start_joints_.kept, joints.first * kept_width(), joints.end * kept_width());
  for (size_t i = first; i < end; ++i) {
    part_.laid_out[i] = false;
    std::vector<geometry::Zoning::SurfaceTriangle>().swap(blocks_[i].surface);
  }
}

void World::exchange_blocks(std::span<const int> chosen) {
  Wanted wanted(*this, part_.rank_of_block);
  for (const int b : chosen) {
    lay_out(b);
    wanted.block[size_t(b)] = true, wanted.block_here[size_t(b)] = !owns(b);
  }
  exchange(wanted);
}

void World::exchange_joints(std::span<const int> of_blocks) {
  Wanted wanted(*this, part_.rank_of_block);
  std::vector<bool> asked(blocks_.size());
  for (const int b : of_blocks) asked[size_t(b)] = true;
  for (size_t i = 0; i < contacts_.list.size(); ++i) {
    const Contact& c = contacts_.list[i];
    if (c.count == 0 || !(asked[size_t(c.pair.a)] || asked[size_t(c.pair.b)])) continue;
    wanted.contact[i] = true, wanted.contact_here[i] = !owns(c);
    for (const int b : {c.pair.a, c.pair.b}) {
      lay_out(b);
      wanted.block[size_t(b)] = true, wanted.block_here[size_t(b)] = !owns(b);
    }
  }
  exchange(wanted);
}

// The rank of a joint's first block may know nothing of the other one any more, or no more than what it touches of it.
void World::exchange_parted_blocks() {
  if (!part_.ranks || !has_replaced_points()) return;
  Wanted wanted(*this, part_.rank_of_block);
  Need need{wanted.block, wanted.block_here, part_.ranks->rank()};
  for (const StartJoint& joint : start_joints_.joint) {
    const int rank_a = part_.rank_of_block[size_t(joint.pair.a)], rank_b = part_.rank_of_block[size_t(joint.pair.b)];
    need.add(size_t(joint.pair.b), rank_a, rank_a == rank_b);
  }
  for (int b = 0; b < block_count(); ++b) {
    if (wanted.block_here[size_t(b)]) lay_out(b);
  }
  exchange(wanted);
}

size_t World::gather_everything(bool to_all) {
  take_back_facets();
  Wanted wanted(*this, part_.rank_of_block);
  const bool here = to_all || part_.ranks->rank() == 0;
  for (int b = 0; b < block_count(); ++b) {
    if (here) lay_out(b);
    wanted.block[size_t(b)] = true, wanted.block_here[size_t(b)] = here && !owns(b);
  }
  for (size_t i = 0; i < contacts_.list.size(); ++i)
    wanted.contact[i] = true, wanted.contact_here[i] = here && !owns(contacts_.list[i]);
  const size_t bytes = exchange(wanted);
  for (Chunk& chunk : chunks_.all) {
    if (here) pack(chunk), bind(contacts_.families[size_t(chunk.family)], chunk);
  }
  return bytes;
}

// ---- Blocks close to those of other ranks --------------------------------------------------------------------------

void World::receive_new_neighbours(const std::vector<geometry::Pair>& pairs) {
  if (!part_.ranks) return;
  Wanted wanted(*this, part_.rank_of_block);
  Need need{wanted.block, wanted.block_here, part_.ranks->rank()};
  for (const auto& [a, b] : pairs) {
    const int rank_a = part_.rank_of_block[size_t(a)], rank_b = part_.rank_of_block[size_t(b)];
    if (rank_a == rank_b) continue;
    need.add(size_t(a), rank_b, false), need.add(size_t(b), rank_a, false);
  }
  for (int b = 0; b < block_count(); ++b) {
    if (wanted.block_here[size_t(b)]) lay_out(b);
  }
  exchange(wanted);
  place_blocks();
}

void World::bind_neighbours() {
  part_.neighbours.clear();
  if (!part_.ranks) return;
  const int here = part_.ranks->rank();
  part_.deviating.resize(blocks_.size(), 0.0);
  std::map<int, std::pair<std::vector<int>, std::vector<int>>> with;  // by rank: blocks sent to it, and received
  for (const Contact& c : contacts_.list) {
    const auto [a, b] = c.pair;
    const int rank_a = part_.rank_of_block[size_t(a)], rank_b = part_.rank_of_block[size_t(b)];
    if (rank_a == rank_b || !owns(c)) continue;
    const bool own = rank_a == here;
    auto& [to, from] = with[own ? rank_b : rank_a];
    to.push_back(own ? a : b), from.push_back(own ? b : a);
  }
  const auto numbers_of = [&](std::vector<int>& list, std::vector<double*>& numbers) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
    const auto add = [&](Vector& v) { numbers.insert(numbers.end(), {&v.x, &v.y, &v.z}); };
    for (const int block : list) {
      const ModelBlock& b = blocks_[size_t(block)];
      if (b.body >= 0) {
        Body& body = bodies_[size_t(b.body)];
        for (Vector* v : {&body.x, &body.v, &body.omega}) add(*v);
        for (Vector& row : body.r.row) add(row);
        for (Vector& row : body.transposed_r.row) add(row);
        numbers.push_back(&part_.deviating[size_t(block)]);
      }
      for (int n = b.first_node; n < b.first_node + b.node_count; ++n) add(nodes_.x[size_t(n)]);
    }
  };
  for (auto& [rank, blocks] : with) {
    Border border{rank, {}, {}, {}, {}};
    numbers_of(blocks.first, border.send), numbers_of(blocks.second, border.receive);
    part_.neighbours.add(std::move(border));
  }
}

void World::receive_neighbours() {
  if (!part_.ranks) return;
  for (size_t i = 0; i < blocks_.size(); ++i)
    part_.deviating[i] = owns(int(i)) && step_sums_.of_block[i].deviates ? 1.0 : 0.0;
  part_.neighbours.send(*part_.ranks);
  part_.neighbours.receive(*part_.ranks);
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (!owns(int(i))) step_sums_.of_block[i].deviates = part_.deviating[i] > 0.0;
  }
}

}  // namespace quoin::blocks
