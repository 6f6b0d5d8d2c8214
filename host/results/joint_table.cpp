#include "results/joint_table.h"

#include <algorithm>
#include <cmath>

#include "geometry/vector.h"
#include "results/surface.h"

namespace quoin {

namespace {

using geometry::Vector;

// The contact points of a frame.
struct Points {
  std::vector<float> place, gap, traction, normal, shear_axis, area, opening, slip, tension, shear;
  std::vector<std::int32_t> block_a, block_b, crack;

  static Vector at(const std::vector<float>& vectors, std::size_t i) {
    return {vectors[3 * i], vectors[3 * i + 1], vectors[3 * i + 2]};
  }
  bool touches(std::size_t i) const { return gap.empty() || norm(at(gap, i)) == 0.0; }
  // Force on block a, N. Tension pulls it along the normal, which points to b.
  Vector force(std::size_t i) const {
    const Vector n = at(normal, i), s = at(shear_axis, i), t = cross(n, s), traction_i = at(traction, i);
    return double{area[i]} * (traction_i.x * n + traction_i.y * s + traction_i.z * t);
  }
};

Points read_points(const VtuFile& file) {
  constexpr auto kPoint = VtkRows::point;
  Points p;
  p.place = file.grid().position;
  const auto moved = file.read<float>("displacement_m", kPoint, 3);  // 0 where places are the current ones
  for (std::size_t i = 0; i < moved.size(); ++i) p.place[i] += moved[i];
  if (file.has("gap_m")) p.gap = file.read<float>("gap_m", kPoint, 3);
  p.traction = file.read<float>("traction_Pa", kPoint, 3), p.normal = file.read<float>("normal", kPoint, 3);
  p.shear_axis = file.read<float>("shear_axis", kPoint, 3), p.area = file.read<float>("area_m2", kPoint);
  p.opening = file.read<float>("opening_m", kPoint), p.slip = file.read<float>("slip_m", kPoint);
  p.tension = file.read<float>("damage_tension", kPoint), p.shear = file.read<float>("damage_shear", kPoint);
  p.block_a = file.read<std::int32_t>("block_a", kPoint), p.block_b = file.read<std::int32_t>("block_b", kPoint);
  p.crack = file.read_indices("crack", kPoint, kCrackCount);
  return p;
}

std::array<double, 3> array_of(const Vector& v) { return {v.x, v.y, v.z}; }

// Centre of compression of these points of a joint, and its distance from the joint's centre over the depth in that
// direction.
void find_centre(const Points& p, const std::vector<std::size_t>& points, JointSum* sum) {
  Vector middle, pressed;
  double area = 0.0, pressure = 0.0;
  for (const std::size_t i : points) {
    if (!p.touches(i)) continue;
    const double a = p.area[i], push = -a * std::min(0.0F, p.traction[3 * i]);
    area += a, middle += a * Points::at(p.place, i), pressure += push, pressed += push * Points::at(p.place, i);
  }
  if (!(area > 0.0)) return;
  middle = middle / area;
  sum->place = array_of(middle);
  if (!(pressure > 0.0)) return;
  sum->place = array_of(pressed / pressure);
  const Vector off = pressed / pressure - middle;
  const double away = norm(off);
  double low = 0.0, high = 0.0;
  for (const std::size_t i : points) {
    if (!p.touches(i) || away == 0.0) continue;
    const double along = dot(Points::at(p.place, i) - middle, off) / away;
    low = std::min(low, along), high = std::max(high, along);
  }
  sum->eccentricity = high > low ? away / (high - low) : 0.0;
}

JointSum sum_of(const Points& p, const std::vector<std::size_t>& points) {
  JointSum sum;
  double normal = 0.0;
  Vector force, along, across;
  for (const std::size_t i : points) {
    sum.opening = std::max(sum.opening, double{p.opening[i]});
    sum.slip = std::max(sum.slip, std::abs(double{p.slip[i]}));
    sum.damage = std::max({sum.damage, double{p.tension[i]}, double{p.shear[i]}});
    sum.crack = std::max(sum.crack, p.crack[i]);
    if (!p.touches(i)) continue;
    sum.area += p.area[i];
    const double n = double{p.area[i]} * double{p.traction[3 * i]};
    normal += n, across += p.force(i) - n * Points::at(p.normal, i);
    const double first = p.block_a[i] <= p.block_b[i] ? 1.0 : -1.0;
    force += first * p.force(i), along += first * double{p.area[i]} * Points::at(p.normal, i);
  }
  if (!(sum.area > 0.0)) return sum;
  sum.normal = normal / sum.area, sum.shear = norm(across) / sum.area;
  sum.force = array_of(force);
  if (const double length = norm(along); length > 0.0) sum.direction = array_of(along / length);
  find_centre(p, points, &sum);
  return sum;
}

}  // namespace

std::map<BlockPair, JointSum> joint_sums(const VtuFile& joints) {
  const Points points = read_points(joints);
  std::map<BlockPair, std::vector<std::size_t>> of_pair;
  for (std::size_t i = 0; i < points.area.size(); ++i)
    of_pair[std::minmax(points.block_a[i], points.block_b[i])].push_back(i);
  std::map<BlockPair, JointSum> sums;
  for (const auto& [pair, of_points] : of_pair) sums[pair] = sum_of(points, of_points);
  return sums;
}

std::map<std::int32_t, Tensor> force_moments(const VtuFile& joints,
                                             const std::map<std::int32_t, std::array<double, 3>>& centre) {
  const Points points = read_points(joints);
  std::map<std::int32_t, Tensor> moments;
  for (std::size_t i = 0; i < points.area.size(); ++i) {
    if (!points.touches(i)) continue;
    for (const auto& [block, sign] : {std::pair{points.block_a[i], 1.0}, std::pair{points.block_b[i], -1.0}}) {
      const auto found = centre.find(block);
      if (found == centre.end()) continue;
      const auto& [x, y, z] = found->second;
      const Vector arm = Points::at(points.place, i) - Vector{x, y, z}, force = sign * points.force(i);
      Tensor& sum = moments[block];
      for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        sum[static_cast<std::size_t>(k)] += arm[k] * force[k];
        sum[static_cast<std::size_t>(3 + k)] += 0.5 * (arm[k] * force[next] + arm[next] * force[k]);
      }
    }
  }
  return moments;
}

}  // namespace quoin
