// Rigid bodies that move side by side, one a lane: which ones.
#pragma once

#include <vector>

#include "model/model.h"

namespace quoin {

// A contact point on the side of its body.
struct BodyPoint {
  int face = 0;  // 2 axis + 1 on the positive side
  Vec3 arm{};    // place from the centre, m
};

// Bodies of one name that have contact points at the same places, in the same order, on every face that they use.
struct BodyClass {
  std::vector<BodyPoint> slot;  // by face
  std::vector<int> body;        // bodies in the order of the model
  int first_slot(int face) const;
};

// Fewer bodies than this move faster one by one.
inline constexpr std::size_t kFewBodies = 4;

// Classes of kFewBodies and more. points_of: by body, face after face.
std::vector<BodyClass> body_classes(const std::vector<RigidBody>& bodies,
                                    const std::vector<std::vector<BodyPoint>>& points_of);

}  // namespace quoin
