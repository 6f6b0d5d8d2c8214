#include "geometry/drawn_shape.h"

#include <fmt/format.h>

#include <map>
#include <numeric>
#include <set>

#include "base/error.h"
#include "base/joined_items.h"

namespace quoin::geometry {
namespace {

using Edge = std::pair<int, int>;
Edge edge_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw Error(Exit::bad_input, fmt::format("block {}: {}", name, what));
}

std::map<Edge, std::vector<int>> faces_by_edge(const RawShape& shape) {
  std::map<Edge, std::vector<int>> found;
  for (int f = 0; f < int(shape.faces.size()); ++f) {
    const auto& face = shape.faces[size_t(f)];
    for (size_t i = 0; i < face.size(); ++i) found[edge_of(face[i], face[(i + 1) % face.size()])].push_back(f);
  }
  return found;
}

// Component number of each face, from 0.
std::vector<int> components(const RawShape& shape) {
  JoinedItems joined(shape.faces.size());  // components keep the order of the file
  for (const auto& [edge, faces] : faces_by_edge(shape)) {
    for (const int f : faces) joined.join(faces[0], f);
  }
  std::vector<int> number;
  int next = 0;
  for (int f = 0; f < int(shape.faces.size()); ++f) {
    const int first = joined.first_of(f);
    number.push_back(first == f ? next++ : number[size_t(first)]);
  }
  return number;
}

bool runs_along(const std::vector<int>& face, int a, int b) {
  for (size_t i = 0; i < face.size(); ++i) {
    if (face[i] == a && face[(i + 1) % face.size()] == b) return true;
  }
  return false;
}

// Largest distance from the planes of a body, m, and its place.
struct Farthest {
  double distance = 0.0;
  Vector at;
  void take(double d, const Vector& p) {
    if (d > distance) distance = d, at = p;
  }
};

// Largest distance of corners from the planes of their faces.
Farthest warp_of(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces) {
  Farthest worst;
  for (const auto& face : faces) {
    const Plane plane = plane_of(vertices, face);
    for (int c : face) worst.take(std::abs(dot(vertices[size_t(c)] - plane.centre, plane.normal)), vertices[size_t(c)]);
  }
  return worst;
}

// Largest depth of corners, middles of edges and middles of faces below the hull.
Farthest depth_of(const RawShape& shape, const ConvexPolyhedron& hull) {
  Farthest worst;
  const auto look = [&](const Vector& p) {
    double depth = 1e300;
    for (size_t f = 0; f < hull.faces.size(); ++f)
      depth = std::min(depth, dot(hull.normals[f], hull.vertices[size_t(hull.faces[f][0])] - p));
    worst.take(depth, p);
  };
  for (const auto& face : shape.faces) {
    for (size_t i = 0; i < face.size(); ++i) {
      const Vector &a = shape.vertices[size_t(face[i])], &b = shape.vertices[size_t(face[(i + 1) % face.size()])];
      look(a);
      look(0.5 * (a + b));
    }
    look(plane_of(shape.vertices, face).centre);
  }
  return worst;
}

// Moves corners to the intersection of the planes of their faces, if their normals differ enough. A corner keeps its
// position along directions that its planes do not determine. Where more than three planes meet in a corner, planes are
// fitted again. Returns false if the faces do not become planar.
bool make_planar(ConvexPolyhedron& shape, double tolerance) {
  constexpr double kLeastShare = 0.01;  // least sum of squared components of normals along a direction
  constexpr int kRounds = 200;
  const double size = longest_extent(shape.vertices);
  std::vector<std::vector<int>> faces_at(shape.vertices.size());
  for (int f = 0; f < int(shape.faces.size()); ++f) {
    for (int c : shape.faces[size_t(f)]) faces_at[size_t(c)].push_back(f);
  }
  for (int round = 0; round < kRounds; ++round) {
    if (round > 0 && warp_of(shape.vertices, shape.faces).distance <= tolerance * size) {
      complete(shape);
      return true;
    }
    std::vector<Plane> planes;
    for (const auto& face : shape.faces) planes.push_back(plane_of(shape.vertices, face));
    for (size_t v = 0; v < shape.vertices.size(); ++v) {
      Matrix sum = Matrix::zero();
      Vector right;
      for (int f : faces_at[v]) {
        const Plane& p = planes[size_t(f)];
        sum += outer(p.normal, p.normal);
        right += dot(p.normal, p.centre - shape.vertices[v]) * p.normal;
      }
      const Eigen3 eigen = symmetric_eigen(sum);
      for (int k = 0; k < 3; ++k) {
        if (eigen.values[k] < kLeastShare) continue;
        const Vector axis = eigen.vectors.column(k);
        shape.vertices[v] += dot(axis, right) / eigen.values[k] * axis;
      }
    }
  }
  return false;
}

// Distance to the nearest plane or corner of a body, m.
double distance_from_surface(const ConvexPolyhedron& body, const Vector& p) {
  double nearest = 1e300, inside = 1e300;
  for (const Vector& q : body.vertices) nearest = std::min(nearest, norm(p - q));
  for (size_t f = 0; f < body.faces.size(); ++f)
    inside = std::min(inside, dot(body.normals[f], body.vertices[size_t(body.faces[f][0])] - p));
  return std::min(nearest, std::abs(inside));
}

// Hull with planar faces of a surface that is uneven by this distance, m. The fourth corner of a quadrilateral is off
// the plane of the other three by four times the warp, twice the tolerance of the hull. Where that produces small
// edges, another tolerance may avoid them.
ConvexPolyhedron planar_hull(const RawShape& shape, double uneven) {
  const double relative = uneven / longest_extent(shape.vertices);
  std::string why = "its corners do not come to rest";
  for (const double factor : {2.2, 1.0, 4.0, 0.3}) {
    try {
      ConvexPolyhedron hull = from_vertices(shape.vertices, shape.name, factor * relative);
      if (make_planar(hull, 0.1 * shape_tolerance)) return hull;
    } catch (const Error& error) {
      why = error.what();
    }
  }
  refuse(shape.name,
         fmt::format("its faces are warped by {:.3g} m and cannot be made planar by moving its corners ({}); "
                     "divide them into triangles where it was drawn",
                     uneven, why));
}

// Outline of a group of faces, counter-clockwise; empty if it is not a single loop.
std::vector<int> outline_of(const ConvexPolyhedron& shape, const std::vector<int>& group) {
  std::map<int, int> next;
  std::set<std::pair<int, int>> ways;
  for (int f : group) {
    const auto& face = shape.faces[size_t(f)];
    for (size_t i = 0; i < face.size(); ++i) ways.insert({face[i], face[(i + 1) % face.size()]});
  }
  for (const auto& [from, to] : ways) {
    if (!ways.contains({to, from}) && !next.emplace(from, to).second) return {};
  }
  std::vector<int> outline;
  for (int at = next.empty() ? -1 : next.begin()->first; at >= 0 && outline.size() < next.size(); at = next.at(at)) {
    if (!outline.empty() && at == outline.front()) return {};
    outline.push_back(at);
  }
  return outline;
}

// Cosine between normals, of 2.5 degrees: steeper faces, as bevels, are meant, unless they are slivers.
constexpr double kRounded = 0.999;

// Groups of neighbouring faces that lie within the tolerance of one plane, with their outlines. Large faces begin.
std::vector<std::vector<int>> coplanar_outlines(const ConvexPolyhedron& shape, double tolerance) {
  const int count = int(shape.faces.size());
  std::vector<std::vector<int>> neighbours(shape.faces.size());
  for (const auto& e : shape.edges)
    neighbours[size_t(e.left)].push_back(e.right), neighbours[size_t(e.right)].push_back(e.left);
  std::vector<int> by_area(shape.faces.size());
  std::iota(by_area.begin(), by_area.end(), 0);
  std::vector<double> area(shape.faces.size());
  for (int f = 0; f < count; ++f) area[size_t(f)] = face_area(shape, f);
  std::stable_sort(by_area.begin(), by_area.end(), [&](int i, int j) { return area[size_t(i)] > area[size_t(j)]; });
  const double sliver = tolerance * longest_extent(shape.vertices);
  std::vector<bool> used(shape.faces.size(), false);
  std::vector<std::vector<int>> outlines;
  for (int first : by_area) {
    if (used[size_t(first)]) continue;
    used[size_t(first)] = true;
    std::vector<int> group{first}, outline = shape.faces[size_t(first)];
    Plane plane = plane_of(shape.vertices, outline);
    const auto joins = [&](int f) {
      if (used[size_t(f)] || (dot(shape.normals[size_t(f)], plane.normal) < kRounded && area[size_t(f)] > sliver))
        return false;
      group.push_back(f);
      const std::vector<int> wider = outline_of(shape, group);
      const Plane of_all = wider.empty() ? plane : plane_of(shape.vertices, wider);
      bool fits = !wider.empty();
      for (int g : group) {
        for (int c : shape.faces[size_t(g)])
          fits &= std::abs(dot(shape.vertices[size_t(c)] - of_all.centre, of_all.normal)) <= tolerance;
      }
      if (fits)
        outline = wider, plane = of_all, used[size_t(f)] = true;
      else
        group.pop_back();
      return fits;
    };
    for (bool again = true; again;) {
      again = false;
      for (size_t i = 0; i < group.size() && !again; ++i)
        again = std::ranges::any_of(neighbours[size_t(group[i])], joins);
    }
    outlines.push_back(outline);
  }
  return outlines;
}

}  // namespace

