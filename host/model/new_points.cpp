#include "model/new_points.h"

#include <algorithm>
#include <cmath>

#include "geometry/overlap.h"
#include "model/contact_frames.h"
#include "model/placed_blocks.h"
#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Cosine between the normals above which faces can overlap; those of steeper ones meet along an edge or at a corner.
constexpr double least_overlap_cosine = 0.05;
// Gap above which a point is on the far side of a tilted block, in multiples of the reach of detection.
constexpr double far_side = 20.0;
// Secant stiffness, over that of the intact joint, up to which tension is none: the end of exponential softening.
constexpr double kNoTension = 1e-12;
// Distance below which points of an overlap are merged, as a fraction of the smallest block.
constexpr double merge_fraction = 1e-6;
// Distance from a gridpoint, as a fraction of an edge, below which a point lies on it. It is far above the rounding of
// points at gridpoints, and far below the size of any zone.
constexpr double kAtGridpoint = 1e-9;

// Overlap across the separating normal below which blocks meet along a rim, as a fraction of the smaller block.
// Closures of joints under usual pressures are below it, chamfers of real units are above.
constexpr double kRim = 2e-3;

// Whether blocks meet along a rim: they overlap by little across the separating normal too. A block that slides flush
// onto another one has sunk by the closure of its joint. So it meets the hidden side of the other.
bool meet_along_rim(const World& w, const Pair& pair, const Vector& normal) {
  constexpr double kAcross = 0.5;  // cosine up to which a face lies across the normal
  const double rim = kRim * std::min(w.blocks[pair.a].least_extent, w.blocks[pair.b].least_extent);
  const auto is_thin = [&](const Placed& owner, const Placed& other) {
    for (size_t f = 0; f < owner.shape->faces.size(); ++f) {
      const Vector& m = owner.normals[f];
      if (std::abs(dot(m, normal)) > kAcross) continue;
      const Vector& on_face = owner.vertices[owner.shape->faces[f][0]];
      const std::span corners(other.vertices, other.shape->vertices.size());
      if (std::ranges::all_of(corners, [&](const Vector& x) { return dot(m, on_face - x) <= rim; })) return true;
    }
    return false;
  };
  const Placed a = placed(w, pair.a), b = placed(w, pair.b);
  return is_thin(a, b) || is_thin(b, a);
}

RigidPoints rigid_points_of(const World& w, const Contact& c, const Vector& normal, bool at_start) {
  const int family = family_of(w, c, normal);
  if (family < 0 || family >= int(w.assembly.families.size())) return RigidPoints::corners;
  const RigidPoints rule = w.assembly.families[size_t(family)].rigid_points;
  if (rule != RigidPoints::cubic_at_start) return rule;
  return at_start || c.initial ? RigidPoints::cubic : RigidPoints::corners;
}

// Makes the gridpoint with all of the weight the first one of the triangle.
void put_on_gridpoint(Facet& facet) {
  for (int k = 0; k < 3; ++k) {
    if (facet.weight[k] < 1.0 - kAtGridpoint) continue;
    std::rotate(facet.node, facet.node + k, facet.node + 3);
    facet.weight[0] = 1.0, facet.weight[1] = facet.weight[2] = 0.0;
    return;
  }
}

// Attaches one side of a point to its block: in its body frame, or on the nearest surface triangle of a deformable
// block.
void anchor(const World& w, NewPoint& made, int block, const Vector& at, int face, bool plane_side) {
  Point& p = made.point;
  const ModelBlock& mb = w.blocks[block];
  if (mb.body >= 0) {
    const Body& body = w.bodies[mb.body];
    if (plane_side) {
      p.n = transposed_times(body.r, p.n), p.s = transposed_times(body.r, p.s), p.t = transposed_times(body.r, p.t);
      p.offset = dot(p.n, transposed_times(body.r, at - body.x));  // offset of the plane; hand_over adds the reference
    } else {
      p.arm = transposed_times(body.r, at - body.x);
    }
    return;
  }
  Facet facet{};
  double best = -1e300;
  for (const auto& tri : mb.surface) {
    if (tri.face != face) continue;
    const Vector& x = w.nodes.x[tri.node[0]];
    const auto share = corner_shares(w.nodes.x[tri.node[1]] - x, w.nodes.x[tri.node[2]] - x, at - x);
    const double least = std::ranges::min(share);
    if (least <= best) continue;
    best = least;
    for (int k = 0; k < 3; ++k) facet.node[k] = tri.node[k];
    std::ranges::copy(share, facet.weight);
  }
  if (plane_side) {
    p.facet_a = 0;  // index set when the point is stored
    made.facet_a = facet;
  } else {
    put_on_gridpoint(facet);
    p.facet_b = 0;
    made.facet_b = facet;
  }
}

