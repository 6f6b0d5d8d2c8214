// Damage of masonry before the first stage, as states of contact points.
#pragma once

#include <span>
#include <vector>

#include "law/law_library.h"
#include "model/property_columns.h"
#include "scene/scene.h"

namespace quoin {

// Data of a block that decide whether a crack runs along its joints.
struct CrackedBlock {
  Vec3 centre;  // position at the start, m
  int unit;     // index of the masonry unit; -1: none
};

// Contact points of one joint family after damage.
struct DamagedFamily {
  std::vector<double> state;          // one column a state of the law, column after column, of all points
  std::vector<double> opening_shift;  // by point, m: added to the opening that the law receives
  std::size_t points = 0;             // number of damaged points
};

// States of damaged points of a family, without traction and at no opening. `points`: all contact points of the family,
// or some. `of_joints`: all points of the joints of these, which give the places of whole joints to cracks. `hit`
// counts the points of each entry of `damage`. Throws Error(bad_input), with the place in the scene: the law has no
// such state, does not allow the value, or refuses it without traction.
DamagedFamily damage_family(const std::vector<Damage>& damage, const JointFamily& family,
                            const std::shared_ptr<const Material>& material, std::span<const PlacedPoint> points,
                            std::span<const PlacedPoint> of_joints, std::span<const CrackedBlock> blocks,
                            const std::vector<PropertyColumn>& columns, std::vector<double>* hit);

}  // namespace quoin
