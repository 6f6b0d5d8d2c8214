// From cold input to hot data: shapes, zones, masses, families; the joints of the start.
#include "model/world.h"

#include <fmt/format.h>

#include <map>

#include "base/error.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

bool is_finite(const Vector& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool is_positive(double v) { return v > 0 && std::isfinite(v); }

bool knows_initial_state(const quoin_law& law, const std::string& id) {
  return std::any_of(law.initial_states, law.initial_states + law.initial_state_count,
                     [&](const char* known) { return id == known; });
}

// Held by a plane of symmetry z = 0: gridpoints in z; bodies in z and about x and y.
constexpr uint8_t kPlaneOfNodes = 0x04, kPlaneOfBodies = 0x1c;

bool touches_plane(const ConvexPolyhedron& shape, const Block& block) {
  return std::any_of(shape.vertices.begin(), shape.vertices.end(),
                     [&](const Vector& p) { return (block.position + matrix(block.orientation) * p).z == 0.0; });
}

// So that the first edge, along which shear is measured, is a side of the brick and not the diagonal of a zone.
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

double least_extent_of(const ConvexPolyhedron& s) {
  double least = 1e300;
  for (size_t f = 0; f < s.faces.size(); ++f) {
    double deepest = 0.0;
    for (const Vector& p : s.vertices) deepest = std::max(deepest, dot(s.normals[f], s.vertices[s.faces[f][0]] - p));
    least = std::min(least, deepest);
  }
  return least;
}

// What the triangles of the surface give to the corner gridpoints, m2: a contact there is then no stiffer than a joint.
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

}  // namespace

World::World(const Assembly& assembly, const SolverSettings& solver,
             std::vector<std::shared_ptr<const Material>> materials, Ranks* ranks)
    : assembly_(assembly) {
  part_.ranks = ranks;
  set_solver(solver);
  number(std::move(materials));
  if (!part_.ranks) begin({});
}

void World::set_solver(const SolverSettings& solver) {
  const SolverSettings before = solver_;
  const bool runs = stepping_.critical_dt > 0, books = runs && energy_;
  const double moving = books ? kinetic_energy_of_all() : 0.0;
  solver_ = solver;
  if (runs) solver_.mass_scaling = before.mass_scaling;
  if (books) step_sums_.later.detection += moving - kinetic_energy_of_all();  // goes with the added inertia
  if (solver.damping == DampingKind::local && (solver_.deformation_inertia != 1.0 || solver_.unit_inertia != 1.0)) {
    throw Error(
        Exit::bad_input,
        "damping = \"local\" with deformation_inertia or unit_inertia above 1: slow vibrations inside units would "
        "brake their motion; use damping = \"block\"");
  }
  for (Family& f : contacts_.families) {
    const size_t n = viscous_contacts() ? f.size() : 0;
    for (auto& column : f.old_traction) column = LaneVector<double>(n);
    f.old_jump = LaneVector<double>(n);
    for (auto& column : f.viscous) column = LaneVector<double>(n);
    for (auto& column : f.maxwell) column = LaneVector<double>(has_maxwell() ? f.size() : 0);
  }
  impacts_.maxwell = quoin::maxwell_elements(has_maxwell() ? solver_.maxwell_damping : 0.0, solver_.maxwell_band);
  for (const Contact& c : contacts_.list) {
    if (!viscous_contacts() || c.count == 0 || !owns(c)) continue;
    std::fill_n(contacts_.families[size_t(c.family)].old_jump.begin() + c.first, c.count, std::nan(""));
  }
  bind_columns();
  choose_impact_damping();
  if (runs) find_time_step(true);
}

// Where the next block's numbers begin in each array.
struct World::Counts {
  size_t bodies = 0, nodes = 0, zone_lanes = 0, corners = 0, normals = 0;
  std::map<std::array<double, 11>, int32_t>
      lanes_of;  // congruent blocks share them: shape, material, zones, orientation
  std::map<std::array<double, 6>, std::pair<int, int>> zoned;  // gridpoints and zones by zoning_key
};

