#include "geometry/zoning.h"

#include <fmt/format.h>

#include <map>
#include <set>

#include "base/error.h"

namespace quoin::geometry {
namespace {

constexpr double most_zones = 1e7;  // largest number of zones of a block

int face_of_triangle(const ConvexPolyhedron& shape, const Vector& a, const Vector& b, const Vector& c, double size) {
  for (size_t f = 0; f < shape.faces.size(); ++f) {
    const Vector &n = shape.normals[f], &o = shape.vertices[shape.faces[f][0]];
    const double worst = std::max({std::abs(dot(n, a - o)), std::abs(dot(n, b - o)), std::abs(dot(n, c - o))});
    if (worst <= 3 * shape_tolerance * size && dot(n, cross(b - a, c - a)) > 0) return int(f);
  }
  return -1;
}

// Triangles of a zone, counter-clockwise seen from outside.
std::array<std::array<int, 3>, 4> triangles_of(const std::array<int, 4>& zone) {
  return {{{zone[0], zone[2], zone[1]},
           {zone[0], zone[1], zone[3]},
           {zone[1], zone[2], zone[3]},
           {zone[2], zone[0], zone[3]}}};
}

std::array<int, 3> in_order(std::array<int, 3> triangle) {
  std::sort(triangle.begin(), triangle.end());
  return triangle;
}

double volume_of(const std::vector<Vector>& nodes, const std::array<int, 4>& t) {
  const Vector& o = nodes[size_t(t[0])];
  return dot(nodes[size_t(t[1])] - o, cross(nodes[size_t(t[2])] - o, nodes[size_t(t[3])] - o)) / 6;
}

// Finds surface triangles: faces of only one zone. stray: message for one that lies inside the shape.
void finish(const ConvexPolyhedron& shape, const std::string& name, Zoning& m,
            const char* stray = "zoning failed: a surface triangle lies on no face") {
  const double size = longest_extent(shape.vertices);
  std::map<std::array<int, 3>, std::array<int, 3>> open;
  double sum = 0.0;
  m.worst_quality = 1.0;
  for (auto& t : m.zones) {
    double volume = volume_of(m.nodes, t);
    if (volume < 0) std::swap(t[2], t[3]), volume = -volume;
    double squares = 0.0;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        const Vector e = m.nodes[t[i]] - m.nodes[t[j]];
        squares += dot(e, e);
        m.longest_edge = std::max(m.longest_edge, norm(e));
      }
    }
    const double quality = 12 * std::cbrt(9 * volume * volume) / squares;
    sum += quality;
    m.worst_quality = std::min(m.worst_quality, quality);
    for (const std::array<int, 3>& f : triangles_of(t)) {
      const std::array<int, 3> key = in_order(f);
      if (!open.emplace(key, f).second) open.erase(key);
    }
  }
  m.mean_quality = sum / double(m.zones.size());
  for (const auto& [key, f] : open) {
    const int face = face_of_triangle(shape, m.nodes[f[0]], m.nodes[f[1]], m.nodes[f[2]], size);
    if (face < 0) {
      throw Error(Exit::bad_input, fmt::format("block {}: near {}: {}", name, place(m.nodes[f[0]]), stray));
    }
    m.surface.push_back({f, face});
  }
}

// Divides every zone into 8: four at the corners, and four of the inner octahedron along its shortest diagonal.
void refine(Zoning& m) {
  std::map<std::pair<int, int>, int> middle;
  auto mid = [&](int a, int b) {
    const auto [it, added] = middle.try_emplace({std::min(a, b), std::max(a, b)}, int(m.nodes.size()));
    if (added) m.nodes.push_back(0.5 * (m.nodes[a] + m.nodes[b]));
    return it->second;
  };
  std::vector<std::array<int, 4>> finer;
  finer.reserve(8 * m.zones.size());
  for (const auto& t : m.zones) {
    const int ab = mid(t[0], t[1]), ac = mid(t[0], t[2]), ad = mid(t[0], t[3]);
    const int bc = mid(t[1], t[2]), bd = mid(t[1], t[3]), cd = mid(t[2], t[3]);
    finer.insert(finer.end(), {{t[0], ab, ac, ad}, {t[1], ab, bc, bd}, {t[2], ac, bc, cd}, {t[3], ad, bd, cd}});
    const int diagonals[3][2] = {{ab, cd}, {ac, bd}, {ad, bc}};
    const int rings[3][4] = {{ac, bc, bd, ad}, {ab, bc, cd, ad}, {ab, bd, cd, ac}};
    int best = 0;
    double length[3];
    for (int k = 0; k < 3; ++k) {
      length[k] = norm(m.nodes[diagonals[k][0]] - m.nodes[diagonals[k][1]]);
      if (length[k] < length[best] * (1 - 1e-9)) best = k;
    }
    for (int k = 0; k < 4; ++k) {
      finer.push_back({diagonals[best][0], diagonals[best][1], rings[best][k], rings[best][(k + 1) % 4]});
    }
  }
  m.zones = std::move(finer);
}

