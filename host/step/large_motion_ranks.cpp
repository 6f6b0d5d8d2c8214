// Blocks of any shape that several processes advance: the data that these exchange.
#include <algorithm>
#include <cmath>

#include "model/fields.h"
#include "model/world_parts.h"
#include "model/world_results.h"
#include "step/large_motion.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

template <class Holds>
bool any_block(const Model& m, std::span<const int> own_pieces, const Holds& holds) {
  return std::ranges::any_of(own_pieces,
                             [&](int piece) { return std::ranges::any_of(m.pieces.blocks_of(piece), holds); });
}

}  // namespace

bool Model::in_trouble(std::span<const int> own_chunks, std::span<const int> own_pieces) const {
  return std::ranges::any_of(own_chunks, [&](int c) { return chunks.all[size_t(c)].call.failed; }) ||
         any_block(*this, own_pieces, [&](int b) { return !std::isfinite(step_sums.of_block[size_t(b)].positions); });
}

bool Model::leaves_frame(std::span<const int> own_pieces) const {
  return any_block(*this, own_pieces,
                   [&](int b) { return pieces.in_frame[size_t(b)] && has_deformed_too_much(*this, b); });
}

bool Model::has_deviating(std::span<const int> own_pieces) const {
  return any_block(*this, own_pieces, [&](int b) { return step_sums.of_block[size_t(b)].deviates; });
}

void Model::scan_for_row(std::span<const int> own_chunks, std::span<const int> own_pieces) {
  for (const int c : own_chunks) {
    Chunk& chunk = chunks.all[size_t(c)];
    chunk.force_sum = force_sum_of(*this, chunk);
    chunk.deepest = deepest_of(*this, chunk);
  }
  for (const int p : own_pieces) {
    for (const int32_t b : pieces.blocks_of(pieces.all[size_t(p)])) {
      BlockSums& sums = step_sums.of_block[size_t(b)];
      sums.moved = moved_by_now(*this, b), sums.turned = turned_by_now(*this, b);
    }
  }
}

void Model::each_memory_of_piece(Part wanted, int piece, const VisitMemory& visit) {
  for (const int32_t i : pieces.blocks_of(pieces.all[size_t(piece)])) {
    if (wanted == Part::motion)
      visit(&step_sums.of_block[size_t(i)].deviates, sizeof(bool));
    else
      visit(&step_sums.of_block[size_t(i)], sizeof(BlockSums));
    WorldFields::of_blocks(*this, [&](const Field& field, auto& array) {
      if (!has(wanted, field.gathered)) return;
      const Items items = items_of_blocks(*this, field.owner, size_t(i), size_t(i) + 1);
      if (items.first < items.end) visit(&array[items.first], (items.end - items.first) * sizeof array[0]);
    });
  }
}

void Model::each_memory_of_chunk(Part wanted, int index, const VisitMemory& visit) {
  if (wanted == Part::motion) return;
  Chunk& chunk = chunks.all[size_t(index)];
  Family& f = contacts.families[size_t(chunk.family)];
  chunk.call.each_result(visit);
  visit(&chunk.force_sum, sizeof chunk.force_sum);
  visit(&chunk.deepest, sizeof chunk.deepest);
  WorldFields::of_points(
      [&](const Field& field, auto& column) {
        if (has(wanted, field.gathered) && !column.empty())
          visit(column.data() + chunk.first, chunk.count * sizeof column[0]);
      },
      f);
  if (wanted != Part::all) return;
  visit(chunk.facets.data(), chunk.facets.size() * sizeof(FacetLanes));
  for (const OtherPoint& other : chunk.others) {
    Point& p = f.point[other.index];
    visit(&p, sizeof(Point));
    if (p.facet_a >= 0) visit(&contacts.facets[size_t(p.facet_a)], sizeof(Facet));
  }
}

// Keys are numbered: bodies first, then gridpoints, then frames of blocks.
void Model::each_side(int index, const std::function<void(int, std::int64_t)>& visit) const {
  const Chunk& chunk = chunks.all[size_t(index)];
  const Family& f = contacts.families[size_t(chunk.family)];
  const auto side = [&](int block, int32_t facet) {
    if (facet < 0) return visit(block, blocks[size_t(block)].body);
    for (const int32_t node : contacts.facets[size_t(facet)].node) visit(block, std::int64_t(bodies.size()) + node);
  };
  for (uint32_t i = chunk.first; i < chunk.first + chunk.count; ++i) {
    const Point& p = f.point[i];
    side(p.a, p.facet_a), side(p.b, p.facet_b);
    if (p.on_gridpoints) visit(p.a, std::int64_t(bodies.size() + nodes.x.size()) + p.a);
  }
}

void Model::numbers_of(std::int64_t key, std::vector<double*>& numbers) {
  const auto add = [&](double* first, int count) {
    for (int k = 0; k < count; ++k) numbers.push_back(first + k);
  };
  if (size_t(key) >= bodies.size() + nodes.x.size()) {
    for (Vector& row : frames.frame[size_t(key) - bodies.size() - nodes.x.size()].transposed_r.row) add(&row.x, 3);
    return;
  }
  if (size_t(key) >= bodies.size()) return add(&nodes.x[size_t(key) - bodies.size()].x, 3);
  Body& body = bodies[size_t(key)];
  add(&body.x.x, 3);
  for (Vector& row : body.r.row) add(&row.x, 3);
  for (Vector& row : body.transposed_r.row) add(&row.x, 3);
}

void Model::motion_of(int block, std::vector<double*>& numbers) {
  const ModelBlock& b = blocks[size_t(block)];
  const auto add = [&](Vector& v) {
    for (int k = 0; k < 3; ++k) numbers.push_back(&v.x + k);
  };
  if (b.body >= 0) add(bodies[size_t(b.body)].x), add(bodies[size_t(b.body)].v);
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i) add(nodes.x[size_t(i)]), add(nodes.v[size_t(i)]);
}

}  // namespace quoin::blocks