// What every process has: settings, how many gridpoints, zones and corners each block has, and where they begin.
void World::number(std::vector<std::shared_ptr<const Material>> materials) {
  if (assembly_.blocks.empty()) throw Error(Exit::bad_input, "the scene has no blocks");
  if (assembly_.families.empty()) throw Error(Exit::bad_input, "the scene has no joint family");
  if (solver_.selective_time_step > 0) {
    throw Error(
        Exit::bad_input,
        "selective_time_step is for the lattice's bricks in small displacements: it adds inertia to gridpoints, which "
        "would change how blocks move as a whole; use deformation_inertia with damping = \"block\", which slows "
        "vibrations alone");
  }
  for (size_t i = 0; i < assembly_.families.size(); ++i) {
    const JointFamily& description = assembly_.families[i];
    adopt(contacts_.families.emplace_back(),
          i < materials.size() && materials[i]
              ? materials[i]
              : std::make_shared<const Material>(Law::find(description.law), description.properties),
          description.initial_state);
  }
  for (const ConvexPolyhedron& shape : assembly_.shapes) {
    ShapeFacts& facts = shapes_.facts.emplace_back();
    facts.mass = mass_properties(shape);
    facts.axes = symmetric_eigen(facts.mass.inertia);
    facts.least_extent = least_extent_of(shape);
    facts.area = 0.0;
    for (size_t f = 0; f < shape.faces.size(); ++f) facts.area += face_area(shape, int(f));
  }
  double least = 1e300;
  Counts counts;
  blocks_.resize(assembly_.blocks.size());
  for (int i = 0; i < block_count(); ++i) {
    number_block(i, counts);
    least = std::min(least, blocks_[size_t(i)].least_extent);
  }
  size_fields(counts);
  find_units();
  find_frames(solver_.internal_forces);
  divide_blocks();
  count_sides();
  const ContactSettings& c = assembly_.contact;
  detection_.size = least;
  detection_.skin = c.skin > 0 ? c.skin : 0.05 * least;
  detection_.reach = detection_.skin / 4;
  detection_.joint_tolerance = c.joint_tolerance > 0 ? c.joint_tolerance : 1e-4 * least;
  small_ = c.small_displacement > 0;
}

void World::number_block(int i, Counts& counts) {
  const Block& input = assembly_.blocks[size_t(i)];
  const auto fault = [&](const std::string& what) {
    return Error(Exit::bad_input, fmt::format("block {}: {}", label(assembly_, i), what));
  };
  if (input.shape < 0 || input.shape >= int(assembly_.shapes.size())) throw fault("has no shape");
  if (input.material < 0 || input.material >= int(assembly_.materials.size())) throw fault("has no material");
  const ConvexPolyhedron& shape = assembly_.shapes[size_t(input.shape)];
  const ShapeFacts& facts = shapes_.facts[size_t(input.shape)];
  const BlockMaterial& m = assembly_.materials[size_t(input.material)];
  const MassProperties& mp = facts.mass;
  if (!(mp.volume > 0)) throw fault(fmt::format("volume {:.3g} m3 must be > 0", mp.volume));
  if (!(m.density > 0)) throw fault(fmt::format("density {} kg/m3 of material '{}' must be > 0", m.density, m.name));
  const Matrix turned = matrix(input.orientation);
  const Vector centroid = input.position + turned * mp.centroid;
  if (!is_finite(centroid) || !is_finite(turned.row[0]) || !is_finite(turned.row[1]) || !is_finite(turned.row[2]))
    throw fault("its place is no finite number; check its position and rotation");
  part_.rough_place.push_back(centroid);

  ModelBlock& b = blocks_[size_t(i)];
  b.shape = &shape;
  b.least_extent = facts.least_extent;
  b.corner_area = facts.area / (3.0 * double(shape.vertices.size()));
  b.first_corner = uint32_t(counts.corners), counts.corners += shape.vertices.size();
  b.first_normal = uint32_t(counts.normals), counts.normals += shape.normals.size();
  const Vector centre = input.rigid ? rigid_mass(input).centre : mp.centroid;
  for (const Vector& p : shape.vertices) b.radius = std::max(b.radius, norm(p - centre));
  b.first_node = int32_t(counts.nodes);
  if (input.rigid) {
    const Body body = body_of(i);
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
    const auto z = zoning_of(i);
    b.node_count = int(z->nodes.size()), b.zone_count = int(z->zones.size());
    if (!input.zoning) counts.zoned[zoning_key(input)] = {b.node_count, b.zone_count};
  } else {
    std::tie(b.node_count, b.zone_count) = known->second;
  }
  counts.nodes += size_t(b.node_count);
  b.first_lanes = int32_t(counts.zone_lanes);
  if (input.zoning) {
    counts.zone_lanes += size_t(b.lanes_count());
    return;
  }
  const Quaternion& q = input.orientation;
  const auto [lanes, is_new] = counts.lanes_of.try_emplace(
      {double(input.shape), double(input.material), input.zone_edge, double(input.divisions[0]),
       double(input.divisions[1]), double(input.divisions[2]), double(input.parity), q.w, q.v.x, q.v.y, q.v.z},
      b.first_lanes);
  b.first_lanes = lanes->second;
  if (is_new) counts.zone_lanes += size_t(b.lanes_count());
}