// Sets the frame of a point whose plane belongs to a deformable block. It is the block's frame where its deformable
// sides are gridpoints. Else it is the triangle's frame, also for edge contacts.
void choose_frame(const World& w, NewPoint& made) {
  Point& p = made.point;
  if (p.facet_a < 0) return;
  Facet on_a = made.facet_a;
  put_on_gridpoint(on_a);
  p.on_gridpoints =
      may_have_frame(w, p.a) && sits_on_gridpoint(on_a) && (p.facet_b < 0 || sits_on_gridpoint(made.facet_b));
  if (!p.on_gridpoints) return take_axes(p, triangle_frame(w.nodes.x, made.facet_a));
  made.facet_a = on_a;
  const Matrix r = rotation_of_frame(w, p.a);
  p.n = transposed_times(r, p.n), p.s = transposed_times(r, p.s), p.t = transposed_times(r, p.t);
}

// Whether the edges cross; appends the point where they do, unless its area (m2) is 0.
bool edge_point(const World& w, const Pair& pair, const Separation& separation, double area,
                std::vector<NewPoint>& out) {
  const Placed a = placed(w, pair.a), b = placed(w, pair.b);
  const auto &ea = a.shape->edges[separation.index_a], &eb = b.shape->edges[separation.index_b];
  const Vector u = a.vertices[ea.head] - a.vertices[ea.tail], v = b.vertices[eb.head] - b.vertices[eb.tail];
  const auto crossing = crossing_points(a.vertices[ea.tail], u, b.vertices[eb.tail], v);
  if (!crossing) return false;
  if (area <= 0) return true;
  const auto& [pa, pb] = *crossing;
  NewPoint made;
  Point& p = made.point;
  p.a = pair.a, p.b = pair.b;
  p.n = separation.normal;
  p.s = normalized(u - dot(u, p.n) * p.n), p.t = cross(p.n, p.s);
  p.area = area;
  p.at = pb;
  made.joint = false;
  anchor(w, made, p.a, pa, ea.left, true);
  anchor(w, made, p.b, pb, eb.left, false);
  choose_frame(w, made);
  out.push_back(made);
  return true;
}

// Plane of a block's face, with axes in it.
struct FacePlane {
  Vector n, origin, s, t;
  FacePlane(const Placed& block, int face) : n(block.normals[face]) {
    const auto& corners = block.shape->faces[face];
    origin = block.vertices[corners[0]];
    const Vector along = block.vertices[corners[1]] - origin;
    s = normalized(along - dot(along, n) * n), t = cross(n, s);
  }
  Point2 flat(const Vector& p) const { return {dot(s, p - origin), dot(t, p - origin)}; }
};

// Part of a face in a plane: whole faces of rigid blocks, surface triangles of deformable ones.
struct Patch {
  Polygon polygon;
  Point2 low{1e300, 1e300}, high{-1e300, -1e300};
  Patch(Polygon corners, bool reverse) : polygon(std::move(corners)) {
    if (reverse) std::reverse(polygon.begin(), polygon.end());
    for (const Point2& q : polygon) {
      low = {std::min(low.x, q.x), std::min(low.y, q.y)}, high = {std::max(high.x, q.x), std::max(high.y, q.y)};
    }
  }
  bool is_apart(const Patch& q) const {
    return high.x < q.low.x || q.high.x < low.x || high.y < q.low.y || q.high.y < low.y;
  }
};

std::vector<Patch> patches_of(const World& w, int block, const Placed& p, int face, bool reverse,
                              const FacePlane& plane) {
  std::vector<Patch> patches;
  if (w.blocks[block].body >= 0) {
    Polygon polygon;
    polygon.reserve(p.shape->faces[face].size());
    for (int k : p.shape->faces[face]) polygon.push_back(plane.flat(p.vertices[k]));
    patches.emplace_back(std::move(polygon), reverse);
    return patches;
  }
  const auto corner = [&](int32_t node) { return plane.flat(w.nodes.x[node]); };
  for (const auto& tri : w.blocks[block].surface) {
    if (tri.face == face)
      patches.emplace_back(Polygon{corner(tri.node[0]), corner(tri.node[1]), corner(tri.node[2])}, reverse);
  }
  return patches;
}

