// Limit analysis against closed forms and against an independent linear programme with the same theorem, points and
// cones.
#include "analysis/limit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <mutex>
#include <numbers>
#include <stdexcept>

#include "analysis/stands.h"
#include "analysis/without_dilation.h"
#include "base/error.h"

namespace quoin {
namespace {

using geometry::Vector;
using std::numbers::pi;

// A unit of a wall in x (length), y (height) and z (depth), m. Weight 1 N/m3, on which multipliers do not depend.
struct Unit {
  Vector lower, size;
};

// Dry assemblies of boxes: contacts at the corners of shared faces.
class Boxes {
 public:
  int add(const Vector& lower, const Vector& size, const Vector& live, bool fixed = false) {
    units_.push_back({lower, size});
    const double weight = size.x * size.y * size.z;
    LimitBlock block;
    block.centre = lower + 0.5 * size, block.fixed = fixed;
    block.dead.force = {0.0, -weight, 0.0};
    block.live.force = weight * live;
    problem.blocks.push_back(block);
    return static_cast<int>(units_.size()) - 1;
  }
  // Adds points at the corners of common faces of two boxes. Normals are along the axes, from the lower box.
  void join(double friction) {
    for (std::size_t a = 0; a < units_.size(); ++a)
      for (std::size_t b = 0; b < units_.size(); ++b)
        for (int axis = 0; axis < 3; ++axis) join_along(a, b, axis, friction);
  }
  LimitProblem problem;

