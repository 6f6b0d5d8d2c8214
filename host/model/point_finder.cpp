#include "model/point_finder.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "base/index.h"
#include "geometry/overlap.h"

namespace quoin {
namespace {

double smallest_edge(const Brick& a, const Brick& b) {
  double edge = a.size[0];
  for (std::size_t c = 0; c < 3; ++c) edge = std::min({edge, a.size[c], b.size[c]});
  return edge;
}

struct FaceNode {
  int node;
  Vec3 position;
};

std::vector<FaceNode> face_nodes(const Brick& brick, const BrickTemplate& shape, int face) {
  const int axis = face / 2, layer = face % 2 == 0 ? 0 : brick.zones[at(axis)];
  std::vector<FaceNode> result;
  for (int k = 0; k <= brick.zones[2]; ++k) {
    for (int j = 0; j <= brick.zones[1]; ++j) {
      for (int i = 0; i <= brick.zones[0]; ++i) {
        const int index[3] = {i, j, k};
        if (index[axis] != layer) continue;
        const int node = shape.node_index(i, j, k);
        result.push_back({node, shape.node[at(node)] + brick.origin});
      }
    }
  }
  return result;
}

// Areas at gridpoints of a face, m2: a third of each triangle that lies wholly in the joint.
std::vector<double> face_areas(const BrickTemplate& shape, int face, const std::vector<char>& in_joint) {
  std::vector<double> area(shape.node.size(), 0.0);
  const std::size_t s = at((face / 2 + 1) % 3), t = at((face / 2 + 2) % 3);
  for (const FaceTriangle& triangle : shape.face_triangle) {
    const auto& n = triangle.node;
    if (triangle.face != face || !in_joint[at(n[0])] || !in_joint[at(n[1])] || !in_joint[at(n[2])]) continue;
    const Vec3 &p = shape.node[at(n[0])], &q = shape.node[at(n[1])], &r = shape.node[at(n[2])];
    const double twice = (q[s] - p[s]) * (r[t] - p[t]) - (q[t] - p[t]) * (r[s] - p[s]);
    for (int node : n) area[at(node)] += std::abs(twice) / 6.0;
  }
  return area;
}

std::string describe(const Assembly& assembly, const Joint& joint, std::size_t index) {
  return fmt::format("joint {} between blocks {} and {} (family '{}')", index, joint.block_a, joint.block_b,
                     assembly.families[at(joint.family)].name);
}

}  // namespace

const std::vector<NewPoint>& PointFinder::find(std::size_t j) {
  points_.clear();
  // The normal points along +axis: a joint whose face_a is a negative face changes sides.
  Joint joint = assembly_.joints[j];
  if (joint.face_a % 2 == 0) {
    std::swap(joint.block_a, joint.block_b);
    joint.face_a += 1;
  }
  const Brick &a = assembly_.bricks[at(joint.block_a)], &b = assembly_.bricks[at(joint.block_b)];
  joint_ = static_cast<int>(j);
  family_ = joint.family;
  axis_ = joint.face_a / 2;
  tolerance_ = kCoordinateTolerance * smallest_edge(a, b);
  const double plane_a = a.origin[at(axis_)] + a.size[at(axis_)], plane_b = b.origin[at(axis_)];
  if (std::abs(plane_a - plane_b) > tolerance_) {
    throw Error(Exit::bad_input, fmt::format("{}: the faces are {} m apart along axis {}; they must touch",
                                             describe(assembly_, assembly_.joints[j], j), plane_b - plane_a, axis_));
  }
  if (a.rigid && b.rigid) {
    rigid_to_rigid(joint, a, b);
  } else if (a.rigid || b.rigid) {
    rigid_to_deformable(joint, a, b);
  } else {
    deformable_to_deformable(joint, a, b);
  }
  if (points_.empty()) {
    throw Error(Exit::bad_input, fmt::format("{}: no contact points; the faces do not share gridpoints",
                                             describe(assembly_, assembly_.joints[j], j)));
  }
  return points_;
}

void PointFinder::add(Side a, Side b, double area, const Vec3& position) {
  if (area > 0.0) points_.push_back({a, b, joint_, family_, axis_, area, position});
}

void PointFinder::deformable_to_deformable(const Joint& joint, const Brick& a, const Brick& b) {
  const auto nodes_a = face_nodes(a, shape(joint.block_a), 2 * axis_ + 1);
  const auto nodes_b = face_nodes(b, shape(joint.block_b), 2 * axis_);
  std::vector<char> in_a(shape(joint.block_a).node.size(), 0), in_b(shape(joint.block_b).node.size(), 0);
  std::vector<std::pair<const FaceNode*, const FaceNode*>> pairs;
  for (const FaceNode& p : nodes_a) {
    for (const FaceNode& q : nodes_b) {
      if (std::abs(p.position[0] - q.position[0]) > tolerance_ ||
          std::abs(p.position[1] - q.position[1]) > tolerance_ ||
          std::abs(p.position[2] - q.position[2]) > tolerance_) {
        continue;
      }
      pairs.emplace_back(&p, &q);
      in_a[at(p.node)] = in_b[at(q.node)] = 1;
    }
  }
  const auto area_a = face_areas(shape(joint.block_a), 2 * axis_ + 1, in_a);
  const auto area_b = face_areas(shape(joint.block_b), 2 * axis_, in_b);
  for (const auto& [p, q] : pairs) {
    // With an odd number of layers the diagonals of the two faces differ: the area is the mean of both sides.
    const double area = 0.5 * (area_a[at(p->node)] + area_b[at(q->node)]);
    add({joint.block_a, p->node}, {joint.block_b, q->node}, area, p->position);
  }
}

void PointFinder::rigid_to_deformable(const Joint& joint, const Brick& a, const Brick& b) {
  const Brick &rigid = a.rigid ? a : b, &soft = a.rigid ? b : a;
  const int soft_block = a.rigid ? joint.block_b : joint.block_a;
  const int face = a.rigid ? 2 * axis_ : 2 * axis_ + 1;
  const BrickTemplate& soft_shape = shape(soft_block);
  std::vector<FaceNode> inside;
  std::vector<char> in_joint(soft_shape.node.size(), 0);
  for (const FaceNode& p : face_nodes(soft, soft_shape, face)) {
    bool covered = true;
    for (std::size_t c = 0; c < 3; ++c) {
      if (c == at(axis_)) continue;
      covered = covered && p.position[c] >= rigid.origin[c] - tolerance_ &&
                p.position[c] <= rigid.origin[c] + rigid.size[c] + tolerance_;
    }
    if (!covered) continue;
    inside.push_back(p);
    in_joint[at(p.node)] = 1;
  }
  const auto area = face_areas(soft_shape, face, in_joint);
  for (const FaceNode& p : inside) {
    const Side soft_side{soft_block, p.node}, rigid_side{a.rigid ? joint.block_a : joint.block_b, -1};
    add(a.rigid ? rigid_side : soft_side, a.rigid ? soft_side : rigid_side, area[at(p.node)], p.position);
  }
}

// Points on a grid over the overlap, edges and corners included, with weights of the trapezoidal rule: rigid blocks
// turn about their true corners. The zones of block a over the overlap set the number of points, at least 2 x 2.
// Families with cubic points have those of blocks of any shape, which integrate cubics exactly.
void PointFinder::rigid_to_rigid(const Joint& joint, const Brick& a, const Brick& b) {
  const std::size_t s = at((axis_ + 1) % 3), t = at((axis_ + 2) % 3);
  double low[3], length[3];
  int cells[3];
  for (std::size_t c : {s, t}) {
    low[c] = std::max(a.origin[c], b.origin[c]);
    length[c] = std::min(a.origin[c] + a.size[c], b.origin[c] + b.size[c]) - low[c];
    if (length[c] <= tolerance_) return;
    cells[c] = std::max(1, static_cast<int>(std::lround(a.zones[c] * length[c] / a.size[c])));
  }
  if (assembly_.families[at(joint.family)].rigid_points != RigidPoints::corners) {
    std::vector<geometry::QuadraturePoint> points;
    const double to[2] = {low[s] + length[s], low[t] + length[t]};
    geometry::cubic_rule({{low[s], low[t]}, {to[0], low[t]}, {to[0], to[1]}, {low[s], to[1]}}, points);
    for (const geometry::QuadraturePoint& q : points) {
      Vec3 p{};
      p[at(axis_)] = b.origin[at(axis_)], p[s] = q.at.x, p[t] = q.at.y;
      add({joint.block_a, -1}, {joint.block_b, -1}, q.area, p);
    }
    return;
  }
  for (int j = 0; j <= cells[t]; ++j) {
    for (int i = 0; i <= cells[s]; ++i) {
      Vec3 p{};
      p[at(axis_)] = b.origin[at(axis_)];
      p[s] = low[s] + length[s] * i / cells[s];
      p[t] = low[t] + length[t] * j / cells[t];
      const double weight = (i == 0 || i == cells[s] ? 0.5 : 1.0) * (j == 0 || j == cells[t] ? 0.5 : 1.0);
      add({joint.block_a, -1}, {joint.block_b, -1}, weight * length[s] * length[t] / (cells[s] * cells[t]), p);
    }
  }
}

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
