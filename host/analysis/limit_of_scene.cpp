#include "analysis/limit_of_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "base/clock.h"
#include "base/error.h"
#include "base/upright_axis.h"
#include "files/notice.h"
#include "geometry/polyhedron.h"
#include "law/law_library.h"
#include "law/property_text.h"
#include "members/linear.h"
#include "members/members.h"
#include "model/contact_frames.h"
#include "model/new_points.h"
#include "model/placed_blocks.h"
#include "scene/driven.h"
#include "scene/generate.h"
#include "scene/generate_blocks.h"
#include "scene/load_place.h"
#include "step/assembly.h"
#include "step/findings.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "step/simulation.h"

namespace quoin {
namespace {

using geometry::Vector;

constexpr const char* kMultiplied[] = {"weight", "forces", "pressures", "loads", "motion"};  // as the enum

// Velocity at which a stage moves a body; 0 where it does not.
Vector motion_of(const BodyControl& control) {
  Vector motion;
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (control.kind[i] == DofKind::velocity) motion[c] = control.velocity[i];
  }
  return motion;
}

// Force on a body along its free components.
Vector force_of(const BodyControl& control) {
  Vector force;
  for (std::size_t c = 0; c < 3; ++c)
    if (control.kind[c] != DofKind::velocity) force[static_cast<int>(c)] = control.force[c];
  return force;
}

bool multiplies_forces(Multiplied multiplied) {
  return multiplied == Multiplied::forces || multiplied == Multiplied::loads;
}
bool multiplies_pressures(Multiplied multiplied) {
  return multiplied == Multiplied::pressures || multiplied == Multiplied::loads;
}

bool has_multiplied(const Stage& stage, Multiplied multiplied) {
  const bool pushes = std::ranges::any_of(stage.controls, [](const BodyControl& c) { return norm(force_of(c)) > 0.0; });
  const bool moves = std::ranges::any_of(stage.controls, [](const BodyControl& c) { return norm(motion_of(c)) > 0.0; });
  return (multiplies_forces(multiplied) && !stage.forces.empty()) ||
         (multiplies_pressures(multiplied) && !stage.pressures.empty()) ||
         (multiplied == Multiplied::loads && pushes) ||
         (multiplied == Multiplied::motion && (moves || stage.whiffletree));
}

const Stage& moving_stage(const Scene& scene, const LimitOptions& options) {
  if (options.stage && options.stage->moving_load) return *options.stage;
  for (const Stage& stage : scene.stages)
    if (stage.moving_load) return stage;
  throw Error(Exit::bad_input,
              fmt::format("{}: no stage has a moving load; give one moving_load = {{ from = [x, y, z], "
                          "to = [x, y, z], force = [x, y, z] }}",
                          scene.file));
}

// Refuses a stage that turns a body where its motion is multiplied.
void refuse_turns(const Stage& stage) {
  const auto turns = std::ranges::find_if(stage.controls, [](const BodyControl& c) { return c.omega != Vec3{}; });
  if (turns == stage.controls.end()) return;
  throw Error(Exit::bad_input,
              fmt::format("{}: limit: the stage turns '{}'; motions with omega cannot be multiplied, as the multiplier "
                          "of a motion is a force along it. Give velocity alone. For ground that tilts, --direction "
                          "gives the tangent of the angle at which dry joints fail",
                          stage.source.text, turns->body));
}

// The stage with the loads that are multiplied.
const Stage& stage_with_loads(const Scene& scene, const LimitOptions& options) {
  const auto has = [&](const Stage& stage) { return has_multiplied(stage, options.multiplied); };
  const auto asked = options.stage ? std::span(options.stage, 1) : std::span(scene.stages);
  const auto found = std::ranges::find_if(asked, has);
  if (found != asked.end()) return *found;
  if (options.multiplied == Multiplied::motion) std::ranges::for_each(asked, refuse_turns);
  throw Error(
      Exit::bad_input,
      fmt::format("{} {} to multiply; give it [[stage.force]], [[stage.pressure]] or [[stage.velocity]]",
                  options.stage ? options.stage->source.text + ": the stage has no" : scene.file + ": no stage has",
                  name_of(options.multiplied)));
}

// The stage whose gravity and loads count. For the weight it is the first collapse stage, or else the first with
// gravity.
const Stage& stage_that_counts(const Scene& scene, const LimitOptions& options) {
  if (options.multiplied != Multiplied::weight) return stage_with_loads(scene, options);
  if (options.stage) {
    if (options.stage->gravity != Vec3{}) return *options.stage;
    throw Error(Exit::bad_input,
                fmt::format("{}: the stage has no gravity, whose weight would be multiplied; give it gravity = [0, "
                            "-9.81, 0]",
                            options.stage->source.text));
  }
  if (options.moving && moving_stage(scene, options).gravity != Vec3{}) return moving_stage(scene, options);
  const Stage* loaded = nullptr;
  for (const Stage& stage : scene.stages) {
    if (stage.gravity != Vec3{} && (stage.collapse || !loaded)) loaded = &stage;
    if (stage.collapse) break;
  }
  if (loaded) return *loaded;
  throw Error(Exit::bad_input, fmt::format("{}: no stage has gravity; give one stage gravity = [0, -9.81, 0], or "
                                           "multiply other loads (--multiply motion, "
                                           "forces, pressures)",
                                           scene.file));
}

// Direction in which the weight is multiplied, if any.
std::optional<Vector> direction_of(const Scene& scene, const LimitOptions& options) {
  if (options.multiplied != Multiplied::weight) return std::nullopt;
  if (!options.direction.empty()) return Vector{options.direction[0], options.direction[1], options.direction[2]};
  if (options.stage && options.stage->collapse) return geometry::vector(options.stage->collapse->direction);
  const auto found = std::ranges::find_if(scene.stages, [](const Stage& s) { return s.collapse.has_value(); });
  return found == scene.stages.end() ? std::nullopt : std::optional(geometry::vector(found->collapse->direction));
}

// Returns the stage with this gravity, whose loads count.
const Stage& find_loads(const Scene& scene, const LimitOptions& options, SceneLimit* limit) {
  limit->halved = scene.wall && scene.wall->half_thickness;
  const Stage& loaded = stage_that_counts(scene, options);
  limit->stage = loaded.name, limit->gravity = geometry::vector(loaded.gravity);
  limit->direction = direction_of(scene, options);
  if (limit->direction && !(norm(*limit->direction) > 0.0 && std::isfinite(norm(*limit->direction))))
    throw Error(Exit::bad_input,
                fmt::format("{}: the direction of the load is no direction: --direction X Y Z, not all 0", scene.file));
  if (limit->halved && limit->direction && limit->direction->z != 0.0)
    throw Error(Exit::bad_input,
                fmt::format("{}: limit: the load acts along z, across the plane of symmetry of a wall with "
                            "half_thickness = true; make wall.half_thickness false, or z of --direction 0",
                            scene.file));
  if (limit->direction) limit->direction = normalized(*limit->direction);
  if (!std::isfinite(options.given)) throw Error(Exit::bad_input, "limit: the given multiplier is not a finite number");
  if (options.given != 0.0 && !limit->direction && options.multiplied == Multiplied::weight)
    throw Error(Exit::bad_input,
                fmt::format("{}: a multiplier is given and no direction: no collapse stage says in which direction the "
                            "load acts; give --direction X Y Z",
                            scene.file));
  return loaded;
}

// Forces, pressures and loads of bodies of a stage.
void add_loads(const Stage& stage, Multiplied multiplied, const blocks::Assembly& assembly, SceneLimit* limit) {
  for (const PointForce& force : stage.forces) {
    const Vector at = geometry::vector(force.point);
    limit->loads.push_back({blocks::block_at(assembly, force.block, at, stage.source.text), at,
                            geometry::vector(force.force), multiplies_forces(multiplied)});
  }
  for (const FacePressure& pressure : stage.pressures) {
    for (const blocks::BlockFace& pressed :
         blocks::outer_faces(assembly, pressure.block, geometry::vector(pressure.normal), stage.source.text)) {
      members::each_triangle(assembly, pressed.block, static_cast<std::size_t>(pressed.face),
                             [&](const std::array<Vector, 3>& corner) {
                               const Vector area = 0.5 * cross(corner[1] - corner[0], corner[2] - corner[0]);
                               limit->loads.push_back({pressed.block, (corner[0] + corner[1] + corner[2]) / 3.0,
                                                       -pressure.pressure * area, multiplies_pressures(multiplied)});
                             });
    }
  }
  for (const BodyControl& control : stage.controls) {
    const Vector force = force_of(control);
    if (norm(force) == 0.0) continue;
    for (const int block : blocks::find_blocks(assembly, control.body, stage.source.text))
      limit->loads.push_back(
          {block, limit->load_places[static_cast<std::size_t>(block)], force, multiplied == Multiplied::loads});
  }
}

// Brittle strength of a joint family, from its law's properties; 0, or no crushing, where the law has no such property.
struct Strength {
  double friction = 0.0, tension = 0.0, cohesion = 0.0;  // -, Pa, Pa
  double crushing = std::numeric_limits<double>::infinity();
};

// Strengths of the points of a family: one set, or one a point where properties scatter.
class Strengths {
 public:
  Strengths(const JointFamily& family, const std::vector<PropertyColumn>& columns, const std::string& file)
      : joints_(fmt::format("{}: joints.{}", file, family.name)),
        material_(Law::find(family.law), family.properties),
        dry_(family.initial_state == "dry"),
        columns_(columns),
        of_all_(at(std::nullopt)) {
    if (!has("friction_angle"))
      throw Error(Exit::bad_input,
                  fmt::format("{}: law '{}' has no friction_angle, so its joints have no limit; "
                              "choose coulomb_slip, fracture_energy or cyclic_joint (--law), for glue inside a unit "
                              "coulomb_slip with a cohesion and tensile_strength of 1e9",
                              joints_, family.law));
  }
  // point: index within the family
  Strength of(std::size_t point) const { return columns_.empty() ? of_all_ : at(point); }

