#include "model/rigid_motion.h"

#include <Eigen/Dense>

namespace quoin {
namespace {

Eigen::Vector3d vector(const Vec3& v) { return {v[0], v[1], v[2]}; }

// Offset of component c of gridpoint n in a lane of a group.
std::size_t offset(const BlockGroup& group, int n, int c, int lane) {
  return static_cast<std::size_t>((group.first_line + n) * kLine + c * kLanes + lane);
}

// Position of gridpoint n of a group from the lowest corner of the first block of its unit.
Eigen::Vector3d place_in_unit(const Model& model, const BlockGroup& group, int n) {
  const BrickTemplate& shape = model.templates[static_cast<std::size_t>(group.brick_template)];
  return vector(shape.node[static_cast<std::size_t>(n)]) + vector(group.offset);
}

int node_count(const Model& model, const BlockGroup& group) {
  return model.templates[static_cast<std::size_t>(group.brick_template)].node_count;
}

// Rigid motion of the blocks of `count` groups as one body; positions from the first block of the unit.
RigidMotion motion_of(const Model& model, const BlockGroup* groups, int count, const LaneVector<double>& node_mass) {
  double mass = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  bool held[3] = {false, false, false};
  const auto for_each_gridpoint = [&](auto visit) {
    for (const BlockGroup* group = groups; group < groups + count; ++group) {
      for (int n = 0; n < node_count(model, *group); ++n)
        visit(*group, n, node_mass[offset(*group, n, 0, 0)], place_in_unit(model, *group, n));
    }
  };
  for_each_gridpoint([&](const BlockGroup& group, int n, double m, const Eigen::Vector3d& x) {
    mass += m;
    moment += m * x;
    for (int c = 0; c < 3; ++c) held[c] = held[c] || model.node_free[offset(group, n, c, 0)] == 0.0;
  });
  const Eigen::Vector3d centre = moment / mass;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for_each_gridpoint([&](const BlockGroup&, int, double m, const Eigen::Vector3d& x) {
    const Eigen::Vector3d r = x - centre;
    inertia += m * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  });
  RigidMotion motion;
  motion.mass = mass;
  for (std::size_t c = 0; c < 3; ++c) {
    motion.centre[c] = centre[static_cast<int>(c)];
    motion.inverse_mass[c] = held[c] ? 0.0 : 1.0 / mass;
  }
  // Rotation about an axis moves gridpoints along the two others: both must be free.
  bool turns[3], any_held = false;
  for (int c = 0; c < 3; ++c) {
    turns[c] = !held[(c + 1) % 3] && !held[(c + 2) % 3];
    any_held = any_held || held[c];
  }
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  if (!any_held) {
    inverse = inertia.inverse();
  } else {
    for (int c = 0; c < 3; ++c) inverse(c, c) = turns[c] ? 1.0 / inertia(c, c) : 0.0;
  }
  for (int i = 0; i < 9; ++i) {
    motion.inertia[static_cast<std::size_t>(i)] = inertia(i / 3, i % 3);
    motion.inverse_inertia[static_cast<std::size_t>(i)] = inverse(i / 3, i % 3);
  }
  return motion;
}

}  // namespace

RigidMotions rigid_motions(const Model& model, const LaneVector<double>& node_mass) {
  RigidMotions motions;
  const auto is_laid_out = [&](const BlockGroup& group) { return node_mass[offset(group, 0, 0, 0)] > 0.0; };
  for (const BlockGroup& group : model.groups) {
    RigidMotion& motion = motions.block.emplace_back();
    if (!is_laid_out(group)) continue;
    motion = motion_of(model, &group, 1, node_mass);
    motion.centre -= group.offset;
  }
  for (const UnitGroup& unit : model.unit_groups) {
    const BlockGroup* first = &model.groups[static_cast<std::size_t>(unit.first_group)];
    motions.unit.emplace_back();
    if (is_laid_out(*first)) motions.unit.back() = motion_of(model, first, unit.group_count, node_mass);
  }
  return motions;
}

}  // namespace quoin
