// Checkpoints as files, and the state of a small wall with changed bytes, from which a run is resumed.
#include <cstring>

#include "input.h"
#include "judge.h"
#include "results/checkpoint_file.h"
#include "scene/read_scene.h"
#include "step/simulation.h"

namespace {

constexpr const char* kWall = R"(
[materials.brick]
young_modulus = 16.7e9
poisson_ratio = 0.15
density = 2000.0
[joints.mortar]
law = "elastic"
normal_stiffness = 8e10
shear_stiffness = 4e10
[wall]
unit = [0.2, 0.05, 0.1]
units_per_course = 2
courses = 2
unit_material = "brick"
bed_joint = "mortar"
head_joint = "mortar"
unit_joint = "mortar"
beam_joint = "mortar"
zones = [1, 1, 1]
[[stage]]
name = "weight"
kind = "pressure"
pressure = 1e5
)";

quoin::Simulation& wall() {
  static quoin::Simulation simulation(quoin::read_scene_text(kWall, "wall.toml"));
  return simulation;
}

}  // namespace

// The first byte selects one of both. Then follows a file, or edits of five bytes: position and new value.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quoin;
  static const std::vector<std::uint8_t> good = [] {
    wall().advance(4);
    return wall().save();
  }();
  if (size == 0) return 0;
  judge({Exit::bad_input, Exit::numerical}, [&] {
    if (data[0] % 2 == 0) {
      read_checkpoint(file_of(data + 1, size - 1, ".bin"), {});
      return;
    }
    std::vector<std::uint8_t> bytes = good;
    for (std::size_t at = 1; at + 5 <= size; at += 5) {
      std::uint32_t place;
      std::memcpy(&place, data + at, 4);
      bytes[place % bytes.size()] = data[at + 4];
    }
    if (data[0] & 2) bytes.resize(bytes.size() - data[0] % 61);
    wall().restore(bytes);
    wall().advance(2);
  });
  return 0;
}
