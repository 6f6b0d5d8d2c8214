// Tables of a building (BuildingSpec) and of its stages.
#pragma once

#include "scene/reader.h"

namespace quoin {

BuildingSpec read_building(reader::Table& t, const Scene& scene);
// Keys of stages of a building. weight: dead load and floors, to equilibrium; push: the floors' whiffletree.
void read_weight(reader::Table& t, Stage& stage, const BuildingSpec& building);
void read_push(reader::Table& t, Stage& stage, const BuildingSpec& building);
// Reads the floors' whiffletree and adds the controls of such a stage. The caller sets its motion.
void read_whiffletree(reader::Table& t, Stage& stage, const BuildingSpec& building);
// The history has the displacement of the last floor, and the forces of the walls on the bottom beam.
void watch_building(Stage& stage, const BuildingSpec& building);
// Adds controls: the bottom beam is held, every floor beam is free under its share of the load.
void add_floor_controls(Stage& stage, const BuildingSpec& building);
// Adds loads: every floor beam has its share of the load, where the stage leaves it free to move down.
void add_floor_loads(Stage& stage, const BuildingSpec& building);

}  // namespace quoin
