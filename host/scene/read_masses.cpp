#include "scene/read_masses.h"

#include <algorithm>

#include "scene/actions/action.h"
#include "scene/generate_blocks.h"
#include "scene/load_place.h"

namespace quoin {

using namespace reader;
using geometry::Vector;

std::vector<AddedMass> read_masses(Table& scene) {
  std::vector<AddedMass> masses;
  scene.each("mass", [&](Table& t) {
    AddedMass& added = masses.emplace_back();
    added.source = {t.where()};
    t.text("block", added.block, "the name of a block, body or beam of a floor", true);
    t.number("mass", added.mass, kPositive, "kg", true);
    Vec3 point{};
    if (t.numbers("point", point, kPlace, "m, where the mass is at the start")) added.point = point;
  });
  return masses;
}

std::vector<AddedMass> masses_of_floors(const BuildingSpec& building) {
  std::vector<AddedMass> masses;
  for (const BuildingSpec::Floor& floor : building.floors) {
    if (floor.mass <= 0.0) continue;
    const auto bodies = floor.bodies();
    for (const std::string& body : bodies)
      masses.push_back({body, floor.mass / static_cast<double>(bodies.size()), std::nullopt, floor.source});
  }
  return masses;
}

void add_masses(const Scene& scene, blocks::Assembly* assembly) {
  constexpr double kOnFace = 1e-6;  // m
  for (const AddedMass& added : scene.masses) {
    const std::vector<int> named = blocks::find_blocks(*assembly, added.block, added.source.text);
    if (added.point && named.size() > 1)
      throw Error(Exit::bad_input, fmt::format("{}: {} blocks are called '{}', and a point is of one alone; remove "
                                               "point, so that they share the mass",
                                               added.source.text, named.size(), added.block));
    for (const int index : named) {
      blocks::Block& block = assembly->blocks[static_cast<std::size_t>(index)];
      refuse_on_fixed(block, "mass", added.source);
      if (!added.point) {
        block.spread_mass += added.mass / static_cast<double>(named.size());
        continue;
      }
      const Vector at = geometry::vector(*added.point);
      if (const double outside = distance_from(*assembly, block, at); !block.rigid && outside > kOnFace)
        throw Error(Exit::bad_input,
                    fmt::format("{}: point {} is {:.3g} m outside of block '{}', which deforms; allowed: a point in it "
                                "or on its face. Rigid blocks carry masses outside of them",
                                added.source.text, geometry::place(at), outside, added.block));
      block.masses.push_back({at, added.mass});
    }
  }
}

}  // namespace quoin
