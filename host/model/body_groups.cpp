#include "model/body_groups.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace quoin {
namespace {

constexpr double kArmTolerance = 1e-9;  // share of the arm

bool same_place(const BodyPoint& p, const BodyPoint& q) {
  double length = 0.0, distance = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    length = std::max(length, std::abs(p.arm[c]));
    distance = std::max(distance, std::abs(p.arm[c] - q.arm[c]));
  }
  return p.face == q.face && distance <= kArmTolerance * length;
}

std::vector<BodyPoint> on_face(const std::vector<BodyPoint>& points, int face) {
  std::vector<BodyPoint> found;
  std::copy_if(points.begin(), points.end(), std::back_inserter(found), [&](const auto& p) { return p.face == face; });
  return found;
}

// Slots that hold the points of both; empty when they do not agree on a face.
std::vector<BodyPoint> common_slots(const std::vector<BodyPoint>& slots, const std::vector<BodyPoint>& points) {
  std::vector<BodyPoint> common;
  for (int face = 0; face < 6; ++face) {
    const auto one = on_face(slots, face), other = on_face(points, face);
    if (!one.empty() && !other.empty() && !std::equal(one.begin(), one.end(), other.begin(), other.end(), same_place))
      return {};
    const auto& used = one.empty() ? other : one;
    common.insert(common.end(), used.begin(), used.end());
  }
  return common;
}

}  // namespace

int BodyClass::first_slot(int face) const {
  return static_cast<int>(std::find_if(slot.begin(), slot.end(), [&](const BodyPoint& s) { return s.face >= face; }) -
                          slot.begin());
}

std::vector<BodyClass> body_classes(const std::vector<RigidBody>& bodies,
                                    const std::vector<std::vector<BodyPoint>>& points_of) {
  std::vector<BodyClass> classes;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (points_of[b].empty()) continue;
    std::vector<BodyPoint> slots;
    const auto found = std::find_if(classes.begin(), classes.end(), [&](const BodyClass& c) {
      if (bodies[static_cast<std::size_t>(c.body[0])].name != bodies[b].name) return false;
      slots = common_slots(c.slot, points_of[b]);
      return !slots.empty();
    });
    if (found == classes.end()) {
      classes.push_back({common_slots({}, points_of[b]), {static_cast<int>(b)}});
    } else {
      found->slot = slots;
      found->body.push_back(static_cast<int>(b));
    }
  }
  classes.erase(
      std::remove_if(classes.begin(), classes.end(), [](const BodyClass& c) { return c.body.size() < kFewBodies; }),
      classes.end());
  return classes;
}

}  // namespace quoin
