// Checks of a run's assumptions, and warnings where they are violated.
#pragma once

#include <optional>
#include <vector>

#include "law/answers.h"
#include "step/state.h"

namespace quoin {

// Counts the contact points that crush already when a stage begins.
void note_crushed(Simulation::Impl& s);
// Whether this step, before a row, is the first of two whose energies are compared.
bool begins_check(const Simulation::Impl& s);
// Whether all laws compute energies. Otherwise energies do not balance.
bool laws_give_energies(const Simulation::Impl& s);
// Ends a comparison of two steps: it is complete, or the second step was not measured.
void end_check(Simulation::Impl& s);
// Adds a step to the comparison: stored energy must change by work less dissipation. The steps that are compared stand
// for all.
void check_energies(Simulation::Impl& s, const Energies& now, double dissipated, double work_before, double work_after);
double least_extent(const Simulation::Impl& s, int block);  // m
// First wrong answer of a law in its last call; none: all are right.
std::optional<WrongAnswer> wrong_law(const Simulation::Impl& s);
// Checks all assumptions when a row is written, after its step; stage_ends: the last of its stage. Returns the new
// warnings, which Outcome has too.
std::vector<Warning> new_warnings(Simulation::Impl& s, bool stage_ends);

}  // namespace quoin
