// Control of a simulation from outside, between two steps: views of its arrays, prescribed velocities, forces and law
// swaps.
#pragma once

#include <cstddef>
#include <string>

#include "step/simulation.h"

namespace quoin {

// Set the velocity or force of the bodies of a name until the next stage begins, without a ramp. NaN components keep
// theirs. A velocity needs a component that the stage holds or moves, a force one that is free. A force replaces forces
// and pressures of the stage along its components. Before the first step these begin the first stage. Each throws
// Error(bad_input) with what the scene has instead, and nothing has changed then.
void set_velocity(Simulation::Impl& s, const std::string& body, const Vec3& velocity);  // m/s
void set_force(Simulation::Impl& s, const std::string& body, const Vec3& force);        // N, on each body of that name
// Swaps the law of a joint family; all points keep their tractions. Throws Error(bad_input) or Error(law_refused).
LawSwap exchange_law(Simulation::Impl& s, const std::string& family, const std::string& law);

// View of a current array of doubles: row r, column c is data[r * row_stride + c * column_stride]. It is valid until
// the simulation is stepped, steered or restored. data null: no such array, as displacements and positions in large
// motion.
struct ArrayView {
  double* data = nullptr;
  std::size_t rows = 0, columns = 1;
  std::ptrdiff_t row_stride = 1, column_stride = 1;
};
enum class BlockArray { displacement, velocity };  // m, m/s
// A row a gridpoint: x, y, z; of a rigid block one row, its centre.
ArrayView view(Simulation::Impl& s, BlockArray what, int block);
enum class PointArray {
  sigma,
  tau_s,
  tau_t,
  area,
  position
};  // Pa, m2, m (position: on the lattice that at the start)
ArrayView view(Simulation::Impl& s, PointArray what, int family);
ArrayView view_state(Simulation::Impl& s, int family, const std::string& id);  // Error(bad_input): no such state
void velocities_changed(Simulation::Impl& s);  // to be called after velocities were written through a view

}  // namespace quoin
