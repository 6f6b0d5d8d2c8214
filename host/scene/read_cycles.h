// Stages of kind cycles, of every kind of scene.
#pragma once

#include "scene/reader.h"

namespace quoin {

// Amplitudes, numbers, velocity, end at force loss; and how long they take. After read_stage_basics. velocity: the
// key that has it, as stages of blocks have tables [[stage.velocity]].
void read_cycles(reader::Table& t, Stage& stage, const char* velocity = "velocity");
// The body that `key` ("body", "block") names goes in the cycles along `direction`, other components as its control
// has them, held without one. The history shows it. bodies: what can be moved; null: not known before the blocks are.
void read_cycled_body(reader::Table& t, const char* key, const std::vector<std::string>* bodies, Stage& stage);

}  // namespace quoin