 private:
  bool has(const char* id) const { return find_property(material_.api(), id) != nullptr; }
  double number(const char* id, std::optional<std::size_t> point) const {
    const auto column = std::ranges::find(columns_, std::string_view(id), &PropertyColumn::id);
    const bool scatters = point && column != columns_.end() && *point < column->values.size();
    return scatters ? column->values[*point] : material_.number(id);
  }
  Strength at(std::optional<std::size_t> point) const {
    const auto find = [&](const char* id, double& value) {
      if (has(id)) value = number(id, point);
    };
    Strength s;
    double degrees = 0.0;  // strengths of dry joints have softened
    find("friction_angle", degrees);
    if (dry_) find("friction_angle_residual", degrees);
    s.friction = std::tan(std::numbers::pi / 180.0 * degrees);
    if (!dry_) find("tensile_strength", s.tension);
    find(dry_ ? "cohesion_residual" : "cohesion", s.cohesion);
    find("compressive_strength", s.crushing);
    if (!(s.crushing > 0.0))
      throw Error(Exit::bad_input,
                  fmt::format("{}: compressive_strength = {:g} Pa: such joints carry no pressure, so nothing stands on "
                              "them; limit analysis takes values above 0. Give the strength, or leave it out for "
                              "joints that do not crush",
                              joints_, s.crushing));
    return s;
  }

