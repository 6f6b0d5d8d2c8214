// Groups of rigid bodies that SIMD kernels advance together, one body a lane.
#pragma once

#include <vector>

#include "model/model.h"

namespace quoin {

// A contact point on the side of its body.
struct BodyPoint {
  int face = 0;  // 2 axis + 1 on the positive side
  Vec3 arm{};    // place from the centre, m
};

// Bodies of one name whose contact points have the same places in the same order, on every face that has any.
struct BodyClass {
  std::vector<BodyPoint> slot;  // by face
  std::vector<int> body;        // bodies in the order of the model
  int first_slot(int face) const;
};

// Classes of fewer bodies than this are faster one by one.
inline constexpr std::size_t kFewBodies = 4;

// Classes of at least kFewBodies bodies. points_of: contact points by body, face after face.
std::vector<BodyClass> body_classes(const std::vector<RigidBody>& bodies,
                                    const std::vector<std::vector<BodyPoint>>& points_of);

}  // namespace quoin
