// Joints of the start whose blocks come apart: their contact points are removed, and with them the state of the joint.
// So each place of a joint at the start keeps the law columns and axes of its last contact point.
//
// A place of a joint moves along with both blocks. It is in contact while a contact point of the pair is near one of
// its two sides. That means nearer than half of the distance between the points of the start.
#include "model/parted_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "model/block_layout.h"
#include "model/contact_frames.h"
#include "model/world.h"
#include "model/world_results.h"

namespace quoin::blocks {

using namespace geometry;

void note_start_joints(World& w) {
  uint32_t points = 0;
  for (const Contact& c : w.contacts.list) {
    if (c.count > 0) w.start_joints.joint.push_back({c.pair, c.family, points, c.count});
    points += c.count;
  }
  w.start_joints.point = LaneVector<StartPoint>(points);
  auto joint = w.start_joints.joint.begin();
  for (const Contact& c : w.contacts.list) {
    if (c.count == 0) continue;
    for (uint32_t k = 0; k < c.count && w.part.owns(c.pair); ++k) {
      const Point& p = w.contacts.families[c.family].point[c.first + k];
      w.start_joints.point[joint->first + k] = {p.at, p.area};
    }
    ++joint;
  }
}

namespace {

// Head of a row of StartJoints::kept; states and then properties that scatter follow it.
struct Head {
  double owner;  // block that n points from: 1 first, 2 second of the pair; 0: no point was replaced yet
  double normal_jump, traction[3];
  Vector n, s;  // axes rotated back to the orientation of that block at the start
};
constexpr size_t kHead = sizeof(Head) / sizeof(double);
static_assert(kHead * sizeof(double) == sizeof(Head));

Head head_of(const double* row) {
  std::array<double, kHead> numbers;
  std::copy_n(row, kHead, numbers.begin());
  return std::bit_cast<Head>(numbers);
}

// Maps positions and directions at the start to the current ones, by the motion of a block.
struct Motion {
  Pose start, now;
  Vector place(const Vector& at) const { return now.x + now.r * transposed_times(start.r, at - start.x); }
  Vector turned(const Vector& v) const { return now.r * transposed_times(start.r, v); }
  Vector back(const Vector& v) const { return start.r * transposed_times(now.r, v); }
};

// The place that is nearest to one of the two sides of a joint.
struct Nearest {
  size_t index = 0;
  double squared = HUGE_VAL;  // square of the distance, m2
};
Nearest nearest_of(std::span<const Location> locations, const Vector& side_a, const Vector& side_b) {
  Nearest nearest;
  for (size_t i = 0; i < locations.size(); ++i) {
    for (const Vector& side : {side_a, side_b}) {
      const Vector d = locations[i].at - side;
      if (dot(d, d) < nearest.squared) nearest = {i, dot(d, d)};
    }
  }
  return nearest;
}

// Half of the mean distance between points of a joint, squared, m2.
double squared_reach(std::span<const StartPoint> points) {
  double area = 0.0;
  for (const StartPoint& p : points) area += p.area;
  return 0.25 * area / double(points.size());
}

}  // namespace

size_t kept_width(const World& w) {
  size_t most = 0;
  for (const Family& f : w.contacts.families) most = std::max(most, f.state.size() + f.columns.size());
  return kHead + most;
}

void keep_of_joint(World& w, const Contact& c, const Family& old, std::span<const Location> locations, uint32_t first) {
  const auto joint = std::ranges::lower_bound(w.start_joints.joint, c.pair, {}, &StartJoint::pair);
  const auto points = std::span(w.start_joints.point).subspan(joint->first, joint->count);
  const Motion a{w.poses.start[size_t(c.pair.a)], pose(w, c.pair.a)};
  const Motion b{w.poses.start[size_t(c.pair.b)], pose(w, c.pair.b)};
  const double reach = squared_reach(points);
  const size_t width = kept_width(w);
  for (size_t k = 0; k < points.size(); ++k) {
    double* const row = &w.start_joints.kept[(joint->first + k) * width];
    const Nearest nearest = nearest_of(locations, a.place(points[k].at), b.place(points[k].at));
    if (nearest.squared > reach && head_of(row).owner != 0.0) continue;  // it keeps the values of an earlier point
    const size_t i = first + nearest.index;
    const Point& p = old.point[i];
    const bool from_a = p.a == c.pair.a;
    const Motion& owner = from_a ? a : b;
    const Head head{from_a ? 1.0 : 2.0,
                    old.normal_jump[i],
                    {old.traction[0][i], old.traction[1][i], old.traction[2][i]},
                    owner.back(in_space(w, p, p.n)),
                    owner.back(in_space(w, p, p.s))};
    double* next = std::ranges::copy(std::bit_cast<std::array<double, kHead>>(head), row).out;
    for (const auto& column : old.state) *next++ = column[i];
    for (const PropertyColumn& column : old.columns) *next++ = column.values[i];
  }
}

namespace {

std::vector<Location> locations_of(const World& w, const Contact& c) {
  std::vector<Location> locations;
  for (uint32_t i = c.first; i < c.first + c.count; ++i)
    locations.push_back(locate(w, w.contacts.families[size_t(c.family)].point[i], w.contacts.facets));
  return locations;
}

}  // namespace

std::vector<PartedPoint> parted_points(const World& w, int first_block, int end_block) {
  std::vector<PartedPoint> parted;
  if (!w.start_joints.any_replaced()) return parted;
  const size_t width = kept_width(w);
  auto joint = std::ranges::lower_bound(w.start_joints.joint, first_block, {},
                                        [](const StartJoint& j) { return int(j.pair.a); });
  for (; joint != w.start_joints.joint.end() && joint->pair.a < end_block; ++joint) {
    if (head_of(&w.start_joints.kept[joint->first * width]).owner == 0.0) continue;
    const auto contact = std::ranges::lower_bound(w.contacts.list, joint->pair, {}, &Contact::pair);
    const bool touches = contact != w.contacts.list.end() && contact->pair == joint->pair && contact->count > 0;
    const std::vector<Location> locations = touches ? locations_of(w, *contact) : std::vector<Location>{};
    const auto points = std::span(w.start_joints.point).subspan(joint->first, joint->count);
    const double reach = squared_reach(points);
    const Motion a{w.poses.start[size_t(joint->pair.a)], pose(w, joint->pair.a)};
    const Motion b{w.poses.start[size_t(joint->pair.b)], pose(w, joint->pair.b)};
    const Family& f = w.contacts.families[size_t(joint->family)];
    for (size_t k = 0; k < points.size(); ++k) {
      const Vector on_a = a.place(points[k].at), on_b = b.place(points[k].at);
      if (nearest_of(locations, on_a, on_b).squared <= reach) continue;
      const double* const row = &w.start_joints.kept[(joint->first + k) * width];
      const Head head = head_of(row);
      const bool from_a = head.owner == 1.0;
      const Motion& owner = from_a ? a : b;
      PartedPoint& p = parted.emplace_back();
      p.a = from_a ? joint->pair.a : joint->pair.b, p.b = from_a ? joint->pair.b : joint->pair.a;
      p.family = joint->family;
      p.side_a = from_a ? on_a : on_b, p.side_b = from_a ? on_b : on_a;
      p.n = owner.turned(head.n), p.s = owner.turned(head.s);
      p.area = points[k].area, p.normal_jump = head.normal_jump;
      std::ranges::copy(head.traction, p.traction);
      const double* const states = row + kHead;
      p.state.assign(states, states + f.state.size());
      p.properties.assign(states + f.state.size(), states + f.state.size() + f.columns.size());
    }
  }
  return parted;
}

// Moves states to a new law by their names, as for points in contact; other states get the values of a dry joint.
void keep_states_by_id(World& w, int family, const quoin_law& old, size_t old_width) {
  if (!w.start_joints.any_replaced()) return;
  const Family& f = w.contacts.families[size_t(family)];
  const quoin_law& law = f.material->api();
  const size_t width = kept_width(w);
  LaneVector<double> next(w.start_joints.point.size() * width);
  for (const StartJoint& joint : w.start_joints.joint) {
    for (size_t point = joint.first; point < size_t(joint.first) + joint.count; ++point) {
      const double* const from = &w.start_joints.kept[point * old_width];
      double* const to = &next[point * width];
      if (head_of(from).owner == 0.0) continue;
      std::copy_n(from, std::min(width, old_width), to);
      if (joint.family != family) continue;
      for (size_t s = 0; s < law.state_count; ++s) {
        size_t same = 0;
        while (same < old.state_count && std::strcmp(old.states[same]->id, law.states[s]->id) != 0) ++same;
        to[kHead + s] = same < old.state_count ? from[kHead + same] : f.dry[s];
      }
      std::copy_n(from + kHead + old.state_count, f.columns.size(), to + kHead + law.state_count);
    }
  }
  w.start_joints.kept = std::move(next);
}

}  // namespace quoin::blocks
