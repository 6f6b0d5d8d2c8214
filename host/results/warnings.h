// Everything that a run warns of: what its stages found out, and what is seen at its end.
#pragma once

#include <string>
#include <vector>

#include "results/crushed_out.h"
#include "results/quasi_static.h"
#include "step/simulation.h"

namespace quoin {

// In the order of their times; each assumption once (Warning::about; quasi_static, too).
std::vector<Warning> warnings_of(const Simulation& simulation, const QuasiStatic& check, const CrushedOut& crushed_out);

// The gnuplot command that writes in a picture which assumptions the run has left; empty: none.
std::string warning_label(const std::vector<Warning>& warnings);

}  // namespace quoin
