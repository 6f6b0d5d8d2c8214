// Data of a model from its assembly: shapes, zones, masses.
#include "model/block_layout.h"

#include <fmt/format.h>

#include <map>

#include "base/error.h"
#include "model/block_units.h"
#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

bool is_finite(const Vector& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool is_positive(double v) { return v > 0 && std::isfinite(v); }

// Bits held by a plane of symmetry z = 0: z of gridpoints; z of bodies and their rotation about x and y.
constexpr uint8_t kPlaneOfNodes = 0x04, kPlaneOfBodies = 0x1c;

bool touches_plane(const ConvexPolyhedron& shape, const Block& block) {
  return std::any_of(shape.vertices.begin(), shape.vertices.end(),
                     [&](const Vector& p) { return (block.position + matrix(block.orientation) * p).z == 0.0; });
}

// Rotates the triangle's gridpoints so that its first edge, along which shear is measured, is a side of the brick and
// not a diagonal.
void begin_at_widest_angle(const std::vector<Vector>& nodes, Zoning::SurfaceTriangle& t) {
  const auto opposite = [&](int k) {
    const Vector edge = nodes[size_t(t.node[size_t((k + 2) % 3)])] - nodes[size_t(t.node[size_t((k + 1) % 3)])];
    return dot(edge, edge);
  };
  int widest = 0;
  for (int k = 1; k < 3; ++k) {
    if (opposite(k) > opposite(widest)) widest = k;
  }
  std::rotate(t.node.begin(), t.node.begin() + widest, t.node.end());
}

// Mean area of the surface triangles at a corner gridpoint, m2. With it a corner contact is no stiffer than a joint.
double area_at_corners(const ModelBlock& b, const LaneVector<Vector>& x) {
  double sum = 0.0;
  for (const auto& t : b.surface) {
    const double third = norm(cross(x[t.node[1]] - x[t.node[0]], x[t.node[2]] - x[t.node[0]])) / 6;
    for (int node : t.node) {
      if (node - b.first_node < int(b.shape->vertices.size())) sum += third;
    }
  }
  return sum;
}

// Next free index of each array.
struct Counts {
  size_t bodies = 0, nodes = 0, zone_lanes = 0, corners = 0, normals = 0;
  std::map<std::array<double, 11>, int32_t> lanes_of;  // congruent blocks share: shape, material, zones, orientation
  std::map<std::array<double, 6>, std::pair<int, int>> zoned;  // gridpoints and zones by zoning_key
};

// Numbers of shapes; shapes that are equal but for rounding have the same number. The grid is a share of the radius,
// far finer than any strain that matters. Its offset keeps round dimensions away from its borders.
std::vector<int> kinds_of_shapes(const std::vector<ConvexPolyhedron>& shapes) {
  constexpr double kGrid = 1e-10, kOffset = 0.2371;
  std::map<std::pair<std::vector<std::vector<int>>, std::vector<int64_t>>, int> known;
  std::vector<int> kinds;
  for (const ConvexPolyhedron& shape : shapes) {
    double radius = 0.0;
    for (const Vector& p : shape.vertices) radius = std::max(radius, norm(p - shape.vertices[0]));
    const double step = kGrid * std::exp2(std::ceil(std::log2(radius)));  // equal for shapes that hardly differ
    std::vector<int64_t> places;
    for (const Vector& p : shape.vertices) {
      for (int k = 0; k < 3; ++k) places.push_back(int64_t(std::floor((p[k] - shape.vertices[0][k]) / step + kOffset)));
    }
    kinds.push_back(known.try_emplace({shape.faces, std::move(places)}, int(known.size())).first->second);
  }
  return kinds;
}

// A rigid block at the start.
Body make_body(const World& w, int block) {
  const Block& input = w.assembly.blocks[size_t(block)];
  const ConvexPolyhedron& shape = w.assembly.shapes[size_t(input.shape)];
  const RigidMass own = rigid_mass(w, input);
  Body body;
  body.x = input.position + matrix(input.orientation) * own.centre;
  body.turn_to(normalized(input.orientation * quaternion(own.axes.vectors)));
  body.weight_mass = own.mass;
  body.mass = body.weight_mass * w.solver.mass_scaling;
  body.inertia = w.solver.mass_scaling * own.axes.values;
  const bool on_plane = w.assembly.symmetry_plane_z0 && touches_plane(shape, input);
  body.support = on_plane ? kPlaneOfBodies : 0;
  body.held = input.fixed ? 0x3f : body.support;
  return body;
}

std::array<double, 6> zoning_key(const Block& b) {
  return {double(b.shape),        b.zone_edge,     double(b.divisions[0]), double(b.divisions[1]),
          double(b.divisions[2]), double(b.parity)};
}

std::shared_ptr<const Zoning> zoning_of(World& w, int block) {
  constexpr size_t kFew = 64;
  const Block& input = w.assembly.blocks[size_t(block)];
  if (input.zoning) return input.zoning;
  if (w.shapes.zonings.size() > kFew) w.shapes.zonings.clear();
  auto& zoning = w.shapes.zonings[zoning_key(input)];
  if (!zoning) zoning = std::make_shared<const Zoning>(make_zoning(w, block));
  return zoning;
}

void number_block(World& w, int i, Counts& counts) {
  const Block& input = w.assembly.blocks[size_t(i)];
  const auto fault = [&](const std::string& what) {
    return Error(Exit::bad_input, fmt::format("block {}: {}", label(w.assembly, i), what));
  };
  if (input.shape < 0 || input.shape >= int(w.assembly.shapes.size())) throw fault("has no shape");
  if (input.material < 0 || input.material >= int(w.assembly.materials.size())) throw fault("has no material");
  const ConvexPolyhedron& shape = w.assembly.shapes[size_t(input.shape)];
  const ShapeFacts& facts = w.shapes.facts[size_t(input.shape)];
  const BlockMaterial& m = w.assembly.materials[size_t(input.material)];
  const MassProperties& mp = facts.mass;
  if (!(mp.volume > 0)) throw fault(fmt::format("volume {:.3g} m3 must be > 0", mp.volume));
  if (!(m.density > 0)) throw fault(fmt::format("density {} kg/m3 of material '{}' must be > 0", m.density, m.name));
  const Matrix turned = matrix(input.orientation);
  const Vector centroid = input.position + turned * mp.centroid;
  if (!is_finite(centroid) || !is_finite(turned.row[0]) || !is_finite(turned.row[1]) || !is_finite(turned.row[2]))
    throw fault("its place is no finite number; check its position and rotation");
  w.part.rough_place.push_back(centroid);

  ModelBlock& b = w.blocks[size_t(i)];
  b.shape = &shape;
  b.least_extent = facts.least_extent;
  b.corner_area = facts.area / (3.0 * double(shape.vertices.size()));
  b.first_corner = uint32_t(counts.corners), counts.corners += shape.vertices.size();
  b.first_normal = uint32_t(counts.normals), counts.normals += shape.normals.size();
  const Vector centre = input.rigid ? rigid_mass(w, input).centre : mp.centroid;
  for (const Vector& p : shape.vertices) b.radius = std::max(b.radius, norm(p - centre));
  b.first_node = int32_t(counts.nodes);
  if (input.rigid) {
    const Body body = make_body(w, i);
    if (!is_positive(body.mass) || !is_positive(body.inertia.x) || !is_positive(body.inertia.y) ||
        !is_positive(body.inertia.z)) {
      throw fault(
          fmt::format("mass {:.3g} kg and principal inertia {:.3g}, {:.3g}, {:.3g} kg m2 must be finite and > 0; "
                      "check density, mass_scaling and the size of the block",
                      body.mass, body.inertia.x, body.inertia.y, body.inertia.z));
    }
    b.body = int32_t(counts.bodies++);
    return;
  }
  if (!(m.young_modulus > 0) || !(m.poisson_ratio > -1 && m.poisson_ratio < 0.5)) {
    throw fault(fmt::format("deformable: material '{}' needs young_modulus > 0 and -1 < poisson_ratio < 0.5 ({}, {})",
                            m.name, m.young_modulus, m.poisson_ratio));
  }
  const auto known = counts.zoned.find(zoning_key(input));
  if (input.zoning || known == counts.zoned.end()) {
    const auto z = zoning_of(w, i);
    b.node_count = int(z->nodes.size()), b.zone_count = int(z->zones.size());
    if (!input.zoning) counts.zoned[zoning_key(input)] = {b.node_count, b.zone_count};
  } else {
    std::tie(b.node_count, b.zone_count) = known->second;
  }
  counts.nodes += size_t(b.node_count);
  b.lanes_count = (b.zone_count + ZoneLanes::kCount - 1) / ZoneLanes::kCount;
  b.first_lanes = int32_t(counts.zone_lanes);
  if (input.zoning) {
    counts.zone_lanes += size_t(b.lanes_count);
    return;
  }
  const Quaternion& q = input.orientation;
  const auto [lanes, is_new] = counts.lanes_of.try_emplace(
      {double(input.shape), double(input.material), input.zone_edge, double(input.divisions[0]),
       double(input.divisions[1]), double(input.divisions[2]), double(input.parity), q.w, q.v.x, q.v.y, q.v.z},
      b.first_lanes);
  b.first_lanes = lanes->second;
  if (is_new) counts.zone_lanes += size_t(b.lanes_count);
}

void size_fields(World& w, const Counts& counts) {
  w.bodies = LaneVector<Body>(counts.bodies);
  for (auto* field : {&w.shapes.corner, &w.shapes.placed_corner}) *field = LaneVector<Vector>(counts.corners);
  for (auto* field : {&w.shapes.normal, &w.shapes.placed_normal}) *field = LaneVector<Vector>(counts.normals);
  for (auto* field : {&w.nodes.x, &w.nodes.reference, &w.nodes.v, &w.nodes.held_v})
    *field = LaneVector<Vector>(counts.nodes);
  for (auto* field : {&w.nodes.mass, &w.nodes.weight_mass}) *field = LaneVector<double>(counts.nodes);
  for (auto* field : {&w.nodes.held, &w.nodes.support}) *field = LaneVector<uint8_t>(counts.nodes);
  w.zones.lanes = LaneVector<ZoneLanes>(counts.zone_lanes);
  w.poses.start = w.poses.broad = LaneVector<Pose>(w.blocks.size());
  w.frames.frame = LaneVector<BlockFrame>(w.blocks.size());
  w.step_sums.contact_force = LaneVector<Vector>(w.blocks.size());
  w.contacts.of_family.resize(w.contacts.families.size());
  w.part.laid_out.resize(w.blocks.size());
}

// Shared data of congruent blocks, from one of them, rotated back into the frame of the shape.
void make_congruent(World& w, int block) {
  lay_out(w, block);
  const ModelBlock& b = w.blocks[size_t(block)];
  const Matrix turned = matrix(w.assembly.blocks[size_t(block)].orientation);
  std::vector<Vector> node;
  for (int n = b.first_node; n < b.first_node + b.node_count; ++n)
    node.push_back(transposed_times(turned, w.nodes.reference[size_t(n)] - w.nodes.reference[size_t(b.first_node)]));
  std::vector<quoin::Zone> zones;
  for (int z = 0; z < b.zone_count; ++z) {
    const Zone from = zone_of(w, block, z);
    quoin::Zone& to = zones.emplace_back();
    to.volume = from.volume;
    for (size_t k = 0; k < 4; ++k) {
      to.node[k] = from.node[k];
      to.shape_gradient[k] = array(transposed_times(turned, from.gradient[k]));
    }
  }
  const Zone first = zone_of(w, block, 0);
  w.zones.congruent.push_back(make_congruent_blocks(node, {w.nodes.mass.data() + b.first_node, size_t(b.node_count)},
                                                    b.shape->vertices.size(), zones, first.lambda, first.mu));
}

// Chooses the blocks that share a stiffness. Both halves of a unit share one with others, or each half has its own.
void find_frames(World& w, InternalForces wanted) {
  w.frames.by_zone.assign(w.blocks.size(), wanted == InternalForces::zones);
  if (wanted == InternalForces::zones) return;
  const std::vector<int> kinds = kinds_of_shapes(w.assembly.shapes);
  using Kind = std::array<double, 7>;
  const auto kind_of = [&](int block) {
    const Block& b = w.assembly.blocks[size_t(block)];
    return Kind{double(kinds[size_t(b.shape)]), double(b.material),     b.zone_edge,     double(b.divisions[0]),
                double(b.divisions[1]),         double(b.divisions[2]), double(b.parity)};
  };
  const auto is_shape_alone = [&](int block) {  // kinds compare neither masses nor zones that are made elsewhere
    const Block& b = w.assembly.blocks[size_t(block)];
    return b.spread_mass == 0.0 && b.masses.empty() && b.zoning == nullptr;
  };
  const auto each_deformable = [&](const auto& visit) {
    for (int i = 0; i < w.block_count(); ++i) {
      if (w.blocks[size_t(i)].body < 0) visit(i, w.units.of(i));
    }
  };
  std::map<Kind, size_t> count;
  each_deformable([&](int block, const Unit& unit) {
    if (std::ranges::all_of(unit.blocks(), is_shape_alone)) ++count[kind_of(block)];
  });
  const auto shares = [&](int block) { return is_shape_alone(block) && count[kind_of(block)] >= kFewestCongruent; };
  std::map<Kind, std::vector<int>> of_kind;
  bool some_distinct = false;
  each_deformable([&](int block, const Unit& unit) {
    if (std::ranges::all_of(unit.blocks(), shares))
      of_kind[kind_of(block)].push_back(block);
    else
      some_distinct = true;
  });
  for (const auto& [kind, blocks] : of_kind) {
    for (const int i : blocks) w.blocks[size_t(i)].congruent = int32_t(w.zones.congruent.size());
    make_congruent(w, blocks.front());
  }
  if (some_distinct) w.nodes.anchor = LaneVector<Vector>(w.nodes.x.size());
}

}  // namespace

