#include "step/lattice_motion.h"

#include <algorithm>
#include <array>

#include "step/gather.h"
#include "step/state.h"

namespace quoin {

Vec3 of_body_at(const Simulation::Impl& s, int body, BodyLanes::Quantity BodyLanes::*translation,
                BodyLanes::Quantity BodyLanes::*rotation, const Vec3& position) {
  const Vec3 turned = s.lattice.of_body(body, rotation);
  const Vec3& centre = s.model.bodies[static_cast<std::size_t>(body)].centre;
  Vec3 result = s.lattice.of_body(body, translation);
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
    result[c] =
        result[c] + turned[next] * (position[last] - centre[last]) - turned[last] * (position[next] - centre[next]);
  }
  return result;
}

Vec3 jump_at_traction(const Simulation::Impl& s, std::int32_t point) {
  return jump_of(s, point, 1.0, -s.data.time_step);
}

std::pair<Vec3, Vec3> motion_of_sides(const Simulation::Impl& s, std::int32_t point, double of_displacement,
                                      double of_velocity) {
  const auto p = static_cast<std::size_t>(point);
  const auto motion_of = [&](int block, std::int32_t gridpoint) {
    const int body = s.model.place[static_cast<std::size_t>(block)].body;
    Vec3 u, v;
    if (body < 0) {
      u = at_gridpoint(s.lattice.displacement, static_cast<std::size_t>(gridpoint));
      v = at_gridpoint(s.lattice.velocity, static_cast<std::size_t>(gridpoint));
    } else {
      u = of_body_at(s, body, &BodyLanes::displacement, &BodyLanes::rotation, s.model.point_position[p]);
      v = of_body_at(s, body, &BodyLanes::velocity, &BodyLanes::spin, s.model.point_position[p]);
    }
    return of_displacement * u + of_velocity * v;
  };
  const Model::Sides sides = s.model.sides_of(point);
  return {motion_of(sides.a, s.model.node_a[p]), motion_of(sides.b, s.model.node_b[p])};
}

Vec3 jump_of(const Simulation::Impl& s, std::int32_t point, double of_displacement, double of_velocity) {
  const auto [a, b] = motion_of_sides(s, point, of_displacement, of_velocity);
  const std::size_t n = s.model.point_axis[static_cast<std::size_t>(point)], next = (n + 1) % 3, last = (n + 2) % 3;
  return {b[n] - a[n], b[next] - a[next], b[last] - a[last]};
}

double opening_at_traction(const Simulation::Impl& s, std::int32_t point) {
  return jump_at_traction(s, point)[0] +
         (s.lattice.normal_shift.empty() ? 0.0 : s.lattice.normal_shift[static_cast<std::size_t>(point)]);
}

JointWrench sum_joint_wrench(const Simulation::Impl& s, int block) {
  const int body = s.model.place[at(block)].body;
  const RigidBody& b = s.model.bodies[at(body)];
  JointWrench sum;
  sum.centre = b.centre;
  for (std::size_t i = 0; i < b.point.size(); ++i) {
    const auto p = static_cast<std::size_t>(b.point[i]), n = static_cast<std::size_t>(s.model.point_axis[p]);
    Vec3 of_point{};
    const Vec3 all = point_traction(s, p);
    for (std::size_t c = 0; c < 3; ++c) of_point[(n + c) % 3] = b.sign[i] * (s.model.area[p] * all[c]);
    sum.force += of_point, sum.moment += cross(b.arm[i], of_point);
  }
  sum.displacement = s.lattice.of_body(body, &BodyLanes::displacement) -
                     s.data.time_step * s.lattice.of_body(body, &BodyLanes::velocity);
  return sum;
}

JointWrench joint_wrench(const Simulation::Impl& s, int block) {
  return has_all(s) ? sum_joint_wrench(s, block) : s.reactions.wrench[at(block)];
}

// Motion of lattice blocks from their corner gridpoints, of rigid bodies from their own rotation.
WholeMotion whole_motion_of(const Simulation::Impl& s, std::size_t brick) {
  const Model::BlockPlace& where = s.model.place[brick];
  const double radius = 0.5 * norm_of(s.model.assembly.bricks[brick].size);
  const Drive* const ground = s.actions.ground_drive();
  // Prescribed velocities are equal on all ranks.
  const Vec3 of_ground =
      ground ? s.lattice.of_body(s.model.place[at(ground->block)].body, &BodyLanes::prescribed_velocity) : Vec3{};
  const auto speed = [&](const Vec3& linear, const Vec3& spin) {
    return norm_of(linear - of_ground) + radius * norm_of(spin);
  };
  if (where.body >= 0)
    return {
        s.lattice.of_body(where.body, &BodyLanes::displacement), s.lattice.of_body(where.body, &BodyLanes::rotation),
        speed(s.lattice.of_body(where.body, &BodyLanes::velocity), s.lattice.of_body(where.body, &BodyLanes::spin))};
  const BlockGroup& group = s.model.groups[static_cast<std::size_t>(where.group)];
  const BrickTemplate& shape = s.model.templates[static_cast<std::size_t>(group.brick_template)];
  std::array<Vec3, 8> moved, rate;
  for (int k = 0; k < 8; ++k) {
    const int node =
        shape.node_index(k & 1 ? shape.zones[0] : 0, k & 2 ? shape.zones[1] : 0, k & 4 ? shape.zones[2] : 0);
    const std::size_t at =
        static_cast<std::size_t>(group.first_line + node) * kLine + static_cast<std::size_t>(where.lane);
    for (std::size_t c = 0; c < 3; ++c) {
      moved[static_cast<std::size_t>(k)][c] = s.lattice.displacement[at + c * kLanes];
      rate[static_cast<std::size_t>(k)][c] = s.lattice.velocity[at + c * kLanes];
    }
  }
  WholeMotion motion = whole_motion(shape.size, moved);
  const WholeMotion of_rate = whole_motion(shape.size, rate);
  motion.speed = speed(of_rate.translation, of_rate.rotation);
  return motion;
}

}  // namespace quoin
