#include "python/stones.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "python/power_cells.h"

namespace quoin::python {

using geometry::Matrix;
using geometry::Vector;

namespace {

constexpr double kOnePlace = 1e-6;  // m for stones of 1 m; closer corners are merged

// Cells or walls a, b, c along an edge, d and e at its ends. The edge has length 0 when all five meet in a point.
using Edge = std::array<int, 5>;

// Position of a point relative to the plane between cells a and b: 0 on it, > 0 on the side of a.
struct Side {
  double value;
  Vector gradient;
};
Side side_of(const PowerDiagram& d, int a, int b, const Vector& x) {
  const auto of = [&](int i) { return static_cast<std::size_t>(i); };
  if (b < 0) {
    const int axis = (-b - 1) / 2;
    Vector normal;
    normal[axis] = 1.0;
    return {x[axis] - ((-b - 1) % 2 ? d.size[axis] : 0.0), normal};
  }
  const Vector u = x - d.seeds[of(a)], v = x - d.seeds[of(b)];
  return {dot(v, v) - d.weights[of(b)] - dot(u, u) + d.weights[of(a)], 2.0 * (d.seeds[of(a)] - d.seeds[of(b)])};
}

// Signed length of an edge, and its derivatives by seeds and weights.
struct Length {
  double value = 0.0;
  struct Term {
    int seed;
    Vector by_place;
    double by_weight;
  };
  std::vector<Term> terms;
};

// Signed length of an edge, along it from the point x of the planes of b, c and d to the plane of e. With n_e = sum l_i
// n_i the value of e's plane at x is r_e - sum l_i r_i. Its derivative by p_b is that of r_b, -2 (x - p_b), times -l_b,
// and so on. None: the three planes do not meet in a point.
std::optional<Length> length_of(const PowerDiagram& diagram, const Edge& edge) {
  const auto [a, b, c, d, e] = edge;
  Vector x = diagram.seeds[static_cast<std::size_t>(a)];
  const auto solve = [&](const Matrix& m, const Vector& right) { return geometry::inverse(m) * right; };
  const Side sb = side_of(diagram, a, b, x), sc = side_of(diagram, a, c, x), sd = side_of(diagram, a, d, x);
  const Matrix rows{{sb.gradient, sc.gradient, sd.gradient}};
  const double flat = norm(sb.gradient) * norm(sc.gradient) * norm(sd.gradient);
  if (std::abs(geometry::determinant(rows)) < 1e-9 * flat) return std::nullopt;
  x -= solve(rows, {sb.value, sc.value, sd.value});
  const Side se = side_of(diagram, a, e, x);
  const double across = dot(se.gradient, normalized(cross(sb.gradient, sc.gradient)));
  if (std::abs(across) < 1e-6 * norm(se.gradient)) return std::nullopt;
  const Vector share = solve(geometry::transposed(rows), se.gradient);
  Length length;
  length.value = se.value / across;
  const auto add = [&](int cell, double factor) {
    if (cell < 0) return;
    const auto term = [&](int seed, double sign) {
      const Vector arm = x - diagram.seeds[static_cast<std::size_t>(seed)];
      length.terms.push_back({seed, sign * -2.0 * factor / across * arm, sign * -factor / across});
    };
    term(cell, 1.0), term(a, -1.0);
  };
  add(b, -share.x), add(c, -share.y), add(d, -share.z), add(e, 1.0);
  return length;
}

// Edges shorter than `bound` whose ends are different corners, with the cells at their ends; and the shortest of all
// edges.
struct ShortEdges {
  std::vector<Edge> edges;
  long left = 0;  // number of these edges
  double shortest = 1e300;
};
ShortEdges short_edges(const std::vector<Cell>& cells, double bound) {
  ShortEdges found;
  for (int a = 0; a < static_cast<int>(cells.size()); ++a) {
    const Cell& cell = cells[static_cast<std::size_t>(a)];
    std::map<std::pair<int, int>, int> face_along;
    std::vector<std::vector<int>> at(cell.corners.size());  // neighbours
    for (std::size_t f = 0; f < cell.faces.size(); ++f) {
      const auto& face = cell.faces[f];
      for (std::size_t i = 0; i < face.size(); ++i) {
        face_along[{face[i], face[(i + 1) % face.size()]}] = cell.neighbours[f];
        at[static_cast<std::size_t>(face[i])].push_back(cell.neighbours[f]);
      }
    }
    for (const auto& [ends, b] : face_along) {
      const auto [u, v] = ends;
      const auto back = face_along.find({v, u});
      if (u > v || back == face_along.end()) continue;
      const double length = norm(cell.corners[static_cast<std::size_t>(u)] - cell.corners[static_cast<std::size_t>(v)]);
      if (length > kOnePlace) found.shortest = std::min(found.shortest, length);
      if (length >= bound) continue;
      if (length > kOnePlace) ++found.left;
      const auto &of_u = at[static_cast<std::size_t>(u)], &of_v = at[static_cast<std::size_t>(v)];
      const auto only = [](const std::vector<int>& here, const std::vector<int>& there) {
        const auto it = std::find_if(here.begin(), here.end(),
                                     [&](int n) { return std::find(there.begin(), there.end(), n) == there.end(); });
        return it == here.end() ? std::optional<int>() : *it;
      };
      const auto d = only(of_u, of_v), e = only(of_v, of_u);
      if (d && e) found.edges.push_back({a, b, back->second, *d, *e});
    }
  }
  return found;
}

// Least-squares solution of smallest norm of sum of terms = -length for each length, by conjugate gradients (CGLS).
std::vector<double> smallest_motion(const std::vector<Length>& lengths, std::size_t unknowns) {
  constexpr double kDamping = 1e-4;
  constexpr int kIterations = 2000;
  const auto unknown_of = [](const Length::Term& t) { return 4 * static_cast<std::size_t>(t.seed); };
  const auto square = [](const std::vector<double>& v) {
    return std::inner_product(v.begin(), v.end(), v.begin(), 0.0);
  };
  std::vector<double> x(unknowns), s(unknowns), q(lengths.size()), residual(lengths.size());
  const auto gradient = [&] {  // s = A' residual - damping^2 x
    for (std::size_t i = 0; i < unknowns; ++i) s[i] = -kDamping * kDamping * x[i];
    for (std::size_t i = 0; i < lengths.size(); ++i) {
      for (const auto& t : lengths[i].terms) {
        double* p = &s[unknown_of(t)];
        for (int k = 0; k < 3; ++k) p[k] += t.by_place[k] * residual[i];
        p[3] += t.by_weight * residual[i];
      }
    }
  };
  for (std::size_t i = 0; i < lengths.size(); ++i) residual[i] = -lengths[i].value;
  gradient();
  std::vector<double> direction = s;
  const double first = square(s);
  double gamma = first;
  for (int k = 0; k < kIterations && gamma > 1e-24 * first; ++k) {
    for (std::size_t i = 0; i < lengths.size(); ++i) {
      q[i] = 0.0;
      for (const auto& t : lengths[i].terms) {
        const double* p = &direction[unknown_of(t)];
        q[i] += t.by_place.x * p[0] + t.by_place.y * p[1] + t.by_place.z * p[2] + t.by_weight * p[3];
      }
    }
    const double alpha = gamma / (square(q) + kDamping * kDamping * square(direction));
    for (std::size_t i = 0; i < unknowns; ++i) x[i] += alpha * direction[i];
    for (std::size_t i = 0; i < lengths.size(); ++i) residual[i] -= alpha * q[i];
    gradient();
    const double next = square(s);
    for (std::size_t i = 0; i < unknowns; ++i) direction[i] = s[i] + next / gamma * direction[i];
    gamma = next;
  }
  return x;
}

// One step of Newton's method: the smallest change of seeds and weights for which the lengths become 0. Edges without a
// length, or with a large one, are left out. Returns the largest length before the step, m.
double shorten(PowerDiagram& diagram, std::map<Edge, Edge>& edges, double bound) {
  constexpr double kLargestStep = 0.1, kInside = 1e-3;  // m for stones of 1 m
  std::vector<Length> lengths;
  double largest = 0.0;
  for (auto it = edges.begin(); it != edges.end();) {
    const std::optional<Length> length = length_of(diagram, it->second);
    if (!length || std::abs(length->value) > 3 * bound) {
      it = edges.erase(it);
      continue;
    }
    largest = std::max(largest, std::abs(length->value));
    double square = 0.0;  // scales rows to unit length, so that conjugate gradients converge
    for (const auto& t : length->terms) square += dot(t.by_place, t.by_place) + t.by_weight * t.by_weight;
    const double scale = 1.0 / std::sqrt(square);
    lengths.push_back(*length), ++it;
    lengths.back().value *= scale;
    for (auto& t : lengths.back().terms) t.by_place *= scale, t.by_weight *= scale;
  }
  const std::vector<double> x = smallest_motion(lengths, 4 * diagram.seeds.size());
  for (std::size_t i = 0; i < diagram.seeds.size(); ++i) {
    double step = 0.0;
    for (std::size_t k = 4 * i; k < 4 * i + 4; ++k) step = std::max(step, std::abs(x[k]));
    const double part = step > kLargestStep ? kLargestStep / step : 1.0;
    for (int k = 0; k < 3; ++k) {
      double& place = diagram.seeds[i][k];
      place = std::clamp(place + part * x[4 * i + static_cast<std::size_t>(k)], kInside, diagram.size[k] - kInside);
    }
    diagram.weights[i] += part * x[4 * i + 3];
  }
  return largest;
}

// Corners without duplicates.
std::vector<Vector> different(const std::vector<Vector>& corners) {
  std::vector<Vector> kept;
  for (const Vector& p : corners) {
    const bool is_new =
        std::none_of(kept.begin(), kept.end(), [&](const Vector& q) { return norm(p - q) <= kOnePlace; });
    if (is_new) kept.push_back(p);
  }
  return kept;
}

}  // namespace

Stones stones(std::vector<Vector> seeds, const Vector& size, double shortest) {
  constexpr int kRounds = 60, kNewton = 8;
  PowerDiagram diagram{std::move(seeds), {}, size};
  diagram.weights.assign(diagram.seeds.size(), 0.0);
  std::optional<std::vector<Cell>> cells = diagram.cells();
  if (!cells) throw Error(Exit::bad_input, "some seeds have no cell: are two of them at the same place?");
  std::map<Edge, Edge> gone;  // by their cells, sorted
  Stones best;
  long fewest = 0;
  const auto keep = [&](const ShortEdges& found) {
    if (!best.corners.empty() && found.left >= fewest) return;
    fewest = found.left;
    best.shortest_edge = found.shortest;
    best.corners.clear();
    for (const Cell& cell : *cells) best.corners.push_back(different(cell.corners));
  };
  for (int round = 0; round < kRounds; ++round) {
    const ShortEdges found = short_edges(*cells, shortest);
    keep(found);
    if (found.shortest >= shortest) break;
    for (const Edge& edge : found.edges) {
      Edge key = edge;
      std::sort(key.begin(), key.end());
      gone.try_emplace(key, edge);
    }
    for (int k = 0; k < kNewton && shorten(diagram, gone, shortest) > 1e-11; ++k) continue;
    // Edges that do not vanish with the others follow from the current cells.
    std::erase_if(gone, [&](const auto& entry) {
      const std::optional<Length> length = length_of(diagram, entry.second);
      return !length || std::abs(length->value) > 0.1 * shortest;
    });
    cells = diagram.cells();
    if (!cells) break;
  }
  return best;
}

}  // namespace quoin::python
