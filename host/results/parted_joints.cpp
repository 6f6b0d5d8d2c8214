#include "results/parted_joints.h"

#include <algorithm>
#include <set>

#include "geometry/vector.h"
#include "step/large_motion.h"

namespace quoin {

std::vector<PartedJoint> parted_joints(const Simulation& simulation) {
  const blocks::Model* riding = simulation.riding();
  if (!riding) return {};
  std::set<std::pair<int, int>> touching;
  for (const blocks::Contact& c : riding->contacts()) {
    if (c.count > 0) touching.insert({c.pair.a, c.pair.b});
  }
  const auto moved = [&](int block, const geometry::Vector& start) {
    return riding->position(block) + riding->orientation(block) * (start - simulation.riding_start(block));
  };
  std::vector<PartedJoint> parted;
  for (const blocks::StartJoint& joint : riding->start_joints()) {
    if (touching.contains({joint.pair.a, joint.pair.b})) continue;
    PartedJoint& now = parted.emplace_back(PartedJoint{joint.pair.a, joint.pair.b, {}, {}, 0.0});
    for (const geometry::Vector& start : riding->start_points(joint)) {
      const geometry::Vector a = moved(joint.pair.a, start), b = moved(joint.pair.b, start);
      now.side_a.push_back(geometry::array(a)), now.side_b.push_back(geometry::array(b));
      now.opening = std::max(now.opening, norm(b - a));
    }
  }
  return parted;
}

}  // namespace quoin
