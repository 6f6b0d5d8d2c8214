// Looks at what a run assumes, and what it says when the run is past that.
#pragma once

#include <optional>
#include <vector>

#include "law/answers.h"
#include "step/state.h"

namespace quoin {

// Whether the energies of this step, before a row, are to be compared with those of the next.
bool begins_check(const Simulation::Impl& s);
// Between a step that was checked and the next, another one has come, or both are done.
void end_check(Simulation::Impl& s);
// The balance of a step: what it stores more, less what came in, is nothing. Steps that were checked stand for all.
void check_energies(Simulation::Impl& s, const Energies& now, double dissipated, double work_before, double work_after);
std::optional<WrongAnswer> wrong_law(const Simulation::Impl& s);  // wrong answer among the last ones of the laws
// When a row is written, after its step. Returns new warnings, which outcome has too.
std::vector<Warning> new_warnings(Simulation::Impl& s);

}  // namespace quoin
