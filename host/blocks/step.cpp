// The explicit step: one function that names the phases, then the phases.
#include <fmt/format.h>

#include "blocks/model.h"
#include "scene/error.h"

namespace quoin::blocks {

using namespace geometry;

void Model::step() {
  internal_forces();           // stresses of the zones -> forces on their gridpoints
  contact_kinematics();        // jumps at the contact points, in frames that ride on the blocks
  contact_law();               // tractions from jumps: the plug-in, one batch a family
  contact_forces();            // tractions -> forces on blocks and gridpoints
  nodal_forces_and_damping();  // weight, loads, pressures, ground motion, damping
  integrate();                 // velocities, then positions and orientations
  watch();
  if (moved_enough()) detect_contacts();
}

void Model::run(double duration) {
  const double end = time_ + duration;
  while (time_ < end - 0.5 * dt_) step();
}

void Model::internal_forces() {
  for (Vector& f : node_f_) f = {};
  for (Body& b : bodies_) b.force = {}, b.torque = {};
  const double beta = solver_.damping == DampingKind::viscous ? solver_.stiffness_damping : 0.0;
  double strain_energy_sum = 0.0;
  for (size_t z = 0; z < zones_.size(); ++z) {
    const Zone& zone = zones_[z];
    // displacement gradient H; Green strain E = (H + H^T + H^T H)/2; S = lambda tr(E) 1 + 2 mu E; P = (1 + H) S
    const Vector u0 = node_x_[zone.node[0]] - node_reference_[zone.node[0]];
    Matrix h = Matrix::zero();
    for (int k = 1; k < 4; ++k)
      h += outer(node_x_[zone.node[k]] - node_reference_[zone.node[k]] - u0, zone.gradient[k]);
    const Matrix strain = 0.5 * (h + transposed(h) + transposed(h) * h);
    Matrix stress = 2 * zone.mu * strain + zone.lambda * trace(strain) * Matrix{};
    if (energy_) {
      double density = 0.0;
      for (int i = 0; i < 3; ++i) density += 0.5 * dot(stress.row[i], strain.row[i]);
      strain_energy_sum += density * zone.volume;
    }
    if (beta > 0) {
      const Matrix rate = (1 / dt_) * (strain - zone_strain_[z]);
      zone_strain_[z] = strain;
      const Matrix viscous = beta * (2 * zone.mu * rate + zone.lambda * trace(rate) * Matrix{});
      stress += viscous;
      if (energy_) {
        for (int i = 0; i < 3; ++i) energies_.damping += zone.volume * dt_ * dot(viscous.row[i], rate.row[i]);
      }
    }
    const Matrix first = stress + h * stress;
    Vector sum;
    for (int k = 1; k < 4; ++k) {
      const Vector f = zone.volume * (first * zone.gradient[k]);
      node_f_[zone.node[k]] -= f;
      sum += f;
    }
    node_f_[zone.node[0]] += sum;
  }
  if (energy_) energies_.strain = strain_energy_sum;
}

void Model::contact_kinematics() {
  for (Family& f : families_) {
    for (size_t i = 0; i < f.point.size(); ++i) {
      Point& p = f.point[i];
      if (p.facet_a >= 0 && !small_) refresh_facet_frame(p, facets_[p.facet_a]);
      const Location now = locate(p, facets_);
      p.at = now.at;
      f.normal_jump[i] = now.jump;
      for (int k = 0; k < 2; ++k) f.slip[k][i] = now.slid[k] - p.slid[k], p.slid[k] = now.slid[k];
      if (p.facet_a >= 0 && !small_) {
        // The foot on the triangle follows the point, so that the pair of forces stays collinear.
        Facet& facet = facets_[p.facet_a];
        for (int k = 0; k < 3; ++k)
          facet.weight[k] += facet.gradient[k][0] * p.slid[0] + facet.gradient[k][1] * p.slid[1];
        p.slid[0] = p.slid[1] = 0.0;
      }
    }
  }
}

void Model::evaluate_family(Family& f) {
  if (f.size() == 0) return;
  quoin_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = f.size();
  batch.normal_jump = {f.normal_jump.data(), 1};
  std::vector<quoin_in> old(f.state.size());
  std::vector<quoin_out> fresh(f.state.size());
  for (size_t s = 0; s < f.state.size(); ++s) old[s] = {f.state[s].data(), 1}, fresh[s] = {f.state[s].data(), 1};
  for (int k = 0; k < 2; ++k) batch.slip_increment[k] = {f.slip[k].data(), 1};
  for (int k = 0; k < 3; ++k)
    batch.traction_old[k] = {f.traction[k].data(), 1}, batch.traction_new[k] = {f.traction[k].data(), 1};
  batch.state_old = old.data(), batch.state_new = fresh.data();
  if (energy_ && !f.stored.empty()) {
    batch.energy_stored = {f.stored.data(), 1};
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) batch.dissipated[k] = {f.dissipated[k].data(), 1};
  }
  const quoin_status status = f.material->api().evaluate(f.material->handle(), &batch);
  if (status != QUOIN_OK || batch.failed_count > 0) {
    size_t bad = 0;
    while (bad + 1 < f.size() &&
           std::isfinite(f.normal_jump[bad] + f.slip[0][bad] + f.slip[1][bad] + f.traction[0][bad]))
      ++bad;
    throw Error(Exit::numerical,
                fmt::format("contact law '{}' failed at {} of {} points (status {}), step {}, near {} between blocks "
                            "{} and {}: normal jump "
                            "{:.3g} m; reduce time_step_fraction",
                            f.material->api().id, batch.failed_count, f.size(), status, step_count_,
                            place(f.point[bad].at), f.point[bad].a, f.point[bad].b, f.normal_jump[bad]));
  }
}

