// Start of a model, its laws, and changes by stages between steps.
#include "model/world.h"

#include <fmt/format.h>

#include "base/error.h"
#include "model/block_layout.h"
#include "model/contact_frames.h"
#include "model/world_results.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

bool knows_initial_state(const quoin_law& law, const std::string& id) {
  return std::any_of(law.initial_states, law.initial_states + law.initial_state_count,
                     [&](const char* known) { return id == known; });
}

void adopt(World& w, Family& f, std::shared_ptr<const Material> material, const std::string& initial_state) {
  f.initial = material->initial_state(initial_state);
  f.dry = knows_initial_state(material->api(), "dry") ? material->initial_state("dry") : f.initial;
  const size_t index = size_t(&f - w.contacts.families.data());
  const quoin_stiffness_bounds bounds = stiffness_bounds_of(w.assembly.families[index], *material, f.columns);
  f.kn = bounds.normal, f.ks = bounds.shear;
  f.state.resize(material->api().state_count);
  f.material = std::move(material);
}

void check(const Assembly& assembly, const SolverSettings& solver) {
  if (assembly.blocks.empty()) throw Error(Exit::bad_input, "the scene has no blocks");
  if (assembly.families.empty()) throw Error(Exit::bad_input, "the scene has no joint family");
  if (solver.selective_time_step > 0) {
    throw Error(
        Exit::bad_input,
        "selective_time_step is for the lattice's bricks in small displacements: it adds inertia to gridpoints, which "
        "would change how blocks move as a whole; use deformation_inertia with damping = \"block\", which slows "
        "vibrations alone");
  }
}

}  // namespace

World::World(const Assembly& scene, const SolverSettings& settings,
             std::vector<std::shared_ptr<const Material>> materials, Ranks* ranks, ThreadPool* threads)
    : assembly(scene), pool(threads) {
  part.ranks = ranks, part.is_shared = ranks;
  set_solver(settings);
  check(assembly, solver);
  for (size_t i = 0; i < assembly.families.size(); ++i) {
    const JointFamily& description = assembly.families[i];
    adopt(*this, contacts.families.emplace_back(),
          i < materials.size() && materials[i]
              ? materials[i]
              : std::make_shared<const Material>(Law::find(description.law), description.properties),
          description.initial_state);
  }
  number_blocks(*this);
  if (!part.ranks) begin({});
}

void World::settle(bool on) {
  is_settling = on;
  damping = damping_of(solver, is_settling);
}

void World::set_solver(const SolverSettings& settings) {
  const double mass_scaling = solver.mass_scaling;
  const bool runs = stepping.critical_dt > 0, books = runs && books_energy;
  const double moving = books ? kinetic_energy_of_all(*this) : 0.0;
  solver = settings;
  if (runs) solver.mass_scaling = mass_scaling;
  settle(is_settling);
  if (books) step_sums.later.detection += moving - kinetic_energy_of_all(*this);  // kinetic energy of the added inertia
  for (Family& f : contacts.families) {
    const size_t n = damping.of_contacts() ? f.size() : 0;
    for (auto& column : f.old_traction) column = LaneVector<double>(n);
    f.old_jump = LaneVector<double>(n);
    for (auto& column : f.viscous) column = LaneVector<double>(n);
    for (auto& column : f.maxwell) column = LaneVector<double>(damping.has_maxwell() ? f.size() : 0);
  }
  const ImpactTerms of_impacts = damping.impacts.value_or(ImpactTerms{});
  impacts.maxwell = quoin::maxwell_elements(of_impacts.maxwell, of_impacts.maxwell_band);
  for (const Contact& c : contacts.list) {
    if (!damping.of_contacts() || c.count == 0 || !part.owns(c.pair)) continue;
    std::fill_n(contacts.families[size_t(c.family)].old_jump.begin() + c.first, c.count, std::nan(""));
  }
  bind_columns(*this);
  choose_impact_damping(*this);
  if (runs) find_time_step(*this, true);
}