// Points of the rule on the overlaps of patches. Linear jumps and shape functions are continuous across borders of
// patches, so points at one place are merged.
void points_on(const World& w, std::span<const Patch> of_a, std::span<const Patch> of_b, bool rigid, RigidPoints rule,
               double tolerance, std::vector<QuadraturePoint>& points) {
  thread_local std::vector<QuadraturePoint> local;
  thread_local Polygon overlap, scratch;
  for (const Patch& p : of_a) {
    for (const Patch& q : of_b) {
      if (p.is_apart(q)) continue;
      clip(q.polygon, p.polygon, tolerance, overlap, scratch);
      if (overlap.empty()) continue;
      local.clear();
      if (rigid && w.assembly.contact.point_spacing > 0)
        grid_rule(overlap, w.assembly.contact.point_spacing, local);
      else if (rigid && rule == RigidPoints::cubic)
        cubic_rule(overlap, local);
      else
        vertex_rule(overlap, local);
      for (const QuadraturePoint& l : local) add_merged(points, 0, l, 10 * tolerance);
    }
  }
}

// The deepest corner below the plane, if it lies on the face; -1: there is none.
int deepest_corner(const Placed& a, int face_of_a, const Placed& b, const FacePlane& plane) {
  const auto depth = [&](int i) { return dot(plane.n, b.vertices[i]); };
  int deepest = 0;
  for (int i = 1; i < int(b.shape->vertices.size()); ++i) {
    if (depth(i) < depth(deepest)) deepest = i;
  }
  if (!(dot(plane.n, b.vertices[deepest] - plane.origin) <= 0)) return -1;
  const Point2 at = plane.flat(b.vertices[deepest]);
  const auto& corners = a.shape->faces[face_of_a];
  for (size_t k = 0; k < corners.size(); ++k) {
    const Point2 p = plane.flat(a.vertices[corners[k]]), q = plane.flat(a.vertices[corners[(k + 1) % corners.size()]]);
    if (!((q.x - p.x) * (at.y - p.y) - (q.y - p.y) * (at.x - p.x) >= 0)) return -1;
  }
  return deepest;
}

// Diagonal of the box around points, m.
double diagonal_of(const std::vector<QuadraturePoint>& points) {
  Point2 low{1e300, 1e300}, high{-1e300, -1e300};
  for (const QuadraturePoint& q : points) {
    low = {std::min(low.x, q.at.x), std::min(low.y, q.at.y)},
    high = {std::max(high.x, q.at.x), std::max(high.y, q.at.y)};
  }
  return points.empty() ? 0.0 : std::hypot(high.x - low.x, high.y - low.y);
}

// Appends points where the face of `carrier` that is turned to `owner` overlaps the face `owner_face`, in the plane of
// that face. farthest: largest gap, m. Their areas add up to half of `nominal` (m2) at least; a single corner gets
// `nominal`.
void face_points(const World& w, int owner, int owner_face, int carrier, bool at_start, double farthest, double nominal,
                 RigidPoints rule, std::vector<NewPoint>& out) {
  const Placed a = placed(w, owner), b = placed(w, carrier);
  const FacePlane plane(a, owner_face);
  const int facing_face = facing(b, -plane.n);
  const Vector nb = b.normals[facing_face];
  const double cosine = -dot(plane.n, nb),
               tolerance = merge_fraction * std::min(w.blocks[owner].least_extent, w.blocks[carrier].least_extent);
  thread_local std::vector<QuadraturePoint> points;
  points.clear();
  if (cosine > least_overlap_cosine) {
    const bool rigid = w.blocks[owner].body >= 0 && w.blocks[carrier].body >= 0;
    points_on(w, patches_of(w, owner, a, owner_face, false, plane), patches_of(w, carrier, b, facing_face, true, plane),
              rigid, rule, tolerance, points);
  }
  double total = 0.0;
  for (const QuadraturePoint& q : points) total += q.area;
  // Faces that meet along an edge overlap by a strip as wide as their coordinates are rounded, which is no joint.
  if (at_start && total <= w.detection.joint_tolerance * diagonal_of(points)) points.clear();
  const auto make = [&](const Vector& at, double area, double gap) {
    NewPoint made;
    Point& p = made.point;
    p.a = owner, p.b = carrier;
    p.n = plane.n, p.s = plane.s, p.t = plane.t;
    p.area = area, p.at = at;
    // For a joint of the start, the gap found there is the reference.
    made.joint = at_start && std::abs(gap) <= w.detection.joint_tolerance && cosine > parallel_cosine;
    p.reference = made.joint ? gap : 0.0;
    anchor(w, made, owner, at - gap * plane.n, owner_face, true);
    anchor(w, made, carrier, at, facing_face, false);
    choose_frame(w, made);
    out.push_back(made);
  };
  if (points.empty()) {  // as for a corner beside a steep face
    const int deepest = deepest_corner(a, owner_face, b, plane);
    if (deepest >= 0 && nominal > 0 && w.blocks[carrier].body >= 0)
      make(b.vertices[deepest], nominal, dot(plane.n, b.vertices[deepest] - plane.origin));
    return;
  }
  // Slivers of overlap would be soft springs; the nominal area keeps corners from sinking in.
  const double stiffen = std::max(1.0, 0.5 * nominal / total);
  const Vector on_b = b.vertices[b.shape->faces[facing_face][0]];
  for (const QuadraturePoint& q : points) {
    const Vector foot = plane.origin + q.at.x * plane.s + q.at.y * plane.t;
    const double gap = dot(on_b - foot, nb) / dot(plane.n, nb);
    if (gap > farthest) continue;
    make(foot + gap * plane.n, q.area * stiffen, gap);
  }
}

}  // namespace