void number_blocks(World& w) {
  for (const ConvexPolyhedron& shape : w.assembly.shapes) {
    ShapeFacts& facts = w.shapes.facts.emplace_back();
    facts.mass = mass_properties(shape);
    facts.axes = symmetric_eigen(facts.mass.inertia);
    facts.least_extent = least_extent(shape);
    facts.area = 0.0;
    for (size_t f = 0; f < shape.faces.size(); ++f) facts.area += face_area(shape, int(f));
  }
  double least = 1e300;
  Counts counts;
  w.blocks.resize(w.assembly.blocks.size());
  for (int i = 0; i < w.block_count(); ++i) {
    number_block(w, i, counts);
    least = std::min(least, w.blocks[size_t(i)].least_extent);
  }
  size_fields(w, counts);
  find_units(w);
  find_frames(w, w.solver.internal_forces);
  const ContactSettings& c = w.assembly.contact;
  w.is_small = c.small_displacement > 0;
  w.frames.fixed.assign(w.blocks.size(), 0);
  for (int i = 0; w.is_small && i < w.block_count(); ++i)
    w.frames.fixed[size_t(i)] = w.blocks[size_t(i)].congruent >= 0;
  divide_blocks(w);
  count_sides(w);
  w.detection.size = least;
  w.detection.skin = c.skin > 0 ? c.skin : 0.05 * least;
  w.detection.reach = w.detection.skin / 4;
  w.detection.joint_tolerance = joint_tolerance_of(w.assembly);
  if (w.detection.joint_tolerance > w.detection.reach)
    throw Error(
        Exit::bad_input,
        fmt::format("contact.joint_tolerance = {:g} m: allowed: at most {:g} m, a quarter of contact.skin: faces "
                    "further apart get no contact points; give a larger skin too",
                    w.detection.joint_tolerance, w.detection.reach));
}

