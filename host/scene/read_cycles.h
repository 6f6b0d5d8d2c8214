// Stages of kind cycles, for walls, buildings and blocks of any shape.
#pragma once

#include "scene/reader.h"

namespace quoin {

// Reads amplitudes, counts, velocity and end at force loss, and sets the duration. Requires read_stage_basics.
// velocity: name of its key, as stages of blocks have tables [[stage.velocity]].
void read_cycles(reader::Table& t, Stage& stage, const char* velocity = "velocity");
// Reads the body named by `key` ("body", "block"), which follows the cycles along `direction`. Its other components are
// as its control has them, held without one. The history shows it. bodies: allowed names; null: checked when the blocks
// are made.
void read_cycled_body(reader::Table& t, const char* key, const std::vector<std::string>* bodies, Stage& stage);

}  // namespace quoin