double unite_faces(ConvexPolyhedron& shape, double tolerance) {
  const std::vector<std::vector<int>> outlines =
      coplanar_outlines(shape, std::min(tolerance, warp_bound * longest_extent(shape.vertices)));
  if (outlines.size() == shape.faces.size()) return 0.0;
  std::vector<int> faces_at(shape.vertices.size(), 0), number(shape.vertices.size(), -1), from;
  for (const auto& outline : outlines) {
    for (int c : outline) ++faces_at[size_t(c)];
  }
  ConvexPolyhedron united;
  for (const auto& outline : outlines) {
    auto& face = united.faces.emplace_back();
    for (int c : outline) {
      if (faces_at[size_t(c)] < 3) continue;  // inside a face, or on a straight edge
      if (number[size_t(c)] < 0) {
        number[size_t(c)] = int(from.size());
        from.push_back(c), united.vertices.push_back(shape.vertices[size_t(c)]);
      }
      face.push_back(number[size_t(c)]);
    }
    if (face.size() < 3) return -1.0;
  }
  if (!make_planar(united, 0.1 * shape_tolerance) || !fault_of_faces(united.vertices, united.faces).empty() ||
      united.vertices.size() + united.faces.size() != united.edges.size() + 2)
    return -1.0;
  double moved = 0.0;
  for (size_t v = 0; v < from.size(); ++v)
    moved = std::max(moved, norm(united.vertices[v] - shape.vertices[size_t(from[v])]));
  for (size_t f = 0; f < outlines.size(); ++f) {  // corners that are left out
    const Vector& on = united.vertices[size_t(united.faces[f].front())];
    for (int c : outlines[f]) moved = std::max(moved, std::abs(dot(united.normals[f], shape.vertices[size_t(c)] - on)));
  }
  shape = std::move(united);
  return moved;
}

