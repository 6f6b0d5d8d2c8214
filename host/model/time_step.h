// Stable time step of central differences for the undamaged assembled system.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "model/impact_damping.h"
#include "model/model.h"
#include "model/rigid_motion.h"
#include "model/shared_model.h"
#include "scene/scene.h"

namespace quoin {

struct TimeStepLimit {
  double value = 0.0;  // s
  Vec3 position{};     // gridpoint or body that sets it, m
  std::string where;   // "block 12, gridpoint 3, family 'mortar' carries 61 % of the stiffness"
};

struct TimeStepReport {
  TimeStepLimit critical;    // 2/omega_max by Lanczos
  TimeStepLimit gershgorin;  // row sums: a guaranteed lower bound of `critical`, without scaling of deformation
  TimeStepLimit nodal;       // eq. 3 with diagonal stiffness, 2 sqrt(m/k): for comparison, usually unstable
  int lanczos_steps = 0;
  double time_step = 0.0;  // step in use, s
  // Local damping adds up to gamma times the force of a degree of freedom to it, which acts like that much more
  // stiffness. Above this fraction of the critical step, 1/sqrt(1 + gamma), stiff modes chatter. 1 without local
  // damping.
  double quiet_fraction = 1.0;
  std::string warning() const;     // text for a step above the quiet one or above 2/omega_max; else empty
  double stiffness_damping = 0.0;  // s, of zones, of viscous damping in use
  double joint_damping = 0.0;      // s, of contact points that it damps in proportion to stiffness
  ImpactDamping impacts;
  bool damps_joints() const { return !impacts.viscosity.empty() || joint_damping > 0.0; }
  double added_mass = 0.0;  // kg, by selective mass scaling
  double model_mass = 0.0;  // kg, before any scaling
};

// Inertia in use (mass scaling included), by component of gridpoints and by rigid body.
struct Inertia {
  LaneVector<double> node;               // kg; 0 where there is no gridpoint
  std::vector<double> body_mass;         // kg
  std::vector<Vec3> body_inertia;        // kg m2
  double deformation = 1.0, unit = 1.0;  // s_b and s_u of rigid_motion.h
  RigidMotions rigid;                    // empty unless scaling or damping needs it
};

// Limits to compute: critical.value alone, or nodal.value with it. `all` computes the third limit and all places too.
// It takes twice the time, and a whole model.
enum class Limits { critical, nodal, all };

// Inertia with the scaling of the settings, of the part of the model that is laid out. shared: as in choose_time_step.
Inertia inertia_in_use(const Model& model, const SolverSettings& settings, SharedModel* shared = nullptr);

// Chooses the time step for an inertia. stages: their whiffletrees are springs. shared: the part of the model that this
// process has; null: all of it. Where the settings need rows, the part has the masses of all blocks that touch it.
TimeStepReport choose_time_step(const Model& model, const SolverSettings& settings, Inertia* inertia,
                                Limits wanted = Limits::all, const std::vector<Stage>& stages = {},
                                SharedModel* shared = nullptr);

// TimeStepReport::quiet_fraction for the damping of these settings.
double quiet_fraction_of(const SolverSettings& settings);

// Whether inertia or time step depend on rows of K.
bool needs_rows(const SolverSettings& settings);

// Eigenvalue of the stiffest whiffletree on the masses that it pulls, 1/s2. Its energy K/(2 n) (sum of the n floors'
// displacements)^2 gives every floor the same force. With the mean over the m_f blocks of a floor, lambda = K/n sum
// 1/(m_f^2 mass). compliances: 1/mass of each block of a name, 1/kg.
double whiffletree_eigenvalue(const std::vector<Stage>& stages,
                              const std::function<std::vector<double>(const Stage&, const std::string&)>& compliances);

// K of the undamaged assembled system times a vector: gridpoints in lane layout, then 6 numbers a rigid body
// (translation, rotation about its centre). Symmetric.
void apply_undamaged_stiffness(const Model& model, const std::vector<double>& u, std::vector<double>* f);

}  // namespace quoin