double density_of(const World& w, const Block& block) {
  const double own = w.assembly.materials[size_t(block.material)].density;
  return block.spread_mass > 0.0 ? own + block.spread_mass / w.shapes.facts[size_t(block.shape)].mass.volume : own;
}

RigidMass rigid_mass(const World& w, const Block& block) {
  const ShapeFacts& facts = w.shapes.facts[size_t(block.shape)];
  const double density = density_of(w, block);
  const Matrix turned = matrix(block.orientation);
  const auto place_of = [&](const Vector& at) { return transposed_times(turned, at - block.position); };
  const Vector centre = block.centre ? place_of(*block.centre) : facts.mass.centroid;
  RigidMass all{density * facts.mass.volume, centre, centre, {density * facts.axes.values, facts.axes.vectors}};
  if (block.masses.empty()) return all;
  const double own = all.mass;
  Vector moment = own * centre;
  for (const PointMass& point : block.masses) all.mass += point.mass, moment += point.mass * place_of(point.at);
  all.centre = moment / all.mass;
  Matrix inertia = density * facts.mass.inertia;
  const auto add = [&](double mass, const Vector& at) {
    const Vector arm = at - all.centre;
    inertia += mass * (dot(arm, arm) * Matrix{} - outer(arm, arm));
  };
  add(own, centre);
  for (const PointMass& point : block.masses) add(point.mass, place_of(point.at));
  all.axes = symmetric_eigen(inertia);
  return all;
}

