// The bounds of small displacements, and walls in large motion against walls in small displacements.
#include "step/large_motion.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "scene/read_scene.h"
#include "step/findings.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

using ::testing::HasSubstr;

std::array<Vec3, 8> corners_of(const Vec3& size) {
  std::array<Vec3, 8> corner;
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t c = 0; c < 3; ++c) corner[i][c] = (i >> c & 1 ? 0.5 : -0.5) * size[c];
  }
  return corner;
}

// For u = t + w x r + E r with a symmetric E, the rigid motion is t and w, without E.
TEST(LargeMotion, WholeMotionIsTranslationAndRotationWithoutStrain) {
  const Vec3 size = {0.22, 0.0625, 0.1}, t = {1e-3, -2e-3, 3e-3}, w = {0.01, -0.02, 0.03};
  const double e[3][3] = {{1e-3, 4e-3, -2e-3}, {4e-3, -3e-3, 5e-3}, {-2e-3, 5e-3, 2e-3}};
  std::array<Vec3, 8> u = corners_of(size);
  for (Vec3& r : u) {
    const Vec3 x = r;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t n = (c + 1) % 3, l = (c + 2) % 3;
      r[c] = t[c] + w[n] * x[l] - w[l] * x[n] + e[c][0] * x[0] + e[c][1] * x[1] + e[c][2] * x[2];
    }
  }
  const WholeMotion m = whole_motion(size, u);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(m.translation[c], t[c], 1e-15);
    EXPECT_NEAR(m.rotation[c], w[c], 1e-15);
  }
}

// Two bricks of 0.2 x 0.1 x 0.05 m beside each other: the joint is a face of 0.1 x 0.05 m.
TEST(LargeMotion, SlidingIsOverTheLengthOfTheJoint) {
  const Assembly assembly = brick_grid({2, 1, 1}, {0.2, 0.1, 0.05}, {1, 1, 1});
  const JointSliding joints(assembly);
  std::vector<WholeMotion> motion(2);
  motion[1].translation = {7e-3, 2e-3, 0.0};  // opening does not count
  MotionSeen seen;
  joints.look(motion, &seen);
  EXPECT_NEAR(seen.sliding, 2e-3 / 0.1, 1e-15);
  EXPECT_EQ(seen.slid_joint, 0);
  EXPECT_EQ(seen.rotation, 0.0);
  // Both blocks rotate together about the joint's centre: no slip, although both centres move.
  motion[0] = {{0.0, -0.1 * 0.02, 0.0}, {0.0, 0.0, 0.02}};
  motion[1] = {{0.0, 0.1 * 0.02, 0.0}, {0.0, 0.0, 0.02}};
  MotionSeen turned;
  joints.look(motion, &turned);
  EXPECT_NEAR(turned.sliding, 0.0, 1e-15);
  EXPECT_NEAR(turned.rotation, 0.02, 1e-15);
  // Joints across every axis. Blocks rotate about the second next axis, by 0.01 below and 0.03 above. The relative
  // motion of their faces along the next axis is the sum of rotation times half of the size.
  const Vec3 size{0.2, 0.1, 0.05};
  for (std::size_t normal = 0; normal < 3; ++normal) {
    std::array<int, 3> count{1, 1, 1};
    count[normal] = 2;
    std::vector<WholeMotion> both(2);
    both[0].rotation[(normal + 2) % 3] = 0.01, both[1].rotation[(normal + 2) % 3] = 0.03;
    MotionSeen slid;
    JointSliding(brick_grid(count, size, {1, 1, 1})).look(both, &slid);
    EXPECT_NEAR(slid.sliding, 0.04 * size[normal] / 2 / size[(normal + 1) % 3], 1e-15) << "across axis " << normal;
  }

  MotionBound bound;
  bound.rotation = 0.03, bound.sliding = 0.03;
  EXPECT_EQ(past_bound(turned, bound, assembly), "");
  bound.rotation = 0.01;
  EXPECT_THAT(past_bound(turned, bound, assembly), HasSubstr("block 0 at (0.100, 0.050, 0.025) m has turned by 0.02 "));
  bound = {0.1, 0.01, true};
  EXPECT_THAT(past_bound(seen, bound, assembly), HasSubstr("have slid on each other by 0.02 "));
}

Scene small_wall(const std::string& large_motion, std::vector<std::string> more = {}, bool by_block = false) {
  more.insert(more.end(), {std::string("solver.damping=") + (by_block ? "block" : "local"),
                           "solver.large_motion=" + large_motion, "wall.units_per_course=3", "output.frames=0"});
  return read_scene(QUOIN_HOST_TESTS "/../cli/small_wall.toml", more);
}

struct Rows : Observer {
  std::vector<HistoryRow> rows;
  int warnings = 0;
  void on_row(const HistoryRow& row) override { rows.push_back(row); }
  void on_warning(const Warning& w) override { warnings += w.about == "small_displacements"; }
};