  std::string joints_;  // for messages
  Material material_;
  bool dry_;
  const std::vector<PropertyColumn>& columns_;
  Strength of_all_;
};

// Columns of a family's properties that scatter, and the index of its first point among all.
std::pair<const std::vector<PropertyColumn>&, std::size_t> columns_of(const Simulation& simulation, int family) {
  const auto f = static_cast<std::size_t>(family);
  const blocks::Model* const shapes = simulation.large_motion();
  if (!shapes) {
    const ContactFamily& found = simulation.model().families[f];
    return {found.columns, static_cast<std::size_t>(found.first_point)};
  }
  std::size_t before = 0;
  for (std::size_t k = 0; k < f; ++k) before += shapes->contacts.families[k].size();
  return {shapes->contacts.families[f].columns, before};
}

void refuse_members(const members::Members& members, const std::string& file) {
  if (!members.beds().empty())
    throw Error(Exit::bad_input, fmt::format("{}: blocks on [[spring]] stand on no strength that limit analysis knows; "
                                             "give what is below them fixed = true instead",
                                             file));
  if (!members.strips().empty())
    throw Error(Exit::bad_input, fmt::format("{}: [[strip]] debonds by softening, which limit analysis does not know; "
                                             "leave strips out, or run the scene",
                                             file));
}

// Ties: any force up to yield, without hardening.
void add_ties(const members::Members& members, SceneLimit* limit) {
  for (const members::Tie& tie : members.ties()) {
    LimitForce force{{}, tie.law.compression ? -tie.law.yield : 0.0, tie.law.yield, tie.law.pretension};
    for (std::size_t i = 0; i + 1 < tie.stops.size(); ++i) {
      const Vector along =
          normalized(start_of(members.nodes(), tie.stops[i + 1]) - start_of(members.nodes(), tie.stops[i]));
      const auto pull = [&](const members::Tie::Stop& stop, double sign) {
        for (const auto& [index, share] : stop) {
          const members::Node& node = members.nodes()[static_cast<std::size_t>(index)];
          force.places.push_back({node.block, node.start, sign * share * along, {}});
        }
      };
      pull(tie.stops[i], 1.0), pull(tie.stops[i + 1], -1.0);
    }
    limit->problem.forces.push_back(force);
    limit->tie_names.push_back(tie.name);
  }
}

// A reaction without bound on a block, along `way` and about `turn`.
void hold(int block, const Vector& at, const Vector& way, const Vector& turn, SceneLimit* limit) {
  limit->problem.forces.push_back({{{block, at, way, turn}}});
}

// Reaction of the ground along the directions in which a node is not free.
void guide(int block, const Vector& at, const std::vector<Vector>& free, bool turns, SceneLimit* limit) {
  std::vector<Vector> held;
  if (free.empty()) held = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (free.size() == 2) held = {cross(free[0], free[1])};
  for (const Vector& way : held) turns ? hold(block, at, {}, way, limit) : hold(block, at, way, {}, limit);
}

// A plane of symmetry at z = 0 leaves a block motions along x and y, and rotation about z.
void keep_on_plane(SceneLimit* limit) {
  for (std::size_t k = 0; k < limit->block_count; ++k) {
    const LimitBlock& block = limit->problem.blocks[k];
    if (block.fixed) continue;
    const auto i = static_cast<int>(k);
    guide(i, block.centre, {{1, 0, 0}, {0, 1, 0}}, false, limit);
    for (const Vector& axis : {Vector{1, 0, 0}, Vector{0, 1, 0}}) hold(i, block.centre, {}, axis, limit);
  }
}

// Directions of the held axes 0..2, but for that of the motion.
std::vector<Vector> held_ways(unsigned held, const Vector& motion) {
  constexpr double kAnother = 1e-6;  // length of what is left of an axis that counts as a direction of its own
  std::vector<Vector> ways;
  const bool moves = norm(motion) > 0.0;
  if (moves) ways.push_back(normalized(motion));
  for (int c = 0; c < 3; ++c) {
    Vector way;
    way[c] = 1.0;
    for (const Vector& other : ways) way = way - dot(way, other) * other;
    if ((held >> c & 1u) && norm(way) > kAnother) ways.push_back(normalized(way));
  }
  if (moves) ways.erase(ways.begin());
  return ways;
}

// Reactions of what holds bodies in a stage. They have no bound, whether it moves the bodies or not. Where the motion
// is multiplied, bodies are free along it.
void hold_bodies(const Stage& stage, Multiplied multiplied, const blocks::Assembly& assembly, SceneLimit* limit) {
  for (const BodyControl& control : stage.controls) {
    const unsigned held = prescribed_by(control);
    const Vector motion = multiplied == Multiplied::motion ? motion_of(control) : Vector{};
    for (const int block : blocks::find_blocks(assembly, control.body, stage.source.text)) {
      LimitBlock& body = limit->problem.blocks[static_cast<std::size_t>(block)];
      if (norm(motion) > 0.0) body.fixed = false;
      if (body.fixed) continue;
      if (held != 0) limit->supports.push_back(block);
      for (const Vector& way : held_ways(held, motion)) hold(block, body.centre, way, {}, limit);
      for (const Vector& axis : held_ways(held >> 3, {})) hold(block, body.centre, {}, axis, limit);
    }
  }
}

// A force along the motion of bodies, whose power is 1 W where the fastest moves at 1 m/s. It acts on the first of
// them. Forces without power between the first and each other body keep the ratios of their velocities.
void drive_bodies(const Stage& stage, const blocks::Assembly& assembly, SceneLimit* limit) {
  std::vector<LimitForce::Place> moved;
  double fastest = 0.0;
  refuse_turns(stage);
  for (const BodyControl& control : stage.controls) {
    const Vector motion = motion_of(control);
    if (norm(motion) == 0.0) continue;
    fastest = std::max(fastest, norm(motion));
    for (const int block : blocks::find_blocks(assembly, control.body, stage.source.text))
      moved.push_back({block, limit->problem.blocks[static_cast<std::size_t>(block)].centre, motion, {}});
  }
  if (moved.empty()) return;
  for (LimitForce::Place& place : moved) place.way = (fastest / dot(place.way, place.way)) * place.way;
  // The half of a wall resists half of the force.
  limit->loads.push_back({moved[0].block, moved[0].at, (limit->halved ? 0.5 : 1.0) * moved[0].way, true});
  limit->reaction = LimitForce{{moved[0]}};
  for (std::size_t k = 1; k < moved.size(); ++k) {
    LimitForce::Place back = moved[0];
    back.way = -back.way;
    limit->problem.forces.push_back({{back, moved[k]}});
  }
}

// Equal forces along x on the floors of a whiffletree, 1 N in sum.
void push_floors(const Whiffletree& whiffletree, const Stage& stage, const blocks::Assembly& assembly,
                 SceneLimit* limit) {
  for (const std::vector<std::string>& floor : whiffletree.floors) {
    for (const std::string& body : floor) {
      const std::vector<int> blocks = blocks::find_blocks(assembly, body, stage.source.text);
      const double share =
          (limit->halved ? 0.5 : 1.0) / static_cast<double>(whiffletree.floors.size() * floor.size() * blocks.size());
      for (const int block : blocks)
        limit->loads.push_back({block, limit->load_places[static_cast<std::size_t>(block)], {share, 0.0, 0.0}, true});
    }
  }
}

// Nodes of floors and beams as blocks; they are held in directions that are not free.
void add_own_nodes(const members::LinearMembers& own, SceneLimit* limit) {
  for (const members::OwnBody& body : own.bodies) {
    for (int n = body.first; n < body.end; ++n) {
      const members::OwnNode& node = own.nodes[static_cast<std::size_t>(n)];
      const auto block = static_cast<int>(limit->problem.blocks.size());
      LimitBlock& added = limit->problem.blocks.emplace_back();
      added.centre = node.at;
      limit->names.push_back(body.label);
      limit->labels.push_back(
          fmt::format("{} at ({:.3f}, {:.3f}, {:.3f}) m", body.label, node.at.x, node.at.y, node.at.z));
      limit->masses.push_back({block, node.mass, node.at, node.ways});
      if (norm(node.load) > 0.0) limit->loads.push_back({block, node.at, node.load});
      guide(block, node.at, node.ways, false, limit), guide(block, node.at, node.turns, true, limit);
    }
  }
}

LimitPoint point_at(const Vector& position, const Vector& normal) {
  LimitPoint point;
  const Vector axis = std::abs(normal.x) < 0.9 ? Vector{1, 0, 0} : Vector{0, 1, 0};
  point.position = position;
  point.n = normal, point.s = normalized(cross(axis, normal)), point.t = cross(point.n, point.s);
  return point;
}

// A member's force acts against its deformation.
void add_deformations(const members::Members& members, const members::LinearMembers& own, SceneLimit* limit) {
  const auto first = static_cast<int>(limit->block_count);
  for (const members::OwnBody& body : own.bodies) {
    std::map<std::string, LimitMember> bounded;
    for (std::size_t i = body.first_deformation; i < body.end_deformation; ++i) {
      const members::Deformation& d = own.deformations[i];
      LimitForce force{{}, d.low, d.high, 0.0};
      for (const members::Deformation::Share& share : d.shares) {
        const members::Node* const node = share.own ? nullptr : &members.nodes()[static_cast<std::size_t>(share.node)];
        force.places.push_back({node ? node->block : first + share.node,
                                node ? node->start : own.nodes[static_cast<std::size_t>(share.node)].at,
                                -1.0 * share.way, -1.0 * share.turn});
      }
      if (*d.what) {
        LimitMember& of = bounded[d.what];
        of.label = body.label, of.what = d.what;
        of.of.push_back(limit->problem.forces.size());
        of.over.push_back(d.over), of.strength.push_back(d.high / d.over);
      }
      limit->problem.forces.push_back(force);
    }
    for (const auto& [what, member] : bounded) limit->members.push_back(member);
    limit->bodies.push_back({first + body.first, first + body.end, body.faces});
  }
  for (const members::Rest& rest : own.rests) {
    const members::Node& node = members.nodes()[static_cast<std::size_t>(rest.node)];
    LimitPoint point = point_at(node.start, rest.out);
    point.a = node.block, point.b = first + rest.own;
    point.friction = rest.friction;
    limit->problem.points.push_back(point);
  }
}

// Dowels: normal force up to yield in both directions, shear force in a circle, no friction.
void add_dowels(const members::Members& members, SceneLimit* limit) {
  for (const members::Dowel& dowel : members.dowels()) {
    const members::Node &first = members.nodes()[static_cast<std::size_t>(dowel.first)],
                        &second = members.nodes()[static_cast<std::size_t>(dowel.second)];
    LimitPoint point = point_at(first.start, dowel.along);
    point.a = first.block, point.b = second.block;
    point.tension = point.crushing = dowel.law.yield_force, point.cohesion = dowel.law.yield_shear;
    point.bar = true;
    limit->problem.points.push_back(point);
  }
}

// Fills: weight and active pressure are constant; the wall's resistance grows up to the passive pressure.
void add_fills(const members::Members& members, SceneLimit* limit) {
  for (const members::Fill& fill : members.fills()) {
    for (const members::FillPoint& p : fill.points) {
      const members::Node& node = members.nodes()[static_cast<std::size_t>(p.node)];
      const Vector force =
          -p.law.upright * p.law.vertical * p.law.up - p.law.level * p.law.active * p.law.vertical * p.law.out;
      limit->loads.push_back({node.block, node.start, force});
      limit->problem.forces.push_back({{{node.block, node.start, -1.0 * p.law.out, {}}},
                                       0.0,
                                       p.law.level * (p.law.passive - p.law.active) * p.law.vertical,
                                       0.0});
    }
  }
}

void add_members(const members::Members& members, const std::string& file, SceneLimit* limit) {
  refuse_members(members, file);
  add_ties(members, limit);
  add_dowels(members, limit), add_fills(members, limit);
  const members::LinearMembers own = members::linear_of(members, file, limit->gravity);
  add_own_nodes(own, limit);
  add_deformations(members, own, limit);
  for (const members::Carried& carried : own.carried) {
    const members::Node& node = members.nodes()[static_cast<std::size_t>(carried.node)];
    limit->masses.push_back({node.block, carried.mass, node.start, {carried.normal}});
    limit->loads.push_back({node.block, node.start, carried.load});
  }
}

// Wrench on each block from an acceleration of all masses.
std::vector<Wrench> pull_of(const SceneLimit& limit, const Vector& acceleration) {
  std::vector<Wrench> pull(limit.problem.blocks.size());
  for (const LimitMass& m : limit.masses) {
    Vector force = m.ways.empty() ? m.mass * acceleration : Vector{};
    for (const Vector& way : m.ways) force += m.mass * dot(acceleration, way) * way;
    Wrench& on = pull[static_cast<std::size_t>(m.block)];
    on.force += force;
    on.moment += cross(m.at - limit.problem.blocks[static_cast<std::size_t>(m.block)].centre, force);
  }
  return pull;
}

// Whether a contact point has a gap at the start of more than joint_tolerance.
bool is_open(const blocks::World& world, const blocks::Point& point) {
  return locate(world, point, world.contacts.facets).jump > world.detection.joint_tolerance;
}

// Whether a pair of blocks touches only at the rim of a face, which the other does not lie on: an edge on an edge. No
// normal is then that of the contact. points: of the pair, at least one.
bool meets_at_rim(const blocks::World& world, const LimitPoint* points, std::size_t count) {
  const Vector& normal = points->n;
  const geometry::Placed owner = placed(world, points->a), other = placed(world, points->b);
  const int face = facing(owner, normal);
  if (dot(owner.normals[face], normal) < blocks::parallel_cosine ||
      -dot(other.normals[facing(other, -normal)], normal) > blocks::parallel_cosine)
    return false;
  Vector middle;
  for (std::size_t i = 0; i < count; ++i) middle += points[i].position / static_cast<double>(count);
  const std::vector<int>& corners = owner.shape->faces[static_cast<std::size_t>(face)];
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector &from = owner.vertices[corners[i]], &to = owner.vertices[corners[(i + 1) % corners.size()]];
    if (dot(cross(normal, normalized(to - from)), middle - from) <= world.detection.joint_tolerance) return true;
  }
  return false;
}

