#include "model/new_points.h"

#include <algorithm>

#include "geometry/overlap.h"
#include "model/contact_frames.h"
#include "model/placed_blocks.h"
#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Cosine above which faces (within about 2.5 degrees of parallel) can be a joint of the start.
constexpr double parallel_cosine = 0.999;
// Distance below which points of an overlap are merged, as a fraction of the smallest block.
constexpr double merge_fraction = 1e-6;
// Distance from a gridpoint, as a fraction of an edge, below which a point lies on it. It is far above the rounding of
// points at gridpoints, and far below the size of any zone.
constexpr double kAtGridpoint = 1e-9;

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
    const Vector &x1 = w.nodes.x[tri.node[0]], e2 = w.nodes.x[tri.node[1]] - x1, e3 = w.nodes.x[tri.node[2]] - x1;
    const Vector m = cross(e2, e3);
    const double square = dot(m, m);
    const double w2 = dot(cross(at - x1, e3), m) / square, w3 = dot(cross(e2, at - x1), m) / square, w1 = 1 - w2 - w3;
    const double least = std::min({w1, w2, w3});
    if (least <= best) continue;
    best = least;
    for (int k = 0; k < 3; ++k) facet.node[k] = tri.node[k];
    facet.weight[0] = w1, facet.weight[1] = w2, facet.weight[2] = w3;
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

// Appends points where the face of `carrier` that is turned to `owner` overlaps the face `owner_face`, in the plane of
// that face. Their areas add up to half of `nominal` (m2) at least; a single corner gets `nominal`.
void face_points(const World& w, int owner, int owner_face, int carrier, bool at_start, double nominal,
                 RigidPoints rule, std::vector<NewPoint>& out) {
  const Placed a = placed(w, owner), b = placed(w, carrier);
  const Vector n = a.normals[owner_face];
  const auto& corners = a.shape->faces[owner_face];
  const Vector origin = a.vertices[corners[0]];
  const Vector along = a.vertices[corners[1]] - origin;
  const Vector s = normalized(along - dot(along, n) * n), t = cross(n, s);
  const int facing_face = facing(b, -n);
  const Vector nb = b.normals[facing_face];
  const double cosine = -dot(n, nb),
               tolerance = merge_fraction * std::min(w.blocks[owner].least_extent, w.blocks[carrier].least_extent);
  const auto flat = [&](const Vector& p) { return Point2{dot(s, p - origin), dot(t, p - origin)}; };

  // Patches: whole faces of rigid blocks, surface triangles of deformable ones.
  struct Patch {
    Polygon polygon;
    Point2 low, high;
  };
  const auto patches = [&](int block, const Placed& p, int face, bool reverse) {
    std::vector<Patch> list;
    const auto add = [&](Polygon polygon) {
      if (reverse) std::reverse(polygon.begin(), polygon.end());
      Point2 low{1e300, 1e300}, high{-1e300, -1e300};
      for (const Point2& q : polygon) {
        low = {std::min(low.x, q.x), std::min(low.y, q.y)}, high = {std::max(high.x, q.x), std::max(high.y, q.y)};
      }
      list.push_back({std::move(polygon), low, high});
    };
    if (w.blocks[block].body >= 0) {
      Polygon polygon;
      for (int k : p.shape->faces[face]) polygon.push_back(flat(p.vertices[k]));
      add(polygon);
    } else {
      for (const auto& tri : w.blocks[block].surface) {
        if (tri.face == face)
          add({flat(w.nodes.x[tri.node[0]]), flat(w.nodes.x[tri.node[1]]), flat(w.nodes.x[tri.node[2]])});
      }
    }
    return list;
  };
  std::vector<QuadraturePoint> points;
  if (cosine > 0.05) {
    const std::vector<Patch> pa = patches(owner, a, owner_face, false), pb = patches(carrier, b, facing_face, true);
    const bool rigid = w.blocks[owner].body >= 0 && w.blocks[carrier].body >= 0;
    Polygon overlap_polygon, scratch;
    std::vector<QuadraturePoint> local;
    for (const Patch& p : pa) {
      for (const Patch& q : pb) {
        if (p.high.x < q.low.x || q.high.x < p.low.x || p.high.y < q.low.y || q.high.y < p.low.y) continue;
        clip(q.polygon, p.polygon, tolerance, overlap_polygon, scratch);
        if (overlap_polygon.empty()) continue;
        local.clear();
        if (rigid && w.assembly.contact.point_spacing > 0) {
          grid_rule(overlap_polygon, w.assembly.contact.point_spacing, local);
        } else if (rigid && rule == RigidPoints::cubic) {
          cubic_rule(overlap_polygon, local);
        } else {
          vertex_rule(overlap_polygon, local);
        }
        // Linear jumps and shape functions are continuous across patch borders, so points at one place are merged.
        for (const QuadraturePoint& l : local) add_merged(points, 0, l, 10 * tolerance);
      }
    }
  }
  const auto make = [&](const Vector& at, double area, double gap) {
    NewPoint made;
    Point& p = made.point;
    p.a = owner, p.b = carrier;
    p.n = n, p.s = s, p.t = t;
    p.area = area, p.at = at;
    // For a joint of the start, the gap found there is the reference.
    made.joint = at_start && std::abs(gap) <= w.detection.joint_tolerance && cosine > parallel_cosine;
    p.reference = made.joint ? gap : 0.0;
    anchor(w, made, owner, at - gap * n, owner_face, true);
    anchor(w, made, carrier, at, facing_face, false);
    choose_frame(w, made);
    out.push_back(made);
  };
  if (points.empty()) {
    // Faces that do not overlap (a corner beside a steep face): the deepest corner of the carrier, if it lies on this
    // face.
    int deepest = 0;
    for (size_t i = 1; i < b.shape->vertices.size(); ++i) {
      if (dot(n, b.vertices[i]) < dot(n, b.vertices[deepest])) deepest = int(i);
    }
    const double gap = dot(n, b.vertices[deepest] - origin);
    const Point2 at = flat(b.vertices[deepest]);
    bool inside = gap <= 0;
    for (size_t k = 0; k < corners.size() && inside; ++k) {
      const Point2 p = flat(a.vertices[corners[k]]), q = flat(a.vertices[corners[(k + 1) % corners.size()]]);
      inside = (q.x - p.x) * (at.y - p.y) - (q.y - p.y) * (at.x - p.x) >= 0;
    }
    if (inside && nominal > 0 && w.blocks[carrier].body >= 0) make(b.vertices[deepest], nominal, gap);
    return;
  }
  // Slivers of overlap would be soft springs; the nominal area keeps corners from sinking in.
  double total = 0.0;
  for (const QuadraturePoint& q : points) total += q.area;
  const double stiffen = std::max(1.0, 0.5 * nominal / total);
  const Vector on_b = b.vertices[b.shape->faces[facing_face][0]];
  for (const QuadraturePoint& q : points) {
    const Vector foot = origin + q.at.x * s + q.at.y * t;
    const double gap = dot(on_b - foot, nb) / dot(n, nb);
    if (!at_start && gap > 20 * w.detection.reach) continue;  // far side of a tilted block
    make(foot + gap * n, q.area * stiffen, gap);
  }
}

}  // namespace

