// Small assemblies and an independent finite-element computation to hold the host against.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <string>

#include "scene/generate.h"
#include "step/state.h"

namespace quoin {

inline constexpr double kYoung = 16.7e9, kPoisson = 0.15, kDensity = 1900.0;
inline constexpr double kNormal = 82e9, kShear = 36e9;  // joint stiffness, Pa/m

BlockMaterial brick_material(double poisson_ratio = kPoisson);
JointFamily elastic_family(double kn = kNormal, double ks = kShear);
JointFamily mortar_family();  // fracture energy, Table 1 of the paper

// count[0] x count[1] x count[2] equal deformable bricks, joined everywhere by the first family.
Assembly brick_grid(std::array<int, 3> count, Vec3 size, std::array<int, 3> zones,
                    JointFamily family = elastic_family(), BlockMaterial material = brick_material());

// Pairs of neighbours along x as units of two halves.
Assembly in_units(Assembly assembly);

// The paper's solid wall, or a smaller one of the same bricks.
Scene wall_scene(int courses = 16, double units = 4.5);

// Solver settings alone: no stages, nothing controlled.
Scene bare_scene(double fraction = 0.6, DampingKind damping = DampingKind::none);

// Stiffness and lumped mass of one brick from 5 tetrahedra a hexahedron, dense, by B^T D B: degrees of freedom 3 node +
// c. Shares no code with the host.
Eigen::MatrixXd dense_stiffness(const Brick& brick, const BlockMaterial& material);
Eigen::VectorXd dense_mass(const Brick& brick, const BlockMaterial& material);

// Of gridpoints, in lane layout.
inline LaneVector<double>& lattice_displacement(Simulation::Impl& s) { return s.lattice.displacement; }
inline LaneVector<double>& lattice_velocity(Simulation::Impl& s) { return s.lattice.velocity; }

// Every moving component from -largest to largest.
void random_velocities(Simulation* simulation, unsigned seed, double largest = 1e-3);

// Largest displacement after some steps from small random velocities; infinite when the step gave up.
double largest_after(const Scene& scene, const Assembly& assembly, int steps);

// The head of a scene file without damping: the material "stone", 2000 kg/m3, and its elastic joints.
std::string undamped_stone(const std::string& kernels);

// Offset of component c of a gridpoint of a deformable block.
std::size_t dof(const Model& model, int block, int node, int c);

}  // namespace quoin
