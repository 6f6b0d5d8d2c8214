// The part of a scene file that describes a building (BuildingSpec); used by read_scene.cpp alone.
#pragma once

#include "scene/reader.h"

namespace quoin {

BuildingSpec read_building(reader::Table& t, const Scene& scene);
// Stages of a building. weight: dead load and floors, to equilibrium; push: the floors' whiffletree.
void read_weight(reader::Table& t, Stage& stage, const BuildingSpec& building);
void read_push(reader::Table& t, Stage& stage, const BuildingSpec& building);
// The floors' whiffletree, and what else such a stage controls; its motion is the caller's to set.
void read_whiffletree(reader::Table& t, Stage& stage, const BuildingSpec& building);
// The bottom beam held, every floor beam free under its share of the load.
void add_floor_controls(Stage& stage, const BuildingSpec& building);
// Every floor beam under its share of the load, as far as the stage leaves it free to go down.
void add_floor_loads(Stage& stage, const BuildingSpec& building);

}  // namespace quoin