void World::size_fields(const Counts& counts) {
  bodies_ = LaneVector<Body>(counts.bodies);
  for (auto* field : {&shapes_.corner, &shapes_.placed_corner}) *field = LaneVector<Vector>(counts.corners);
  for (auto* field : {&shapes_.normal, &shapes_.placed_normal}) *field = LaneVector<Vector>(counts.normals);
  for (auto* field : {&nodes_.x, &nodes_.reference, &nodes_.v, &nodes_.held_v})
    *field = LaneVector<Vector>(counts.nodes);
  for (auto* field : {&nodes_.mass, &nodes_.weight_mass}) *field = LaneVector<double>(counts.nodes);
  for (auto* field : {&nodes_.held, &nodes_.support}) *field = LaneVector<uint8_t>(counts.nodes);
  zones_.lanes = LaneVector<ZoneLanes>(counts.zone_lanes);
  poses_.start = poses_.broad = LaneVector<Pose>(blocks_.size());
  frames_.frame = LaneVector<BlockFrame>(blocks_.size());
  step_sums_.contact_force = LaneVector<Vector>(blocks_.size());
  contacts_.of_family.resize(contacts_.families.size());
  part_.laid_out.resize(blocks_.size());
}

void World::begin(std::vector<int> rank_of_block) {
  part_.rank_of_block = std::move(rank_of_block);
  std::vector<double> masses(blocks_.size());
  std::optional<Error> fault;
  try {
    for (int i = 0; i < block_count(); ++i) {
      if (!owns(i)) continue;
      lay_out(i);
      const ModelBlock& b = blocks_[size_t(i)];
      double& mass = masses[size_t(i)];
      if (b.body >= 0) mass = bodies_[size_t(b.body)].weight_mass;
      for (int n = b.first_node; n < b.first_node + b.node_count; ++n) mass += nodes_.weight_mass[size_t(n)];
    }
  } catch (const Error& error) {
    fault = error;
  }
  fail_together(fault);
  gather_by_block(masses);
  for (size_t i = 0; i < blocks_.size(); ++i) blocks_[i].mass = masses[i];
  detect_contacts(true);
  draw_columns();
  set_solver(SolverSettings(solver_));
  find_time_step();
}

double World::density_of(const Block& block) const {
  const double own = assembly_.materials[size_t(block.material)].density;
  return block.spread_mass > 0.0 ? own + block.spread_mass / shapes_.facts[size_t(block.shape)].mass.volume : own;
}

