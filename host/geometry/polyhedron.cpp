#include "geometry/polyhedron.h"

#include <fmt/format.h>

#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "base/error.h"

namespace quoin::geometry {
namespace {

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw Error(Exit::bad_input, fmt::format("block {}: {}", name, what));
}

struct Triangle {
  int corner[3];
  Vector normal;
  double offset;
  bool alive = true;
};

// Twice the vector area of a polygon (Newell), robust for slightly warped faces.
Vector newell(const std::vector<Vector>& vertices, const std::vector<int>& face) {
  Vector sum;
  const Vector& o = vertices[face[0]];
  for (size_t i = 1; i + 1 < face.size(); ++i) sum += cross(vertices[face[i]] - o, vertices[face[i + 1]] - o);
  return sum;
}

// Incremental hull. Blocks have few vertices, so the simple quadratic method suffices.
std::vector<Triangle> triangle_hull(const std::vector<Vector>& p, double tolerance, const std::string& name) {
  const int n = int(p.size());
  // Four corners of a large simplex, found greedily.
  int a = 0, b = 0, c = 0, d = 0;
  for (int i = 0; i < n; ++i) {
    if (p[i].x < p[a].x) a = i;
  }
  for (int i = 0; i < n; ++i) {
    if (norm(p[i] - p[a]) > norm(p[b] - p[a])) b = i;
  }
  if (norm(p[b] - p[a]) <= 0) refuse(name, "all vertices coincide");
  const Vector along = normalized(p[b] - p[a]);
  auto off_line = [&](int i) { return norm(cross(p[i] - p[a], along)); };
  for (int i = 0; i < n; ++i) {
    if (off_line(i) > off_line(c)) c = i;
  }
  if (off_line(c) <= tolerance) refuse(name, fmt::format("its vertices lie on one line, near {}", place(p[a])));
  const Vector up = normalized(cross(p[b] - p[a], p[c] - p[a]));
  for (int i = 0; i < n; ++i) {
    if (std::abs(dot(p[i] - p[a], up)) > std::abs(dot(p[d] - p[a], up))) d = i;
  }
  if (std::abs(dot(p[d] - p[a], up)) <= tolerance) {
    refuse(name, fmt::format("its vertices lie in one plane (zero volume), near {}", place(p[a])));
  }
  if (dot(p[d] - p[a], up) > 0) std::swap(b, c);

  std::vector<Triangle> hull;
  auto add = [&](int i, int j, int k) {
    const Vector m = cross(p[j] - p[i], p[k] - p[i]);
    const double length = norm(m);
    const Vector normal = length > 0 ? m / length : Vector{};
    hull.push_back({{i, j, k}, normal, dot(normal, p[i])});
  };
  add(a, b, c), add(a, d, b), add(b, d, c), add(c, d, a);
  // Above the rounding of coordinates far from the origin, which narrow triangles magnify.
  const double visible_above =
      std::min(tolerance, std::max(1e-3 * tolerance, 1e4 * std::numeric_limits<double>::epsilon() * norm(p[a])));
  for (int i = 0; i < n; ++i) {
    if (i == a || i == b || i == c || i == d) continue;
    std::set<std::pair<int, int>> border;
    bool outside = false;
    for (const Triangle& t : hull) outside |= t.alive && dot(t.normal, p[i]) - t.offset > tolerance;
    if (!outside) continue;
    for (Triangle& t : hull) {
      if (!t.alive || dot(t.normal, p[i]) - t.offset <= visible_above) continue;
      t.alive = false;
      for (int k = 0; k < 3; ++k) {
        const int u = t.corner[k], v = t.corner[(k + 1) % 3];
        if (border.erase({v, u}) == 0) border.insert({u, v});
      }
    }
    for (const auto& [u, v] : border) add(u, v, i);
    std::erase_if(hull, [](const Triangle& t) { return !t.alive; });
  }
  return hull;
}

}  // namespace