double longest_edge_of(const Zoning& m) {
  double longest = 0.0;
  for (const auto& t : m.zones) {
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) longest = std::max(longest, norm(m.nodes[t[i]] - m.nodes[t[j]]));
    }
  }
  return longest;
}

// Halves edges longer than `bound` (m), the longest first, in all zones around them. Short edges are not divided,
// unlike by refine(), which keeps the time step. The division of a face depends on its own edges alone; of equal edges
// the one with the lower midpoint comes first. So blocks that share a face have the same triangles there.
class Bisection {
 public:
  Bisection(Zoning& m, double bound) : m_(m), bound_(bound) {
    for (int z = 0; z < int(m.zones.size()); ++z) add(z);
  }

  void run() {
    while (!queue_.empty()) {
      const Edge edge = queue_.begin()->second;
      queue_.erase(queue_.begin());
      halve(edge);
    }
  }

 private:
  using Edge = std::pair<int, int>;
  // Length to a millionth, longest first, then the midpoint: x, y, z to a millionth.
  using Rank = std::array<long, 4>;

  Rank rank_of(const Edge& e) const {
    const Vector a = m_.nodes[size_t(e.first)], b = m_.nodes[size_t(e.second)], middle = 0.5 * (a + b);
    const double unit = 1e-6 * bound_;
    return {-std::lround(norm(a - b) / unit), std::lround(middle.x / unit), std::lround(middle.y / unit),
            std::lround(middle.z / unit)};
  }

  void add(int zone) {
    const auto& t = m_.zones[size_t(zone)];
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        const Edge edge{std::min(t[i], t[j]), std::max(t[i], t[j])};
        auto& around = zones_around_[edge];
        around.push_back(zone);
        if (norm(m_.nodes[size_t(edge.first)] - m_.nodes[size_t(edge.second)]) > bound_)
          queue_.insert({rank_of(edge), edge});
      }
    }
  }

  void halve(const Edge& edge) {
    const int middle = int(m_.nodes.size());
    m_.nodes.push_back(0.5 * (m_.nodes[size_t(edge.first)] + m_.nodes[size_t(edge.second)]));
    const std::vector<int> around = std::move(zones_around_[edge]);
    zones_around_.erase(edge);
    for (const int z : around) {
      std::array<int, 4> with_second = m_.zones[size_t(z)];
      for (auto& [other, zones] : edges_of(z)) {
        if (other != edge) std::erase(*zones, z);
      }
      std::replace(with_second.begin(), with_second.end(), edge.first, middle);
      std::replace(m_.zones[size_t(z)].begin(), m_.zones[size_t(z)].end(), edge.second, middle);
      m_.zones.push_back(with_second);
      add(z);
      add(int(m_.zones.size()) - 1);
    }
  }

  std::vector<std::pair<Edge, std::vector<int>*>> edges_of(int zone) {
    const auto& t = m_.zones[size_t(zone)];
    std::vector<std::pair<Edge, std::vector<int>*>> edges;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        const Edge edge{std::min(t[i], t[j]), std::max(t[i], t[j])};
        const auto found = zones_around_.find(edge);
        if (found != zones_around_.end()) edges.push_back({edge, &found->second});
      }
    }
    return edges;
  }

  Zoning& m_;
  double bound_;
  std::map<Edge, std::vector<int>> zones_around_;
  std::set<std::pair<Rank, Edge>> queue_;
};

}  // namespace

ZoneSize size_of_zone(const Zoning& zoning, const std::array<int, 4>& zone) {
  double largest = 0.0, shortest = 1e300;  // twice the area of a side, an edge
  for (const auto& [a, b, c] : triangles_of(zone)) {
    const Vector u = zoning.nodes[size_t(b)] - zoning.nodes[size_t(a)],
                 v = zoning.nodes[size_t(c)] - zoning.nodes[size_t(a)];
    largest = std::max(largest, norm(cross(u, v)));
    shortest = std::min({shortest, norm(u), norm(v), norm(u - v)});
  }
  return {6 * std::abs(volume_of(zoning.nodes, zone)) / largest, shortest};
}