namespace {

void draw_columns(World& w) {
  std::vector<PlacedBlock> placed;
  for (const Block& b : w.assembly.blocks) placed.push_back({b.unit, b.course});
  for (size_t k = 0; k < w.contacts.families.size(); ++k) {
    const JointFamily& description = w.assembly.families[k];
    Family& f = w.contacts.families[k];
    if (!description.scatters()) continue;
    const std::vector<PlacedPoint> points = placed_points(w, f);
    f.columns = draw_properties(description, *f.material, points, placed);
    const quoin_stiffness_bounds bounds = stiffness_bounds_of(description, *f.material, f.columns);
    f.kn = bounds.normal, f.ks = bounds.shear;
  }
}

}  // namespace

void World::begin(std::vector<int> rank_of_block) {
  part.rank_of_block = std::move(rank_of_block);
  std::vector<double> masses(blocks.size());
  std::optional<Error> fault;
  try {
    for (int i = 0; i < block_count(); ++i) {
      if (!part.owns(i)) continue;
      lay_out(*this, i);
      const ModelBlock& b = blocks[size_t(i)];
      double& mass = masses[size_t(i)];
      if (b.body >= 0) mass = bodies[size_t(b.body)].weight_mass;
      for (int n = b.first_node; n < b.first_node + b.node_count; ++n) mass += nodes.weight_mass[size_t(n)];
    }
  } catch (const Error& error) {
    fault = error;
  }
  part.fail_together(fault);
  part.gather_by_block(masses);
  for (size_t i = 0; i < blocks.size(); ++i) blocks[i].mass = masses[i];
  detect_contacts(*this, true);
  draw_columns(*this);
  set_solver(SolverSettings(solver));
  find_time_step(*this);
}

void World::take_law(int family, std::shared_ptr<const Material> material) {
  const quoin_law& law = material->api();
  const std::string& wanted = assembly.families[size_t(family)].initial_state;
  adopt(*this, contacts.families[size_t(family)], std::move(material),
        knows_initial_state(law, wanted) ? wanted : law.initial_states[0]);
}

void World::replace_law(int family, std::shared_ptr<const Material> material, std::span<const double> state,
                        std::span<const double> opening_shift) {
  Family& f = contacts.families[size_t(family)];
  const double kn = f.kn, ks = f.ks;
  take_back_facets(*this);
  const std::shared_ptr<const Material> old = f.material;
  const size_t old_width = kept_width(*this);
  take_law(family, std::move(material));
  keep_states_by_id(*this, family, old->api(), old_width);
  for (size_t k = 0; k < f.state.size(); ++k)
    f.state[k].assign(state.begin() + long(k * f.size()), state.begin() + long((k + 1) * f.size()));
  for (size_t i = 0; i < f.size(); ++i) {
    keep_opening(f.point[i], 0.0, opening_shift[i]);
    f.normal_jump[i] += opening_shift[i];
    if (!f.old_jump.empty()) f.old_jump[i] += opening_shift[i];
  }
  // Columns would keep the old law's energies if the new law writes none.
  std::fill(f.stored.begin(), f.stored.end(), 0.0);
  for (auto& column : f.dissipated) std::fill(column.begin(), column.end(), 0.0);
  divide_work(*this);
  if (damping.impacts) choose_impact_damping(*this);
  if (damping.impacts || f.kn > kn || f.ks > ks) find_time_step(*this);
}

void World::set_gravity(const Vector& g) { actions.gravity = g; }

namespace {

// Driven components have no kinetic energy: a released component adds its own, a caught one passes it to the support.
void change_held(uint8_t& held, uint8_t next, double mass, const Vector& v, Energies& energies) {
  const int changed = held ^ next;
  for (int k = 0; changed != 0 && k < 3; ++k)
    if (changed >> k & 1) energies.external += (next >> k & 1 ? -0.5 : 0.5) * mass * v[k] * v[k];
  held = next;
}

}  // namespace