// Leaves out the points of pairs that meet at a rim. Points of a pair are consecutive. Returns the number of pairs.
std::size_t leave_rims_out(const blocks::World& world, std::vector<LimitPoint>* points) {
  std::size_t pairs = 0;
  std::vector<LimitPoint> kept;
  for (auto first = points->begin(); first != points->end();) {
    const auto end =
        std::find_if(first, points->end(), [&](const LimitPoint& p) { return p.a != first->a || p.b != first->b; });
    if (meets_at_rim(world, &*first, static_cast<std::size_t>(end - first)))
      ++pairs;
    else
      kept.insert(kept.end(), first, end);
    first = end;
  }
  *points = std::move(kept);
  return pairs;
}

// Wrenches on blocks from weights and loads. given: multiple of the live ones that counts as dead.
void sum_loads(double given, SceneLimit* limit) {
  const std::vector<Wrench> dead = pull_of(*limit, limit->gravity);
  const std::vector<Wrench> live =
      pull_of(*limit, limit->direction ? norm(limit->gravity) * *limit->direction : Vector{});
  for (std::size_t k = 0; k < dead.size(); ++k)
    limit->problem.blocks[k].dead = dead[k], limit->problem.blocks[k].live = live[k];
  for (const LimitLoad& load : limit->loads) {
    LimitBlock& block = limit->problem.blocks[static_cast<std::size_t>(load.block)];
    Wrench& sum = load.live ? block.live : block.dead;
    sum.force += load.force, sum.moment += cross(load.at - block.centre, load.force);
    if (load.live) limit->live_force += load.force;
  }
  for (LimitBlock& block : limit->problem.blocks)
    block.dead.force += given * block.live.force, block.dead.moment += given * block.live.moment;
}

