// Positions of floors: their nodes, and the blocks at their edges.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "members/floor.h"
#include "scene/generate_blocks.h"
#include "scene/load_place.h"

namespace quoin::members {

namespace {

Floor::Grid grid_of(const FloorSpec& spec) {
  const Vector along = geometry::vector(spec.along), across = geometry::vector(spec.across);
  Floor::Grid grid{
      geometry::vector(spec.corner), normalized(along), normalized(across), {norm(along), norm(across)}, {}};
  for (std::size_t c = 0; c < 2; ++c)
    grid.pieces[c] = std::max(1, static_cast<int>(std::ceil(grid.size[c] / spec.spacing - 1e-9)));
  return grid;
}

// Distributes the weight of a line of nodes to its first and last held nodes, by the lever rule. Returns whether a node
// is held. line: nodes; at: their positions along it, m; held: by node, its connectors of these edges.
bool carry(const Floor& floor, const std::vector<int>& line, const std::vector<double>& at, double share,
           const std::vector<std::vector<std::size_t>>& held, std::vector<double>& carried) {
  std::size_t first = 0, last = line.size() - 1;
  const auto is_held = [&](std::size_t k) { return !held[static_cast<std::size_t>(line[k])].empty(); };
  while (first < last && !is_held(first)) ++first;
  while (last > first && !is_held(last)) --last;
  if (!is_held(first)) return false;
  const auto give = [&](std::size_t k, double area) {
    const std::vector<std::size_t>& to = held[static_cast<std::size_t>(line[k])];
    for (const std::size_t c : to) carried[c] += area / static_cast<double>(to.size());
  };
  for (std::size_t k = 0; k < line.size(); ++k) {
    const double area = share * floor.share_of(line[k]);
    const double lever = first == last ? 0.0 : (at[k] - at[first]) / (at[last] - at[first]);
    give(first, (1.0 - lever) * area), give(last, lever * area);
  }
  return true;
}

// Piece of a floor's edge for which a connector stands: its node, and its ends, m.
struct Piece {
  Vector node, from, to;
};

// Of the blocks that hold the node, or most of the piece, the one nearest to the middle of the piece; -1: none. Of
// those equally near, as where two walls or courses meet at the node: the one nearest to both ends, then the lowest. So
// the order of blocks is without effect.
int wall_at(const Piece& piece, const Floor::Grid& grid, const Placing& placing) {
  const blocks::Assembly& assembly = placing.assembly;
  constexpr double kSame = 1e-9;  // m
  const Vector normal = cross(grid.along, grid.across), middle = 0.5 * (piece.from + piece.to);
  const bool points_up = std::max({normal.x, normal.y, normal.z}) > -std::min({normal.x, normal.y, normal.z});
  const Vector up = points_up ? normal : -normal;
  int wall = -1;
  std::array<double, 5> best{};
  for (int block = 0; block < static_cast<int>(assembly.blocks.size()); ++block) {
    const auto off = [&](const Vector& at) {
      return distance_from(assembly, assembly.blocks[static_cast<std::size_t>(block)], at);
    };
    const auto holds = [&](const Vector& at) { return off(at) <= placing.allowed_off(block); };
    if (!holds(piece.node) && !(holds(middle) && holds(piece.to))) continue;
    const Vector centre = blocks::centre_of(assembly, block);
    const std::array ranks{off(middle), off(piece.from) + off(piece.to), dot(up, centre), dot(grid.along, centre),
                           dot(grid.across, centre)};
    const auto [here, there] =
        std::ranges::mismatch(ranks, best, [](double a, double b) { return std::abs(a - b) <= kSame; });
    if (wall < 0 || (here != ranks.end() && *here < *there)) wall = block, best = ranks;
  }
  return wall;
}

void connect(Floor& floor, Placing& placing) {
  const int n = floor.grid().pieces[0], m = floor.grid().pieces[1];
  const double a = floor.grid().size[0] / n, b = floor.grid().size[1] / m;
  const auto start_at = [&](int i, int j) { return floor.start_of(floor.place_at(i, j)); };
  const auto block_of = [&](const Vector& at) {
    double off = 0.0;
    return placing.block_at(at, &off);
  };
  // A corner belongs to an edge that runs along a wall there, not to one that ends at a wall. The end piece of such an
  // edge, which may be its only one, has its middle and its other end in the wall.
  const auto add = [&](int i, int j, bool along, const InPlane& out) {
    const int k = along ? i : j, last = along ? n : m;
    const bool corner = k == 0 || k == last;
    const int inner = k == 0 ? 1 : last - 1;
    const Vector at = start_at(i, j), next = start_at(along ? inner : i, along ? j : inner), half = 0.5 * (next - at);
    if (block_of(at) < 0 || (corner && (block_of(next) < 0 || block_of(at + half) < 0))) return;
    const int wall = wall_at({at, corner ? at : at - half, at + half}, floor.grid(), placing);
    Floor::Connector connector;
    connector.place = floor.place_at(i, j), connector.node = placing.add(wall, at);
    connector.out = out, connector.length = (along ? a : b) * (corner ? 0.5 : 1.0);
    floor.connectors().push_back(connector);
  };
  for (int i = 0; i <= n; ++i) add(i, 0, true, {0, -1}), add(i, m, true, {0, 1});
  for (int j = 0; j <= m; ++j) add(0, j, false, {-1, 0}), add(n, j, false, {1, 0});
}

// Distributes the floor's weight to the edges on which its joists end.
void carry_weight(const FloorSpec& spec, Floor& floor) {
  const int n = floor.grid().pieces[0], m = floor.grid().pieces[1];
  std::vector<double> carried(floor.connectors().size());
  const double share = spec.span == "both" ? 0.5 : 1.0;
  for (const bool across : {false, true}) {
    if (spec.span == (across ? "along" : "across")) continue;
    std::vector<std::vector<std::size_t>> held(static_cast<std::size_t>((n + 1) * (m + 1)));
    for (std::size_t c = 0; c < floor.connectors().size(); ++c) {
      const Floor::Connector& connector = floor.connectors()[c];
      if ((connector.out.across != 0.0) == across) held[static_cast<std::size_t>(connector.place)].push_back(c);
    }
    for (int i = 0; i <= (across ? n : m); ++i) {
      std::vector<int> line;
      std::vector<double> at;
      for (int j = 0; j <= (across ? m : n); ++j) {
        line.push_back(across ? floor.place_at(i, j) : floor.place_at(j, i));
        at.push_back(floor.grid().size[across ? 1 : 0] * j / (across ? m : n));
      }
      if (!carry(floor, line, at, share, held, carried))
        throw Error(Exit::bad_input,
                    fmt::format("{}: floor '{}' has no wall for the weight of its line from {} to {}; put one of these "
                                "into a block, or change span (\"{}\")",
                                spec.source.text, spec.name, geometry::place(floor.start_of(line.front())),
                                geometry::place(floor.start_of(line.back())), spec.span));
    }
  }
  for (std::size_t c = 0; c < carried.size(); ++c) floor.connectors()[c].carried = carried[c];
}

}  // namespace

Floor placed(const FloorSpec& spec, Placing& placing) {
  Membrane membrane;
  membrane.along = spec.stiffness_along, membrane.across = spec.stiffness_across;
  membrane.shear = spec.shear_stiffness, membrane.shear_yield = spec.shear_yield;
  membrane.mass = spec.mass, membrane.load = spec.load;
  const ConnectorLaw law{spec.axial_stiffness, spec.connector_stiffness,
                         spec.axial_strength,  spec.connector_strength,
                         spec.friction,        spec.pull_out,
                         spec.bearing};
  Floor floor(spec.name, grid_of(spec), membrane, law);
  connect(floor, placing);
  if (floor.connectors().empty()) {
    std::string places;
    const int n = floor.grid().pieces[0], m = floor.grid().pieces[1];
    for (const auto& [i, j] : {std::pair{0, 0}, std::pair{n, 0}, std::pair{n, m}, std::pair{0, m}}) {
      const Vector corner = floor.start_of(floor.place_at(i, j));
      double off = 0.0;
      placing.block_at(corner, &off);
      places += fmt::format("{}{} ({:.3g} m off the nearest block)", places.empty() ? "" : ", ",
                            geometry::place(corner), off);
    }
    throw Error(Exit::bad_input,
                fmt::format("{}: floor '{}' meets no wall: none of the nodes of its edges lies in or on "
                            "a block; corners: {}. Move its edges into walls, or take a smaller spacing",
                            spec.source.text, spec.name, places));
  }
  carry_weight(spec, floor);
  return floor;
}

std::vector<std::string> column_names(const FloorSpec& spec) {
  return {fmt::format("floor_{}_shear_N_per_m", spec.name), fmt::format("floor_{}_anchor_N_per_m", spec.name),
          fmt::format("floor_{}_pulled_out_m", spec.name)};
}

}  // namespace quoin::members
