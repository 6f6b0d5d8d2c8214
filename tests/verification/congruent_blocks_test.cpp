// Blocks whose internal forces are computed with a stiffness matrix in the co-rotational frame
// (host/step/deformable_kernels.h). Three or more congruent blocks share one matrix, others have their own. For
// comparison, equal blocks computed zone by zone (zone_kernels.h).
#include <algorithm>
#include <cstring>

#include "../momentum.h"
#include "model/world_results.h"
#include "support.h"

namespace quoin::verification {
namespace {

const Vector kAxis = normalized(Vector{0.5, -0.3, 0.8});

enum class Kind { congruent, distinct };
constexpr Kind kKinds[] = {Kind::congruent, Kind::distinct};
std::string name_of(Kind kind) { return kind == Kind::congruent ? "blocks of one shape" : "blocks of unlike shapes"; }

// Returns `count` separate bricks with different rotations; those of other kinds differ in lengths and gridpoints.
// In large motion from the start, or in small displacements at first.
Scene bricks_apart(int count, Kind kind = Kind::congruent, bool small_at_first = false) {
  Scene scene(elastic_joint(1e9, 1e9), 2000, 1e9, 0.2);
  if (!small_at_first) scene.assembly.contact.small_displacement = 0.0;
  for (int i = 0; i < count; ++i) {
    const bool is_other = kind == Kind::distinct && i > 0;
    const double length = is_other ? 0.4 + 0.01 * i : 0.4;
    Block b;
    b.rigid = false, b.divisions = {is_other ? 1 + i % 3 : 2, 1, 1};
    b.orientation = geometry::rotation(0.7 * i * kAxis);
    b.position = {2.0 * i, 0.0, 0.0};
    scene.assembly.add(box({-0.5 * length, -0.05, -0.1}, {length, 0.1, 0.2}), b);
  }
  if (kind == Kind::congruent) {
    for (Block& b : scene.assembly.blocks) b.shape = 0;
  }
  return scene;
}

SolverSettings zone_by_zone(SolverSettings solver) {
  solver.internal_forces = InternalForces::zones;
  return solver;
}

// Sets equal velocities in the frame of each block, m/s.
void shake(Model& m, double size) {
  for (int i = 0; i < m.block_count(); ++i) {
    uint64_t random = 88172645463325252u;
    const Matrix turned = geometry::matrix(m.assembly.blocks[size_t(i)].orientation);
    const ModelBlock& b = m.blocks[i];
    for (int n = b.first_node; n < b.first_node + b.node_count; ++n) {
      Vector v;
      for (int k = 0; k < 3; ++k) {
        random ^= random << 13, random ^= random >> 7, random ^= random << 17;
        v[k] = size * (double(random >> 11) / 9007199254740992.0 - 0.5);
      }
      m.nodes.v[size_t(n)] = turned * v;
    }
  }
}

// Returns the displacements of a block in its own frame.
std::vector<Vector> displacements(const Model& m, int block) {
  const ModelBlock& b = m.blocks[block];
  const Matrix turned = geometry::matrix(m.assembly.blocks[size_t(block)].orientation);
  std::vector<Vector> u;
  for (int n = b.first_node; n < b.first_node + b.node_count; ++n)
    u.push_back(transposed_times(turned, m.nodes.x[size_t(n)] - m.nodes.reference[size_t(n)]));
  return u;
}

double largest_difference(const std::vector<Vector>& a, const std::vector<Vector>& b) {
  double largest = 0.0;
  for (size_t i = 0; i < a.size(); ++i) largest = std::max(largest, norm(a[i] - b[i]));
  return largest;
}
double largest(const std::vector<Vector>& a) { return largest_difference(a, std::vector<Vector>(a.size())); }

// The motions by both methods differ by the square of the strain: a hundredth of the motion has a ten thousandth of the
// difference.
TEST(BlocksInFrames, AreThoseZoneByZoneForSmallStrain) {
  for (const Kind kind : kKinds) {
    for (const auto& [what, solver] : {std::pair{"undamped", undamped(0.7)}, {"viscous", viscous(0, 2e-5, 0.7)}}) {
      double difference[2];
      for (int i = 0; i < 2; ++i) {
        auto framed = bricks_apart(4, kind).model(solver), other = bricks_apart(4, kind).model(zone_by_zone(solver));
        ASSERT_EQ(count_of(*framed, kind == Kind::congruent ? Piece::Kind::congruent : Piece::Kind::distinct), 4);
        ASSERT_EQ(count_of(*other, Piece::Kind::by_zone), 4);
        for (Model* m : {framed.get(), other.get()}) {
          shake(*m, i == 0 ? 1.0 : 0.01);
          for (int step = 0; step < 40; ++step) m->step();
        }
        difference[i] = 0.0;
        for (int block = 0; block < 4; ++block) {
          const std::vector<Vector> u = displacements(*other, block);
          difference[i] = std::max(difference[i], largest_difference(displacements(*framed, block), u) / largest(u));
          // For any rotation of a block; positions are up to 6 m.
          if (kind == Kind::congruent) {
            EXPECT_LT(largest_difference(displacements(*framed, block), displacements(*framed, 0)), 1e-13);
          }
        }
      }
      check_error(name_of(kind) + " beside zone by zone, " + what + ", motion 1e-4", difference[1], 2e-4, "-",
                  "relative");
      EXPECT_NEAR(difference[0] / difference[1], 100.0, 30.0) << name_of(kind) << ", " << what;
    }
  }
}

// Blocks in co-rotational frames have another product with K than blocks computed zone by zone. Without deformation
// both agree to rounding, which Lanczos' method amplifies. A rotation changes only its start vector; it ends when the
// eigenvalue has converged to 1e-6.
TEST(BlocksInFrames, HighestFrequencyIsThatZoneByZoneHoweverTurned) {
  for (const Kind kind : kKinds) {
    auto framed = bricks_apart(4, kind).model(undamped(0.7)),
         other = bricks_apart(4, kind).model(zone_by_zone(undamped(0.7)));
    const double at_start = framed->stepping.critical_dt;
    for (Model* m : {framed.get(), other.get()}) {
      const Matrix turned = geometry::matrix(geometry::rotation(1.9 * kAxis));
      for (Vector& x : change_node_positions(*m)) x = turned * x;
      m->hold_by_springs(0.0);  // computes the time step again
    }
    const double found = framed->stepping.critical_dt;
    check_error(name_of(kind) + ", 2/omega_max beside zone by zone", std::abs(found / other->stepping.critical_dt - 1),
                1e-9, "-", "relative");
    check_error(name_of(kind) + ", 2/omega_max when turned", std::abs(found / at_start - 1), 1e-5, "-", "relative");
  }
}

// A free block that vibrates and rotates: momenta are constant to rounding, energy has no drift.
TEST(BlocksInFrames, TumblingKeepsMomentumAndEnergy) {
  for (const Kind kind : kKinds) {
    auto m = bricks_apart(3, kind).model(undamped(0.5));
    const Vector omega{13.0, 33.0, 20.0};
    shake(*m, 0.1);
    for (int i = 0; i < m->block_count(); ++i) {
      const ModelBlock& b = m->blocks[i];
      for (int n = b.first_node; n < b.first_node + b.node_count; ++n)
        m->nodes.v[size_t(n)] += cross(omega, m->nodes.x[size_t(n)] - position_of(*m, i));
    }
    m->track_energy(true);
    m->step();
    const Vector linear = linear_momentum(*m), angular = angular_momentum(*m);
    const double start = m->step_sums.energies.kinetic + m->step_sums.energies.strain, end = 20 * 2 * pi / norm(omega);
    double early = 0.0, all = 0.0;
    while (m->stepping.time < end) {
      m->step();
      all = std::max(all, std::abs((m->step_sums.energies.kinetic + m->step_sums.energies.strain) / start - 1));
      if (m->stepping.time < 0.1 * end) early = all;
    }
    const std::string what = name_of(kind) + ", tumbling 20 turns: ";
    check_error(what + "momentum", norm(linear_momentum(*m) - linear) / norm(angular), 1e-11, "-", "relative");
    check_error(what + "angular momentum", norm(angular_momentum(*m) - angular) / norm(angular), 1e-11, "-",
                "relative");
    check_error(what + "energy", all, 2e-3, "-", "relative, swinging");
    EXPECT_LT(all, 2.0 * early) << name_of(kind) << ": it drifts";
  }
}

// Viscosity of zones does not brake steady rotation, and the extension is that of the zone-by-zone computation.
TEST(BlocksInFrames, ViscositySeesNoRigidMotion) {
  const double omega = 60.0;
  const auto spin = [&](int count, Kind kind, const SolverSettings& solver, double* lost) {
    auto m = bricks_apart(count, kind).model(solver);
    for (int i = 0; i < count; ++i) {
      const Vector axis = geometry::matrix(m->assembly.blocks[size_t(i)].orientation) * Vector{0, 1, 0};
      m->set_velocity(i, {}, omega * axis);
    }
    m->run(2 * 2 * pi / omega);  // initial vibrations decay
    const double before = kinetic_energy_of_all(*m);
    m->run(10 * 2 * pi / omega);
    *lost = 1 - kinetic_energy_of_all(*m) / before;
    const ModelBlock& b = m->blocks[0];
    double longest = 0.0;
    for (int i = b.first_node; i < b.first_node + b.node_count; ++i) {
      for (int j = b.first_node; j < i; ++j)
        longest = std::max(longest, norm(m->nodes.x[size_t(i)] - m->nodes.x[size_t(j)]));
    }
    return longest - norm(Vector{0.4, 0.1, 0.2});
  };
  double lost = 0.0;
  const SolverSettings solver = viscous(0, 2e-5, 0.7);
  const double alone = spin(1, Kind::congruent, zone_by_zone(solver), &lost);
  EXPECT_GT(alone, 1e-6);
  for (const Kind kind : kKinds) {
    const double stretch = spin(3, kind, solver, &lost);
    check_error(name_of(kind) + ", viscous, 10 turns: kinetic energy lost", std::abs(lost), 1e-9, "-", "relative");
    check(name_of(kind) + ", centrifugal stretch", alone, stretch, 1e-3, "m", "that of zone by zone");
  }
}

// A block with a strain too large for a co-rotational frame changes to the zone-by-zone computation; energy is
// constant.
TEST(BlocksInFrames, LeaveWhenTheyDeformMuch) {
  auto congruent = bricks_apart(3).model(undamped(0.5)), alone = bricks_apart(1).model(zone_by_zone(undamped(0.5)));
  for (Model* m : {congruent.get(), alone.get()}) {
    // Extended along its length, 3 % at most.
    for (int i = 0; i < m->block_count(); ++i) {
      const ModelBlock& b = m->blocks[i];
      for (int n = b.first_node; n < b.first_node + b.node_count; ++n) {
        const Matrix turned = geometry::matrix(m->assembly.blocks[size_t(i)].orientation);
        const double x = transposed_times(turned, m->nodes.reference[size_t(n)] - position_of(*m, i)).x;
        m->nodes.v[size_t(n)] = 100.0 * x * (turned * Vector{1, 0, 0});
      }
    }
    m->track_energy(true);
    m->step();
  }
  const auto energy = [](const Model& m) { return m.step_sums.energies.kinetic + m.step_sums.energies.strain; };
  const auto change = [&](const Model& m, double from) { return std::abs(energy(m) / from - 1); };
  const double start = energy(*congruent), start_alone = energy(*alone);
  double furthest = 0.0, lost = 0.0, lost_alone = 0.0;
  for (int step = 0; step < 60; ++step) {
    congruent->step(), alone->step();
    furthest = std::max(furthest, largest(displacements(*alone, 0)));
    lost = std::max(lost, change(*congruent, start)), lost_alone = std::max(lost_alone, change(*alone, start_alone));
  }
  EXPECT_GT(furthest, 0.02 * 0.1);
  check_error("blocks of one shape, stretched by percents: swing of the energy", lost, 2e-3, "-",
              "elasticity of small strain in frames; zone by zone 5e-4");
  EXPECT_LT(lost_alone, 1e-3);
  EXPECT_LT(largest_difference(displacements(*congruent, 0), displacements(*alone, 0)), 0.03 * furthest);
}

// The motion of a block is bitwise independent of its neighbours in a SIMD group.
TEST(BlocksInFrames, CompanyChangesNoBit) {
  for (const Kind kind : kKinds) {
    std::vector<Vector> of[2];
    for (const int run : {0, 1}) {
      auto m = bricks_apart(11, kind).model(undamped(0.7));
      shake(*m, 0.1);
      m->set_gravity({0, -9.81, 0});
      for (int i = 0; i < m->block_count() && run == 1; ++i) {
        if (i != 1 && i != 9) m->set_velocity(i, {0.3 * i, 1.0, -2.0}, {40.0, 5.0 * i, 0.0});
      }
      for (int step = 0; step < 20; ++step) m->step();
      for (const int block : {1, 9}) {
        for (const Vector& u : displacements(*m, block)) of[run].push_back(u);
      }
    }
    EXPECT_EQ(std::memcmp(of[0].data(), of[1].data(), of[0].size() * sizeof(Vector)), 0) << name_of(kind);
  }
}

// ---- Fixed frames (host/model/fixed_frames.h) ----------------------------------------------------------------------

int fixed_count(const Model& m) { return int(std::count(m.frames.fixed.begin(), m.frames.fixed.end(), 1)); }

// Fixed and co-rotational frames differ by the rotation times the motion: a hundredth of the motion has a hundredth of
// the relative difference. That is 1e-4 at a motion of 1e-4 of the block. Their orientation makes no difference.
TEST(FixedFrames, AreThoseThatTurnForSmallRotations) {
  for (const auto& [what, solver] : {std::pair{"undamped", undamped(0.7)}, {"viscous", viscous(0, 2e-5, 0.7)}}) {
    double difference[2];
    for (int i = 0; i < 2; ++i) {
      auto fixed = bricks_apart(4, Kind::congruent, true).model(solver), other = bricks_apart(4).model(solver);
      for (Model* m : {fixed.get(), other.get()}) {
        shake(*m, i == 0 ? 0.1 : 0.001);
        for (int step = 0; step < 40; ++step) m->step();
      }
      ASSERT_EQ(fixed_count(*fixed), 4);
      ASSERT_EQ(fixed_count(*other), 0);
      difference[i] = 0.0;
      for (int block = 0; block < 4; ++block) {
        const std::vector<Vector> u = displacements(*other, block);
        difference[i] = std::max(difference[i], largest_difference(displacements(*fixed, block), u) / largest(u));
        EXPECT_LT(largest_difference(displacements(*fixed, block), displacements(*fixed, 0)), 1e-14);
      }
    }
    check_error(std::string("Fixed frames beside those that turn, ") + what, difference[1], 1e-5, "-", "relative");
    EXPECT_NEAR(difference[0] / difference[1], 100.0, 30.0) << what;
  }
}

// Energies of a vibration in a fixed frame: strain energy and kinetic energy exchange, viscosity takes what is lost.
// The sum swings by the square of the step: 2.4 % at three times this one.
TEST(FixedFrames, EnergyOfVibrationCloses) {
  for (const auto& [what, solver] : {std::pair{"undamped", undamped(0.1)}, {"viscous", viscous(0, 2e-5, 0.1)}}) {
    auto m = bricks_apart(3, Kind::congruent, true).model(solver);
    shake(*m, 0.01);
    m->track_energy(true);
    m->step();
    const auto& e = m->step_sums.energies;
    const double start = e.kinetic + e.strain + e.damping;
    double error = 0.0, most = 0.0;
    for (int step = 0; step < 1200; ++step) {
      m->step();
      error = std::max(error, std::abs(e.kinetic + e.strain + e.damping - start));
      most = std::max(most, e.strain);
    }
    ASSERT_EQ(fixed_count(*m), 3);
    EXPECT_GT(most, 0.1 * start);
    check_error(std::string("Fixed frames, ") + what + ": energy", error / start, 0.005, "-", "swinging, of the first");
  }
}

// A brick that spins about an oblique axis leaves its fixed frame at 5e-3 rad. The other seven of its piece leave with
// it, those of the next piece stay. Momentum and angular momentum stay to rounding, energy to the square of the
// rotation. Strain is that of the centrifugal force, far below E (theta^2/2)^2.
TEST(FixedFrames, ABlockThatTurnsLeavesWithItsPiece) {
  auto m = bricks_apart(20, Kind::congruent, true).model(undamped(0.5));
  ASSERT_EQ(fixed_count(*m), 20);
  m->set_velocity(0, {0.1, 0.0, 0.0}, {0.5, 0.3, -0.4});
  m->track_energy(true);
  m->step();
  const Vector linear = linear_momentum(*m), angular = angular_momentum(*m, position_of(*m, 0));
  const double kinetic = m->step_sums.energies.kinetic;
  double turned_then = 0.0;
  while (fixed_count(*m) == 20 && m->stepping.time < 0.1) turned_then = turned(*m, 0), m->step();
  EXPECT_EQ(fixed_count(*m), 12);
  EXPECT_NEAR(turned_then, 5e-3, 4e-4);
  check_error("Left fixed frames: momentum", norm(linear_momentum(*m) - linear) / norm(linear), 1e-12, "-", "relative");
  check_error("Left fixed frames: angular momentum",
              norm(angular_momentum(*m, position_of(*m, 0)) - angular) / norm(angular), 1e-10, "-", "relative");
  for (int step = 0; step < 200; ++step) m->step();
  check_error("Left fixed frames: kinetic energy", std::abs(m->step_sums.energies.kinetic / kinetic - 1), 1e-4, "-",
              "relative");
  check_error("Left fixed frames: strain energy", m->step_sums.energies.strain / kinetic, 1e-4, "-", "of the kinetic");
  EXPECT_NEAR(turned(*m, 0), m->stepping.time * norm(Vector{0.5, 0.3, -0.4}), 1e-4);
}

}  // namespace
}  // namespace quoin::verification
