#include "model/placed_points.h"

#include <algorithm>
#include <numeric>

#include "base/index.h"
#include "model/point_finder.h"

namespace quoin {

namespace {

const Joint& joint_of(const Model& model, std::int32_t point) {
  return model.assembly.joints[at(model.point_joint[at(point)])];
}

std::pair<int, int> blocks_of(const Joint& joint) { return {joint.block_a, joint.block_b}; }

}  // namespace

std::vector<PlacedPoint> placed_points(const Model& model, std::span<const std::int32_t> points) {
  // Joint by joint, as the finder returns all points of a joint together.
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return model.point_joint[at(points[i])] < model.point_joint[at(points[j])];
  });
  std::vector<PlacedPoint> placed(points.size());
  PointFinder finder(model);
  const std::vector<NewPoint>* found = nullptr;
  std::int32_t found_joint = -1;
  for (const std::size_t i : order) {
    const std::int32_t joint = model.point_joint[at(points[i])];
    if (joint != found_joint) found = &finder.find(at(joint)), found_joint = joint;
    const NewPoint& p = (*found)[at(model.point_in_joint[at(points[i])])];
    const Joint& of_point = joint_of(model, points[i]);
    const Model::Sides sides = Model::sides_of(of_point);
    placed[i] = {p.position, p.area, sides.a, sides.b};
    for (std::size_t k = 0; k < 3; ++k) placed[i].axis[k][(at(of_point.face_a / 2) + k) % 3] = 1.0;
  }
  return placed;
}

std::vector<std::int32_t> points_of_same_joints(const Model& model, const ContactFamily& family,
                                                std::span<const std::int32_t> points) {
  std::vector<std::pair<int, int>> wanted;
  for (const std::int32_t p : points) {
    if (const auto blocks = blocks_of(joint_of(model, p)); wanted.empty() || wanted.back() != blocks)
      wanted.push_back(blocks);
  }
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  std::vector<std::int32_t> all;
  for (std::int32_t p = family.first_point; p < family.first_point + family.point_count; ++p) {
    if (std::binary_search(wanted.begin(), wanted.end(), blocks_of(joint_of(model, p)))) all.push_back(p);
  }
  return all;
}

}  // namespace quoin