void Model::contact_law() {
  const bool viscous = solver_.damping == DampingKind::viscous && solver_.stiffness_damping > 0;
  for (Family& f : families_) {
    if (viscous) {
      for (int k = 0; k < 3; ++k) f.old_traction[k] = f.traction[k];
    }
    evaluate_family(f);
  }
  if (!energy_) return;
  energies_.contact_stored = stored_in_contacts();
  for (const Family& f : families_) {
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) {
      for (size_t i = 0; i < f.size(); ++i) energies_.dissipated[k] += f.dissipated[k][i] * f.point[i].area;
    }
  }
}

void Model::contact_forces() {
  const double beta = solver_.damping == DampingKind::viscous ? solver_.stiffness_damping : 0.0;
  for (Vector& f : block_contact_force_) f = {};
  double total = 0.0;
  size_t loaded = 0;
  for (Family& f : families_) {
    for (size_t i = 0; i < f.point.size(); ++i) {
      double sigma = f.traction[0][i], tau_s = f.traction[1][i], tau_t = f.traction[2][i];
      const Point& p = f.point[i];
      if (beta > 0 && std::isnan(f.old_jump[i])) {
        f.old_jump[i] = f.normal_jump[i];  // placed anew: the change since the last step is no motion
      } else if (beta > 0) {
        // Stiffness-proportional: the rate of the traction itself, so that slip and open joints are not damped. It may
        // slow a closed contact but never pull on it.
        const double rate = beta / dt_;
        double normal = rate * (sigma - f.old_traction[0][i]);
        if (sigma <= 0) normal = std::min(normal, -sigma);
        if (sigma == 0) normal = 0;
        const double shear_s = tau_s == 0 ? 0 : rate * (tau_s - f.old_traction[1][i]);
        const double shear_t = tau_t == 0 ? 0 : rate * (tau_t - f.old_traction[2][i]);
        if (energy_) {
          energies_.damping +=
              p.area * (normal * (f.normal_jump[i] - f.old_jump[i]) + shear_s * f.slip[0][i] + shear_t * f.slip[1][i]);
        }
        sigma += normal, tau_s += shear_s, tau_t += shear_t;
        f.old_jump[i] = f.normal_jump[i];
      }
      if (sigma == 0 && tau_s == 0 && tau_t == 0) continue;
      Vector force = p.area * (sigma * p.n + tau_s * p.s + tau_t * p.t);  // on a
      if (p.facet_a >= 0) {
        const Facet& facet = facets_[p.facet_a];
        // The pair acts at p.at: shear times the gap is a couple that the triangle takes as normal forces.
        const double gap = f.normal_jump[i] + p.reference;
        for (int k = 0; k < 3; ++k) {
          const double couple = -gap * p.area * (facet.gradient[k][0] * tau_s + facet.gradient[k][1] * tau_t);
          node_f_[facet.node[k]] += facet.weight[k] * force + couple * p.n;
        }
      } else {
        Body& a = bodies_[blocks_[p.a].body];
        force = a.r * force;
        a.force += force;
        a.torque += cross(p.at - a.x, force);
      }
      if (p.facet_b >= 0) {
        const Facet& facet = facets_[p.facet_b];
        for (int k = 0; k < 3; ++k) node_f_[facet.node[k]] -= facet.weight[k] * force;
      } else {
        Body& b = bodies_[blocks_[p.b].body];
        b.force -= force;
        b.torque -= cross(p.at - b.x, force);
      }
      block_contact_force_[p.a] += force;
      block_contact_force_[p.b] -= force;
      total += norm(force);
      ++loaded;
    }
  }
  total_force_ = loaded > 0 ? total / double(loaded) : 0.0;
}

