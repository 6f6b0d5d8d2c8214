// Rigid bodies that move side by side, one a lane: which ones, and in which lane.
#pragma once

#include <utility>
#include <vector>

#include "model/model.h"

namespace quoin {

// A contact point as its body sees it.
struct BodyPoint {
  int face = 0;  // 2 axis + 1 on the positive side
  Vec3 arm{};    // from the centre, m
};

// Bodies of one name that have contact points at the same places, in the same order, on every face that they use.
struct BodyClass {
  std::vector<BodyPoint> slot;  // by face
  std::vector<int> body;        // in the order of the model
  int first_slot(int face) const;
};

// Fewer bodies than this move faster one by one.
inline constexpr std::size_t kFewBodies = 4;

// Classes of kFewBodies and more. points_of: by body, face after face.
std::vector<BodyClass> body_classes(const std::vector<RigidBody>& bodies,
                                    const std::vector<std::vector<BodyPoint>>& points_of);

// Body i of a class goes to lane i / G of group i mod G: G, for bodies joined as these pairs are. Where the same
// difference of i joins most pairs, as in the courses of a wall, G is a multiple of it: then the lanes of a group have
// their neighbours in the lanes of one other group, and contact points need no gathers.
int group_count(const BodyClass& kind, const std::vector<std::pair<int, int>>& joined);

}  // namespace quoin
