// What a controller outside does between two steps (steer.cpp): it reads arrays where they lie, and moves, loads and
// exchanges.
#pragma once

#include <cstddef>
#include <string>

#include "step/simulation.h"

namespace quoin {

// From now on and until the next stage begins; without a ramp. What the stage does not hold along a component has no
// velocity to be given, what it holds takes no force. Before the first step the first stage is begun. Each throws
// Error(bad_input) with what the scene has instead, and nothing has changed then. Components that are free (held for
// forces) keep theirs: NaN.
void set_velocity(Simulation::Impl& s, const std::string& body, const Vec3& velocity);  // m/s
void set_force(Simulation::Impl& s, const std::string& body, const Vec3& force);        // N, on each body of that name
// The tractions of all points stay. Throws Error(law_refused) too.
LawSwap exchange_law(Simulation::Impl& s, const std::string& family, const std::string& law);

// Where arrays of now lie, in doubles: row r, column c at data[r * row_stride + c * column_stride]. Good until the
// simulation is stepped, steered or restored. data null: there is none, as displacements in large motion.
struct ArrayView {
  double* data = nullptr;
  std::size_t rows = 0, columns = 1;
  std::ptrdiff_t row_stride = 1, column_stride = 1;
};
enum class BlockArray { displacement, velocity };  // m, m/s
// By gridpoint, x y z; of a rigid block one row: its centre.
ArrayView view(Simulation::Impl& s, BlockArray what, int block);
enum class PointArray { sigma, tau_s, tau_t, area, position };  // Pa, m2, m (reference on the lattice, else now)
ArrayView view(Simulation::Impl& s, PointArray what, int family);
ArrayView view_state(Simulation::Impl& s, int family, const std::string& id);  // Error(bad_input): no such state
void velocities_changed(Simulation::Impl& s);  // to be called after velocities were written through a view

}  // namespace quoin