void World::prescribe(int block, const Vector& velocity, const Vector& omega, uint8_t held) {
  if (!part.laid_out[size_t(block)]) return;
  const ModelBlock& b = blocks[block];
  if (b.body >= 0) {
    Body& body = bodies[b.body];
    const auto holds_rotation = [](uint8_t bits) { return (bits & 0x38) == 0x38; };
    const int let_go = int(holds_rotation(body.held)) - int(holds_rotation(held | body.support));
    step_sums.energies.external += let_go * 0.5 * dot(body.momentum, body.omega);
    change_held(body.held, held | body.support, body.mass, body.v, step_sums.energies);
    body.held_v = velocity, body.held_omega = omega;
    return;
  }
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i) {
    const Vector v = gridpoint_velocity(*this, block, i - b.first_node);
    change_held(nodes.held[i], uint8_t((held & 7) | nodes.support[i]), nodes.mass[i], v, step_sums.energies);
    nodes.held_v[i] = velocity;
  }
  pieces.held_changed.push_back(block);
}

void World::set_velocity(int block, const Vector& velocity, const Vector& omega) {
  const ModelBlock& b = blocks[block];
  if (b.body >= 0) {
    Body& body = bodies[b.body];
    body.v = velocity, body.omega = omega;
    const Vector w = transposed_times(body.r, omega);
    body.momentum = body.r * Vector{body.inertia.x * w.x, body.inertia.y * w.y, body.inertia.z * w.z};
    return;
  }
  checks.dt = 0.0;  // the motion changes more than the checks assume: all are due
  const Vector centre = position_of(*this, block);
  LaneVector<Vector>& v = change_node_velocities(*this);
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i) v[i] = velocity + cross(omega, nodes.x[i] - centre);
}

void World::add(Load load) {
  if (blocks.at(load.block).body >= 0) {
    const Pose& start = poses.start[size_t(load.block)];
    load.arm = transposed_times(start.r, load.point - start.x);
  } else {
    load.share = shares_at(*this, load.block, load.point);
  }
  actions.loaded[size_t(load.block)] = 1;
  actions.loads.push_back(std::move(load));
}

void World::add(Pressure pressure) {
  const ModelBlock& b = blocks.at(pressure.block);
  if (pressure.face < 0 || pressure.face >= int(b.shape->faces.size())) {
    throw Error(Exit::bad_input,
                fmt::format("pressure on block {}: face {} does not exist; there are faces 0 to {}",
                            label(assembly, pressure.block), pressure.face, b.shape->faces.size() - 1));
  }
  if (b.body >= 0) {
    ConvexPolyhedron local = *b.shape;
    local.vertices.assign(shapes.corner.begin() + b.first_corner,
                          shapes.corner.begin() + b.first_corner + long(b.shape->vertices.size()));
    update_normals(local);
    pressure.arm = face_centroid(local, pressure.face);
    pressure.push = -face_area(local, pressure.face) * local.normals[pressure.face];
  } else {
    for (const auto& t : b.surface) {
      if (t.face == pressure.face) pressure.triangles.push_back({t.node[0], t.node[1], t.node[2]});
    }
  }
  actions.loaded[size_t(pressure.block)] = 1;
  actions.pressures.push_back(std::move(pressure));
}

void World::apply_force(int block, const Vector& force, const Vector& moment) {
  if (actions.applied.empty()) actions.applied.resize(blocks.size());
  actions.applied[size_t(block)] = {force, moment};
  actions.loaded[size_t(block)] = 1;
}

void World::track_energy(bool on) {
  step_sums.energies = {};
  step_sums.later = {};
  for (Family& f : contacts.families) {
    for (auto& column : f.viscous) column = LaneVector<double>(damping.of_contacts() ? f.size() : 0);
  }
  book_energy(on);
}

void World::book_energy(bool on) {
  copy_velocities(*this);  // steps that book energies read them
  books_energy = on;
  for (Family& f : contacts.families) {
    f.stored = LaneVector<double>(on ? f.size() : 0);
    for (auto& d : f.dissipated) d = LaneVector<double>(on ? f.size() : 0);
  }
  bind_columns(*this);
}

}  // namespace quoin::blocks
