// Contact detection: which blocks are close, where they touch, and what history a new contact point inherits.
#include <fmt/format.h>

#include "blocks/model.h"
#include "geometry/overlap.h"
#include "scene/error.h"

namespace quoin::blocks {

using namespace geometry;

namespace {
// Faces closer to parallel than this (about 2.5 degrees) at the start can be a joint.
constexpr double parallel_cosine = 0.999;
// Between features that agree within this fraction of the smallest block, the reference face of before is kept.
constexpr double preference_fraction = 1e-4;
// Faces of detected overlap merge points within this fraction of the smallest block.
constexpr double merge_fraction = 1e-6;

// Blocks turned by more than this (rad) end the small-displacement mode: frozen normals would be wrong by as much.
constexpr double small_rotation = 1e-3;

}  // namespace

struct Model::NewPoint {
  Point point;
  Facet facet_a, facet_b;
  bool joint = true;  // within the joint tolerance at the start
};

Placed Model::placed(int block) const {
  const ModelBlock& b = blocks_[block];
  const Vector* v = placed_corner_.data() + b.first_corner;
  Vector centre;
  const size_t n = b.shape->vertices.size();
  for (size_t i = 0; i < n; ++i) centre += v[i];
  return {b.shape, v, placed_normal_.data() + b.first_normal, centre / double(n)};
}

void Model::place_blocks() {
  for (const ModelBlock& b : blocks_) {
    Vector* corner = placed_corner_.data() + b.first_corner;
    Vector* normal = placed_normal_.data() + b.first_normal;
    const size_t corners = b.shape->vertices.size(), faces = b.shape->faces.size();
    if (b.body >= 0) {
      const Body& body = bodies_[b.body];
      for (size_t i = 0; i < corners; ++i) corner[i] = body.x + body.r * corner_[b.first_corner + i];
      for (size_t f = 0; f < faces; ++f) normal[f] = body.r * body_normal_[b.first_normal + f];
      continue;
    }
    for (size_t i = 0; i < corners; ++i) corner[i] = node_x_[size_t(b.first_node) + i];
    for (size_t f = 0; f < faces; ++f) {
      const auto& face = b.shape->faces[f];
      Vector m;
      for (size_t i = 1; i + 1 < face.size(); ++i) {
        m += cross(corner[face[i]] - corner[face[0]], corner[face[i + 1]] - corner[face[0]]);
      }
      normal[f] = normalized(m);
    }
  }
}

// How far b has moved as seen from a since the pair's last narrow detection: translation plus rotation times radius, m.
double Model::pair_motion(const Contact& c) const {
  Vector xa, xb;
  Matrix ra, rb;
  pose(c.pair.a, xa, ra), pose(c.pair.b, xb, rb);
  const Vector shift = transposed_times(ra, xb - xa) - c.relative_x;
  const double angle = angle_between(transposed(ra) * rb, c.relative_r);
  return norm(shift) + angle * std::max(blocks_[c.pair.b].radius, std::min(blocks_[c.pair.a].radius, norm(xb - xa)));
}

double Model::detection_fraction() const {
  return assembly_.contact.small_displacement > 0 ? assembly_.contact.small_displacement : 0.005;
}

double Model::allowed_motion(const Contact& c) const {
  const double extent = std::min(blocks_[c.pair.a].least_extent, blocks_[c.pair.b].least_extent);
  const double fraction = detection_fraction();
  if (c.count == 0) return std::max(fraction * extent, 0.5 * c.separation.distance);
  return (c.initial ? std::max(fraction, assembly_.contact.joint_motion) : fraction) * extent;
}

bool Model::moved_enough() {
  if (step_count_ < next_check_) return false;
  const double fraction = detection_fraction();
  double fastest = 0.0;
  for (const Body& b : bodies_) fastest = std::max(fastest, dot(b.v, b.v));
  for (const ModelBlock& b : blocks_) {
    if (b.body >= 0)
      fastest = std::max(fastest, dot(bodies_[b.body].omega, bodies_[b.body].omega) * b.radius * b.radius);
    if (b.body < 0) fastest = std::max(fastest, dot(node_v_[b.first_node], node_v_[b.first_node]));
  }
  // Looked at again long before anything can have moved by the tolerance, even if it speeds up at 10 g meanwhile.
  const double speed = 2 * std::sqrt(fastest) + 100.0 * 100 * dt_;
  next_check_ = step_count_ + std::clamp(long(0.25 * fraction * size_ / (speed * dt_)), 1l, 100l);

  bool moved = false;
  for (size_t i = 0; i < blocks_.size() && !moved && !small_; ++i) {
    Vector x;
    Matrix r;
    pose(int(i), x, r);
    const double angle = angle_between(r, blocks_[i].broad_r);
    moved = norm(x - blocks_[i].broad_x) + angle * blocks_[i].radius > 0.25 * skin_;
  }
  for (size_t i = 0; i < contacts_.size() && !moved; ++i) {
    const Contact& c = contacts_[i];
    moved = pair_motion(c) > allowed_motion(c);
  }
  // Small displacement also means that no block has come near others that are not its neighbours, and that frozen
  // frames on deformable blocks still point the right way.
  for (size_t i = 0; i < blocks_.size() && !moved && small_; ++i) {
    Vector x;
    Matrix r;
    pose(int(i), x, r);
    moved = norm(x - start_x_[i]) > 0.25 * skin_ || angle_between(r, start_r_[i]) > small_rotation;
  }
  if (moved) small_ = false;  // for good: what has moved once will move again
  return moved;
}

void Model::detect_contacts(bool everything) {
  const bool at_start = detections_ == 0;
  ++detections_;
  place_blocks();

  // Broad phase, when some block has used up its part of the skin.
  bool broad = everything;
  for (size_t i = 0; i < blocks_.size() && !broad; ++i) {
    Vector x;
    Matrix r;
    pose(int(i), x, r);
    const double angle = angle_between(r, blocks_[i].broad_r);
    broad = norm(x - blocks_[i].broad_x) + angle * blocks_[i].radius > 0.2 * skin_;
  }
  std::vector<Pair> pairs;
  if (broad) {
    std::vector<Box> boxes(blocks_.size());
    const Vector inflate{0.5 * skin_, 0.5 * skin_, 0.5 * skin_};
    for (size_t i = 0; i < blocks_.size(); ++i) {
      const ModelBlock& b = blocks_[i];
      for (size_t k = 0; k < b.shape->vertices.size(); ++k) boxes[i].include(placed_corner_[b.first_corner + k]);
      boxes[i].lower -= inflate, boxes[i].upper += inflate;
      pose(int(i), blocks_[i].broad_x, blocks_[i].broad_r);
    }
    pairs = overlapping_pairs(boxes);
    const auto held = [&](int i) {
      return blocks_[i].body >= 0 && bodies_[blocks_[i].body].held == 0x3f && assembly_.blocks[i].fixed;
    };
    std::erase_if(pairs, [&](const Pair& p) { return held(p.a) && held(p.b); });
  } else {
    for (const Contact& c : contacts_) pairs.push_back(c.pair);
  }

  // Narrow phase, for new pairs and those that have moved enough.
  std::vector<Contact> next;
  next.reserve(pairs.size());
  struct Source {
    long old = -1;              // contact of before, or -1
    bool fresh = false;         // points made anew
    size_t begin = 0, end = 0;  // in `made`
  };
  std::vector<Source> sources;
  sources.reserve(pairs.size());
  std::vector<NewPoint> made;
  size_t old_index = 0;
  bool changed = false;
  for (const Pair& pair : pairs) {
    while (old_index < contacts_.size() && contacts_[old_index].pair < pair)
      changed |= contacts_[old_index++].count > 0;
    const bool known = old_index < contacts_.size() && contacts_[old_index].pair == pair;
    Contact c;
    Source source;
    if (known) {
      c = contacts_[old_index];
      source.old = long(old_index++);
      if (!everything && pair_motion(c) <= 0.8 * allowed_motion(c)) {
        next.push_back(c), sources.push_back(source);
        continue;
      }
    }
    c.pair = pair;
    ++narrow_calls_;
    const Placed a = placed(pair.a), b = placed(pair.b);
    c.separation = separate(a, b, skin_, preference_fraction * size_, known ? &c.separation : nullptr);
    Vector xa, xb;
    Matrix ra, rb;
    pose(pair.a, xa, ra), pose(pair.b, xb, rb);
    c.relative_x = transposed_times(ra, xb - xa);
    c.relative_r = transposed(ra) * rb;
    if (at_start && c.separation.distance < -joint_tolerance_) {
      throw Error(
          Exit::bad_input,
          fmt::format(
              "blocks {} and {} overlap by {:.3g} m near {} (more than the joint tolerance {:.3g} m); move or cut one "
              "of them",
              label(assembly_, pair.a), label(assembly_, pair.b), -c.separation.distance,
              place(0.5 * (a.centre + b.centre)), joint_tolerance_));
    }
    source.begin = source.end = made.size();
    if (c.separation.distance <= reach_) {
      make_points(c, at_start, made);
      source.end = made.size();
      source.fresh = true;
    } else if (c.count > 0) {
      // Beyond reach: the points go, unless one still carries something (a joint that stretches further than the skin).
      bool carries = false;
      const Family& f = families_[c.family];
      for (uint32_t i = c.first; i < c.first + c.count; ++i) {
        carries |= f.traction[0][i] != 0.0 || f.traction[1][i] != 0.0 || f.traction[2][i] != 0.0;
      }
      source.fresh = !carries;
    } else {
      source.fresh = true;
    }
    if (source.end > source.begin && c.family < 0) {
      Vector middle;
      for (size_t i = source.begin; i < source.end; ++i) middle += made[i].point.at / double(source.end - source.begin);
      c.family = assembly_.family_of ? assembly_.family_of({pair.a, pair.b, middle, c.separation.normal}) : 0;
      if (c.family >= int(families_.size())) {
        throw Error(Exit::bad_input, fmt::format("blocks {} and {} meet near {}, and no joint family is given for them",
                                                 label(assembly_, pair.a), label(assembly_, pair.b), place(middle)));
      }
    }
    if (c.family < 0) source.end = source.begin;  // declared to pass through each other
    changed |= source.end > source.begin || (source.fresh && c.count > 0);
    next.push_back(c), sources.push_back(source);
  }
  while (old_index < contacts_.size()) changed |= contacts_[old_index++].count > 0;
  if (!changed && !at_start) {
    contacts_ = std::move(next);
    return;
  }

  // New arrays in the order of the pairs; history goes along.
  const double energy_before = energy_ ? energy_of_contacts_now() : 0.0;
  std::vector<Family> old(families_.size());
  std::vector<size_t> count(families_.size(), 0);
  for (size_t i = 0; i < next.size(); ++i) {
    if (next[i].family >= 0)
      count[next[i].family] += sources[i].fresh ? sources[i].end - sources[i].begin : next[i].count;
  }
  for (size_t k = 0; k < families_.size(); ++k) {
    Family& f = families_[k];
    old[k] = f;
    resize(f, count[k]);
  }
  const std::vector<Facet> old_facets = facets_;
  facets_.clear();
  std::vector<uint32_t> fill(families_.size(), 0);
  for (size_t i = 0; i < next.size(); ++i) {
    Contact& c = next[i];
    const Source& source = sources[i];
    if (c.family < 0) {
      c.count = 0;
      continue;
    }
    Family& f = families_[c.family];
    const Family& before = old[c.family];
    const uint32_t first = fill[c.family];
    const auto copy_history = [&](uint32_t from, uint32_t to) {
      for (size_t s = 0; s < f.state.size(); ++s) f.state[s][to] = before.state[s][from];
      for (int k = 0; k < 3; ++k) f.traction[k][to] = before.traction[k][from];
      f.normal_jump[to] = before.normal_jump[from];
      if (!f.old_jump.empty() && !before.old_jump.empty() && !source.fresh) f.old_jump[to] = before.old_jump[from];
      if (!before.stored.empty()) f.stored[to] = before.stored[from];
    };
    const auto carry_facet = [&](int32_t& index) {
      if (index < 0) return;
      facets_.push_back(old_facets[index]);
      index = int32_t(facets_.size()) - 1;
    };
    if (!source.fresh) {
      for (uint32_t k = 0; k < c.count; ++k) {
        f.point[first + k] = before.point[c.first + k];
        copy_history(c.first + k, first + k);
        carry_facet(f.point[first + k].facet_a), carry_facet(f.point[first + k].facet_b);
      }
      fill[c.family] += c.count;
      c.first = first;
      continue;
    }
    const auto in_space = [&](const Point& z, const Vector& v) {
      return z.facet_a >= 0 || blocks_[z.a].body < 0 ? v : bodies_[blocks_[z.a].body].r * v;
    };
    // History is matched by place: old points have moved along with their blocks.
    double old_area = 0.0;
    for (uint32_t k = 0; k < c.count; ++k) old_area += before.point[c.first + k].area;
    const double radius2 = c.count > 0 ? std::max(2.0 * old_area / c.count, 1e-4 * size_ * size_) : 0.0;
    for (size_t k = source.begin; k < source.end; ++k) {
      NewPoint& made_point = made[k];
      const uint32_t to = first + uint32_t(k - source.begin);
      Point& p = f.point[to];
      p = made_point.point;
      if (p.facet_a >= 0) facets_.push_back(made_point.facet_a), p.facet_a = int32_t(facets_.size()) - 1;
      if (p.facet_b >= 0) facets_.push_back(made_point.facet_b), p.facet_b = int32_t(facets_.size()) - 1;
      long nearest = -1;
      double best = radius2;
      for (uint32_t j = 0; j < c.count; ++j) {
        const Vector d = before.point[c.first + j].at - p.at;
        if (dot(d, d) < best) best = dot(d, d), nearest = long(c.first + j);
      }
      if (nearest >= 0) {
        const Point& q = before.point[nearest];
        copy_history(uint32_t(nearest), to);
        const bool open = before.traction[0][nearest] == 0.0 && before.traction[1][nearest] == 0.0 &&
                          before.traction[2][nearest] == 0.0;
        p.reference = c.initial || !open ? q.reference : 0.0;  // an open dry contact starts from the true gap
        // Traction keeps its direction in space: tau is turned from the old frame into the new one. The roles of a and
        // b may have changed with the reference face; sigma and the traction on the block that was a change together
        // with it.
        const double sign = q.a == p.a ? 1.0 : -1.0;
        const Vector tau =
            sign * (before.traction[1][nearest] * in_space(q, q.s) + before.traction[2][nearest] * in_space(q, q.t));
        const Vector s = in_space(p, p.s), t = in_space(p, p.t);
        const double size_before = norm(tau);
        double ts = dot(tau, s), tt = dot(tau, t);
        const double size_after = std::sqrt(ts * ts + tt * tt);
        if (size_after > 0) ts *= size_before / size_after, tt *= size_before / size_after;
        f.traction[1][to] = ts, f.traction[2][to] = tt;
      } else {
        const bool bonded = at_start && made_point.joint;
        const auto& values = bonded ? f.initial : f.dry;
        for (size_t s = 0; s < f.state.size(); ++s) f.state[s][to] = values[s];
        if (!bonded) p.reference = 0.0;
      }
      // The zero of the jumps: d_n counts from the reference gap, slip from here, less what the last step has moved and
      // the law has not seen yet.
      if (p.facet_a < 0) p.offset += p.reference;
      const Location now = locate(p, facets_);
      p.at = now.at;
      for (int axis = 0; axis < 2; ++axis) p.slid[axis] = now.slid[axis];
      if (nearest >= 0) {
        const Point& q = before.point[nearest];
        const Location moved = locate(q, old_facets);
        const Vector pending = in_space(q, (moved.slid[0] - q.slid[0]) * q.s + (moved.slid[1] - q.slid[1]) * q.t);
        const double sign = q.a == p.a ? 1.0 : -1.0;
        p.slid[0] -= sign * dot(pending, in_space(p, p.s)), p.slid[1] -= sign * dot(pending, in_space(p, p.t));
      }
    }
    if (!at_start) keep_energy(f, before, old_facets, c, first, uint32_t(source.end - source.begin));
    c.initial = c.initial || (at_start && source.end > source.begin);
    c.first = first, c.count = uint32_t(source.end - source.begin);
    fill[c.family] += c.count;
  }
  contacts_ = std::move(next);
  // Both sides at the positions of now: what appears or vanishes with the new points is booked, not hidden.
  if (energy_) energies_.detection += energy_before - energy_of_contacts_now();
  divide_work();
  if (!at_start) {
    const double bound = local_stiffness_bound();
    if (bound > 1.01 * stiffness_bound_) find_time_step();
  }
}

void Model::resize(Family& f, size_t n) const {
  f.point.assign(n, {});
  f.normal_jump.assign(n, 0.0);
  for (auto& c : f.slip) c.assign(n, 0.0);
  for (auto& c : f.traction) c.assign(n, 0.0);
  for (auto& c : f.state) c.assign(n, 0.0);
  // Of no use without stiffness damping, and then gone: a stage may have switched it off.
  const size_t viscous = viscous_contacts() ? n : 0;
  for (auto& c : f.old_traction) c.assign(viscous, 0.0);
  f.old_jump.assign(viscous, std::nan(""));  // not known: no rate, no viscous traction in the first step
  if (energy_) {
    f.stored.assign(n, 0.0);
    for (auto& c : f.dissipated) c.assign(n, 0.0);
  }
}

// New points must not hold more energy than those they replace (more area on the same overlap would): the overlap
// counts from a shifted reference, and shear traction is scaled down. Both are estimated with the elastic stiffness;
// the exact change is booked.
void Model::keep_energy(Family& f, const Family& before, const std::vector<Facet>& old_facets, const Contact& c,
                        uint32_t first, uint32_t count) {
  double normal_before = 0.0, normal_after = 0.0, shear_before = 0.0, shear_after = 0.0;
  for (uint32_t i = c.first; i < c.first + c.count; ++i) {
    const Point& q = before.point[i];
    const double d = std::min(0.0, locate(q, old_facets).jump);
    normal_before += q.area * d * d;
    shear_before +=
        q.area * (before.traction[1][i] * before.traction[1][i] + before.traction[2][i] * before.traction[2][i]);
  }
  for (uint32_t i = first; i < first + count; ++i) {
    const double d = std::min(0.0, locate(f.point[i], facets_).jump);
    normal_after += f.point[i].area * d * d;
    shear_after += f.point[i].area * (f.traction[1][i] * f.traction[1][i] + f.traction[2][i] * f.traction[2][i]);
  }
  if (normal_after > normal_before) {
    const double scale = std::sqrt(normal_before / normal_after);
    for (uint32_t i = first; i < first + count; ++i) {
      Point& p = f.point[i];
      const double d = locate(p, facets_).jump;
      if (d >= 0) continue;
      p.reference += (1 - scale) * d;
      if (p.facet_a < 0) p.offset += (1 - scale) * d;
    }
  }
  if (shear_after > shear_before) {
    const double scale = std::sqrt(shear_before / shear_after);
    for (uint32_t i = first; i < first + count; ++i) f.traction[1][i] *= scale, f.traction[2][i] *= scale;
  }
}

// Stored energy that the contact points would have at the positions of now without further slip, and what they would
// dissipate on the way there, J.
double Model::energy_of_contacts_now() {
  double sum = 0.0;
  for (const Family& f : families_) {
    if (f.size() == 0) continue;
    Family trial = f;
    for (size_t i = 0; i < f.size(); ++i) trial.normal_jump[i] = locate(f.point[i], facets_).jump;
    for (auto& slip : trial.slip) std::fill(slip.begin(), slip.end(), 0.0);
    Chunk all;
    all.count = uint32_t(f.size());
    bind(trial, all);
    trial.material->api().evaluate(trial.material->handle(), &all.batch);
    for (size_t i = 0; i < trial.size(); ++i) {
      double density = trial.stored[i];
      for (const auto& d : trial.dissipated) density += d[i];
      sum += density * trial.point[i].area;
    }
  }
  return sum;
}

void Model::make_points(Contact& c, bool at_start, std::vector<NewPoint>& out) {
  const Separation& s = c.separation;
  if (s.feature == Separation::edges) {
    edge_point(c, out);
  } else if (s.feature == Separation::face_of_a) {
    face_points(c.pair.a, s.index_a, c.pair.b, at_start, out);
  } else {
    face_points(c.pair.b, s.index_b, c.pair.a, at_start, out);
  }
}

// Points where the face of `carrier` that looks at `owner` overlaps the face `owner_face`, in the plane of that face.
void Model::face_points(int owner, int owner_face, int carrier, bool at_start, std::vector<NewPoint>& out) {
  const Placed a = placed(owner), b = placed(carrier);
  const Vector n = a.normals[owner_face];
  const auto& corners = a.shape->faces[owner_face];
  const Vector origin = a.vertices[corners[0]];
  const Vector along = a.vertices[corners[1]] - origin;
  const Vector s = normalized(along - dot(along, n) * n), t = cross(n, s);
  const int facing_face = facing(b, -n);
  const Vector nb = b.normals[facing_face];
  const double cosine = -dot(n, nb),
               tolerance = merge_fraction * std::min(blocks_[owner].least_extent, blocks_[carrier].least_extent);
  const auto flat = [&](const Vector& p) { return Point2{dot(s, p - origin), dot(t, p - origin)}; };

  // The patches: whole faces of rigid blocks, surface triangles of deformable ones.
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
    if (blocks_[block].body >= 0) {
      Polygon polygon;
      for (int k : p.shape->faces[face]) polygon.push_back(flat(p.vertices[k]));
      add(polygon);
    } else {
      for (const auto& tri : blocks_[block].surface) {
        if (tri.face == face) add({flat(node_x_[tri.node[0]]), flat(node_x_[tri.node[1]]), flat(node_x_[tri.node[2]])});
      }
    }
    return list;
  };
  std::vector<QuadraturePoint> points;
  if (cosine > 0.05) {
    const std::vector<Patch> pa = patches(owner, a, owner_face, false), pb = patches(carrier, b, facing_face, true);
    const bool rigid = blocks_[owner].body >= 0 && blocks_[carrier].body >= 0;
    Polygon overlap_polygon, scratch;
    std::vector<QuadraturePoint> local;
    for (const Patch& p : pa) {
      for (const Patch& q : pb) {
        if (p.high.x < q.low.x || q.high.x < p.low.x || p.high.y < q.low.y || q.high.y < p.low.y) continue;
        clip(q.polygon, p.polygon, tolerance, overlap_polygon, scratch);
        if (overlap_polygon.empty()) continue;
        local.clear();
        if (rigid && assembly_.contact.point_spacing > 0) {
          grid_rule(overlap_polygon, assembly_.contact.point_spacing, local);
        } else if (rigid && assembly_.contact.cubic_points) {
          cubic_rule(overlap_polygon, local);
        } else {
          vertex_rule(overlap_polygon, local);
        }
        // Linear jumps and shape functions agree across patch borders, so coinciding points are one.
        for (const QuadraturePoint& l : local) add_merged(points, 0, l, 10 * tolerance);
      }
    }
  }
  const double corner_area = std::min(blocks_[owner].corner_area, blocks_[carrier].corner_area);
  const auto make = [&](const Vector& at, double area, double gap) {
    NewPoint made;
    Point& p = made.point;
    p.a = owner, p.b = carrier;
    p.n = n, p.s = s, p.t = t;
    p.area = area, p.at = at;
    // a joint of the start: the gap found there is the reference
    made.joint = at_start && std::abs(gap) <= joint_tolerance_ && cosine > parallel_cosine;
    p.reference = made.joint ? gap : 0.0;
    anchor(made, owner, at - gap * n, owner_face, true);
    anchor(made, carrier, at, facing_face, false);
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
    if (inside && blocks_[carrier].body >= 0) make(b.vertices[deepest], corner_area, gap);
    return;
  }
  // Slivers of overlap would be soft springs; a nominal area keeps corners from sinking in.
  double total = 0.0;
  for (const QuadraturePoint& q : points) total += q.area;
  const double stiffen = at_start ? 1.0 : std::max(1.0, 0.5 * corner_area / total);
  const Vector on_b = b.vertices[b.shape->faces[facing_face][0]];
  for (const QuadraturePoint& q : points) {
    const Vector foot = origin + q.at.x * s + q.at.y * t;
    const double gap = dot(on_b - foot, nb) / dot(n, nb);
    if (!at_start && gap > 20 * reach_) continue;  // far side of a tilted block
    make(foot + gap * n, q.area * stiffen, gap);
  }
}