World::RigidMass World::rigid_mass(const Block& block) const {
  const ShapeFacts& facts = shapes_.facts[size_t(block.shape)];
  const double density = density_of(block);
  RigidMass all{density * facts.mass.volume, facts.mass.centroid, {density * facts.axes.values, facts.axes.vectors}};
  if (block.masses.empty()) return all;
  const double own = all.mass;
  const Matrix turned = matrix(block.orientation);
  const auto place_of = [&](const PointMass& point) { return transposed_times(turned, point.at - block.position); };
  Vector moment = own * facts.mass.centroid;
  for (const PointMass& point : block.masses) all.mass += point.mass, moment += point.mass * place_of(point);
  all.centre = moment / all.mass;
  Matrix inertia = density * facts.mass.inertia;
  const auto add = [&](double mass, const Vector& at) {
    const Vector arm = at - all.centre;
    inertia += mass * (dot(arm, arm) * Matrix{} - outer(arm, arm));
  };
  add(own, facts.mass.centroid);
  for (const PointMass& point : block.masses) add(point.mass, place_of(point));
  all.axes = symmetric_eigen(inertia);
  return all;
}

// A rigid block at the start.
Body World::body_of(int block) const {
  const Block& input = assembly_.blocks[size_t(block)];
  const ConvexPolyhedron& shape = assembly_.shapes[size_t(input.shape)];
  const RigidMass own = rigid_mass(input);
  Body body;
  body.x = input.position + matrix(input.orientation) * own.centre;
  body.turn_to(normalized(input.orientation * quaternion(own.axes.vectors)));
  body.weight_mass = own.mass;
  body.mass = body.weight_mass * solver_.mass_scaling;
  body.inertia = solver_.mass_scaling * own.axes.values;
  const bool on_plane = assembly_.symmetry_plane_z0 && touches_plane(shape, input);
  body.support = on_plane ? kPlaneOfBodies : 0;
  body.held = input.fixed ? 0x3f : body.support;
  return body;
}

std::array<double, 6> World::zoning_key(const Block& b) {
  return {double(b.shape),        b.zone_edge,     double(b.divisions[0]), double(b.divisions[1]),
          double(b.divisions[2]), double(b.parity)};
}

std::shared_ptr<const Zoning> World::zoning_of(int block) {
  constexpr size_t kFew = 64;
  const Block& input = assembly_.blocks[size_t(block)];
  if (input.zoning) return input.zoning;
  if (shapes_.zonings.size() > kFew) shapes_.zonings.clear();
  auto& zoning = shapes_.zonings[zoning_key(input)];
  if (!zoning) zoning = std::make_shared<const Zoning>(make_zoning(block));
  return zoning;
}

Zoning World::make_zoning(int block) const {
  const Block& input = assembly_.blocks[size_t(block)];
  if (input.zoning) return *input.zoning;
  const ConvexPolyhedron& shape = assembly_.shapes[size_t(input.shape)];
  return input.divisions[0] > 0 ? make_brick_zones(shape, input.divisions, input.parity, label(assembly_, block))
                                : make_zones(shape, input.zone_edge, label(assembly_, block));
}

// What a block is at the start.
void World::lay_out(int block) {
  if (part_.laid_out[size_t(block)]) return;
  part_.laid_out[size_t(block)] = true;
  const ModelBlock& b = blocks_[size_t(block)];
  if (b.body >= 0) {
    bodies_[size_t(b.body)] = body_of(block);
    const RigidMass own = rigid_mass(assembly_.blocks[size_t(block)]);
    auto corner = shapes_.corner.begin() + b.first_corner;
    for (const Vector& p : b.shape->vertices) *corner++ = transposed_times(own.axes.vectors, p - own.centre);
    auto normal = shapes_.normal.begin() + b.first_normal;
    for (const Vector& n : b.shape->normals) *normal++ = transposed_times(own.axes.vectors, n);
  } else {
    lay_out_zones(block);
  }
  Pose& start = poses_.start[size_t(block)];
  pose(block, start.x, start.r);
  poses_.broad[size_t(block)] = start;
}

