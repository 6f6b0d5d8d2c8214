// Damage that masonry has before the first stage, as states of its contact points.
#pragma once

#include <span>
#include <vector>

#include "law/law_library.h"
#include "model/property_columns.h"
#include "scene/scene.h"

namespace quoin {

// The data of a block that cracks depend on.
struct CrackedBlock {
  Vec3 centre;  // m, of the start
  int unit;     // masonry unit; -1: none
};

// What damage makes of the points of one joint family.
struct DamagedFamily {
  std::vector<double> state;          // columns of the law, one after the other, of all points
  std::vector<double> opening_shift;  // by point, m: added to the opening of the law
  std::size_t points = 0;             // number of damaged points
};

// Contact points of a family, all or some, without traction and at no opening. `of_joints` has all points of their
// joints, by which cracks know where a joint is. `hit` counts, by entry of `damage`, the points that it finds. Throws
// Error(bad_input), with the place in the scene, for what the law does not have, does not allow, or cannot bear at
// rest.
DamagedFamily damage_family(const std::vector<Damage>& damage, const JointFamily& family,
                            const std::shared_ptr<const Material>& material, std::span<const PlacedPoint> points,
                            std::span<const PlacedPoint> of_joints, std::span<const CrackedBlock> blocks,
                            const std::vector<PropertyColumn>& columns, std::vector<double>* hit);

}  // namespace quoin