void Model::edge_point(const Contact& c, std::vector<NewPoint>& out) {
  const Placed a = placed(c.pair.a), b = placed(c.pair.b);
  const auto &ea = a.shape->edges[c.separation.index_a], &eb = b.shape->edges[c.separation.index_b];
  const Vector u = a.vertices[ea.head] - a.vertices[ea.tail], v = b.vertices[eb.head] - b.vertices[eb.tail];
  const auto [pa, pb] = closest_points(a.vertices[ea.tail], u, b.vertices[eb.tail], v);
  NewPoint made;
  Point& p = made.point;
  p.a = c.pair.a, p.b = c.pair.b;
  p.n = c.separation.normal;
  p.s = normalized(u - dot(u, p.n) * p.n), p.t = cross(p.n, p.s);
  p.area = std::min(blocks_[p.a].corner_area, blocks_[p.b].corner_area);
  p.at = pb;
  made.joint = false;
  anchor(made, p.a, pa, ea.left, true);
  anchor(made, p.b, pb, eb.left, false);
  out.push_back(made);
}

// Ties one side of a point to its block: in the body frame of a rigid block, on the nearest surface triangle of a
// deformable one.
void Model::anchor(NewPoint& made, int block, const Vector& at, int face, bool plane_side) {
  Point& p = made.point;
  const ModelBlock& mb = blocks_[block];
  if (mb.body >= 0) {
    const Body& body = bodies_[mb.body];
    if (plane_side) {
      p.n = transposed_times(body.r, p.n), p.s = transposed_times(body.r, p.s), p.t = transposed_times(body.r, p.t);
      p.offset = dot(p.n, transposed_times(body.r, at - body.x));  // of the plane; settle_reference adds the reference
    } else {
      p.arm = transposed_times(body.r, at - body.x);
    }
    return;
  }
  Facet facet{};
  double best = -1e300;
  for (const auto& tri : mb.surface) {
    if (tri.face != face) continue;
    const Vector &x1 = node_x_[tri.node[0]], e2 = node_x_[tri.node[1]] - x1, e3 = node_x_[tri.node[2]] - x1;
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
    p.facet_a = 0;  // numbered when the point is stored
    made.facet_a = facet;
    // edge contacts of deformable blocks keep the plane of the triangle they sit on
    refresh_facet_frame(p, made.facet_a);
  } else {
    p.facet_b = 0;
    made.facet_b = facet;
  }
}