std::optional<std::array<int, 8>> brick_corners(const ConvexPolyhedron& shape) {
  if (shape.vertices.size() != 8 || shape.faces.size() != 6 || shape.edges.size() != 12) return std::nullopt;
  for (const auto& f : shape.faces) {
    if (f.size() != 4) return std::nullopt;
  }
  std::array<std::vector<int>, 8> neighbours;
  for (const auto& e : shape.edges) neighbours[e.tail].push_back(e.head), neighbours[e.head].push_back(e.tail);
  for (const auto& nb : neighbours) {
    if (nb.size() != 3) return std::nullopt;
  }
  auto common = [&](int a, int b, int other) {
    for (int i : neighbours[a]) {
      for (int j : neighbours[b]) {
        if (i == j && i != other) return i;
      }
    }
    return -1;
  };
  std::array<int, 8> c{};
  c[0] = 0;
  c[1] = neighbours[0][0], c[2] = neighbours[0][1], c[4] = neighbours[0][2];
  const Vector &o = shape.vertices[c[0]], u = shape.vertices[c[1]] - o, v = shape.vertices[c[2]] - o,
               w = shape.vertices[c[4]] - o;
  if (dot(u, cross(v, w)) < 0) std::swap(c[1], c[2]);
  c[3] = common(c[1], c[2], c[0]), c[5] = common(c[1], c[4], c[0]), c[6] = common(c[2], c[4], c[0]);
  if (c[3] < 0 || c[5] < 0 || c[6] < 0) return std::nullopt;
  c[7] = common(c[3], c[5], c[1]);
  if (c[7] < 0) return std::nullopt;
  return c;
}

double hexahedra_along(double length, double target_edge) {
  return std::max(1.0, std::ceil(length / target_edge - 1e-6));
}

std::array<int, 3> brick_divisions(const ConvexPolyhedron& shape, double target_edge) {
  const std::array<int, 8> c = *brick_corners(shape);
  std::array<int, 3> n{1, 1, 1};
  for (int axis = 0; axis < 3; ++axis) {
    double longest = 0.0;
    for (int b = 0; b < 8; ++b) {
      if (b >> axis & 1) continue;
      longest = std::max(longest, norm(shape.vertices[c[b]] - shape.vertices[c[b | 1 << axis]]));
    }
    n[axis] = int(std::min(hexahedra_along(longest, target_edge), most_zones));
  }
  return n;
}

Zoning make_brick_zones(const ConvexPolyhedron& shape, std::array<int, 3> n, int parity, const std::string& name) {
  const auto corners = brick_corners(shape);
  if (!corners || n[0] < 1 || n[1] < 1 || n[2] < 1) {
    throw Error(Exit::bad_input,
                fmt::format("block {}: divisions need a six-sided block of brick topology and positive counts", name));
  }
  const double count = 5.0 * n[0] * n[1] * n[2];
  if (count > most_zones) {
    throw Error(Exit::bad_input, fmt::format("block {}: {} x {} x {} hexahedra are {:.1e} zones, more than {:g}; take "
                                             "fewer divisions or a larger zone edge",
                                             name, n[0], n[1], n[2], count, most_zones));
  }
  Zoning m;
  m.nodes = shape.vertices;
  const int nx = n[0] + 1, ny = n[1] + 1, nz = n[2] + 1;
  std::vector<int> id(size_t(nx) * ny * nz);
  auto at = [&](int i, int j, int k) -> int& { return id[(size_t(k) * ny + j) * nx + i]; };
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        const bool end[3] = {i == 0 || i == n[0], j == 0 || j == n[1], k == 0 || k == n[2]};
        if (end[0] && end[1] && end[2]) {
          at(i, j, k) = (*corners)[(i > 0 ? 1 : 0) + (j > 0 ? 2 : 0) + (k > 0 ? 4 : 0)];
          continue;
        }
        const double x = double(i) / n[0], y = double(j) / n[1], z = double(k) / n[2];
        Vector p;
        for (int c = 0; c < 8; ++c) {
          p += (c & 1 ? x : 1 - x) * (c & 2 ? y : 1 - y) * (c & 4 ? z : 1 - z) * shape.vertices[(*corners)[c]];
        }
        at(i, j, k) = int(m.nodes.size());
        m.nodes.push_back(p);
      }
    }
  }
  for (int k = 0; k < n[2]; ++k) {
    for (int j = 0; j < n[1]; ++j) {
      for (int i = 0; i < n[0]; ++i) {
        int c[8];
        for (int b = 0; b < 8; ++b) c[b] = at(i + (b & 1), j + (b >> 1 & 1), k + (b >> 2));
        if ((i + j + k + parity) % 2 == 0) {  // four corners and one inner tetrahedron
          m.zones.insert(m.zones.end(), {{c[0], c[1], c[2], c[4]},
                                         {c[3], c[2], c[1], c[7]},
                                         {c[5], c[4], c[7], c[1]},
                                         {c[6], c[7], c[4], c[2]},
                                         {c[1], c[2], c[4], c[7]}});
        } else {
          m.zones.insert(m.zones.end(), {{c[1], c[0], c[3], c[5]},
                                         {c[2], c[3], c[0], c[6]},
                                         {c[4], c[5], c[6], c[0]},
                                         {c[7], c[6], c[5], c[3]},
                                         {c[0], c[3], c[5], c[6]}});
        }
      }
    }
  }
  finish(shape, name, m);
  return m;
}