void World::lay_out_zones(int block) {
  const Block& input = assembly_.blocks[size_t(block)];
  const BlockMaterial& m = assembly_.materials[size_t(input.material)];
  const Matrix turned = matrix(input.orientation);
  const std::shared_ptr<const Zoning> z = zoning_of(block);
  const double density = density_of(input);
  ModelBlock& b = blocks_[size_t(block)];
  const size_t first = size_t(b.first_node), count = size_t(b.node_count);
  for (size_t n = 0; n < count; ++n) {
    const Vector x = input.position + turned * z->nodes[n];
    nodes_.x[first + n] = nodes_.reference[first + n] = x;
    nodes_.v[first + n] = nodes_.held_v[first + n] = {};
    const bool on_plane = assembly_.symmetry_plane_z0 && x.z == 0.0;
    nodes_.support[first + n] = on_plane ? kPlaneOfNodes : 0;
    nodes_.held[first + n] = uint8_t((input.fixed ? 7 : 0) | nodes_.support[first + n]);
    nodes_.mass[first + n] = 0.0;
  }
  if (zones_in_lanes(b).front().count == 0)
    blocks::lay_out(*z, turned, m, {zones_.lanes.data() + b.first_lanes, size_t(b.lanes_count())});
  for (int k = 0; k < b.zone_count; ++k) {
    const Zone zone = this->zone(block, k);
    for (const int32_t node : zone.node) nodes_.mass[first + size_t(node)] += density * zone.volume / 4;
  }
  for (const PointMass& point : input.masses) {
    for (const auto& [node, share] : shares_at(block, point.at)) nodes_.mass[size_t(node)] += share * point.mass;
  }
  for (size_t n = first; n < first + count; ++n) {
    nodes_.weight_mass[n] = nodes_.mass[n];
    nodes_.mass[n] *= solver_.mass_scaling;
    if (!is_positive(nodes_.mass[n])) {
      throw Error(Exit::bad_input,
                  fmt::format("a gridpoint has the mass {:.3g} kg, which must be finite and > 0; check densities, "
                              "mass_scaling and the sizes of the blocks",
                              nodes_.mass[n]));
    }
  }
  frames_.frame[size_t(block)].transposed_r = transposed(start_of_frame(block));
  b.surface.clear();
  for (Zoning::SurfaceTriangle t : z->surface) {
    if (input.divisions[0] > 0) begin_at_widest_angle(z->nodes, t);
    for (int& n : t.node) n += b.first_node;
    b.surface.push_back(t);
  }
  b.corner_area = area_at_corners(b, nodes_.reference) / (3.0 * double(b.shape->vertices.size()));
  if (b.congruent >= 0 || nodes_.anchor.empty()) return;
  std::ranges::copy(
      anchors_of(std::span(nodes_.reference).subspan(first, count), std::span(nodes_.mass).subspan(first, count)),
      nodes_.anchor.begin() + b.first_node);
}

namespace {

// Shapes that are the same but for rounding have the same number. The grid, a part of the radius, is far finer than any
// strain that matters; its offset keeps round dimensions away from where rounding turns.
std::vector<int> kinds_of_shapes(const std::vector<ConvexPolyhedron>& shapes) {
  constexpr double kGrid = 1e-10, kOffset = 0.2371;
  std::map<std::pair<std::vector<std::vector<int>>, std::vector<int64_t>>, int> known;
  std::vector<int> kinds;
  for (const ConvexPolyhedron& shape : shapes) {
    double radius = 0.0;
    for (const Vector& p : shape.vertices) radius = std::max(radius, norm(p - shape.vertices[0]));
    const double step = kGrid * std::exp2(std::ceil(std::log2(radius)));  // the same for shapes that hardly differ
    std::vector<int64_t> places;
    for (const Vector& p : shape.vertices) {
      for (int k = 0; k < 3; ++k) places.push_back(int64_t(std::floor((p[k] - shape.vertices[0][k]) / step + kOffset)));
    }
    kinds.push_back(known.try_emplace({shape.faces, std::move(places)}, int(known.size())).first->second);
  }
  return kinds;
}

}  // namespace