// Assembles the problem: rigid blocks, and a force at each contact point that is closed. Weights follow from the
// outlines of the blocks.
void assemble(const Simulation& simulation, const LimitOptions& options, const Stage& loaded, SceneLimit* limit) {
  const Scene& scene = simulation.scene();
  const blocks::Assembly assembly = assembly_of(simulation);
  for (int i = 0; i < static_cast<int>(simulation.block_count()); ++i) {
    const blocks::Block& input = assembly.blocks[static_cast<std::size_t>(i)];
    std::vector<Vector> corners;
    for (const Vec3& x : block_mesh(simulation, i).gridpoint) corners.push_back(geometry::vector(x));
    LimitBlock block;
    block.fixed = input.fixed || is_ground(scene, input.name);
    const geometry::MassProperties mass = mass_properties(geometry::from_vertices(corners, input.name));
    block.centre = input.centre.value_or(mass.centroid);
    limit->load_places.push_back(block.centre);
    double weighs =
        assembly.materials[static_cast<std::size_t>(input.material)].density * mass.volume + input.spread_mass;
    Vector moment = weighs * block.centre;
    for (const blocks::PointMass& point : input.masses) weighs += point.mass, moment += point.mass * point.at;
    if (!input.masses.empty()) block.centre = moment / weighs;
    limit->masses.push_back({i, weighs, block.centre, {}});
    limit->problem.blocks.push_back(block);
    limit->names.push_back(input.name);
    const Vector& x = block.centre;
    limit->labels.push_back(fmt::format("{} at ({:.3f}, {:.3f}, {:.3f}) m", block_label(simulation, i), x.x, x.y, x.z));
  }
  std::map<int, std::pair<Strengths, std::size_t>> strengths;  // of families that have points, and their first points
  const blocks::Model* const shapes = simulation.large_motion();
  for (const ContactPoint& p : contact_points(simulation)) {
    if (!strengths.contains(p.family)) {
      const auto [columns, first] = columns_of(simulation, p.family);
      const std::string& family = assembly.families[static_cast<std::size_t>(p.family)].name;
      strengths.emplace(p.family, std::pair(Strengths(scene.joints.at(family), columns, scene.file), first));
    }
    const auto& [of_family, first] = strengths.at(p.family);
    const std::size_t index = static_cast<std::size_t>(p.index) - first;
    if (shapes && is_open(*shapes, shapes->contacts.families[static_cast<std::size_t>(p.family)].point[index]))
      continue;
    const Strength s = of_family.of(index);
    limit->problem.points.push_back({p.block_a, p.block_b, geometry::vector(p.position), geometry::vector(p.normal),
                                     geometry::vector(p.s), geometry::vector(p.t), s.friction, s.tension * p.area,
                                     s.cohesion * p.area, s.crushing * p.area, p.area, 0.0, p.family});
  }
  if (shapes) limit->edge_count = leave_rims_out(*shapes, &limit->problem.points);
  limit->block_count = limit->problem.blocks.size(), limit->point_count = limit->problem.points.size();
  if (shapes && shapes->held_by.members) add_members(*shapes->held_by.members, scene.file, limit);
  if (limit->halved) keep_on_plane(limit);
  for (const JointFamily& family : assembly.families) limit->families.push_back(family.name);
  if (loaded.collapse || options.stage || options.multiplied != Multiplied::weight)
    hold_bodies(loaded, options.multiplied, assembly, limit);
  add_loads(loaded, options.multiplied, assembly, limit);
  if (options.multiplied == Multiplied::motion) {
    drive_bodies(loaded, assembly, limit);
    if (loaded.whiffletree) push_floors(*loaded.whiffletree, loaded, assembly, limit);
  }
  sum_loads(options.given, limit);
}