Zoning make_zones(const ConvexPolyhedron& shape, double target_edge, const std::string& name) {
  if (!(target_edge > 0))
    throw Error(Exit::bad_input, fmt::format("block {}: zone edge {} m must be > 0", name, target_edge));
  const double estimate = 10 * mass_properties(shape).volume / (target_edge * target_edge * target_edge);
  if (!(estimate <= most_zones)) {
    throw Error(Exit::bad_input,
                fmt::format("block {}: zone edge {:.3g} m gives about {:.1e} zones, more than {:g}; take a larger "
                            "edge",
                            name, target_edge, estimate, most_zones));
  }
  if (brick_corners(shape)) return make_brick_zones(shape, brick_divisions(shape, target_edge), 0, name);
  Zoning m;
  m.nodes = shape.vertices;
  const int centre = int(m.nodes.size());
  m.nodes.push_back(mass_properties(shape).centroid);
  for (size_t f = 0; f < shape.faces.size(); ++f) {
    const auto& face = shape.faces[f];
    if (face.size() == 3) {
      m.zones.push_back({centre, face[0], face[1], face[2]});
      continue;
    }
    const int middle = int(m.nodes.size());
    m.nodes.push_back(face_centroid(shape, int(f)));
    for (size_t i = 0; i < face.size(); ++i) m.zones.push_back({centre, middle, face[i], face[(i + 1) % face.size()]});
  }
  const double bound = 1.5 * target_edge;
  while (longest_edge_of(m) > 8 * bound) refine(m);  // halving fine zones one by one is slow
  Bisection(m, bound).run();
  finish(shape, name, m);
  return m;
}