// The halves of a unit go together: they are of one kind, or each has its own.
void World::find_frames(InternalForces wanted) {
  frames_.by_zone.assign(blocks_.size(), wanted == InternalForces::zones);
  if (wanted == InternalForces::zones) return;
  const std::vector<int> kinds = kinds_of_shapes(assembly_.shapes);
  using Kind = std::array<double, 7>;
  const auto kind_of = [&](int block) {
    const Block& b = assembly_.blocks[size_t(block)];
    return Kind{double(kinds[size_t(b.shape)]), double(b.material),     b.zone_edge,     double(b.divisions[0]),
                double(b.divisions[1]),         double(b.divisions[2]), double(b.parity)};
  };
  std::map<Kind, std::vector<int>> of_kind;
  std::vector<int> distinct;
  for (int i = 0; i < block_count(); ++i) {
    if (blocks_[size_t(i)].body >= 0) continue;
    const Unit unit = units_.of(i);
    const bool is_made_elsewhere = assembly_.blocks[size_t(i)].zoning != nullptr;  // shapes are compared, not zones
    const auto carries_mass = [&](int block) {
      const Block& b = assembly_.blocks[size_t(block)];
      return b.spread_mass > 0.0 || !b.masses.empty();
    };
    if (is_made_elsewhere || carries_mass(unit.block[0]) || carries_mass(unit.block[size_t(unit.count) - 1]) ||
        kind_of(unit.block[0]) != kind_of(unit.block[size_t(unit.count) - 1]))
      distinct.push_back(i);
    else
      of_kind[kind_of(i)].push_back(i);
  }
  for (const auto& [kind, blocks] : of_kind) {
    if (blocks.size() < kFewestAlike) {
      distinct.insert(distinct.end(), blocks.begin(), blocks.end());
      continue;
    }
    for (const int i : blocks) blocks_[size_t(i)].congruent = int32_t(zones_.congruent.size());
    make_congruent(blocks.front());
  }
  if (!distinct.empty()) nodes_.anchor = LaneVector<Vector>(nodes_.x.size());
}

// Turned back to how the shape stands.
void World::make_congruent(int block) {
  lay_out(block);
  const ModelBlock& b = blocks_[size_t(block)];
  const Matrix turned = matrix(assembly_.blocks[size_t(block)].orientation);
  std::vector<Vector> node;
  for (int n = b.first_node; n < b.first_node + b.node_count; ++n)
    node.push_back(transposed_times(turned, nodes_.reference[size_t(n)] - nodes_.reference[size_t(b.first_node)]));
  std::vector<quoin::Zone> zones;
  for (int z = 0; z < b.zone_count; ++z) {
    const Zone from = zone(block, z);
    quoin::Zone& to = zones.emplace_back();
    to.volume = from.volume;
    for (size_t k = 0; k < 4; ++k) {
      to.node[k] = from.node[k];
      to.shape_gradient[k] = array(transposed_times(turned, from.gradient[k]));
    }
  }
  const Zone first = zone(block, 0);
  zones_.congruent.push_back(make_congruent_blocks(node, {nodes_.mass.data() + b.first_node, size_t(b.node_count)},
                                                   zones, first.lambda, first.mu));
}

void World::draw_columns() {
  std::vector<PlacedBlock> placed;
  for (const Block& b : assembly_.blocks) placed.push_back({b.unit, b.course});
  for (size_t k = 0; k < contacts_.families.size(); ++k) {
    const JointFamily& description = assembly_.families[k];
    Family& f = contacts_.families[k];
    if (!description.scatters()) continue;
    std::vector<PlacedPoint> points;
    for (const Point& p : f.point) points.push_back({array(p.at), p.area, p.a, p.b});
    f.columns = draw_properties(description, *f.material, points, placed);
    const quoin_stiffness_bounds bounds = stiffness_bounds_of(description, *f.material, f.columns);
    f.kn = bounds.normal, f.ks = bounds.shear;
  }
}