std::string place(const Vector& p) { return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", p.x, p.y, p.z); }

double longest_extent(const std::vector<Vector>& points) {
  Box b;
  for (const Vector& p : points) b.include(p);
  const Vector e = b.upper - b.lower;
  return points.empty() ? 0.0 : std::max({e.x, e.y, e.z});
}

double least_extent(const ConvexPolyhedron& shape) {
  double least = 1e300;
  for (size_t f = 0; f < shape.faces.size(); ++f) {
    double deepest = 0.0;
    for (const Vector& p : shape.vertices)
      deepest = std::max(deepest, dot(shape.normals[f], shape.vertices[shape.faces[f][0]] - p));
    least = std::min(least, deepest);
  }
  return least;
}

void update_normals(ConvexPolyhedron& shape) {
  shape.normals.resize(shape.faces.size());
  for (size_t f = 0; f < shape.faces.size(); ++f) shape.normals[f] = normalized(newell(shape.vertices, shape.faces[f]));
}

void complete(ConvexPolyhedron& shape) {
  update_normals(shape);
  shape.edges.clear();
  std::map<std::pair<int, int>, int> owner;
  for (size_t f = 0; f < shape.faces.size(); ++f) {
    const auto& face = shape.faces[f];
    for (size_t i = 0; i < face.size(); ++i) owner[{face[i], face[(i + 1) % face.size()]}] = int(f);
  }
  for (const auto& [ends, f] : owner) {
    const auto back = owner.find({ends.second, ends.first});
    if (ends.first < ends.second && back != owner.end()) {
      shape.edges.push_back({ends.first, ends.second, f, back->second});
    }
  }
}

namespace {

// Distinct points, as mesh files repeat corners.
std::vector<Vector> different(const std::vector<Vector>& input, double tolerance) {
  std::vector<Vector> points;
  for (const Vector& p : input) {
    bool is_new = true;
    for (const Vector& q : points) is_new &= norm(p - q) > tolerance;
    if (is_new) points.push_back(p);
  }
  return points;
}

// Corners of a face, counter-clockwise about its normal, without points inside it and on straight sides.
std::vector<int> corners_in_order(const std::vector<Vector>& points, const std::set<int>& corners, const Vector& normal,
                                  double tolerance) {
  Vector centre;
  for (int c : corners) centre += points[c] / double(corners.size());
  const Vector s = any_normal(normal), r = cross(normal, s);
  std::vector<int> face(corners.begin(), corners.end());
  std::vector<double> angle(points.size(), 0.0);
  for (int c : face) angle[c] = std::atan2(dot(points[c] - centre, r), dot(points[c] - centre, s));
  std::sort(face.begin(), face.end(), [&](int i, int j) { return angle[i] < angle[j]; });
  for (bool again = true; again && face.size() > 3;) {
    again = false;
    for (size_t i = 0; i < face.size(); ++i) {
      const Vector& before = points[face[(i + face.size() - 1) % face.size()]];
      const Vector& here = points[face[i]];
      const Vector& after = points[face[(i + 1) % face.size()]];
      if (dot(normal, cross(here - before, after - before)) <= 2 * tolerance * norm(after - before)) {
        face.erase(face.begin() + long(i));
        again = true;
        break;
      }
    }
  }
  return face;
}

// Faces of the hull, with coplanar neighbours merged.
std::vector<std::vector<int>> faces_of(const std::vector<Triangle>& hull, const std::vector<Vector>& points,
                                       double size, double tolerance) {
  std::vector<double> area(hull.size());
  for (size_t i = 0; i < hull.size(); ++i) {
    const int* c = hull[i].corner;
    area[i] = norm(cross(points[c[1]] - points[c[0]], points[c[2]] - points[c[0]]));
  }
  std::vector<size_t> by_area(hull.size());
  std::iota(by_area.begin(), by_area.end(), 0u);
  std::stable_sort(by_area.begin(), by_area.end(), [&](size_t i, size_t j) { return area[i] > area[j]; });
  std::vector<bool> used(hull.size(), false);
  std::vector<std::vector<int>> faces;
  for (size_t first : by_area) {  // large triangles set the planes of faces; slivers join the plane that they lie in
    if (used[first]) continue;
    const Triangle& t = hull[first];
    std::set<int> corners;
    for (size_t other = 0; other < hull.size(); ++other) {
      if (used[other]) continue;
      bool coplanar = dot(hull[other].normal, t.normal) > 0.5 || area[other] < tolerance * size;
      for (int c : hull[other].corner) coplanar &= std::abs(dot(t.normal, points[c]) - t.offset) <= 2 * tolerance;
      if (!coplanar) continue;
      used[other] = true;
      corners.insert(hull[other].corner, hull[other].corner + 3);
    }
    // Drops slivers between faces, but not faces that are only small.
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, norm(points[t.corner[k]] - points[t.corner[(k + 1) % 3]]));
    if (area[first] >= tolerance * longest) faces.push_back(corners_in_order(points, corners, t.normal, tolerance));
  }
  return faces;
}

}  // namespace