void weld(RawShape& shape) {
  const double tolerance = shape_tolerance * longest_extent(shape.vertices);
  std::vector<int> order(shape.vertices.size()), first(order.size(), -1);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return std::pair(shape.vertices[size_t(a)].x, a) < std::pair(shape.vertices[size_t(b)].x, b);
  });
  for (size_t i = 0; i < order.size(); ++i) {
    if (first[size_t(order[i])] >= 0) continue;
    const Vector& p = shape.vertices[size_t(order[i])];
    for (size_t j = i; j < order.size() && shape.vertices[size_t(order[j])].x - p.x <= tolerance; ++j) {
      if (first[size_t(order[j])] < 0 && norm(shape.vertices[size_t(order[j])] - p) <= tolerance)
        first[size_t(order[j])] = order[i];
    }
  }
  for (auto& face : shape.faces) {
    std::vector<int> corners;
    for (int c : face) {
      const int one = first[size_t(c)];
      if (corners.empty() || corners.back() != one) corners.push_back(one);
    }
    while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
    face = corners;
  }
  std::set<std::vector<int>> known;
  std::erase_if(shape.faces, [&](std::vector<int> face) {
    std::sort(face.begin(), face.end());
    return face.size() < 3 || !known.insert(face).second;
  });
}

std::vector<RawShape> split(const RawShape& shape) {
  const std::vector<int> component = components(shape);
  const int count = component.empty() ? 0 : *std::max_element(component.begin(), component.end()) + 1;
  std::vector<RawShape> parts(static_cast<size_t>(count));
  std::vector<std::map<int, int>> number(parts.size());
  for (size_t f = 0; f < component.size(); ++f) {
    RawShape& part = parts[size_t(component[f])];
    auto& face = part.faces.emplace_back();
    for (int c : shape.faces[f]) {
      const auto [it, added] = number[size_t(component[f])].try_emplace(c, int(part.vertices.size()));
      if (added) part.vertices.push_back(shape.vertices[size_t(c)]);
      face.push_back(it->second);
    }
  }
  for (RawShape& part : parts) part.name = shape.name, part.support = shape.support, part.number = shape.number;
  return parts;
}

bool is_closed(const RawShape& shape) {
  const auto faces = faces_by_edge(shape);
  return std::all_of(faces.begin(), faces.end(), [](const auto& entry) { return entry.second.size() == 2; });
}

