// Contact points of a joint: at gridpoints of deformable blocks, on a grid between rigid ones.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/model.h"

namespace quoin {

// Tolerance of coordinates, as a fraction of the smallest edge at the joint.
inline constexpr double kCoordinateTolerance = 1e-6;

// One side of a joint's contact point before numbering: a template gridpoint of a deformable block, or a rigid body.
struct Side {
  int block = -1;
  int node = -1;  // gridpoint of a template, or slot of a body in a group; -1: a lone body
};

struct NewPoint {
  Side a, b;
  int joint, family, axis;
  double area;
  Vec3 position;
};

class PointFinder {
 public:
  explicit PointFinder(const Model& model) : model_(model), assembly_(model.assembly) {}

  // Contact points of joint j, in a fixed order; valid until the next call. Throws Error(bad_input) for faces that do
  // not touch or share no gridpoints.
  const std::vector<NewPoint>& find(std::size_t j);

 private:
  void add(Side a, Side b, double area, const Vec3& position);
  const BrickTemplate& shape(int block) const { return model_.template_of(block); }
  void deformable_to_deformable(const Joint& joint, const Brick& a, const Brick& b);
  void rigid_to_deformable(const Joint& joint, const Brick& a, const Brick& b);
  void rigid_to_rigid(const Joint& joint, const Brick& a, const Brick& b);

  const Model& model_;
  const Assembly& assembly_;
  std::vector<NewPoint> points_;
  int joint_ = 0, family_ = 0, axis_ = 0;
  double tolerance_ = 0.0;
};

// Places of these points on the lattice, laid out or not. Output and initial damage by place need the points of whole
// joints, of which a rank may have only a part. points: numbers, ascending. Places have the same order.
std::vector<PlacedPoint> placed_points(const Model& model, std::span<const std::int32_t> points);
// Numbers of all points of a family whose pair of blocks has one of these points, ascending.
std::vector<std::int32_t> points_of_same_joints(const Model& model, const ContactFamily& family,
                                                std::span<const std::int32_t> points);

}  // namespace quoin