// Large motion has the gridpoints, contact points and masses of the lattice. Zones have one pattern, so triangles of
// joined faces coincide.
TEST(LargeMotion, BricksBecomeBlocksWithTheSameContactPoints) {
  for (const bool units_in_halves : {false, true}) {
    std::vector<std::string> more;
    if (units_in_halves) more = {"wall.mid_unit_joints=true", "wall.unit_joint=mortar", "wall.zones=[4,2,2]"};
    Simulation small(small_wall("never", more)), large(small_wall("always", more));
    ASSERT_TRUE(large.large_motion());
    EXPECT_EQ(large.block_count(), small.block_count());
    EXPECT_EQ(large.zone_count(), small.zone_count());
    EXPECT_NEAR(large.time_step_report().model_mass, small.time_step_report().model_mass,
                1e-12 * small.time_step_report().model_mass);
    const auto by_place = [](std::vector<ContactPoint> points) {
      const auto key = [](const ContactPoint& p) {
        const auto mm = [](double x) { return std::lround(1e6 * x); };
        return std::array{mm(p.position[0]), mm(p.position[1]), mm(p.position[2]),
                          static_cast<long>(std::min(p.block_a, p.block_b)),
                          static_cast<long>(std::max(p.block_a, p.block_b))};
      };
      std::sort(points.begin(), points.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
      return points;
    };
    const auto a = by_place(contact_points(small));
    large.advance(1);  // computes positions of contact points
    const auto b = by_place(contact_points(large));
    ASSERT_GT(a.size(), 0u);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(a[i].position[c], b[i].position[c], 1e-9);
      EXPECT_NEAR(a[i].area, b[i].area, 1e-9 * a[i].area);
      EXPECT_EQ(a[i].family, b[i].family);
    }
  }
}

const std::vector<std::string> kHalves = {"wall.mid_unit_joints=true", "wall.unit_joint=mortar"};

// Added inertia and damping by block are those of the lattice, whose mass matrix is tested against a dense one. The
// highest frequency agrees within the tolerance of Lanczos (1e-6 of its square), and so does the time step.
TEST(LargeMotion, TimeStepIsThatOfTheLattice) {
  for (const bool halves : {false, true}) {
    const auto more = halves ? kHalves : std::vector<std::string>{};
    const Simulation small(small_wall("never", more, true)), large(small_wall("always", more, true));
    const TimeStepReport &a = small.time_step_report(), &b = large.time_step_report();
    EXPECT_NEAR(b.critical.value, a.critical.value, 1e-5 * a.critical.value);
    EXPECT_NEAR(b.time_step, a.time_step, 1e-5 * a.time_step);
    const Simulation as_printed(small_wall("always", more));
    EXPECT_GT(b.time_step, 2.0 * as_printed.time_step_report().time_step);
  }
}

// Compares a wall in small displacements and in large motion. They differ by what small displacements neglect: 0.5 mm
// over 125 mm is a drift of 0.004, and the peak is at about a fifth of it. The tolerance is 0.5 % at the peak, and 1 %
// of the peak along the curve, where cracks may grow a step earlier or later.
void expect_same_curve(const std::vector<std::string>& more, bool by_block) {
  Rows of_small, of_large;
  Simulation small(small_wall("never", more, by_block)), large(small_wall("always", more, by_block));
  small.run(of_small);
  large.run(of_large);
  const auto shear = [](const Rows& from) {
    std::vector<std::pair<double, double>> curve;
    for (const HistoryRow& row : from.rows) {
      if (row.stage == 1) curve.push_back({row.displacement, row.resistance});
    }
    return curve;
  };
  const auto a = shear(of_small), b = shear(of_large);
  const auto peak = [](const auto& curve) {
    double largest = 0.0;
    for (const auto& [u, f] : curve) largest = std::max(largest, f);
    return largest;
  };
  ASSERT_GT(peak(a), 1e3);
  EXPECT_NEAR(peak(b), peak(a), 0.005 * peak(a));
  const auto at = [](const auto& curve, double u) {
    const auto next = std::find_if(curve.begin(), curve.end(), [u](const auto& p) { return p.first >= u; });
    if (next == curve.begin()) return curve.front().second;
    if (next == curve.end()) return curve.back().second;
    const auto before = next - 1;
    return before->second + (u - before->first) / (next->first - before->first) * (next->second - before->second);
  };
  double squares = 0.0;
  for (int i = 1; i <= 100; ++i) {
    const double difference = at(b, i * 5e-6) - at(a, i * 5e-6);
    squares += 0.01 * difference * difference;
  }
  std::printf("peak %.6g N, difference %.2g; of the curve %.2g of it; %ld and %ld steps\n", peak(a),
              peak(b) / peak(a) - 1.0, std::sqrt(squares) / peak(a), small.step(), large.step());
  EXPECT_LT(std::sqrt(squares), 0.01 * peak(a));
  EXPECT_GT(b.size(), 100u);
  EXPECT_GT(motion_seen(small).rotation, 1e-4);
  EXPECT_GT(motion_seen(large).rotation, 1e-4);
}

TEST(LargeMotion, CurveIsThatOfSmallDisplacements) { expect_same_curve({}, false); }
TEST(LargeMotion, CurveIsThatOfSmallDisplacementsUnderDampingByBlock) { expect_same_curve({}, true); }
TEST(LargeMotion, CurveOfUnitsInHalvesIsThatOfSmallDisplacements) { expect_same_curve(kHalves, true); }

TEST(LargeMotion, PastTheBoundARunStopsOrWarnsOnce) {
  Rows rows;
  Simulation stops(small_wall("never", {"solver.rotation_bound=1e-5"}));
  try {
    stops.run(rows);
    FAIL() << "went on";
  } catch (const Error& e) {
    EXPECT_EQ(e.exit_code, Exit::numerical);
    EXPECT_THAT(e.what(), HasSubstr("more than solver.rotation_bound = 1e-05"));
  }
  Rows all;
  Scene scene = small_wall("never", {"solver.sliding_bound=1e-6"});
  scene.solver.motion_bound.stop = false;
  Simulation goes_on(scene);
  goes_on.run(all);
  EXPECT_EQ(all.warnings, 1);
  EXPECT_THAT(past_motion_bound(goes_on), HasSubstr("have slid on each other"));
}

}  // namespace
}  // namespace quoin