void Model::nodal_forces_and_damping() {
  const Vector g = gravity_factor_.at(time_) * gravity_;
  for (Body& b : bodies_) b.force += b.weight_mass * g;
  for (size_t i = 0; i < node_f_.size(); ++i) node_f_[i] += node_weight_mass_[i] * g;
  for (const Load& l : loads_) {
    const Vector f = l.factor.at(time_) * l.force;
    const ModelBlock& b = blocks_[l.block];
    if (b.body >= 0) {
      Body& body = bodies_[b.body];
      body.force += f;
      body.torque += cross(body.r * l.arm, f);
    } else {
      for (const auto& [node, weight] : l.share) node_f_[node] += weight * f;
    }
  }
  for (const Pressure& p : pressures_) {
    const double value = p.value * p.factor.at(time_);
    const ModelBlock& b = blocks_[p.block];
    if (b.body >= 0) {
      Body& body = bodies_[b.body];
      const Vector f = value * (body.r * p.push);
      body.force += f;
      body.torque += cross(body.r * p.arm, f);
    } else {
      for (const auto& t : p.triangles) {
        const Vector m = cross(node_x_[t[1]] - node_x_[t[0]], node_x_[t[2]] - node_x_[t[0]]);
        for (int32_t node : t) node_f_[node] -= value / 6 * m;
      }
    }
  }
  for (const GroundMotion& m : motions_) {
    const Vector v = m.acceleration.integral(time_ + 0.5 * dt_) * m.direction;
    for (int block : m.blocks) prescribe(block, v);
  }
}

namespace {

// New velocity of one degree of freedom of mass m under force f, with the damping asked for; work of damping into
// `taken`.
struct Damper {
  double gamma;  // local
  double alpha;  // viscous, mass proportional, 1/s
  double dt;
  double velocity(double v, double f, double m, double& taken) const {
    if (gamma > 0) {
      const double damping = v == 0 ? 0 : -std::copysign(gamma * std::abs(f), v);
      const double next = v + dt / m * (f + damping);
      taken -= damping * 0.5 * (v + next) * dt;
      return next;
    }
    if (alpha > 0) {
      const double next = ((1 - 0.5 * alpha * dt) * v + dt / m * f) / (1 + 0.5 * alpha * dt);
      const double mean = 0.5 * (v + next);
      taken += alpha * m * mean * mean * dt;
      return next;
    }
    return v + dt / m * f;
  }
};

}  // namespace