Zoning make_zoning(const World& w, int block) {
  const Block& input = w.assembly.blocks[size_t(block)];
  if (input.zoning) return *input.zoning;
  const ConvexPolyhedron& shape = w.assembly.shapes[size_t(input.shape)];
  return input.divisions[0] > 0 ? make_brick_zones(shape, input.divisions, input.parity, label(w.assembly, block))
                                : make_zones(shape, input.zone_edge, label(w.assembly, block));
}

namespace {

void lay_out_zones(World& w, int block) {
  const Block& input = w.assembly.blocks[size_t(block)];
  const BlockMaterial& m = w.assembly.materials[size_t(input.material)];
  const Matrix turned = matrix(input.orientation);
  const std::shared_ptr<const Zoning> z = zoning_of(w, block);
  const double density = density_of(w, input);
  ModelBlock& b = w.blocks[size_t(block)];
  const size_t first = size_t(b.first_node), count = size_t(b.node_count);
  for (size_t n = 0; n < count; ++n) {
    const Vector x = input.position + turned * z->nodes[n];
    w.nodes.x[first + n] = w.nodes.reference[first + n] = x;
    w.nodes.v[first + n] = w.nodes.held_v[first + n] = {};
    const bool on_plane = w.assembly.symmetry_plane_z0 && x.z == 0.0;
    w.nodes.support[first + n] = on_plane ? kPlaneOfNodes : 0;
    w.nodes.held[first + n] = uint8_t((input.fixed ? 7 : 0) | w.nodes.support[first + n]);
    w.nodes.mass[first + n] = 0.0;
  }
  if (w.zones.lanes_of(b).front().count == 0)
    blocks::lay_out(*z, turned, m, {w.zones.lanes.data() + b.first_lanes, size_t(b.lanes_count)});
  for (int k = 0; k < b.zone_count; ++k) {
    const Zone zone = zone_of(w, block, k);
    for (const int32_t node : zone.node) w.nodes.mass[first + size_t(node)] += density * zone.volume / 4;
  }
  for (const PointMass& point : input.masses) {
    for (const auto& [node, share] : shares_at(w, block, point.at)) w.nodes.mass[size_t(node)] += share * point.mass;
  }
  for (size_t n = first; n < first + count; ++n) {
    w.nodes.weight_mass[n] = w.nodes.mass[n];
    w.nodes.mass[n] *= w.solver.mass_scaling;
    if (!is_positive(w.nodes.mass[n])) {
      throw Error(Exit::bad_input,
                  fmt::format("a gridpoint has the mass {:.3g} kg, which must be finite and > 0; check densities, "
                              "mass_scaling and the sizes of the blocks",
                              w.nodes.mass[n]));
    }
  }
  w.frames.frame[size_t(block)].transposed_r = transposed(start_of_frame(w, block));
  b.surface.clear();
  b.surface.reserve(z->surface.size());
  for (Zoning::SurfaceTriangle t : z->surface) {
    if (input.divisions[0] > 0) begin_at_widest_angle(z->nodes, t);
    for (int& n : t.node) n += b.first_node;
    b.surface.push_back(t);
  }
  b.corner_area = area_at_corners(b, w.nodes.reference) / (3.0 * double(b.shape->vertices.size()));
  if (b.congruent >= 0 || w.nodes.anchor.empty()) return;
  const size_t corners = b.shape->vertices.size();
  std::ranges::copy(
      anchors_of(std::span(w.nodes.reference).subspan(first, corners), std::span(w.nodes.mass).subspan(first, corners)),
      w.nodes.anchor.begin() + b.first_node);
}

}  // namespace