namespace {

[[noreturn]] void refuse_tetrahedra(const std::string& name, const std::string& what) {
  throw Error(Exit::bad_input, fmt::format("block {}: {}", name, what));
}

// A triangle in the orientation of its first tetrahedron, and its two tetrahedra; second -1: it has only one.
struct Owners {
  std::array<int, 3> triangle;
  int first, second = -1;
};
using Triangles = std::map<std::array<int, 3>, Owners>;

// Checks a tetrahedron and returns its volume. number: that of the tetrahedron, for messages.
double sound_volume(const std::vector<Vector>& points, const std::array<int, 4>& t, int number,
                    const std::string& name) {
  constexpr double kFlat = 1e-6;  // least volume over the cube of the longest edge
  const int count = int(points.size());
  double longest = 0.0;
  for (size_t i = 0; i < t.size(); ++i) {
    if (t[i] < 0 || t[i] >= count)
      refuse_tetrahedra(
          name, fmt::format("tetrahedron {} names vertex {}; there are vertices 0 to {}", number, t[i], count - 1));
    for (size_t j = 0; j < i; ++j) longest = std::max(longest, norm(points[size_t(t[i])] - points[size_t(t[j])]));
  }
  const double volume = volume_of(points, t);
  if (!(std::abs(volume) > kFlat * longest * longest * longest))
    refuse_tetrahedra(
        name, fmt::format("tetrahedron {} near {} is flat: {:.3g} m3 with an edge of {:.3g} m; mesh the body anew",
                          number, place(points[size_t(t[0])]), volume, longest));
  if (volume < 0)
    refuse_tetrahedra(name, fmt::format("tetrahedron {} near {} is inverted ({:.3g} m3): swap two of its corners",
                                        number, place(points[size_t(t[0])]), volume));
  return volume;
}

void add_triangle(const std::array<int, 3>& f, int tetrahedron, const std::vector<Vector>& points,
                  const std::string& name, Triangles* triangles) {
  const auto [it, is_new] = triangles->try_emplace(in_order(f), Owners{f, tetrahedron});
  if (is_new) return;
  Owners& o = it->second;
  if (o.second >= 0)
    refuse_tetrahedra(
        name, fmt::format("tetrahedra {}, {} and {} share the triangle near {}; a triangle has two at most", o.first,
                          o.second, tetrahedron, place(points[size_t(f[0])])));
  o.second = tetrahedron;
  size_t turn = 0;
  while (o.triangle[turn] != f[0]) ++turn;
  if (o.triangle[(turn + 1) % 3] == f[1])
    refuse_tetrahedra(
        name, fmt::format("tetrahedra {} and {} overlap: both lie on the same side of the triangle near {}", o.first,
                          tetrahedron, place(points[size_t(f[0])])));
}

// Corners of triangles that belong to only one tetrahedron.
std::vector<Vector> skin_of(const std::vector<Vector>& points, const Triangles& triangles) {
  std::vector<bool> outside(points.size(), false);
  for (const auto& [key, o] : triangles) {
    if (o.second < 0) outside[size_t(key[0])] = outside[size_t(key[1])] = outside[size_t(key[2])] = true;
  }
  std::vector<Vector> skin;
  for (size_t i = 0; i < points.size(); ++i) {
    if (outside[i]) skin.push_back(points[i]);
  }
  return skin;
}

// Zoning with the corners of the shape first, as in all zonings.
Zoning numbered(const ConvexPolyhedron& shape, const std::vector<Vector>& points,
                const std::vector<std::array<int, 4>>& tetrahedra) {
  std::map<std::array<double, 3>, int> number;
  for (int i = 0; i < int(points.size()); ++i) number.try_emplace(array(points[size_t(i)]), i);
  std::vector<int> place_of(points.size(), -1);
  Zoning z;
  for (const Vector& corner : shape.vertices) {
    place_of[size_t(number.at(array(corner)))] = int(z.nodes.size());
    z.nodes.push_back(corner);
  }
  for (size_t i = 0; i < points.size(); ++i) {
    if (place_of[i] >= 0) continue;
    place_of[i] = int(z.nodes.size());
    z.nodes.push_back(points[i]);
  }
  for (const std::array<int, 4>& t : tetrahedra) {
    std::array<int, 4>& zone = z.zones.emplace_back();
    for (size_t i = 0; i < t.size(); ++i) zone[i] = place_of[size_t(t[i])];
  }
  return z;
}

}  // namespace

ZonedShape from_tetrahedra(const std::vector<Vector>& points, const std::vector<std::array<int, 4>>& tetrahedra,
                           const std::string& name) {
  if (tetrahedra.empty() || double(tetrahedra.size()) > most_zones)
    refuse_tetrahedra(name, fmt::format("{} tetrahedra; allowed: 1 to {:g}", tetrahedra.size(), most_zones));
  for (size_t i = 0; i < points.size(); ++i) {
    const Vector& p = points[i];
    if (!std::isfinite(p.x + p.y + p.z)) refuse_tetrahedra(name, fmt::format("vertex {} is not a number", i));
  }
  Triangles triangles;
  std::vector<bool> used(points.size(), false);
  double volume = 0.0;
  for (int k = 0; k < int(tetrahedra.size()); ++k) {
    const std::array<int, 4>& t = tetrahedra[size_t(k)];
    volume += sound_volume(points, t, k, name);
    for (const int corner : t) used[size_t(corner)] = true;
    for (const std::array<int, 3>& f : triangles_of(t)) add_triangle(f, k, points, name, &triangles);
  }
  const auto idle = std::find(used.begin(), used.end(), false);
  if (idle != used.end()) {
    const auto i = idle - used.begin();
    refuse_tetrahedra(
        name, fmt::format("vertex {} at {} belongs to no tetrahedron; leave it out", i, place(points[size_t(i)])));
  }
  ZonedShape made{from_vertices(skin_of(points, triangles), name), {}};
  made.zoning = numbered(made.shape, points, tetrahedra);
  finish(
      made.shape, name, made.zoning,
      "a triangle that one tetrahedron has alone lies inside the hull of the body: neighbours share no whole triangle "
      "there (vertices that are there twice, hanging vertices, a hole), or the body is not convex; mesh it "
      "conformingly, "
      "or cut it into convex parts");
  const double hull = mass_properties(made.shape).volume;
  if (std::abs(volume - hull) > 10 * shape_tolerance * hull)
    refuse_tetrahedra(
        name,
        fmt::format("its tetrahedra have {:.9g} m3 in all, and the body that they bound {:.9g} m3: they overlap or "
                    "leave holes",
                    volume, hull));
  return made;
}

}  // namespace quoin::geometry
