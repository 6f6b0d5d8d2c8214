#include "step/rigid_bodies.h"

#include "base/local_damping.h"

namespace quoin {
namespace {

// Advances one degree of freedom with eq. 1, relative to a ground of this velocity. Returns the damping force.
double advance_component(double force, double inertia, const StepData& step, double ground, double* velocity) {
  double damping = 0.0;
  if (step.eq1 != Eq1::nothing) {
    damping = local_damping(step.local_damping, force, *velocity - ground);
  } else if (step.mass_damping > 0.0) {
    damping = step.mass_damping * inertia * (*velocity - ground);
  }
  *velocity += (force - damping) * (step.time_step / inertia);
  return damping;
}

}  // namespace

void advance_body(const RigidBody& body, double mass, const Vec3& inertia, const StepData& step, BodyLanes* state,
                  Measured* measured) {
  Vec3 force{}, moment{};
  for (std::size_t i = 0; i < body.point.size(); ++i) {
    const std::size_t point = static_cast<std::size_t>(body.point[i]);
    const Vec3 f{body.sign[i] * step.force[0][point], body.sign[i] * step.force[1][point],
                 body.sign[i] * step.force[2][point]};
    force += f, moment += cross(body.arm[i], f);
  }

  Measured work;
  const double half_dt = 0.5 * step.time_step;
  Vec3 displacement, rotation, velocity, spin;
  for (std::size_t c = 0; c < 3; ++c) {
    const double before = state->velocity[c][0];
    double& after = state->velocity[c][0];
    if (state->prescribed[c][0] != 0.0) {
      // The support does the work that the joints take from it.
      after = state->prescribed_velocity[c][0];
      work.external_before -= force[c] * before * half_dt;
      work.external_after -= force[c] * after * half_dt;
    } else if (!body.held[c]) {
      const double given = state->applied_force[c][0] + body.mass * step.gravity[c];
      const double damping = advance_component(force[c] + given, mass, step, step.ground_velocity[c], &after);
      work.external_before += given * before * half_dt;
      work.external_after += given * after * half_dt;
      work.damping_before += damping * before * half_dt;
      work.damping_after += damping * after * half_dt;
      work.kinetic += 0.5 * mass * before * after;
      work.unbalanced_squared += (force[c] + given) * (force[c] + given);
    }
    const double spin_before = state->spin[c][0];
    double& spin_after = state->spin[c][0];
    if (state->prescribed[3 + c][0] != 0.0) {
      work.external_before -= moment[c] * spin_before * half_dt;
      work.external_after -= moment[c] * spin_after * half_dt;
    } else if (!body.held[3 + c]) {
      const double given = state->applied_moment[c][0];
      const double damping = advance_component(moment[c] + given, inertia[c], step, 0.0, &spin_after);
      work.external_before += given * spin_before * half_dt;
      work.external_after += given * spin_after * half_dt;
      work.damping_before += damping * spin_before * half_dt;
      work.damping_after += damping * spin_after * half_dt;
      work.kinetic += 0.5 * inertia[c] * spin_before * spin_after;
    }
    velocity[c] = after;
    spin[c] = spin_after;
    displacement[c] = state->displacement[c][0] += step.time_step * after;
    rotation[c] = state->rotation[c][0] += step.time_step * spin_after;
  }
  for (std::size_t i = 0; i < body.slave.size(); ++i) {
    const Vec3 v = velocity + cross(spin, body.arm[i]), u = displacement + cross(rotation, body.arm[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t at = static_cast<std::size_t>(body.slave[i]) + kLanes * c;
      step.velocity[at] = v[c], step.displacement[at] = u[c];
    }
  }
  if (measured) *measured = work;
}

}  // namespace quoin
