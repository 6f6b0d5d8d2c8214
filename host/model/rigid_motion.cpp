#include "model/rigid_motion.h"

#include <Eigen/Dense>
#include <cmath>

namespace quoin {
namespace {

Eigen::Vector3d vector(const Vec3& v) { return {v[0], v[1], v[2]}; }

// Offset of component c of gridpoint n in a lane of a group.
std::size_t offset(const BlockGroup& group, int n, int c, int lane) {
  return static_cast<std::size_t>((group.first_line + n) * kLine + c * kLanes + lane);
}

}  // namespace

RigidMotion rigid_motion_of(const Model& model, const BlockGroup& group, const LaneVector<double>& node_mass) {
  const BrickTemplate& shape = model.templates[static_cast<std::size_t>(group.brick_template)];
  const auto mass_of = [&](int n) { return node_mass[offset(group, n, 0, 0)]; };
  double mass = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  bool held[3] = {false, false, false};
  for (int n = 0; n < shape.node_count; ++n) {
    mass += mass_of(n);
    moment += mass_of(n) * vector(shape.node[static_cast<std::size_t>(n)]);
    for (int c = 0; c < 3; ++c) held[c] = held[c] || model.node_free[offset(group, n, c, 0)] == 0.0;
  }
  const Eigen::Vector3d centre = moment / mass;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (int n = 0; n < shape.node_count; ++n) {
    const Eigen::Vector3d r = vector(shape.node[static_cast<std::size_t>(n)]) - centre;
    inertia += mass_of(n) * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  RigidMotion motion;
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
  for (int i = 0; i < 9; ++i) motion.inverse_inertia[static_cast<std::size_t>(i)] = inverse(i / 3, i % 3);
  return motion;
}

void scale_deformation(const Model& model, const std::vector<RigidMotion>& motions, const LaneVector<double>& node_mass,
                       double deformation_inertia, std::vector<double>* x) {
  const double factor = 1.0 / std::sqrt(deformation_inertia);
  for (std::size_t g = 0; g < model.groups.size(); ++g) {
    const BlockGroup& group = model.groups[g];
    const BrickTemplate& shape = model.templates[static_cast<std::size_t>(group.brick_template)];
    const RigidMotion& motion = motions[g];
    const auto inverse_inertia =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(motion.inverse_inertia.data());
    for (int lane = 0; lane < group.block_count; ++lane) {
      Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
      const auto arm = [&](int n) {
        return Eigen::Vector3d(vector(shape.node[static_cast<std::size_t>(n)]) - vector(motion.centre));
      };
      for (int n = 0; n < shape.node_count; ++n) {
        const double root = std::sqrt(node_mass[offset(group, n, 0, lane)]);
        Eigen::Vector3d f;
        for (int c = 0; c < 3; ++c) f[c] = root * (*x)[offset(group, n, c, lane)];
        force += f;
        torque += arm(n).cross(f);
      }
      const Eigen::Vector3d linear = vector(motion.inverse_mass).cwiseProduct(force);
      const Eigen::Vector3d angular = inverse_inertia * torque;
      for (int n = 0; n < shape.node_count; ++n) {
        const double root = std::sqrt(node_mass[offset(group, n, 0, lane)]);
        const Eigen::Vector3d rigid = root * (linear + angular.cross(arm(n)));
        for (int c = 0; c < 3; ++c) {
          double& value = (*x)[offset(group, n, c, lane)];
          value = factor * value + (1.0 - factor) * rigid[c];
        }
      }
    }
  }
}

}  // namespace quoin