int family_of(const World& w, const Contact& c, const Vector& normal) {
  if (c.family >= 0 || !w.assembly.family_of) return std::max(c.family, 0);
  return w.assembly.family_of({c.pair.a, c.pair.b, normal});
}

void make_points(const World& w, const Contact& c, const Separation& s, bool at_start, std::vector<NewPoint>& out) {
  // Corner contacts get a nominal area, which keeps corners from sinking in. Blocks that touch along an edge since the
  // start get none, as their neighbours keep them apart (four units around a joint's end). With the nominal area, units
  // could not slide past an edge that protrudes by some micrometres.
  const double nominal =
      c.beside_joint ? 0.0 : std::min(w.blocks[c.pair.a].corner_area, w.blocks[c.pair.b].corner_area);
  const double of_faces = at_start ? 0.0 : nominal;
  const RigidPoints rule = rigid_points_of(w, c, s.normal, at_start);
  if (s.feature == Separation::edges) {
    if (edge_point(w, c.pair, s, nominal, out)) return;
    // Edges that separate the blocks but pass beside each other, as the rims of stacked units do.
    const Placed a = placed(w, c.pair.a), b = placed(w, c.pair.b);
    const int face_of_a = facing(a, s.normal), face_of_b = facing(b, -s.normal);
    if (dot(a.normals[face_of_a], s.normal) >= -dot(b.normals[face_of_b], s.normal))
      face_points(w, c.pair.a, face_of_a, c.pair.b, at_start, of_faces, rule, out);
    else
      face_points(w, c.pair.b, face_of_b, c.pair.a, at_start, of_faces, rule, out);
  } else if (s.feature == Separation::face_of_a) {
    face_points(w, c.pair.a, s.index_a, c.pair.b, at_start, of_faces, rule, out);
  } else {
    face_points(w, c.pair.b, s.index_b, c.pair.a, at_start, of_faces, rule, out);
  }
}

}  // namespace quoin::blocks
