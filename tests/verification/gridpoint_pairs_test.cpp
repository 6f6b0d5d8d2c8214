// Contact points between gridpoints of both blocks, or of block a and a rigid block b. Their axes rotate with the
// co-rotational frame of block a (host/step/contact_kernels.h).
#include <algorithm>

#include "../momentum.h"
#include "support.h"

namespace quoin::verification {
namespace {

enum class Row { of_one_mesh, of_unlike_meshes, rigid_end };

std::string name_of(Row row) {
  if (row == Row::of_one_mesh) return "bricks of one mesh";
  return row == Row::of_unlike_meshes ? "bricks of unlike meshes" : "bricks, the last one rigid,";
}

// Returns three bricks in a row along x, with joints of low shear stiffness.
Scene row_of_bricks(Row row) {
  Scene scene(elastic_joint(1e8, 1e6), 2000, 1e10, 0.2);
  for (int i = 0; i < 3; ++i) {
    const Vector lower{0.2 * i, 0.0, 0.0}, size{0.2, 0.2, 0.2};
    if (row == Row::rigid_end && i == 2)
      scene.brick(lower, size);
    else
      scene.soft(lower, size, {row == Row::of_unlike_meshes ? 1 + i : 2, 2, 2});
  }
  scene.assembly.contact.small_displacement = 1e-9;
  scene.assembly.contact.joint_motion = 10.0;  // no contact detection during the run
  return scene;
}

int points_on_gridpoints(const Model& m) {
  int count = 0;
  for (const auto& family : m.contacts.families) {
    for (const auto& p : family.point) count += p.on_gridpoints ? 1 : 0;
  }
  return count;
}

}  // namespace

// In fixed frames too (host/model/fixed_frames.h). The last brick slides by 16 mm off the centre, under pressure,
// before any block turns by 5e-3 rad. Arms are those of the start. So angular momentum changes by the rotation times
// the couple of contact forces, d x f, at most: by a twentieth of the couple. Without the moment on the frame it
// changes by all of it. This moment does work on the rotation. It is taken from the contact points, whose axes rotate
// with the block. With axes that stay 7e-4 of the stored energy is gained.
TEST(PointsOnGridpoints, KeepAngularMomentumAndEnergyInFixedFrames) {
  for (const Row row : {Row::of_one_mesh, Row::rigid_end}) {
    Scene scene(elastic_joint(1e8, 1e5), 2000, 1e10, 0.2);
    for (int i = 0; i < 4; ++i) {
      const Vector lower{0.2 * i, 0.0, 0.0}, size{0.2, 0.2, 0.2};
      row == Row::rigid_end&& i == 3 ? scene.brick(lower, size) : scene.soft(lower, size, {2, 2, 2});
    }
    scene.assembly.contact.small_displacement = 1e-9;
    scene.assembly.contact.joint_motion = 10.0;  // no contact detection during the run
    auto m = scene.model(undamped(0.5));
    m->set_velocity(3, {-0.05, 3.0, 1.5}, {});
    m->track_energy(true);
    const Vector before = angular_momentum(*m);
    Vector couple;  // over time, N m s
    double energy = 0.0, change = 0.0;
    while (m->stepping.time < 5e-3) {
      m->step();
      const Energies& e = m->step_sums.energies;
      if (energy == 0.0) energy = e.kinetic + e.strain + e.contact_stored;
      change = e.kinetic + e.strain + e.contact_stored - energy;
      for (const Family& f : m->contacts.families) {
        for (size_t k = 0; k < f.size(); ++k) {
          const Vector from = m->nodes.x[size_t(m->contacts.facets[size_t(f.point[k].facet_a)].node[0])];
          couple += m->stepping.dt * cross(place_of(*m, f.point[k]) - from, force_on_a(*m, f, k));
        }
      }
    }
    EXPECT_GT(norm(couple), 1e-4 * norm(before));
    EXPECT_FALSE(m->is_small);
    EXPECT_EQ(std::count(m->frames.fixed.begin(), m->frames.fixed.end(), 1), row == Row::rigid_end ? 3 : 4);
    EXPECT_GT(norm(moved(*m, 3)), 0.012);
    check_error(name_of(row) + " in fixed frames: angular momentum", norm(angular_momentum(*m) - before) / norm(couple),
                0.05, "-", "of the couple");
    check_error(name_of(row) + " in fixed frames: energy", std::abs(change) / m->step_sums.energies.contact_stored,
                1e-5, "-", "of the stored energy");
  }
}

// The middle brick slides by a third of its side while all bricks rotate. Gridpoints are then far from those of the
// other side. Without a moment on the frame of block a angular momentum would change by slip times force.
TEST(PointsOnGridpoints, KeepMomentaAndEnergyHoweverFarTheySlide) {
  for (const Row row : {Row::of_one_mesh, Row::of_unlike_meshes, Row::rigid_end}) {
    const std::string what = name_of(row);
    auto m = row_of_bricks(row).model(undamped(0.5));
    EXPECT_EQ(points_on_gridpoints(*m), 2 * 9) << what;
    for (int i = 0; i < 3; ++i) {
      const Vector spin{3.0, -2.0, 4.0}, slide{0.0, i == 1 ? 4.0 : -2.0, i == 1 ? 2.0 : -1.0};
      m->set_velocity(i, slide + cross(spin, position_of(*m, i) - position_of(*m, 1)), spin);
    }
    m->track_energy(true);
    do m->step();
    while (std::ranges::count(m->frames.fixed, 1) > 0);
    const Vector linear = linear_momentum(*m), angular = angular_momentum(*m);
    const Energies& first = m->step_sums.energies;
    const double start = first.kinetic + first.strain + first.contact_stored;
    double slid = 0.0, worst = 0.0, early = 0.0;
    constexpr double kEnd = 0.4;  // s, about five vibrations and a rotation of 90 degrees
    while (m->stepping.time < kEnd) {
      m->step();
      const Energies& e = m->step_sums.energies;
      worst = std::max(worst, std::abs((e.kinetic + e.strain + e.contact_stored) / start - 1));
      if (m->stepping.time < 0.25 * kEnd) early = worst;
      for (const double s : m->contacts.families[0].slid[0]) slid = std::max(slid, std::abs(s));
    }
    EXPECT_GT(slid, 0.05) << what;
    EXPECT_EQ(points_on_gridpoints(*m), 2 * 9) << what;
    check_error(what + " that slide on gridpoints: momentum", norm(linear_momentum(*m) - linear) / norm(angular), 1e-11,
                "-", "relative");
    // K u of bricks with different zones is computed from strains of zones, which have rounding at every step.
    check_error(what + " that slide on gridpoints: angular momentum",
                norm(angular_momentum(*m) - angular) / norm(angular), 1e-9, "-", "relative");
    check_error(what + " that slide on gridpoints: energy", worst, 2e-3, "-", "relative, swinging");
    EXPECT_LT(worst, 2.0 * early) << what << ": it drifts";
  }
}

}  // namespace quoin::verification
