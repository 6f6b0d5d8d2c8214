// All warnings of a run: of its stages, and of its final state.
#pragma once

#include <string>
#include <vector>

#include "results/crushed_out.h"
#include "results/quasi_static.h"
#include "step/simulation.h"

namespace quoin {

// Warnings in the order of their times, each assumption once (Warning::about; quasi_static, too).
std::vector<Warning> warnings_of(const Simulation& simulation, const QuasiStatic& check, const CrushedOut& crushed_out);

// gnuplot command for a label that lists the assumptions that the run violates; empty: none.
std::string warning_label(const std::vector<Warning>& warnings);

}  // namespace quoin
