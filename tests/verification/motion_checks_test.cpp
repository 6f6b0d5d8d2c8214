// The time of the next contact detection (model/motion_checks.cpp). No pair of rigid blocks moves by more than its
// bound between checks, for any interval of checks and any impact.
#include "model/motion_checks.h"

#include <algorithm>
#include <limits>

#include "model/block_layout.h"
#include "support.h"

namespace quoin::verification {
namespace {

// Returns the largest motion of a pair since its last contact detection, relative to its bound.
double furthest_of(const Model& m) {
  double most = 0.0;
  for (size_t i = 0; i < m.contacts.list.size(); ++i) {
    const Contact& c = m.contacts.list[i];
    const PairPlace& place = m.contacts.place[i];
    const double moved = pair_motion(m, c, place, pose(m, c.pair.a), pose(m, c.pair.b));
    most = std::max(most, moved / allowed_motion(m, c, place));
  }
  return most;
}

// Returns the step of the next check of any pair of this block.
long next_check_of(const Model& m, int block) {
  long first = std::numeric_limits<long>::max();
  for (const PairCheck& check : m.checks.pair) {
    if (check.a == block || check.b == block) first = std::min(first, check.step);
  }
  return first;
}

TEST(MotionLooks, NobodyComesFurtherThanItMayWhateverHitsIt) {
  Scene scene(dry_joint(2e9, 1e9, 33));
  scene.brick({-5, -0.2, -5}, {10, 0.2, 10}, true);
  std::vector<int> stack;
  for (int i = 0; i < 4; ++i) stack.push_back(scene.brick({0, 0.1 * i, 0}, {0.2, 0.1, 0.2}));
  const int ball = scene.brick({-0.5, 0.25, 0.05}, {0.1, 0.1, 0.1});
  Model m(scene.assembly, viscous(0, 4e-5));
  m.set_gravity({0, -gravity, 0});
  m.prescribe(ball, {});
  run_steps(m, 500);  // the stack comes to rest

  constexpr int kQuiet = 500;
  int looks = 0;
  for (int i = 0; i < kQuiet; ++i) {
    looks += checks_motion(m);
    m.step();
  }
  EXPECT_LT(looks, kQuiet / 10) << "at rest, and looked at all the time";
  const long detections = m.detection.count;

  m.prescribe(ball, {}, {}, 0);
  m.set_velocity(ball, {8, 0, 0}, {0, 0, 20});
  double furthest = 0.0;
  const double end = m.stepping.time + 0.15;
  while (m.stepping.time < end) {
    m.step();
    furthest = std::max(furthest, furthest_of(m));
  }
  EXPECT_GT(norm(velocity_of(m, stack[2])) + norm(velocity_of(m, stack[3])), 0.1)
      << "nothing was hit: nothing is tested";
  EXPECT_GT(m.detection.count, detections + 10);
  // Above the bound contacts are detected at the end of this step, which resets the motion. 1e-12 is for rounding.
  EXPECT_LE(furthest, 1.0 + 1e-12);
}

// Two neighbours at 4 mm: they move towards each other or past each other, rotate in equal or opposite directions, or
// one about the other. Their relative motion follows from both motions, parts of which may cancel. The last two blocks
// rotate as one body. Moving straight on, their distance is of second order in the rotation.
TEST(MotionLooks, NobodyComesFurtherThanItMayHoweverTheyMove) {
  const struct {
    Vector va, wa, vb, wb;
  } motions[] = {{{0, 0.5, 0}, {}, {0, -0.5, 0}, {}},
                 {{0.5, 0, 0}, {}, {-0.5, 0, 0}, {}},
                 {{0, -0.5, 0}, {}, {0, 0.5, 0}, {}},
                 {{}, {0, 0, 5}, {}, {0, 0, -5}},
                 {{}, {0, 5, 0}, {}, {0, -5, 0}},
                 {{}, {0, 0, 5}, {-0.52, 0, 0}, {}},
                 {{}, {0, 0, 5}, {0.52, 0, 0}, {}},
                 {{0.5, 0.5, 0}, {}, {0.5, 0.4, 0}, {0, 0, 3}},
                 {{0.26, 0, 0}, {0, 0, 5}, {-0.26, 0, 0}, {0, 0, 5}}};
  for (const auto& motion : motions) {
    Scene scene(dry_joint(2e9, 1e9, 33));
    const int a = scene.brick({0, 0, 0}, {0.2, 0.1, 0.2}), b = scene.brick({0, 0.104, 0}, {0.2, 0.1, 0.2});
    Model m(scene.assembly, viscous(0, 4e-5));
    run_steps(m, 1);
    m.set_velocity(a, motion.va, motion.wa);
    m.set_velocity(b, motion.vb, motion.wb);
    double furthest = 0.0;
    int looks = 0, steps = 0;
    for (; m.stepping.time < 0.05; ++steps) {
      looks += checks_motion(m);
      m.step();
      furthest = std::max(furthest, furthest_of(m));
    }
    EXPECT_LT(looks, 0.7 * steps) << "looked at all the time: nothing is tested";
    EXPECT_LE(furthest, 1.0 + 1e-12) << motion.va.x << ' ' << motion.va.y << ' ' << motion.wa.y << ' ' << motion.wa.z;
  }
}

// A deformable block slides along a floor on which others stand. Its pairs are checked often, those of the others
// rarely. No pair exceeds its bound, since accelerations are below the 10 g that the rule assumes.
TEST(MotionLooks, DeformableBlocksAreCheckedByTheirOwnSpeed) {
  Scene scene(dry_joint(2e8, 1e8, 5), 2000, 1e9, 0.2);
  scene.brick({-5, -0.2, -5}, {20, 0.2, 10}, true);
  const int slider = scene.soft({0, 0, 0}, {0.2, 0.1, 0.2}, {2, 1, 2});
  const int standing = scene.soft({0, 0, 1}, {0.2, 0.1, 0.2}, {2, 1, 2});
  Model m(scene.assembly, viscous(0, 4e-5));
  m.set_gravity({0, -gravity, 0});
  run_steps(m, 4000);  // both come to rest
  m.set_velocity(slider, {2, 0, 0});
  const Vector start = position_of(m, slider);
  constexpr int kSteps = 4000;
  int of_slider = 0, of_standing = 0;
  double furthest = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    of_slider += next_check_of(m, slider) == m.stepping.count + 1;
    of_standing += next_check_of(m, standing) == m.stepping.count + 1;
    m.step();
    furthest = std::max(furthest, furthest_of(m));
  }
  EXPECT_GT(norm(position_of(m, slider) - start), 0.05) << "nothing has slid: nothing is tested";
  EXPECT_LT(of_slider, kSteps) << "looked at all the time";
  EXPECT_GT(of_slider, 3 * of_standing);
  EXPECT_LT(of_standing, kSteps / 20);
  EXPECT_LE(furthest, 1.0 + 1e-12);
}

}  // namespace
}  // namespace quoin::verification