void World::pose(int block, Vector& x, Matrix& r) const {
  const ModelBlock& b = blocks_[block];
  if (b.body >= 0) {
    x = bodies_[b.body].x, r = bodies_[b.body].r;
    return;
  }
  // Deformable: mean of the corners, and axes along the first face. Strains are small, so any material axes do.
  const auto& face = b.shape->faces[0];
  const Vector* p = nodes_.x.data() + b.first_node;
  x = {};
  const size_t n = b.shape->vertices.size();
  for (size_t i = 0; i < n; ++i) x += p[i];
  x = x / double(n);
  const Vector e1 = normalized(p[face[1]] - p[face[0]]);
  const Vector e3 = normalized(cross(e1, p[face[2]] - p[face[0]]));
  r = Matrix::columns(e1, cross(e3, e1), e3);
}

void World::adopt(Family& f, std::shared_ptr<const Material> material, const std::string& initial_state) {
  f.initial = material->initial_state(initial_state);
  f.dry = knows_initial_state(material->api(), "dry") ? material->initial_state("dry") : f.initial;
  const size_t index = size_t(&f - contacts_.families.data());
  const quoin_stiffness_bounds bounds = stiffness_bounds_of(assembly_.families[index], *material, f.columns);
  f.kn = bounds.normal, f.ks = bounds.shear;
  f.state.resize(material->api().state_count);
  f.material = std::move(material);
}

void World::take_law(int family, std::shared_ptr<const Material> material) {
  const quoin_law& law = material->api();
  const std::string& wanted = assembly_.families[size_t(family)].initial_state;
  adopt(contacts_.families[size_t(family)], std::move(material),
        knows_initial_state(law, wanted) ? wanted : law.initial_states[0]);
}

void World::replace_law(int family, std::shared_ptr<const Material> material, std::span<const double> state,
                        std::span<const double> opening_shift) {
  Family& f = contacts_.families[size_t(family)];
  const double kn = f.kn, ks = f.ks;
  take_back_facets();
  const std::shared_ptr<const Material> old = f.material;
  const size_t old_width = kept_width();
  take_law(family, std::move(material));
  keep_states_by_id(family, old->api(), old_width);
  for (size_t k = 0; k < f.state.size(); ++k)
    f.state[k].assign(state.begin() + long(k * f.size()), state.begin() + long((k + 1) * f.size()));
  for (size_t i = 0; i < f.size(); ++i) {
    // The opening counts from a gap that is smaller by the shift; only rigid planes have it in their offset too.
    Point& p = f.point[i];
    p.reference -= opening_shift[i];
    if (p.facet_a < 0) p.offset -= opening_shift[i];
    f.normal_jump[i] += opening_shift[i];
    if (!f.old_jump.empty()) f.old_jump[i] += opening_shift[i];
  }
  // What the old law has stored stays in the columns if the new one writes none.
  std::fill(f.stored.begin(), f.stored.end(), 0.0);
  for (auto& column : f.dissipated) std::fill(column.begin(), column.end(), 0.0);
  divide_work();
  if (f.kn > kn || f.ks > ks) find_time_step();
}

void World::set_gravity(const Vector& g, TimeSeries factor) {
  actions_.gravity = g, actions_.gravity_factor = std::move(factor);
}

// The motion of what is driven is no kinetic energy: what is let go adds its own, what is caught leaves it to the
// support.
void World::hold(uint8_t& held, uint8_t next, double mass, const Vector& v) {
  const int changed = held ^ next;
  for (int k = 0; changed != 0 && k < 3; ++k)
    if (changed >> k & 1) step_sums_.energies.external += (next >> k & 1 ? -0.5 : 0.5) * mass * v[k] * v[k];
  held = next;
}