void Model::integrate() {
  const Damper damper{solver_.damping == DampingKind::local ? solver_.local_damping : 0.0,
                      solver_.damping == DampingKind::viscous ? solver_.mass_damping : 0.0, dt_};
  double kinetic = 0.0, damped = 0.0, external = 0.0, unbalanced = 0.0, sum = 0.0;
  const Vector g = gravity_factor_.at(time_) * gravity_;
  for (size_t i = 0; i < node_x_.size(); ++i) {
    Vector& v = node_v_[i];
    const Vector before = v, force = node_f_[i];
    for (int k = 0; k < 3; ++k) {
      if (node_held_[i] >> k & 1) {
        v[k] = node_held_v_[i][k];
        if (energy_)
          external += (node_mass_[i] * (v[k] - before[k]) / dt_ - force[k] + node_weight_mass_[i] * g[k]) * 0.5 *
                      (v[k] + before[k]) * dt_;
      } else {
        v[k] = damper.velocity(v[k], force[k], node_mass_[i], damped);
        unbalanced = std::max(unbalanced, std::abs(force[k]));
        if (energy_) external += node_weight_mass_[i] * g[k] * 0.5 * (v[k] + before[k]) * dt_;
      }
    }
    if (energy_) {
      const Vector mean = 0.5 * (before + v);
      kinetic += 0.5 * node_mass_[i] * dot(mean, mean);
    }
    node_x_[i] += dt_ * v;
    sum += node_x_[i].x + node_x_[i].y + node_x_[i].z;
  }
  for (Body& b : bodies_) {
    const Vector v_before = b.v, omega_before = b.omega, momentum_before = b.momentum;
    for (int k = 0; k < 3; ++k) {
      if (b.held >> k & 1) {
        b.v[k] = b.held_v[k];
        if (energy_)
          external += (b.mass * (b.v[k] - v_before[k]) / dt_ - b.force[k] + b.weight_mass * g[k]) * 0.5 *
                      (b.v[k] + v_before[k]) * dt_;
      } else {
        b.v[k] = damper.velocity(b.v[k], b.force[k], b.mass, damped);
        unbalanced = std::max(unbalanced, std::abs(b.force[k]));
        if (energy_) external += b.weight_mass * g[k] * 0.5 * (b.v[k] + v_before[k]) * dt_;
      }
    }
    b.x += dt_ * b.v;

    if ((b.held >> 3) == 7) {
      b.omega = b.held_omega;
      if (energy_) external -= dot(b.torque, b.omega) * dt_;
    } else {
      Vector torque = b.torque;
      if (damper.gamma > 0) {
        for (int k = 0; k < 3; ++k) {
          if (b.omega[k] == 0 || (b.held >> (3 + k) & 1)) continue;
          const double damping = -std::copysign(damper.gamma * std::abs(torque[k]), b.omega[k]);
          torque[k] += damping;
          damped -= damping * b.omega[k] * dt_;
        }
      }
      const double a = 0.5 * damper.alpha * dt_;
      b.momentum = (1 / (1 + a)) * ((1 - a) * b.momentum + dt_ * torque);
      // Implicit midpoint for the orientation at constant angular momentum: omega = R_mid I^-1 R_mid^T momentum
      const auto spin = [&](const Matrix& r) {
        const Vector l = transposed_times(r, b.momentum);
        return r * Vector{l.x / b.inertia.x, l.y / b.inertia.y, l.z / b.inertia.z};
      };
      Vector omega = spin(b.r);
      for (int iteration = 0; iteration < 20; ++iteration) {
        const Vector next = spin(matrix(rotation(0.5 * dt_ * omega) * b.q));
        const Vector change = next - omega;
        omega = next;
        if (dot(change, change) <= 1e-30 * dot(omega, omega)) break;
      }
      if (b.held >> 3) {
        for (int k = 0; k < 3; ++k) {
          if (b.held >> (3 + k) & 1) omega[k] = b.held_omega[k];
        }
        const Vector w = transposed_times(b.r, omega);
        b.momentum = b.r * Vector{b.inertia.x * w.x, b.inertia.y * w.y, b.inertia.z * w.z};
      }
      b.omega = omega;
      if (a > 0) damped += 2 * a * 0.25 * dot(b.momentum + momentum_before, b.omega + omega_before);
    }
    if (b.omega.x != 0 || b.omega.y != 0 || b.omega.z != 0) {
      b.q = normalized(rotation(dt_ * b.omega) * b.q);
      b.r = matrix(b.q);
    }
    sum += b.x.x + b.x.y + b.x.z + b.q.w;
    if (energy_) {
      const Vector mean = 0.5 * (v_before + b.v);
      kinetic += 0.5 * b.mass * dot(mean, mean);
      if ((b.held >> 3) != 7) kinetic += 0.125 * dot(b.momentum + momentum_before, b.omega + omega_before);
    }
  }
  if (energy_) {
    for (const Load& l : loads_) {
      const Vector f = l.factor.at(time_) * l.force;
      const ModelBlock& b = blocks_[l.block];
      if (b.body >= 0) {
        const Body& body = bodies_[b.body];
        external += dot(f, body.v + cross(body.omega, body.r * l.arm)) * dt_;
      } else {
        for (const auto& [node, weight] : l.share) external += weight * dot(f, node_v_[node]) * dt_;
      }
    }
    for (const Pressure& p : pressures_) {
      const double value = p.value * p.factor.at(time_);
      const ModelBlock& b = blocks_[p.block];
      if (b.body >= 0) {
        const Body& body = bodies_[b.body];
        external += value * dot(body.r * p.push, body.v + cross(body.omega, body.r * p.arm)) * dt_;
      } else {
        for (const auto& t : p.triangles) {
          const Vector m = cross(node_x_[t[1]] - node_x_[t[0]], node_x_[t[2]] - node_x_[t[0]]);
          for (int32_t node : t) external -= value / 6 * dot(m, node_v_[node]) * dt_;
        }
      }
    }
    energies_.kinetic = kinetic;
    energies_.damping += damped;
    energies_.external += external;
  }
  unbalanced_ = unbalanced;
  sum_of_positions_ = sum;
  time_ += dt_;
  ++step_count_;
}

void Model::watch() const {
  if (std::isfinite(sum_of_positions_)) return;
  for (int i = 0; i < block_count(); ++i) {
    const ModelBlock& b = blocks_[i];
    double own = 0.0;
    if (b.body >= 0) {
      const Body& body = bodies_[b.body];
      own = body.x.x + body.x.y + body.x.z + body.q.w;
    }
    for (int k = b.first_node; k < b.first_node + b.node_count; ++k) own += node_x_[k].x + node_x_[k].y + node_x_[k].z;
    if (std::isfinite(own)) continue;
    throw Error(Exit::numerical,
                fmt::format("block {}, {} at the start: its position is no finite number at step {}, time {:.6g} s; "
                            "check the velocities and forces of the stage, or reduce time_step_fraction",
                            label(assembly_, i), place(start_x_[i]), step_count_, time_));
  }
}

}  // namespace quoin::blocks