std::optional<double> pulled_opening(const World& w, const Contact& c) {
  std::optional<double> largest;
  for (uint32_t i = c.first; i < c.first + c.count; ++i) {
    const Family& f = w.contacts.families[size_t(c.family)];
    const double opening = f.normal_jump[i], tension = f.traction[0][i];
    if (tension > kNoTension * f.kn * std::abs(opening)) largest = std::max(largest.value_or(opening), opening);
  }
  return largest;
}

int family_of(const World& w, const Contact& c, const Vector& normal) {
  if (c.family >= 0 || !w.assembly.family_of) return std::max(c.family, 0);
  return w.assembly.family_of({c.pair.a, c.pair.b, normal});
}

void make_points(const World& w, Contact& c, const Separation& s, bool at_start, std::vector<NewPoint>& out) {
  // Corner contacts get a nominal area, which keeps corners from sinking in. Blocks that touch along an edge since the
  // start get none, as their neighbours keep them apart (four units around a joint's end). Nor do those that meet along
  // a rim. With the nominal area, units could not slide past an edge that protrudes by some micrometres.
  const double of_corner = std::min(w.blocks[c.pair.a].corner_area, w.blocks[c.pair.b].corner_area);
  if (!at_start && c.beside_joint == 0 && meet_along_rim(w, c.pair, s.normal)) c.beside_joint = Contact::kOnRim;
  const double nominal = c.beside_joint != 0 ? 0.0 : of_corner;
  const double of_faces = at_start ? 0.0 : nominal;
  const RigidPoints rule = rigid_points_of(w, c, s.normal, at_start);
  // A joint that is pulled further than points are placed is still whole, on both sides of a tilted block.
  const bool is_pulled = pulled_opening(w, c).value_or(0.0) > w.detection.reach;
  const double farthest = at_start || is_pulled ? HUGE_VAL : far_side * w.detection.reach;
  const size_t before = out.size();
  if (s.feature == Separation::edges) {
    if (!is_pulled && edge_point(w, c.pair, s, nominal, out)) return;
    // Edges that separate the blocks but pass beside each other, as the rims of stacked units do.
    const Placed a = placed(w, c.pair.a), b = placed(w, c.pair.b);
    const int face_of_a = facing(a, s.normal), face_of_b = facing(b, -s.normal);
    if (dot(a.normals[face_of_a], s.normal) >= -dot(b.normals[face_of_b], s.normal))
      face_points(w, c.pair.a, face_of_a, c.pair.b, at_start, farthest, of_faces, rule, out);
    else
      face_points(w, c.pair.b, face_of_b, c.pair.a, at_start, farthest, of_faces, rule, out);
  } else if (s.feature == Separation::face_of_a) {
    face_points(w, c.pair.a, s.index_a, c.pair.b, at_start, farthest, of_faces, rule, out);
  } else {
    face_points(w, c.pair.b, s.index_b, c.pair.a, at_start, farthest, of_faces, rule, out);
  }
  double area = 0.0;
  for (size_t i = before; i < out.size(); ++i) area += out[i].point.area;
  if (c.beside_joint == Contact::kOnRim && area >= 0.5 * of_corner) c.beside_joint = 0;  // it would have no effect
}

}  // namespace quoin::blocks
