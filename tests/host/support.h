// Small assemblies, and an independent finite-element computation for comparison with the host.
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

// Returns count[0] x count[1] x count[2] equal deformable bricks, with joints of one family between all neighbours.
Assembly brick_grid(std::array<int, 3> count, Vec3 size, std::array<int, 3> zones,
                    JointFamily family = elastic_family(), BlockMaterial material = brick_material());

// Makes units of two halves from pairs of neighbours along x.
Assembly in_units(Assembly assembly);

// Returns the paper's solid wall, or another one of the same bricks.
Scene wall_scene(int courses = 16, double units = 4.5);

// Returns a scene with solver settings only, without stages and controls.
Scene bare_scene(double fraction = 0.6, DampingKind damping = DampingKind::none);

// Return stiffness B^T D B and lumped mass of one brick of 5 tetrahedra in each hexahedron, dense. Degrees of freedom
// are 3 node + c. Independent of the code of the host.
Eigen::MatrixXd dense_stiffness(const Brick& brick, const BlockMaterial& material);
Eigen::VectorXd dense_mass(const Brick& brick, const BlockMaterial& material);

// Return displacements and velocities of gridpoints, in lane layout.
inline LaneVector<double>& lattice_displacement(Simulation::Impl& s) { return s.lattice.displacement; }
inline LaneVector<double>& lattice_velocity(Simulation::Impl& s) { return s.lattice.velocity; }

// Sets every velocity component that may move to a random number from -largest to largest, m/s.
void random_velocities(Simulation* simulation, unsigned seed, double largest = 1e-3);

// Returns the largest displacement after some steps from small random velocities; infinite if the step throws.
double largest_after(const Scene& scene, const Assembly& assembly, int steps);

// Returns the beginning of a scene without damping: the material "stone", 2000 kg/m3, and its elastic joints.
std::string undamped_stone(const std::string& kernels);

// Returns the offset of component c of a gridpoint of a deformable block.
std::size_t dof(const Model& model, int block, int node, int c);

}  // namespace quoin