ConvexPolyhedron from_vertices(const std::vector<Vector>& input, const std::string& name, double relative_tolerance) {
  if (input.size() < 4) refuse(name, fmt::format("has {} vertices; a polyhedron needs at least 4", input.size()));
  for (size_t i = 0; i < input.size(); ++i) {
    if (!std::isfinite(input[i].x + input[i].y + input[i].z)) refuse(name, fmt::format("vertex {} is not a number", i));
  }
  const double size = longest_extent(input), tolerance = relative_tolerance * size;
  const std::vector<Vector> points = different(input, tolerance);
  if (points.size() < 4) refuse(name, fmt::format("has only {} different vertices", points.size()));
  ConvexPolyhedron shape;
  shape.faces = faces_of(triangle_hull(points, tolerance, name), points, size, tolerance);
  std::vector<int> renumber(points.size(), -1);
  for (auto& face : shape.faces) {
    for (int& c : face) {
      if (renumber[c] < 0) {
        renumber[c] = int(shape.vertices.size());
        shape.vertices.push_back(points[c]);
      }
      c = renumber[c];
    }
  }
  complete(shape);
  // Euler's formula detects errors of tolerances: nearly flat corners, points closer than the tolerance.
  if (shape.vertices.size() + shape.faces.size() != shape.edges.size() + 2 || mass_properties(shape).volume <= 0) {
    refuse(name,
           fmt::format("degenerate shape near {}: {} corners, {} faces and {} edges do not close (are corners closer "
                       "than {:.1e} m, or faces almost coplanar?)",
                       place(shape.vertices.empty() ? points[0] : shape.vertices[0]), shape.vertices.size(),
                       shape.faces.size(), shape.edges.size(), tolerance));
  }
  return shape;
}

void check_closed(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces,
                  const std::string& name) {
  const double size = longest_extent(vertices), tolerance = shape_tolerance * size;
  const int n = int(vertices.size());
  if (faces.size() < 4) refuse(name, fmt::format("has {} faces; a polyhedron needs at least 4", faces.size()));
  for (int i = 0; i < n; ++i) {
    if (!std::isfinite(vertices[i].x + vertices[i].y + vertices[i].z))
      refuse(name, fmt::format("vertex {} is not a number", i));
  }
  std::map<std::pair<int, int>, int> owner;
  for (size_t f = 0; f < faces.size(); ++f) {
    if (faces[f].size() < 3)
      refuse(name, fmt::format("face {} has {} corners; it needs at least 3", f, faces[f].size()));
    for (size_t i = 0; i < faces[f].size(); ++i) {
      const int u = faces[f][i], v = faces[f][(i + 1) % faces[f].size()];
      if (u < 0 || u >= n)
        refuse(name, fmt::format("face {} names vertex {}; there are vertices 0 to {}", f, u, n - 1));
      if (v >= 0 && v < n && !owner.emplace(std::pair{u, v}, int(f)).second) {
        refuse(name, fmt::format(
                         "faces {} and {} both run along the edge from {} to {} in the same direction: one of them is "
                         "inverted (corners must run counter-clockwise seen from outside)",
                         owner[{u, v}], f, place(vertices[u]), place(vertices[v])));
      }
    }
  }
  for (const auto& [ends, f] : owner) {
    if (!owner.contains({ends.second, ends.first})) {
      refuse(name, fmt::format("the surface is open: the edge from {} to {} of face {} has no neighbour",
                               place(vertices[ends.first]), place(vertices[ends.second]), f));
    }
  }
  const double volume = volume_within(vertices, faces);
  if (std::abs(volume) <= tolerance * size * size) {
    refuse(name, fmt::format("has zero volume ({:.3g} m3 within a box of side {:.3g} m)", volume, size));
  }
  if (volume < 0) {
    refuse(name,
           fmt::format("is inverted (volume {:.3g} m3): the corners of every face must run counter-clockwise seen from "
                       "outside",
                       volume));
  }
}

