// Readers of the tables of a scene and of its stages, one file each: read_NAME.cpp. host/scenes lists the keys. Faults
// go to the context of the table. folder: that of files named by the scene, with its slash.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scene/members.h"
#include "scene/reader.h"

namespace quoin {

// [wall], after materials, joints and solver.
WallSpec read_wall(reader::Table& t, const Scene& scene);

// Size of the wall of openings; 0: its own keys are at fault.
struct Lattice {
  int half_units = 0, courses = 0;
  double half_unit = 0.0;  // m
};

// Reads all tables `opening` of a wall of half units, with their lintels. Openings that do not fit are faults.
std::vector<WallSpec::Opening> read_openings(reader::Table& wall, const Lattice& lattice,
                                             const std::map<std::string, BlockMaterial>& materials);
// Reads all tables `changed` of a wall with these openings: units that are missing or of another material.
std::vector<WallSpec::Changed> read_changed(reader::Table& wall, const Lattice& lattice, const WallSpec& spec,
                                            const std::map<std::string, BlockMaterial>& materials);

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

// Stages of walls and buildings: the short kinds, and custom ones with controls and actions. previous: the stage
// before; null: this is the first. pressure: that of the last pressure stage, which later stages may keep, Pa.
Stage read_stage(reader::Table t, Scene& scene, const Stage* previous, double& pressure, const std::string& folder);

// Blocks of any shape, their [contact] and their stages.
BlocksSpec read_blocks(reader::Table& t, const Scene& scene, const std::string& folder);
void read_contact(reader::Table& c, const SolverSettings& solver, BlocksSpec::Contact* contact);
Stage read_block_stage(reader::Table t, const Scene& scene, const Stage* previous, const std::string& folder);

// Stages of kind cycles, for walls, buildings and blocks of any shape.
// Reads amplitudes, counts, velocity and end at force loss, and sets the duration. Requires read_stage_basics.
// velocity: name of its key, as stages of blocks have tables [[stage.velocity]].
void read_cycles(reader::Table& t, Stage& stage, const char* velocity = "velocity");
// Reads the body named by `key` ("body", "block"), which follows the cycles along `direction`. Its other components are
// as its control has them, held without one. The history shows it. bodies: allowed names; null: checked when the blocks
// are made.
void read_cycled_body(reader::Table& t, const char* key, const std::vector<std::string>* bodies, Stage& stage);

std::shared_ptr<const MemberSpecs> read_members(reader::Table& t, const Scene& scene);  // null: the scene has none
// Reads one [[damage]]. Properties of laws are checked when the simulation is made.
Damage read_damage(reader::Table& t, const Scene& scene);

}  // namespace quoin