 private:
  void join_along(std::size_t a, std::size_t b, int axis, double friction) {
    const Unit &p = units_[a], &q = units_[b];
    if (problem.blocks[a].fixed && problem.blocks[b].fixed) return;
    const double face = p.lower[axis] + p.size[axis];
    if (std::abs(face - q.lower[axis]) > 1e-9) return;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const double u0 = std::max(p.lower[u], q.lower[u]), u1 = std::min(p.lower[u] + p.size[u], q.lower[u] + q.size[u]);
    const double v0 = std::max(p.lower[v], q.lower[v]), v1 = std::min(p.lower[v] + p.size[v], q.lower[v] + q.size[v]);
    if (u1 - u0 < 1e-9 || v1 - v0 < 1e-9) return;
    for (const double at_u : {u0, u1}) {
      for (const double at_v : {v0, v1}) {
        LimitPoint point;
        point.a = static_cast<int>(a), point.b = static_cast<int>(b), point.friction = friction;
        point.position[axis] = face, point.position[u] = at_u, point.position[v] = at_v;
        point.n[axis] = 1.0, point.s[u] = 1.0, point.t[v] = 1.0;
        problem.points.push_back(point);
      }
    }
  }
  std::vector<Unit> units_;
};

double multiplier(const LimitProblem& problem, const LimitSettings& settings = {}) {
  const LimitResult result = limit_multiplier(problem, settings);
  EXPECT_EQ(result.status, LimitStatus::solved);
  EXPECT_LT(result.gap, 1e-6);
  return result.multiplier;
}

// Returns a running bond of `width` units of 0.4 x 0.175 x 0.2 m on a fixed base; odd courses begin with a half unit.
LimitProblem running_bond(int width, int courses, double friction, int first_half, double height = 0.175) {
  Boxes wall;
  wall.add({-1.0, -0.2, 0.0}, {2.0 + 0.4 * width, 0.2, 0.2}, {}, true);
  for (int c = 0; c < courses; ++c) {
    const double y = height * c;
    const bool halves = c % 2 == first_half;
    double x = 0.0;
    for (int i = 0; i < width + (halves ? 1 : 0); ++i) {
      const double length = halves && (i == 0 || i == width) ? 0.2 : 0.4;
      wall.add({x, y, 0.0}, {length, height, 0.2}, {1.0, 0.0, 0.0});
      x += length;
    }
  }
  wall.join(friction);
  return wall.problem;
}

// A block on a plane slides at mu or overturns at b/h, whichever is smaller. Exact, since it slides along an edge of
// the friction pyramid.
TEST(Limit, BlockSlidesOrTurns) {
  for (const double friction : {0.2, 0.9}) {
    Boxes one;
    one.add({-2.0, -1.0, -2.0}, {5.0, 1.0, 5.0}, {}, true);
    one.add({0.0, 0.0, 0.0}, {1.0, 2.0, 1.0}, {1.0, 0.0, 0.0});
    one.join(friction);
    const LimitResult result = limit_multiplier(one.problem);
    EXPECT_NEAR(result.multiplier, std::min(friction, 0.5), 1e-9);
    // Mechanism: the work of the live load is 1, that of the dead load -multiplier.
    const Wrench& v = result.velocity[1];
    EXPECT_GT(dot(v.force, one.problem.blocks[1].live.force), 0.0);
    EXPECT_NEAR(-dot(v.force, one.problem.blocks[1].dead.force) / dot(v.force, one.problem.blocks[1].live.force),
                result.multiplier, 1e-9);
    if (friction > 0.5) {
      EXPECT_LT(v.moment.z, 0.0);  // about its toe at positive x
    }
  }
}

// Separate blocks overturn at half their width over their height. With 1200 points an interior solution is used if it
// is as accurate as a vertex. 1e-6 is the difference of both bounds.
TEST(Limit, ManyPointsAreSolvedInTheMiddle) {
  Boxes many;
  many.add({-1.0, -1.0, -1.0}, {800.0, 1.0, 3.0}, {}, true);
  for (int k = 0; k < 300; ++k) many.add({2.0 * k, 0.0, 0.0}, {1.0, 2.0, 1.0}, {1.0, 0.0, 0.0});
  many.join(0.9);
  ASSERT_GE(many.problem.points.size(), 1200u);
  const LimitResult result = limit_multiplier(many.problem);
  ASSERT_EQ(result.status, LimitStatus::solved);
  EXPECT_NEAR(result.multiplier, 0.5, 1e-6);
  EXPECT_LT(result.gap, 1e-6);
  const Stands answer = stands(many.problem);
  EXPECT_TRUE(answer.stands);
  EXPECT_EQ(answer.friction, 0.0);
}

// Forces of the result are in equilibrium and within strength, as the static theorem requires. Checked without the
// solver.
TEST(Limit, ForcesAreInEquilibriumAndWithinStrength) {
  const LimitProblem problem = running_bond(3, 5, 0.65, 1);
  const LimitResult result = limit_multiplier(problem);
  std::vector<Wrench> sum(problem.blocks.size());
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    const LimitPoint& p = problem.points[i];
    const auto& [n, s, t] = result.force[i];
    EXPECT_LE(n, 1e-9);
    EXPECT_LE(std::hypot(s, t), -0.65 * n + 1e-9);
    const Vector f = n * p.n + s * p.s + t * p.t;
    for (const auto& [block, sign] : {std::pair(p.a, 1.0), std::pair(p.b, -1.0)}) {
      auto& [force, moment] = sum[static_cast<std::size_t>(block)];
      force += sign * f;
      moment += sign * cross(p.position - problem.blocks[static_cast<std::size_t>(block)].centre, f);
    }
  }
  for (std::size_t k = 1; k < problem.blocks.size(); ++k) {
    const LimitBlock& b = problem.blocks[k];
    EXPECT_LT(norm(sum[k].force + b.dead.force + result.multiplier * b.live.force), 1e-8);
    EXPECT_LT(norm(sum[k].moment + b.dead.moment + result.multiplier * b.live.moment), 1e-8);
  }
}

// Ferris and Tin-Loi (2001), walls 1 and 2. In a plane problem shear acts along the joints only, so four facets are
// exact.
TEST(Limit, FerrisAndTinLoi) {
  LimitSettings settings;
  settings.facets = 4;
  EXPECT_NEAR(multiplier(running_bond(5, 6, 0.65, 0), settings), 0.64286, 1e-4);
  EXPECT_NEAR(multiplier(running_bond(5, 10, 0.65, 0), settings), 0.58000, 1e-4);
}

// Wall 3 of Ferris and Tin-Loi with an opening. Lengths in units of 0.4 m, negative: void. An independent programme has
// 0.40369.
TEST(Limit, FerrisAndTinLoiWithAnOpening) {
  using Course = std::vector<double>;
  const Course fe{1, 1, 1, 1}, fu{0.5, 1, 1, 1, 0.5}, we{1, 0.5, -1, 0.5, 1}, wu{0.5, 1, -1, 1, 0.5};
  Boxes wall;
  wall.add({-1.0, -0.2, 0.0}, {3.6, 0.2, 0.2}, {}, true);
  double y = 0.0;
  for (const Course& course : {fe, fu, fe, wu, we, wu, we, wu, fe, fu, fe}) {
    double x = 0.0;
    for (const double units : course) {
      const double length = 0.4 * std::abs(units);
      if (units > 0.0) wall.add({x, y, 0.0}, {length, 0.175, 0.2}, {1.0, 0.0, 0.0});
      x += length;
    }
    y += 0.175;
  }
  wall.join(0.65);
  LimitSettings settings;
  settings.facets = 4;
  EXPECT_NEAR(multiplier(wall.problem, settings), 0.40369, 1e-4 * 0.40369);
}

// At high friction a wall of 8 x 4 units of 0.4 x 0.2 m in running bond overturns as one body: 3.2/0.8. (Without
// dilation: 0.714.)
TEST(Limit, DilationLocksABondedWall) {
  LimitSettings settings;
  settings.facets = 4;
  EXPECT_NEAR(multiplier(running_bond(8, 4, 10.0, 0, 0.2), settings), 4.0, 1e-6);
}

LimitWithoutDilation without_dilation(const LimitProblem& problem, int facets = 4) {
  LimitSettings settings;
  settings.facets = facets;
  return limit_without_dilation(problem, settings);
}

// Against an independent programme without dilation; tolerance 1 %.
TEST(Limit, WithoutDilationFerrisAndTinLoi) {
  for (const auto& [courses, expected] : {std::pair(6, 0.6398), std::pair(10, 0.5629)}) {
    const LimitWithoutDilation found = without_dilation(running_bond(5, courses, 0.65, 0));
    EXPECT_TRUE(found.settled);
    EXPECT_NEAR(found.multiplier, expected, 0.01 * expected);
    for (const SettledLimit& start : found.start) {
      EXPECT_TRUE(start.settled) << start.from;
      EXPECT_NEAR(start.multiplier, expected, 0.01 * expected) << start.from;
      EXPECT_LE(start.beyond, 0.1) << start.from;        // relative to the mean normal force, at one point
      EXPECT_LE(start.share_beyond, 0.1) << start.from;  // relative to all friction
    }
  }
}

// The wall of DilationLocksABondedWall, 4.00 with dilation, has 0.714 from the normal forces under weight. (A run:
// 0.716.)
TEST(Limit, WithoutDilationABondedWallIsNotLocked) {
  const LimitWithoutDilation found = without_dilation(running_bond(8, 4, 10.0, 0, 0.2));
  EXPECT_TRUE(found.settled);
  EXPECT_NEAR(found.multiplier, 0.714, 0.01 * 0.714);
  EXPECT_EQ(found.start[0].from, "weight");
  EXPECT_TRUE(found.start[0].settled);
}

// With many sliding points single ones alternate between iterations: the multiplier varies by at most half a percent.
// Both starts agree to 2 %, since normal forces are not unique, and are below the associated multiplier.
TEST(Limit, WithoutDilationLargeWallsSettle) {
  const LimitProblem wall = running_bond(12, 24, 0.65, 1, 0.2);
  const LimitResult associated = limit_multiplier(wall);
  const LimitWithoutDilation found = without_dilation(wall);
  EXPECT_TRUE(found.settled);
  ASSERT_EQ(found.start.size(), 2u);
  for (const SettledLimit& start : found.start) {
    EXPECT_TRUE(start.settled) << start.from;
    EXPECT_LE(start.spread, 0.0026) << start.from;
    EXPECT_LT(start.multiplier, associated.multiplier) << start.from;
    EXPECT_NEAR(start.multiplier, found.multiplier, 0.02 * found.multiplier) << start.from;
  }
  EXPECT_GT(found.multiplier, 0.9 * associated.multiplier);
}

// A block that slides on a plane, or overturns, has the same multiplier with and without dilation.
TEST(Limit, WithoutDilationOneBlockIsTheSame) {
  for (const double friction : {0.2, 0.9}) {
    Boxes one;
    one.add({-2.0, -1.0, -2.0}, {5.0, 1.0, 5.0}, {}, true);
    one.add({0.0, 0.0, 0.0}, {1.0, 2.0, 1.0}, {1.0, 0.0, 0.0});
    one.join(friction);
    const LimitWithoutDilation found = without_dilation(one.problem);
    EXPECT_TRUE(found.settled);
    EXPECT_NEAR(found.multiplier, std::min(friction, 0.5), 1e-3);
  }
}

// Weight 2 on four points; a block that overhangs has no tension at its heel.
TEST(Limit, ElasticForcesUnderWeight) {
  Boxes one;
  one.add({-2.0, -1.0, -2.0}, {2.5, 1.0, 5.0}, {}, true);      // to x = 0.5
  one.add({0.0, 0.0, 0.0}, {0.8, 2.0, 1.0}, {1.0, 0.0, 0.0});  // its centre at 0.4
  one.join(0.5);
  // The joint is from 0 to 0.5 m, the centre at 0.4 m: 1/5 and 4/5 of 1.6.
  double at_heel = 0.0, at_toe = 0.0;
  const std::vector<double> normal = elastic_normal_forces(one.problem);
  for (std::size_t i = 0; i < normal.size(); ++i)
    (one.problem.points[i].position.x < 0.25 ? at_heel : at_toe) += normal[i];
  EXPECT_NEAR(at_heel, 0.32, 1e-4);
  EXPECT_NEAR(at_toe, 1.28, 1e-4);
}

// Returns an arch of voussoirs. A semicircular one with t/R 0.15 and hinges only (friction 10) has the horizontal
// multipliers 0.1667, 0.1493, 0.1448.
LimitProblem arch(int voussoirs, double thickness, double friction, double from, double to) {
  LimitProblem problem;
  problem.blocks.resize(static_cast<std::size_t>(voussoirs) + 1);  // the last one is the ground
  problem.blocks.back().fixed = true;
  const double inner = 1.0 - thickness / 2.0, outer = 1.0 + thickness / 2.0, step = (to - from) / voussoirs;
  for (int i = 0; i <= voussoirs; ++i) {
    const double angle = from + step * i;
    if (i < voussoirs) {  // a ring sector: area and centroid
      LimitBlock& block = problem.blocks[static_cast<std::size_t>(i)];
      const double weight = 0.5 * step * (outer * outer - inner * inner);
      const double radius = 2.0 / 3.0 * (std::pow(outer, 3) - std::pow(inner, 3)) / (outer * outer - inner * inner) *
                            std::sin(step / 2.0) / (step / 2.0);
      block.centre = radius * Vector{std::cos(angle + step / 2.0), std::sin(angle + step / 2.0), 0.0};
      block.dead.force = {0.0, -weight, 0.0}, block.live.force = {weight, 0.0, 0.0};
    }
    for (const double radius : {inner, outer}) {
      for (const double z : {0.0, 1.0}) {
        LimitPoint point;
        point.a = i > 0 ? i - 1 : voussoirs, point.b = i < voussoirs ? i : voussoirs, point.friction = friction;
        point.position = {radius * std::cos(angle), radius * std::sin(angle), z};
        point.n = {-std::sin(angle), std::cos(angle), 0.0};
        point.s = {std::cos(angle), std::sin(angle), 0.0}, point.t = {0.0, 0.0, 1.0};
        problem.points.push_back(point);
      }
    }
  }
  for (LimitBlock& block : problem.blocks) block.centre.z = 0.5;
  return problem;
}

TEST(Limit, Arches) {
  EXPECT_NEAR(multiplier(arch(7, 0.15, 10.0, 0.0, pi)), 0.1667, 1e-4);
  EXPECT_NEAR(multiplier(arch(16, 0.15, 10.0, 0.0, pi)), 0.1493, 1e-4);
  EXPECT_NEAR(multiplier(arch(36, 0.15, 10.0, 0.0, pi)), 0.1448, 1e-4);
  // Oppenheim's arch as ring sectors, 157.5 degrees in 7 voussoirs: 0.37001.
  EXPECT_NEAR(multiplier(arch(7, 0.15, 10.0, 11.25 * pi / 180.0, 168.75 * pi / 180.0)), 0.37001, 1e-4);
}

// Smallest thickness of a semicircular arch (Milankovitch 1907): 0.10746 of the radius. Below it has no equilibrium.
TEST(Limit, ArchThinnerThanItsLeastThicknessFalls) {
  EXPECT_EQ(limit_multiplier(arch(60, 0.1090, 10.0, 0.0, pi)).status, LimitStatus::solved);
  const LimitResult thin = limit_multiplier(arch(60, 0.1060, 10.0, 0.0, pi));
  EXPECT_EQ(thin.status, LimitStatus::no_equilibrium);
  EXPECT_FALSE(thin.blocks_concerned.empty());
}

// Smallest thickness of an arch of 140 degrees: 0.04126 of the radius.
TEST(Limit, FlatArchThinnerThanItsLeastThicknessFalls) {
  const double from = 20.0 * pi / 180.0, to = 160.0 * pi / 180.0;
  EXPECT_EQ(limit_multiplier(arch(60, 0.0419, 10.0, from, to)).status, LimitStatus::solved);
  EXPECT_EQ(limit_multiplier(arch(60, 0.0406, 10.0, from, to)).status, LimitStatus::no_equilibrium);
}

// Out of plane: a parapet overturns at t/h. A wall of two halves has a fixed top with a force N at
// its middle. Its multiplier is 4 (t/h) (1 + 1.5 N/W), by virtual work of its two halves.
TEST(Limit, WallsOutOfPlane) {
  constexpr double t = 0.2, h = 2.4;
  Boxes parapet;
  parapet.add({-1.0, -1.0, -1.0}, {3.0, 1.0, 3.0}, {}, true);
  parapet.add({0.0, 0.0, 0.0}, {1.0, h, t}, {0.0, 0.0, 1.0});
  parapet.join(2.0);
  EXPECT_NEAR(multiplier(parapet.problem), t / h, 1e-4 * t / h);
  for (const double load : {0.0, 0.5, 2.0}) {  // N over the weight
    Boxes wall;
    wall.add({-1.0, -1.0, -1.0}, {3.0, 1.0, 3.0}, {}, true);
    wall.add({0.0, 0.0, 0.0}, {1.0, h / 2, t}, {0.0, 0.0, 1.0});
    wall.add({0.0, h / 2, 0.0}, {1.0, h / 2, t}, {0.0, 0.0, 1.0});
    wall.join(2.0);
    wall.problem.blocks[2].dead.force.y -= load * h * t;  // the weight is equal to the volume
    for (const double x : {0.0, 1.0}) {
      LimitPoint held;  // support along z at the height of the top
      held.a = 2, held.b = 0, held.friction = 0.0;
      held.position = {x, h, t / 2}, held.n = {0.0, 0.0, 1.0}, held.s = {1.0, 0.0, 0.0}, held.t = {0.0, 1.0, 0.0};
      wall.problem.points.push_back(held);
    }
    const double expected = 4.0 * t / h * (1.0 + 1.5 * load);
    EXPECT_NEAR(multiplier(wall.problem), expected, 1e-4 * expected) << load;
  }
}

// Returns a facade of units of 0.4 x 0.2 x 0.2 m and two side walls of 0.8 m with interlocking corners, under an
// outward load (-z).
LimitProblem u_shape(int facade_units, int courses, double friction) {
  Boxes walls;
  const double length = 0.4 * facade_units;
  const Vector live{0.0, 0.0, -1.0};
  walls.add({-1.0, -0.2, -1.0}, {length + 2.0, 0.2, 3.0}, {}, true);
  for (int c = 0; c < courses; ++c) {
    const double y = 0.2 * c;
    const bool through = c % 2 == 0;  // in this course the facade extends to the corners
    for (double x = through ? 0.0 : 0.2; x < length - 0.3; x += 0.4) walls.add({x, y, 0.0}, {0.4, 0.2, 0.2}, live);
    for (const double x : {0.0, length - 0.2}) {
      if (through) {
        walls.add({x, y, 0.2}, {0.2, 0.2, 0.4}, live);
        walls.add({x, y, 0.6}, {0.2, 0.2, 0.2}, live);
      } else {
        walls.add({x, y, 0.0}, {0.2, 0.2, 0.4}, live);
        walls.add({x, y, 0.4}, {0.2, 0.2, 0.4}, live);
      }
    }
  }
  walls.join(friction);
  return walls.problem;
}

// Out of plane: an independent programme with equal pyramids has 0.28653 and 0.20579; a free wall overturns at t/h.
TEST(Limit, FacadesHeldBySideWalls) {
  LimitSettings settings;
  settings.facets = 16, settings.facet_on_axis = true;
  EXPECT_NEAR(multiplier(u_shape(4, 8, 0.6), settings), 0.28653, 1e-4 * 0.28653);
  EXPECT_NEAR(multiplier(u_shape(6, 10, 0.6), settings), 0.20579, 1e-4 * 0.20579);
  LimitProblem free = running_bond(5, 10, 0.6, 0, 0.2);
  for (LimitBlock& block : free.blocks) block.live.force = {0.0, 0.0, -norm(block.dead.force)};
  EXPECT_NEAR(multiplier(free), 0.1, 1e-6);
}

// A bonded block under a moment. The joint of 1 m x 1 m with points at its corners opens at M = ft A/2 + W/2. Half of
// the tension acts at 1 m from the toe. The load acts 1 m above the joint.
TEST(Limit, TensionAndCohesionHold) {
  Boxes one;
  one.add({-2.0, -1.0, -2.0}, {5.0, 1.0, 5.0}, {}, true);
  one.add({0.0, 0.0, 0.0}, {1.0, 2.0, 1.0}, {1.0, 0.0, 0.0});
  one.join(0.7);
  for (LimitPoint& p : one.problem.points) p.tension = 5.0 / 4.0, p.cohesion = 40.0;
  // M = W lambda about the toe is equal to W/2 plus the tension of two corners at 1 m: lambda W = W/2 + 5/2, W = 2.
  EXPECT_NEAR(multiplier(one.problem), 0.5 + 2.5 / 2.0, 1e-8);
  for (LimitPoint& p : one.problem.points) p.tension = 0.0, p.cohesion = 0.1;
  // It slides at 4 c + mu W before it overturns, with friction 0.1 in place of 0.7.
  for (LimitPoint& p : one.problem.points) p.friction = 0.1;
  EXPECT_NEAR(multiplier(one.problem), (0.4 + 0.1 * 2.0) / 2.0, 1e-8);
  LimitSettings turned;  // a facet across the direction of sliding
  turned.facets = 16, turned.facet_on_axis = true;
  EXPECT_NEAR(multiplier(one.problem, turned), 0.3 * std::cos(pi / 16.0), 1e-8);
}

// Crushing: each corner carries N <= fc. With fc = 1.2 and W = 2 both toe corners carry all of W (2 <= 2.4), as without
// crushing. With 0.8 they carry 1.6 and the heel 0.4: M = W/2 - 0.4.
TEST(Limit, CrushingShortensTheLever) {
  for (const double cap : {1.2, 0.8}) {
    Boxes one;
    one.add({-2.0, -1.0, -2.0}, {5.0, 1.0, 5.0}, {}, true);
    one.add({0.0, 0.0, 0.0}, {1.0, 2.0, 1.0}, {1.0, 0.0, 0.0});
    one.join(5.0);
    for (LimitPoint& p : one.problem.points) p.crushing = cap;
    const double heel = std::max(0.0, 2.0 - 2.0 * cap);
    EXPECT_NEAR(multiplier(one.problem), (1.0 - heel) / 2.0, 1e-8) << cap;
  }
}

LimitSettings whole_cones() {
  LimitSettings settings;
  settings.facets = 0;
  return settings;
}

// Whole cones against closed forms: a block slides in any direction at its friction.
TEST(WholeCones, MeetClosedForms) {
  for (const double turned : {0.0, 0.1, 0.7}) {
    Boxes one;
    one.add({-9.0, -1.0, -9.0}, {19.0, 1.0, 19.0}, {}, true);
    one.add({0.0, 0.0, 0.0}, {1.0, 0.5, 1.0}, {std::cos(turned), 0.0, std::sin(turned)});
    one.join(0.3);
    const LimitResult found = limit_multiplier(one.problem, whole_cones());
    EXPECT_EQ(found.facets, 0);
    EXPECT_NEAR(found.multiplier, 0.3, 1e-6) << turned;
    for (LimitPoint& p : one.problem.points) p.cohesion = 0.02;
    EXPECT_NEAR(multiplier(one.problem, whole_cones()), 0.3 + 4 * 0.02 / 0.5, 1e-6) << turned;
  }
  EXPECT_NEAR(multiplier(running_bond(5, 6, 0.65, 0), whole_cones()), 0.64286, 1e-5);
  EXPECT_NEAR(multiplier(running_bond(5, 10, 0.65, 0), whole_cones()), 0.58000, 1e-5);
  EXPECT_NEAR(multiplier(running_bond(8, 4, 10.0, 0, 0.2), whole_cones()), 4.0, 1e-4);
  EXPECT_NEAR(multiplier(arch(36, 0.15, 10.0, 0.0, pi), whole_cones()), 0.1448, 1e-4);
}

// Tension, crushing and ties with whole cones, against pyramids in planes where these are exact.
TEST(WholeCones, HaveTheStrengthsOfPyramids) {
  Boxes one;
  one.add({-2.0, -1.0, -2.0}, {5.0, 1.0, 5.0}, {}, true);
  one.add({0.0, 0.0, 0.0}, {1.0, 2.0, 1.0}, {1.0, 0.0, 0.0});
  one.join(5.0);
  const auto same = [&](const char* what) {
    EXPECT_NEAR(multiplier(one.problem, whole_cones()), multiplier(one.problem), 1e-5) << what;
  };
  same("dry");
  for (LimitPoint& p : one.problem.points) p.tension = 1.25, p.cohesion = 40.0;
  same("bonded");
  for (LimitPoint& p : one.problem.points) p.crushing = 0.8;
  same("crushed");
  for (LimitPoint& p : one.problem.points) p.tension = 0.0, p.cohesion = 0.1, p.friction = 0.0;
  same("without friction");
  const geometry::Vector x{1.0, 0.0, 0.0};
  one.problem.forces.push_back({{{0, {-1.0, 2.0, 0.5}, x, {}}, {1, {0.0, 2.0, 0.5}, -x, {}}}, 0.0, 0.3});
  same("tied");
  const LimitResult tied = limit_multiplier(one.problem, whole_cones());
  EXPECT_NEAR(tied.member_force.at(0), 0.3, 1e-5);
  // A couple on a third body without other supports, and a force without bounds.
  one.problem.blocks.push_back({{0.0, 3.0, 0.5}, false, {}, {}});
  for (const geometry::Vector& way : {x, geometry::Vector{0.0, 1.0, 0.0}, geometry::Vector{0.0, 0.0, 1.0}}) {
    one.problem.forces.push_back({{{2, {0.0, 3.0, 0.5}, way, {}}, {1, {0.0, 2.0, 0.5}, -way, {}}}});
    one.problem.forces.push_back(
        {{{2, {0.0, 3.0, 0.5}, {}, way}, {1, {0.0, 2.0, 0.5}, {}, -way}, {0, {}, {}, {}}}, -0.2, 0.2});
  }
  same("with a body of three places");
}

// Inscribed pyramids of 16 facets are at most 1 - cos(pi/16) = 1.9 % within the cones: case 10 has up to 1.5 % more.
TEST(WholeCones, AreNoWeakerThanPyramidsWithinThem) {
  LimitSettings sixteen;
  sixteen.facets = 16, sixteen.facet_on_axis = true;
  for (const auto& [units, courses] : {std::pair(4, 8), std::pair(6, 10)}) {
    const LimitProblem walls = u_shape(units, courses, 0.6);
    const double whole = multiplier(walls, whole_cones()), within = multiplier(walls, sixteen);
    std::printf("facade of %d units: %.5f, 16 facets %.5f\n", units, whole, within);
    EXPECT_GE(whole, within - 1e-6);
    EXPECT_LE(whole, 1.015 * within);
  }
}

// Forces in equilibrium and within the cones, to 1e-6 of a block's weight.
TEST(WholeCones, GiveForcesInEquilibriumAndWithinStrength) {
  const LimitProblem wall = running_bond(6, 8, 0.65, 0);
  const LimitResult found = limit_multiplier(wall, whole_cones());
  const double weight = norm(wall.blocks.back().dead.force);
  std::vector<Vector> sum;
  for (const LimitBlock& b : wall.blocks) sum.push_back(b.dead.force + found.multiplier * b.live.force);
  for (std::size_t i = 0; i < wall.points.size(); ++i) {
    const LimitPoint& p = wall.points[i];
    const auto& [n, s, t] = found.force[i];
    EXPECT_LE(std::hypot(s, t), -p.friction * n + 1e-6 * weight);
    const Vector f = n * p.n + s * p.s + t * p.t;
    sum[static_cast<std::size_t>(p.a)] += f, sum[static_cast<std::size_t>(p.b)] += -f;
  }
  for (std::size_t k = 0; k < sum.size(); ++k)
    if (!wall.blocks[k].fixed) {
      EXPECT_LT(norm(sum[k]), 1e-5 * weight) << k;
    }
}

TEST(Limit, WhatHasNoAnswerIsNamed) {
  Boxes floating;
  floating.add({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, {}, true);
  floating.add({0.0, 1.0, 0.0}, {1.0, 1.0, 1.0}, {1.0, 0.0, 0.0});
  floating.add({9.0, 9.0, 0.0}, {1.0, 1.0, 1.0}, {1.0, 0.0, 0.0});
  floating.join(0.5);
  const LimitResult result = limit_multiplier(floating.problem);
  EXPECT_EQ(result.status, LimitStatus::no_equilibrium);
  EXPECT_EQ(result.blocks_concerned, std::vector<int>{2});

  Boxes pressed;  // a downward load causes no mechanism
  pressed.add({-1.0, 0.0, -1.0}, {3.0, 1.0, 3.0}, {}, true);
  pressed.add({0.0, 1.0, 0.0}, {1.0, 1.0, 1.0}, {0.0, -1.0, 0.0});
  pressed.join(0.5);
  EXPECT_EQ(limit_multiplier(pressed.problem).status, LimitStatus::unbounded);
  EXPECT_EQ(limit_multiplier(pressed.problem).blocks_concerned, std::vector<int>{1});

  // Cones have no solution; pyramids give the reason.
  EXPECT_EQ(limit_multiplier(floating.problem, whole_cones()).status, LimitStatus::no_equilibrium);
  EXPECT_EQ(limit_multiplier(pressed.problem, whole_cones()).status, LimitStatus::unbounded);

  LimitProblem bad = pressed.problem;
  bad.points[0].friction = -1.0;
  EXPECT_ANY_THROW(limit_multiplier(bad));
  bad = pressed.problem;
  bad.blocks[1].live = {};
  EXPECT_ANY_THROW(limit_multiplier(bad));
  LimitSettings settings;
  settings.facets = 3;
  EXPECT_ANY_THROW(limit_multiplier(pressed.problem, settings));
}

// A slab of 4 x 0.4 x 1 m on piers at x = -1.25 and 1.25 m, each 0.5 m wide, under a load at x. Between the outer edges
// of the piers nothing moves, whatever the load. Past the edge at 1.5 m the slab of weight 1.6 tips about it:
// 1.6 (1.5 - 0.5)/(x - 1.5).
TEST(Limit, LoadsThatNothingMovesUnderAreNamed) {
  for (int k = 0; k <= 19; ++k) {
    const double x = -1.4 + 3.8 * k / 19;
    Boxes bridge;
    bridge.add({-3.0, -0.5, -1.0}, {6.0, 0.5, 3.0}, {}, true);
    bridge.add({-1.5, 0.0, 0.0}, {0.5, 1.0, 1.0}, {});
    bridge.add({1.0, 0.0, 0.0}, {0.5, 1.0, 1.0}, {});
    bridge.add({-1.5, 1.0, 0.0}, {4.0, 0.4, 1.0}, {});
    bridge.join(std::tan(pi / 6));
    LimitBlock& slab = bridge.problem.blocks[3];
    slab.live = {{0.0, -1.0, 0.0}, cross(Vector{x, 1.4, 0.5} - slab.centre, {0.0, -1.0, 0.0})};
    for (const LimitSettings& settings : {LimitSettings{}, whole_cones()}) {
      const LimitResult result = limit_multiplier(bridge.problem, settings);
      if (x < 1.5 + 1e-3) {
        EXPECT_EQ(result.status, LimitStatus::unbounded) << x;
        continue;
      }
      ASSERT_EQ(result.status, LimitStatus::solved) << x;
      EXPECT_NEAR(result.multiplier, 1.6 / (x - 1.5), 1e-5 * result.multiplier) << x;  // of whole cones: kGap
    }
  }
}

// Past the deadline both solvers end without an answer, which is said; sequences have not settled.
TEST(Limit, EndsAtItsDeadline) {
  const LimitProblem wall = arch(16, 0.2, 0.7, 0.0, pi);
  for (LimitSettings settings : {LimitSettings{}, whole_cones()}) {
    settings.deadline = std::chrono::steady_clock::now();
    const LimitResult result = limit_multiplier(wall, settings);
    EXPECT_EQ(result.status, LimitStatus::late);
    EXPECT_THAT([&] { require_answer(result); }, testing::ThrowsMessage<Error>(testing::HasSubstr("--seconds")));
    EXPECT_THROW(stands(wall, settings), Error);
    const LimitWithoutDilation without = limit_without_dilation(wall, settings);
    EXPECT_FALSE(without.settled);
    EXPECT_TRUE(without.late);
  }
}

// Steps are reported with the phase that they belong to. What a report throws ends the analysis, from two threads too.
TEST(Limit, ReportsItsStepsAndCanBeStopped) {
  const LimitProblem ring = arch(16, 0.2, 0.7, 0.0, pi);
  LimitSettings settings = whole_cones();
  std::mutex mutex;
  std::vector<std::string> steps;
  settings.progress = [&](const std::string& step) {
    const std::lock_guard lock(mutex);
    steps.push_back(step);
  };
  limit_multiplier(ring, in_phase(settings, "arch"));
  EXPECT_GT(steps.size(), 3u);
  EXPECT_THAT(steps, testing::Each(testing::StartsWith("arch: step ")));
  steps.clear();
  limit_without_dilation(ring, settings);
  EXPECT_THAT(steps, testing::Contains(testing::StartsWith("from weight, problem 2: step ")));
  EXPECT_THAT(steps, testing::Contains(testing::StartsWith("from associated, problem 1: step ")));
  settings.progress = [](const std::string& step) {
    if (step.starts_with("from")) throw std::runtime_error("stop");
  };
  EXPECT_THROW(limit_without_dilation(ring, settings), std::runtime_error);
}

// Returns a block of 0.5 x 0.4 m on a plane tilted by atan(0.3), with friction 0.7. It slides below a friction of 0.3
// and overturns only above 0.5/0.4. The result without dilation is equal, since the plane carries all normal force.
LimitProblem tilted(double slope, double friction) {
  Boxes one;
  one.add({-2.0, -1.0, -2.0}, {5.0, 1.0, 5.0}, {}, true);
  one.add({0.0, 0.0, 0.0}, {0.5, 0.4, 1.0}, {});
  one.join(friction);
  LimitBlock& block = one.problem.blocks[1];
  block.dead.force.x = -slope * block.dead.force.y;
  return one.problem;
}

TEST(Stands, ATiltedBlockNeedsTheFrictionOfItsSlope) {
  const Stands found = stands(tilted(0.3, 0.7));
  EXPECT_TRUE(found.stands);
  EXPECT_NEAR(found.friction.value(), 0.3 / 0.7, 2e-3 * 0.3 / 0.7);  // accurate to 0.1 %
  EXPECT_TRUE(found.out_of_balance.empty());
  const LimitWithoutDilation without = friction_without_dilation(tilted(0.3, 0.7));
  ASSERT_TRUE(without.settled);
  EXPECT_NEAR(without.multiplier, 0.3 / 0.7, 2e-3 * 0.3 / 0.7);
}

TEST(Stands, WithTooLittleFrictionItIsSaidHowMuchIsNeeded) {
  const Stands found = stands(tilted(0.3, 0.2));
  EXPECT_FALSE(found.stands);
  EXPECT_NEAR(found.friction.value(), 1.5, 2e-3 * 1.5);
  EXPECT_EQ(found.out_of_balance, std::vector<int>{1});
}

TEST(Stands, NoFrictionHoldsWhatTurnsOver) {
  const Stands found = stands(tilted(1.3, 10.0));
  EXPECT_FALSE(found.stands);
  EXPECT_NEAR(found.carried, 0.0, 1e-9);
  EXPECT_FALSE(found.friction.has_value());
}

// A block that hangs from a ceiling by a bond of 0.4 of its weight.
TEST(Stands, ABondCarriesItsShare) {
  Boxes one;
  one.add({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, {});
  one.add({-2.0, 1.0, -2.0}, {5.0, 1.0, 5.0}, {}, true);
  one.join(0.5);
  for (LimitPoint& p : one.problem.points) p.tension = 0.1, p.cohesion = 1.0;
  const Stands found = stands(one.problem);
  EXPECT_FALSE(found.stands);
  EXPECT_NEAR(found.carried, 0.4, 1e-9);
}

// A tensile strength of twice the weight, without cohesion: Coulomb's line ends at sigma = c/mu = 0, so that the block
// falls. Without friction the line has no end, and that strength held it.
TEST(Stands, WithoutCohesionNoTensileStrengthHolds) {
  Boxes one;
  one.add({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, {});
  one.add({-2.0, 1.0, -2.0}, {5.0, 1.0, 5.0}, {}, true);
  one.join(0.5);
  for (LimitPoint& p : one.problem.points) p.tension = 0.5;
  const Stands hung = stands(one.problem);
  EXPECT_FALSE(hung.stands);
  EXPECT_NEAR(hung.carried, 0.0, 1e-6);
  EXPECT_FALSE(hung.friction.has_value());
}

// Without live loads the friction needed without dilation is not below that needed with dilation.
TEST(Stands, WithoutDilationNoLessFrictionIsNeeded) {
  LimitProblem ring = arch(16, 0.15, 0.7, 0.0, pi);
  LimitSettings settings;
  settings.facets = 4;  // exact in a plane problem
  const double associated = stands(ring, settings).friction.value();
  const LimitWithoutDilation without = friction_without_dilation(ring, settings);
  ASSERT_TRUE(without.settled);
  EXPECT_GT(without.multiplier, associated * (1.0 - 5e-3));
  EXPECT_GT(associated, 0.3);
  EXPECT_LT(without.multiplier, 1.0);
}

TEST(Stands, BlocksThatNothingHoldsAreNamed) {
  Boxes two;
  two.add({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, {}, true);
  two.add({0.0, 1.0, 0.0}, {1.0, 1.0, 1.0}, {});
  two.add({9.0, 1.0, 0.0}, {1.0, 1.0, 1.0}, {});
  two.add({9.0, 2.0, 0.0}, {1.0, 1.0, 1.0}, {});
  two.join(0.5);
  EXPECT_EQ(unconnected_blocks(two.problem), (std::vector<int>{2, 3}));
}

}  // namespace
}  // namespace quoin