// Lays out the data of a block at the start.
void lay_out(World& w, int block) {
  if (w.part.laid_out[size_t(block)]) return;
  w.part.laid_out[size_t(block)] = true;
  const ModelBlock& b = w.blocks[size_t(block)];
  if (b.body >= 0) {
    w.bodies[size_t(b.body)] = make_body(w, block);
    const RigidMass own = rigid_mass(w, w.assembly.blocks[size_t(block)]);
    w.blocks[size_t(block)].load_arm = transposed_times(own.axes.vectors, own.load_place - own.centre);
    auto corner = w.shapes.corner.begin() + b.first_corner;
    for (const Vector& p : b.shape->vertices) *corner++ = transposed_times(own.axes.vectors, p - own.centre);
    auto normal = w.shapes.normal.begin() + b.first_normal;
    for (const Vector& n : b.shape->normals) *normal++ = transposed_times(own.axes.vectors, n);
  } else {
    lay_out_zones(w, block);
  }
  w.poses.start[size_t(block)] = w.poses.broad[size_t(block)] = pose(w, block);
}

Pose pose(const World& w, int block) {
  const ModelBlock& b = w.blocks[size_t(block)];
  if (b.body >= 0) return {w.bodies[size_t(b.body)].x, w.bodies[size_t(b.body)].r};
  // Deformable: mean of the corners, and axes along the first face. Strains are small, so any axes fixed in the
  // material serve.
  const auto& face = b.shape->faces[0];
  const Vector* p = w.nodes.x.data() + b.first_node;
  Vector x;
  const size_t n = b.shape->vertices.size();
  for (size_t i = 0; i < n; ++i) x += p[i];
  const Vector e1 = normalized(p[face[1]] - p[face[0]]);
  const Vector e3 = normalized(cross(e1, p[face[2]] - p[face[0]]));
  return {x / double(n), Matrix::columns(e1, cross(e3, e1), e3)};
}

// Shape functions of the zone that contains the point, or of the nearest zone.
std::vector<std::pair<int32_t, double>> shares_at(const World& w, int block, const Vector& point) {
  const ModelBlock& b = w.blocks[size_t(block)];
  double best = -1e300;
  std::vector<std::pair<int32_t, double>> share;
  for (int z = 0; z < b.zone_count; ++z) {
    const Zone zone = zone_of(w, block, z);
    const Vector from_first = point - w.nodes.reference[size_t(b.first_node + zone.node[0])];
    double n[4], least = 1e300;
    for (int k = 0; k < 4; ++k) {
      n[k] = (k == 0 ? 1.0 : 0.0) + dot(zone.gradient[k], from_first);
      least = std::min(least, n[k]);
    }
    if (least <= best) continue;
    best = least;
    share.clear();
    for (int k = 0; k < 4; ++k) share.push_back({b.first_node + zone.node[k], n[k]});
    if (least >= -1e-9) break;
  }
  return share;
}

}  // namespace quoin::blocks