void orient(RawShape& shape) {
  const auto neighbours = faces_by_edge(shape);
  std::vector<bool> seen(shape.faces.size(), false);
  for (size_t start = 0; start < shape.faces.size(); ++start) {
    std::vector<int> front{int(start)};
    if (seen[start]) continue;
    seen[start] = true;
    while (!front.empty()) {
      const std::vector<int> face = shape.faces[size_t(front.back())];
      front.pop_back();
      for (size_t i = 0; i < face.size(); ++i) {
        const int a = face[i], b = face[(i + 1) % face.size()];
        const auto& sharing = neighbours.at(edge_of(a, b));
        if (sharing.size() != 2) continue;
        for (int other : sharing) {
          if (seen[size_t(other)]) continue;
          auto& turned = shape.faces[size_t(other)];
          if (runs_along(turned, a, b)) std::reverse(turned.begin(), turned.end());
          seen[size_t(other)] = true;
          front.push_back(other);
        }
      }
    }
  }
  if (!shape.faces.empty() && volume_within(shape.vertices, shape.faces) < 0) {
    for (auto& face : shape.faces) std::reverse(face.begin(), face.end());
  }
}

bool is_flat(const RawShape& shape) {
  if (shape.vertices.empty()) return false;
  const double size = longest_extent(shape.vertices);
  if (is_closed(shape) && std::abs(volume_within(shape.vertices, shape.faces)) > shape_tolerance * size * size * size)
    return false;
  Matrix spread = Matrix::zero();
  Vector centre;
  for (const Vector& p : shape.vertices) centre += p / double(shape.vertices.size());
  for (const Vector& p : shape.vertices) spread += outer(p - centre, p - centre);
  const Vector normal = symmetric_eigen(spread).vectors.column(0);
  const double bound = warp_bound * size;
  return std::all_of(shape.vertices.begin(), shape.vertices.end(),
                     [&](const Vector& p) { return std::abs(dot(p - centre, normal)) <= bound; });
}

DrawnShape from_drawn(const RawShape& shape) {
  check_closed(shape.vertices, shape.faces, shape.name);
  const std::string fault = fault_of_faces(shape.vertices, shape.faces);
  if (fault.empty()) return {from_vertices(shape.vertices, shape.name), 0.0};

  const double size = longest_extent(shape.vertices), bound = warp_bound * size;
  const Farthest warp = warp_of(shape.vertices, shape.faces);
  const Farthest depth = depth_of(shape, from_vertices(shape.vertices, shape.name));
  if (warp.distance > bound) {
    refuse(shape.name, fmt::format("a face is not planar: its corner {} lies {:.3g} m off the plane (allowed: {:.3g} "
                                   "m, {:g} of the block's extent); divide the face into triangles",
                                   place(warp.at), warp.distance, bound, warp_bound));
  }
  if (depth.distance > bound) {
    refuse(shape.name, fmt::format("is not convex: near {} its surface lies {:.3g} m inside its hull (allowed: {:.3g} "
                                   "m, {:g} of its extent); {}",
                                   place(depth.at), depth.distance, bound, warp_bound, how_to_cut));
  }
  DrawnShape drawn{planar_hull(shape, std::max(warp.distance, depth.distance)), 0.0};
  for (const Vector& p : shape.vertices) drawn.warp = std::max(drawn.warp, distance_from_surface(drawn.shape, p));
  return drawn;
}

ConvexPolyhedron plate(const RawShape& shape, const Vector& others) {
  constexpr double kThickness = 0.1;  // share of the extent
  const Plane plane = plane_of(shape.vertices, shape.faces[0]);
  const double side = dot(others - plane.centre, plane.normal) > 0 ? -1.0 : 1.0;
  const Vector back = kThickness * longest_extent(shape.vertices) * side * plane.normal;
  std::vector<Vector> points;
  double area = 0.0;
  for (const Vector& p : shape.vertices) {
    points.push_back(p - dot(p - plane.centre, plane.normal) * plane.normal);
    points.push_back(points.back() + back);
  }
  for (const auto& face : shape.faces) {
    Vector twice;
    for (size_t i = 1; i + 1 < face.size(); ++i)
      twice += cross(shape.vertices[size_t(face[i])] - shape.vertices[size_t(face[0])],
                     shape.vertices[size_t(face[i + 1])] - shape.vertices[size_t(face[0])]);
    area += norm(twice) / 2;
  }
  ConvexPolyhedron made = from_vertices(points, shape.name);
  const double hull = mass_properties(made).volume / norm(back);
  if (area < (1 - warp_bound) * hull)
    refuse(shape.name,
           fmt::format("is a face of {:.4g} m2 in a hull of {:.4g} m2, and a support must be convex; divide "
                       "it, or draw it as closed blocks",
                       area, hull));
  return made;
}

}  // namespace quoin::geometry