void require_supports(const Scene& scene, const SceneLimit& limit) {
  const std::vector<LimitBlock>& blocks = limit.problem.blocks;
  if (limit.supports.empty() &&
      std::none_of(blocks.begin(), blocks.end(), [](const LimitBlock& b) { return b.fixed; })) {
    std::vector<int> all(blocks.size());
    std::iota(all.begin(), all.end(), 0);
    throw Error(Exit::bad_input,
                fmt::format("{}: no block is fixed, so nothing holds the others; give {}:{}", scene.file,
                            scene.wall ? "wall.bottom_beam = true" : "one fixed = true", blocks_text(limit, all)));
  }
  const std::vector<int> loose = unconnected_blocks(limit.problem, limit.supports);
  if (!loose.empty())
    throw Error(
        Exit::bad_input,
        fmt::format("{}: no chain of joints leads to a fixed block from {} block(s), so nothing holds them:{}\n  "
                    "let them touch what is fixed along more than an edge, or leave them out",
                    scene.file, loose.size(), blocks_text(limit, loose)));
}

void require_solved(const std::string& file, const SceneLimit& limit, const LimitResult& result) {
  if (result.status == LimitStatus::no_equilibrium)
    throw Error(Exit::numerical, fmt::format("{}: the given loads alone cannot be carried; out of balance:{}", file,
                                             blocks_text(limit, result.blocks_concerned)));
  if (result.status == LimitStatus::unbounded)
    throw Error(Exit::numerical,
                fmt::format("{}: no multiple of the load moves a block; is its direction right, and is anything free "
                            "to move? With associated flow, which lifts what slides, blocks may also lock; a run has "
                            "none. The load acts on:{}",
                            file, blocks_text(limit, result.blocks_concerned)));
  require_answer(result);
}