// The frame of a deformable plane side: n of its triangle, s along its first edge.
void Model::refresh_facet_frame(Point& p, Facet& facet) const {
  const Vector &x1 = node_x_[facet.node[0]], e2 = node_x_[facet.node[1]] - x1, e3 = node_x_[facet.node[2]] - x1;
  const double length = norm(e2);
  p.s = e2 / length;
  p.n = normalized(cross(e2, e3));
  p.t = cross(p.n, p.s);
  const double x3 = dot(p.s, e3), y3 = dot(p.t, e3);
  facet.gradient[1][0] = 1 / length, facet.gradient[1][1] = -x3 / (length * y3);
  facet.gradient[2][0] = 0, facet.gradient[2][1] = 1 / y3;
  for (int k = 0; k < 2; ++k) facet.gradient[0][k] = -facet.gradient[1][k] - facet.gradient[2][k];
}

// Where the point is now: place in space, gap from the plane less the reference, position along s and t in a's frame.
Model::Location Model::locate(const Point& p, const std::vector<Facet>& facets) const {
  Location l;
  if (p.facet_b >= 0) {
    const Facet& facet = facets[p.facet_b];
    l.at = facet.weight[0] * node_x_[facet.node[0]] + facet.weight[1] * node_x_[facet.node[1]] +
           facet.weight[2] * node_x_[facet.node[2]];
  } else {
    const Body& b = bodies_[blocks_[p.b].body];
    l.at = b.x + b.r * p.arm;
  }
  if (p.facet_a >= 0) {
    const Facet& facet = facets[p.facet_a];
    const Vector d = l.at - (facet.weight[0] * node_x_[facet.node[0]] + facet.weight[1] * node_x_[facet.node[1]] +
                             facet.weight[2] * node_x_[facet.node[2]]);
    l.jump = dot(p.n, d) - p.reference;
    l.slid[0] = dot(p.s, d), l.slid[1] = dot(p.t, d);
  } else {
    const Body& a = bodies_[blocks_[p.a].body];
    const Vector j = transposed_times(a.r, l.at - a.x);
    l.jump = dot(p.n, j) - p.offset;
    l.slid[0] = dot(p.s, j), l.slid[1] = dot(p.t, j);
  }
  return l;
}

}  // namespace quoin::blocks