void World::prescribe(int block, const Vector& velocity, const Vector& omega, uint8_t held) {
  if (!part_.laid_out[size_t(block)]) return;
  const ModelBlock& b = blocks_[block];
  if (b.body >= 0) {
    Body& body = bodies_[b.body];
    const auto holds_rotation = [](uint8_t bits) { return (bits & 0x38) == 0x38; };
    const int let_go = int(holds_rotation(body.held)) - int(holds_rotation(held | body.support));
    step_sums_.energies.external += let_go * 0.5 * dot(body.momentum, body.omega);
    hold(body.held, held | body.support, body.mass, body.v);
    body.held_v = velocity, body.held_omega = omega;
    return;
  }
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i) {
    hold(nodes_.held[i], uint8_t((held & 7) | nodes_.support[i]), nodes_.mass[i], nodes_.v[i]);
    nodes_.held_v[i] = velocity;
  }
  pieces_.held_changed.push_back(block);
}

void World::release(int block) { prescribe(block, {}, {}, 0); }

void World::set_velocity(int block, const Vector& velocity, const Vector& omega) {
  const ModelBlock& b = blocks_[block];
  if (b.body >= 0) {
    Body& body = bodies_[b.body];
    body.v = velocity, body.omega = omega;
    const Vector w = transposed_times(body.r, omega);
    body.momentum = body.r * Vector{body.inertia.x * w.x, body.inertia.y * w.y, body.inertia.z * w.z};
    return;
  }
  const Vector centre = position(block);
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i)
    nodes_.v[i] = velocity + cross(omega, nodes_.x[i] - centre);
}

void World::add(Load load) {
  if (blocks_.at(load.block).body >= 0) {
    const Pose& start = poses_.start[size_t(load.block)];
    load.arm = transposed_times(start.r, load.point - start.x);
  } else {
    load.share = shares_at(load.block, load.point);
  }
  actions_.loaded[size_t(load.block)] = 1;
  actions_.loads.push_back(std::move(load));
}

// Shape functions of the zone that holds the point, or of the nearest one.
std::vector<std::pair<int32_t, double>> World::shares_at(int block, const Vector& point) const {
  const ModelBlock& b = blocks_[size_t(block)];
  double best = -1e300;
  std::vector<std::pair<int32_t, double>> share;
  for (int z = 0; z < b.zone_count; ++z) {
    const Zone zone = this->zone(block, z);
    const Vector from_first = point - nodes_.reference[size_t(b.first_node + zone.node[0])];
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

void World::add(Pressure pressure) {
  const ModelBlock& b = blocks_.at(pressure.block);
  if (pressure.face < 0 || pressure.face >= int(b.shape->faces.size())) {
    throw Error(Exit::bad_input,
                fmt::format("pressure on block {}: face {} does not exist; there are faces 0 to {}",
                            label(assembly_, pressure.block), pressure.face, b.shape->faces.size() - 1));
  }
  if (b.body >= 0) {
    ConvexPolyhedron local = *b.shape;
    local.vertices.assign(shapes_.corner.begin() + b.first_corner,
                          shapes_.corner.begin() + b.first_corner + long(b.shape->vertices.size()));
    update_normals(local);
    pressure.arm = face_centroid(local, pressure.face);
    pressure.push = -face_area(local, pressure.face) * local.normals[pressure.face];
  } else {
    for (const auto& t : b.surface) {
      if (t.face == pressure.face) pressure.triangles.push_back({t.node[0], t.node[1], t.node[2]});
    }
  }
  actions_.loaded[size_t(pressure.block)] = 1;
  actions_.pressures.push_back(std::move(pressure));
}

void World::apply_force(int block, const Vector& force) {
  if (actions_.applied.empty()) actions_.applied.resize(blocks_.size());
  actions_.applied[size_t(block)] = force;
  actions_.loaded[size_t(block)] = 1;
}

void World::track_energy(bool on) {
  step_sums_.energies = {};
  step_sums_.later = {};
  for (Family& f : contacts_.families) {
    for (auto& column : f.viscous) column = LaneVector<double>(viscous_contacts() ? f.size() : 0);
  }
  book_energy(on);
}

void World::book_energy(bool on) {
  energy_ = on;
  for (Family& f : contacts_.families) {
    f.stored = LaneVector<double>(on ? f.size() : 0);
    for (auto& d : f.dissipated) d = LaneVector<double>(on ? f.size() : 0);
  }
  bind_columns();
}

}  // namespace quoin::blocks
