#include "step/corner_bending.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "model/world_results.h"
#include "step/block_motion.h"
#include "step/rank_agreement.h"
#include "step/results.h"
#include "step/run_watch.h"
#include "step/state.h"

namespace quoin {

using geometry::Vector;

namespace {

// Rotation of a closed joint, and the depth over which it was found, between points at least `apart` from each other.
struct Rotation {
  double angle = 0.0, depth = 0.0;  // rad, m
};

Rotation rotation_of(std::span<const ContactPoint> points, double apart) {
  Rotation most;
  for (const ContactPoint& p : points) {
    for (const ContactPoint& q : points) {
      const double depth = norm(geometry::vector(p.position) - geometry::vector(q.position));
      const double angle = depth > apart ? (p.jump[0] - q.jump[0]) / depth : 0.0;
      if (angle > most.angle) most = {angle, depth};
    }
  }
  return most;
}

Vector centre(const Simulation::Impl& s, int block) {
  if (s.large_motion) return position_of(*s.large_motion, block);
  return geometry::vector(centre_of(s.model.assembly.bricks[static_cast<std::size_t>(block)]));
}

}  // namespace

std::string bending_at_corners(const Simulation::Impl& s) {
  constexpr double kAllowed = 0.02;  // sway that is missing, share of the depth of a joint
  constexpr double kBed = 0.7;       // least cosine between the normal of a bed joint and gravity
  constexpr double kDeep = 0.25;     // depth of a joint that carries a stack, share of the least extent of its blocks
  const std::vector<JointFamily>& families = s.model.assembly.families;
  const auto at_corners = [](const JointFamily& f) { return f.rigid_points == RigidPoints::corners; };
  if ((s.scene.blocks && s.scene.blocks->contact.point_spacing > 0.0) || std::ranges::none_of(families, at_corners))
    return "";
  const Vector gravity = geometry::vector(s.data.gravity);
  const Vector up = norm(gravity) > 0.0 ? -normalized(gravity) : Vector{0, 1, 0};
  const std::vector<ContactPoint> points = contact_points(s, all_points(s), true);
  double top = -std::numeric_limits<double>::infinity();
  for (const ContactPoint& p : points) top = std::max(top, dot(up, geometry::vector(p.position)));
  if (s.parts.divided) top = largest_of_ranks(s, top);

  double most = 0.0, family = 0.0;
  for (std::size_t first = 0, end = 0; first < points.size(); first = end) {
    const ContactPoint& p = points[first];
    while (end < points.size() && points[end].block_a == p.block_a && points[end].block_b == p.block_b) ++end;
    const std::span<const ContactPoint> joint = std::span(points).subspan(first, end - first);
    if (!at_corners(families[static_cast<std::size_t>(p.family)]) || !is_rigid(s, p.block_a) ||
        !is_rigid(s, p.block_b) || std::abs(dot(up, geometry::vector(p.normal))) < kBed ||
        !std::ranges::all_of(joint, [](const ContactPoint& q) { return q.jump[0] < 0.0; }))
      continue;
    const double rise = std::abs(dot(up, centre(s, p.block_b) - centre(s, p.block_a)));
    const double least = std::min(least_extent(s, p.block_a), least_extent(s, p.block_b));
    const double lever = top - dot(up, geometry::vector(p.position));
    const Rotation turned = rotation_of(joint, kDeep * least);
    const double sway = turned.angle * lever * (1.0 + lever / std::max(rise, least));
    if (sway > most * turned.depth) most = sway / turned.depth, family = p.family;
  }
  if (s.parts.divided) {
    const double of_all = largest_of_ranks(s, most);
    family = largest_of_ranks(s, most == of_all ? family : -1.0), most = of_all;
  }
  if (!(most > kAllowed)) return "";
  return fmt::format(
      "joints '{}' of rigid blocks have contact points at corners alone, and turn a third as far under a moment, while "
      "they are closed, as joints of their normal_stiffness: what stands on them sways too little, by about {:.2g} "
      "times the depth of a joint, and buckles too late; take contact.cubic_points = true, or a larger "
      "normal_stiffness",
      families[static_cast<std::size_t>(family)].name, most);
}

}  // namespace quoin