// Both ways along the two axes that are farthest from gravity: those along x and z where it is closest to y.
std::vector<Vector> horizontal_ways(const Vector& gravity) {
  const int upright = upright_axis(geometry::array(gravity));
  std::vector<Vector> ways;
  for (int c = 0; c < 3; ++c) {
    for (const double sign : {1.0, -1.0}) {
      Vector way;
      way[c] = sign;
      if (c != upright) ways.push_back(way);
    }
  }
  return ways;
}

// Smallest margin of four loads: the weight along these ways. Two where a plane of symmetry holds z.
void find_least_margin(const std::string& file, const LimitSettings& settings, SceneLimit* limit) {
  for (const Vector& way : horizontal_ways(limit->gravity)) {
    if (limit->halved && way.z != 0.0) continue;
    LimitProblem pushed = limit->problem;
    const std::vector<Wrench> live = pull_of(*limit, norm(limit->gravity) * way);
    for (std::size_t k = 0; k < live.size(); ++k) pushed.blocks[k].live = live[k];
    const LimitResult result = limit_multiplier(pushed, settings);
    if (result.status == LimitStatus::unbounded) continue;
    require_solved(file, *limit, result);
    if (limit->margin && *limit->margin <= result.multiplier) continue;
    limit->margin = result.multiplier, limit->margin_direction = way;
  }
}

// Computes each position by itself, beside the weight. The worst position has the smallest multiplier.
void find_moving(const Simulation& simulation, const LimitOptions& options, SceneLimit* limit) {
  const Scene& scene = simulation.scene();
  const Stage& stage = moving_stage(scene, options);
  limit->moving_force = geometry::vector(stage.moving_load->force);
  const std::vector<blocks::LoadPlace> places =
      blocks::places_of(*stage.moving_load, assembly_of(simulation), stage.source.text);
  LimitProblem& problem = limit->problem;
  for (LimitBlock& b : problem.blocks) b.live = {};
  Wrench worst;
  for (const blocks::LoadPlace& place : places) {
    LimitBlock& block = problem.blocks[static_cast<std::size_t>(place.block)];
    MovingLimit& here = limit->moving.emplace_back(MovingLimit{place.block, place.position, place.at, std::nullopt});
    if (block.fixed) continue;
    block.live = {limit->moving_force, cross(place.at - block.centre, limit->moving_force)};
    const LimitResult result = limit_multiplier(
        problem, in_phase(options.settings, fmt::format("position {} of {}", limit->moving.size(), places.size())));
    if (result.status != LimitStatus::unbounded) {
      require_solved(scene.file, *limit, result);
      here.multiplier = result.multiplier;
      if (!limit->limit || result.multiplier < limit->limit->multiplier)
        limit->limit = result, limit->worst = limit->moving.size() - 1, worst = block.live;
    }
    block.live = {};
  }
  if (!limit->limit)
    throw Error(Exit::numerical, fmt::format("{}: no multiple of moving_load moves a block, from any of its {} "
                                             "positions",
                                             stage.source.text, places.size()));
  problem.blocks[static_cast<std::size_t>(limit->moving[limit->worst].block)].live = worst;
  limit->margin = limit->limit->multiplier;
}

// Refuses what has no meaning here or together.
void refuse(const Scene& scene, const LimitOptions& options) {
  const bool of_stage = options.multiplied != Multiplied::weight;
  if (!scene.damage.empty())
    throw Error(
        Exit::bad_input,
        fmt::format("{}: [[damage]]: limit analysis has the strengths of undamaged joints; give damaged joints a "
                    "family of their own with the strengths that are left (a dry one: initial_state = \"dry\"), "
                    "or leave the damage out",
                    scene.file));
  constexpr double kMostSeconds = 1e9;  // some thirty years
  if (!(options.seconds > 0.0 && options.seconds <= kMostSeconds))
    throw Error(Exit::bad_input,
                fmt::format("limit: {} s of time; allowed: more than 0, at most {:g}", options.seconds, kMostSeconds));
  if (options.moving && (options.given != 0.0 || !options.direction.empty() || of_stage))
    throw Error(Exit::bad_input, fmt::format("{}: with a moving load that alone is multiplied; leave --direction, "
                                             "--multiply and --given out",
                                             scene.file));
  if (options.multiplied == Multiplied::motion && options.given != 0.0)
    throw Error(Exit::bad_input,
                fmt::format("{}: a motion has no load to be given beforehand; leave --given out", scene.file));
  if (of_stage && !options.direction.empty())
    throw Error(Exit::bad_input, fmt::format("{}: --direction is that of the weight, and --multiply {} multiplies "
                                             "loads that have one; leave one of them out",
                                             scene.file, name_of(options.multiplied)));
}