double volume_within(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces) {
  double volume = 0.0;
  const Vector& o = vertices[faces[0][0]];
  for (const auto& face : faces) {
    for (size_t i = 1; i + 1 < face.size(); ++i) {
      const Vector &a = vertices[face[0]], &b = vertices[face[i]], &c = vertices[face[i + 1]];
      volume += dot(a - o, cross(b - o, c - o)) / 6;
    }
  }
  return volume;
}

Plane plane_of(const std::vector<Vector>& vertices, const std::vector<int>& face) {
  Plane plane;
  for (int c : face) plane.centre += vertices[c] / double(face.size());
  const Vector m = newell(vertices, face);
  if (norm(m) > 0.0) plane.normal = normalized(m);
  return plane;
}

std::string fault_of_faces(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces) {
  const double tolerance = shape_tolerance * longest_extent(vertices);
  for (size_t f = 0; f < faces.size(); ++f) {
    if (norm(newell(vertices, faces[f])) <= tolerance * tolerance)
      return fmt::format("face {} at {} has no area", f, place(vertices[faces[f][0]]));
    const Plane plane = plane_of(vertices, faces[f]);
    for (int c : faces[f]) {
      const double off = dot(vertices[c] - plane.centre, plane.normal);
      if (std::abs(off) > tolerance) {
        return fmt::format("face {} is not planar: its corner {} lies {:.3g} m off the plane", f, place(vertices[c]),
                           off);
      }
    }
    for (size_t i = 0; i < vertices.size(); ++i) {
      const double front = dot(vertices[i] - plane.centre, plane.normal);
      if (front > 2 * tolerance) {
        return fmt::format("is not convex: vertex {} at {} lies {:.3g} m in front of face {}; {}", i,
                           place(vertices[i]), front, f, how_to_cut);
      }
    }
  }
  return {};
}

ConvexPolyhedron from_faces(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces,
                            const std::string& name) {
  check_closed(vertices, faces, name);
  const std::string fault = fault_of_faces(vertices, faces);
  if (!fault.empty()) refuse(name, fault);
  return from_vertices(vertices, name);
}

ConvexPolyhedron box(const Vector& lower, const Vector& size) {
  ConvexPolyhedron b;
  for (int i = 0; i < 8; ++i) {
    b.vertices.push_back(lower + Vector{i & 1 ? size.x : 0.0, i & 2 ? size.y : 0.0, i & 4 ? size.z : 0.0});
  }
  b.faces = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};  // -x +x -y +y -z +z
  complete(b);
  return b;
}

MassProperties mass_properties(const ConvexPolyhedron& shape) {
  MassProperties m;
  const Vector origin = shape.vertices[0];
  Matrix second = Matrix::zero();  // integral of x (x) x about the origin
  for (const auto& face : shape.faces) {
    for (size_t i = 1; i + 1 < face.size(); ++i) {
      const Vector a = shape.vertices[face[0]] - origin, b = shape.vertices[face[i]] - origin,
                   c = shape.vertices[face[i + 1]] - origin;
      const double v = dot(a, cross(b, c)) / 6;
      const Vector sum = a + b + c;
      m.volume += v;
      m.centroid += v / 4 * sum;
      second += v / 20 * (outer(a, a) + outer(b, b) + outer(c, c) + outer(sum, sum));
    }
  }
  m.centroid = m.centroid / m.volume;
  second = second - m.volume * outer(m.centroid, m.centroid);
  m.inertia = trace(second) * Matrix{} - second;
  m.centroid += origin;
  return m;
}

double face_area(const ConvexPolyhedron& shape, int face) {
  return 0.5 * norm(newell(shape.vertices, shape.faces[face]));
}

Vector face_centroid(const ConvexPolyhedron& shape, int face) {
  const auto& f = shape.faces[face];
  const Vector o = shape.vertices[f[0]], n = newell(shape.vertices, f);
  Vector sum;
  double total = 0.0;
  for (size_t i = 1; i + 1 < f.size(); ++i) {
    const Vector &b = shape.vertices[f[i]], &c = shape.vertices[f[i + 1]];
    const double w = dot(cross(b - o, c - o), n);
    sum += w / 3 * (o + b + c);
    total += w;
  }
  return sum / total;
}

}  // namespace quoin::geometry