// The associated multiplier, or without a direction the least margin.
void find_multiplier(const Simulation& simulation, const LimitOptions& options, SceneLimit* limit) {
  if (options.moving) return find_moving(simulation, options, limit);
  const std::string& file = simulation.scene().file;
  const LimitSettings settings = in_phase(options.settings, "multiplier");
  if (!limit->direction && options.multiplied == Multiplied::weight) return find_least_margin(file, settings, limit);
  limit->limit = limit_multiplier(limit->problem, settings);
  require_solved(file, *limit, *limit->limit);
  limit->margin = limit->limit->multiplier, limit->margin_direction = limit->direction.value_or(Vector{});
  limit->limit->multiplier += options.given;
}

void say_if_apart(const std::string& file, const char* what, const LimitWithoutDilation& without) {
  if (without.apart <= kDoubt) return;
  notice(fmt::format(
      "quoin: {}: without dilation the {} is {:.4g} from elastic forces under weight and {:.4g} from associated ones. "
      "{:.4g}, the worse one, counts; which is right hangs on normal forces, as a run has them (a stage of collapse)",
      file, what, without.start[0].multiplier, without.start[1].multiplier, without.multiplier));
}

}  // namespace

const char* name_of(Multiplied multiplied) { return kMultiplied[static_cast<std::size_t>(multiplied)]; }

Multiplied multiplied_named(const std::string& name) {
  const auto found = std::ranges::find(kMultiplied, name);
  if (found != std::end(kMultiplied)) return static_cast<Multiplied>(found - std::begin(kMultiplied));
  throw Error(Exit::bad_input,
              fmt::format("limit: '{}' cannot be multiplied; allowed: {}. A displacement has no multiplier, as forces "
                          "between rigid blocks do not grow with it; motion gives the force, in N, at which what a "
                          "stage moves goes on moving",
                          name, fmt::join(kMultiplied, ", ")));
}

std::string blocks_text(const SceneLimit& limit, const std::vector<int>& blocks) {
  constexpr std::size_t kNamed = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(kNamed, blocks.size()); ++i)
    text += "\n  block " + limit.labels[static_cast<std::size_t>(blocks[i])];
  if (blocks.size() > kNamed) text += fmt::format("\n  and {} more", blocks.size() - kNamed);
  return text;
}

Scene for_limit(Scene scene, Multiplied multiplied) {
  if (multiplied != Multiplied::weight && scene.blocks) scene.solver.kernels = Kernels::general;
  return scene;
}

SceneLimit limit_of(const Simulation& simulation, const LimitOptions& given) {
  const std::string& file = simulation.scene().file;
  LimitOptions options = given;
  if (!options.settings.progress) options.settings.progress = notices_of_progress(file);
  refuse(simulation.scene(), options);
  SceneLimit limit;
  const Stage& loaded = find_loads(simulation.scene(), options, &limit);
  if (!simulation.scene().start.empty())
    notice(
        fmt::format("quoin: {}: start: without effect here, as limit analysis has the blocks as they are built", file));
  if (!loaded.law_swaps.empty())
    notice(
        fmt::format("quoin: {}: law: without effect here, as limit analysis has the laws of [joints]; --law replaces "
                    "them",
                    loaded.source.text));
  assemble(simulation, options, loaded, &limit);
  require_supports(simulation.scene(), limit);
  const auto in_time = [&](LimitSettings settings) {
    settings.deadline =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options.seconds));
    return settings;
  };
  options.settings = in_time(options.settings);
  LimitProblem still = limit.problem;
  if (limit.reaction) still.forces.push_back(*limit.reaction);
  limit.stands = stands(still, in_phase(options.settings, "stability"), options.friction);
  if (limit.stands.stands) find_multiplier(simulation, options, &limit);
  if (options.associated) return limit;
  if (limit.limit) {
    limit.without_dilation =
        limit_without_dilation(limit.problem, in_phase(in_time(options.settings), "without dilation"));
    limit.without_dilation->multiplier += options.given;
    for (SettledLimit& start : limit.without_dilation->start) start.multiplier += options.given;
    say_if_apart(file, "multiplier", *limit.without_dilation);
  }
  if (!limit.stands.friction) return limit;
  // If normal forces alone carry all loads, they do so without dilation too.
  limit.friction =
      *limit.stands.friction > 0.0
          ? friction_without_dilation(still, in_phase(in_time(options.settings), "friction without dilation"))
          : LimitWithoutDilation{{}, true, 0.0};
  say_if_apart(file, "smallest scale of friction", *limit.friction);
  return limit;
}

std::function<void(const std::string&)> notices_of_progress(const std::string& file) {
  struct Last {
    std::mutex mutex;
    Clock::time_point time = Clock::now();
  };
  return [file, last = std::make_shared<Last>()](const std::string& step) {
    constexpr double kPeriod = 2.0;  // s
    const std::lock_guard lock(last->mutex);
    if (seconds_since(last->time) < kPeriod) return;
    last->time = Clock::now();
    notice(fmt::format("quoin: {}: limit analysis: {}", file, step));
  };
}

}  // namespace quoin
