// Added inertia without change of rigid motion, and damping by block, in large motion (host/model/block_inertia.h).
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "../momentum.h"
#include "support.h"

namespace quoin::verification {
namespace {

SolverSettings scaled(double deformation, double unit = 1.0, double fraction = 0.7) {
  SolverSettings s = undamped(fraction);
  s.deformation_inertia = deformation, s.unit_inertia = unit;
  return s;
}
SolverSettings by_block(double deformation, double unit = 1.0, double fraction = 0.7) {
  SolverSettings s = scaled(deformation, unit, fraction);
  s.damping = DampingKind::block, s.local_damping = 0.3, s.deformation_damping = 0.2;
  return s;
}

// Returns one block, or the two halves of a unit on an elastic joint, rotated about the origin. Contacts are those of
// walls in large motion: points of the joint move with their blocks.
Scene unit_scene(int halves, const Quaternion& turn = {}, const JointFamily& joint = elastic_joint(1e11, 5e10)) {
  Scene scene(joint, 2000, 1e9, 0.2);
  scene.assembly.contact.small_displacement = 0.0, scene.assembly.contact.joint_motion = 0.05;
  const double half = 0.2;
  for (int i = 0; i < halves; ++i) {
    Block b;
    b.rigid = false, b.divisions = {2, 1, 1}, b.parity = i, b.orientation = turn, b.unit = 0;
    const double x = halves == 1 ? -0.5 * half : (i - 1) * half;
    scene.assembly.add(box({x, -0.06, -0.1}, {half, 0.12, 0.2}), b);
  }
  return scene;
}

void add_noise(Model& m, double size) {
  uint64_t random = 88172645463325252u;
  for (Vector& v : m.nodes.v) {
    for (int k = 0; k < 3; ++k) {
      random ^= random << 13, random ^= random >> 7, random ^= random << 17;
      v[k] += size * (double(random >> 11) / 9007199254740992.0 - 0.5);
    }
  }
}

double energy_of(const Model& m) {
  const Energies& e = m.step_sums.energies;
  return e.kinetic + e.strain + e.contact_stored;
}

// Sets velocities of all deformable blocks: rotation about the origin with `omega`, plus `velocity`.
void spin(Model& m, const Vector& omega, const Vector& velocity = {}) {
  for (int i = 0; i < m.block_count(); ++i) m.set_velocity(i, velocity + cross(omega, position_of(m, i)), omega);
}

// Free vibration and rotation about an axis that is not a principal one: momenta are constant, energy has no drift.
TEST(ScaledInertia, TumblingKeepsMomentumAndEnergy) {
  const Vector omega{13.0, 33.0, 20.0};
  for (const int halves : {1, 2}) {
    auto m = unit_scene(halves).model(scaled(64.0, 16.0));
    spin(*m, omega, {3.0, -1.0, 2.0});
    add_noise(*m, 0.1);
    m->track_energy(true);
    m->step();
    const Vector about = position_of(*m, 0), linear = linear_momentum(*m), angular = angular_momentum(*m, about);
    const double start = energy_of(*m), end = 20 * 2 * pi / norm(omega);
    double early = 0.0, all = 0.0;
    while (m->stepping.time < end) {
      m->step();
      all = std::max(all, std::abs(energy_of(*m) / start - 1));
      if (m->stepping.time < 0.1 * end) early = all;
    }
    const std::string name = std::string(halves == 1 ? "block" : "unit") + ", inertia scaled, tumbling 20 turns: ";
    check_error(name + "momentum", norm(linear_momentum(*m) - linear) / norm(linear), 1e-11, "-", "relative");
    check_error(name + "angular momentum", norm(angular_momentum(*m, about) - angular) / norm(angular), 1e-10, "-",
                "relative");
    // The product of two velocities is less than the square of their mean by (a dt)^2/4, for deformation s_b times. The
    // radial acceleration a swings between 0 and 2 omega^2 r.
    const double step = norm(omega) * m->stepping.dt;
    check_error(name + "energy", all, 64.0 * step * step, "-", "relative, swinging; s_b (omega dt)^2");
    EXPECT_LT(all, 2.0 * early) << "it drifts";
  }
}

// Steady rotation about a principal axis, vibrations damped: extension and joint traction are those of the true mass.
// Without the convective terms they would be s times larger.
TEST(ScaledInertia, CentrifugalStretchIsThatOfTheTrueMass) {
  for (const int halves : {1, 2}) {
    const auto stretch = [&](double s, double* tension) {
      SolverSettings solver = by_block(s, s > 1 ? 16.0 : 1.0, 0.5);
      solver.local_damping = 0.0, solver.deformation_damping = 0.5;
      auto m = unit_scene(halves).model(solver);
      const double omega = 100.0;
      spin(*m, {0, omega, 0});
      m->run(3 * 2 * pi / omega);
      double longest = 0.0;
      for (const Vector& x : m->nodes.x) {
        for (const Vector& y : m->nodes.x) longest = std::max(longest, norm(x - y));
      }
      double rest = 0.0;
      for (const Vector& x : m->nodes.reference) {
        for (const Vector& y : m->nodes.reference) rest = std::max(rest, norm(x - y));
      }
      m->step();
      *tension = norm(m->step_sums.contact_force[0]);
      return longest - rest;
    };
    double true_tension = 0.0, tension = 0.0;
    const double true_stretch = stretch(1.0, &true_tension), scaled_stretch = stretch(64.0, &tension);
    const std::string name = halves == 1 ? "spinning block" : "spinning unit";
    check(name + ": centrifugal stretch, s_b = 64", true_stretch, scaled_stretch, 1e-3, "m", "that of s = 1");
    if (halves == 1) continue;
    const double mass = 2000 * 0.2 * 0.12 * 0.2;
    check(name + ": joint tension, s_u = 16", true_tension, tension, 1e-3, "N", "that of s = 1");
    check(name + ": joint tension", mass * 1e4 * 0.1, tension, 5e-3, "N", "m omega^2 r; the unit stretches");
  }
}

// A free block falls and rotates as a rigid body for all factors; the angular velocity of a symmetric top is constant.
TEST(ScaledInertia, FreeFallIsExact) {
  for (const int halves : {1, 2}) {
    SolverSettings solver = by_block(100.0, 30.0);
    solver.local_damping = 0.0;
    auto m = unit_scene(halves, geometry::rotation({0.4, -0.7, 0.5})).model(solver);
    m->set_gravity({1.0, -9.81, 0.5});
    const Vector start = position_of(*m, 0);
    for (int i = 0; i < 500; ++i) m->step();
    const double t = m->stepping.time, dt = m->stepping.dt;
    // Central differences from rest: x = g t (t + dt)/2.
    const Vector fall = position_of(*m, 0) - start;
    const std::string name =
        std::string("free fall, turned ") + (halves == 1 ? "block" : "unit") + ", inertia scaled: ";
    check(name + "fall", 0.5 * 9.81 * t * (t + dt), -fall.y, 1e-9, "m");
    check(name + "drift along x", 0.5 * 1.0 * t * (t + dt), fall.x, 1e-9, "m");
    check_error(name + "strain energy over kinetic energy", strain_energy(*m) / kinetic_energy_of_all(*m), 1e-18, "-");
  }
}

// A cube with a face that must stay in its plane rotates only about the normal of the face. The results are equal for
// each axis and for mirror images, since a hexahedron of five tetrahedra has these symmetries.
TEST(ScaledInertia, APlaneHoldsTheSameAlongEveryAxis) {
  std::map<std::array<long, 3>, Vector> first;  // by position in mm; the first axis is the normal
  for (const auto& axes : {std::array{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}}) {
    Scene scene(elastic_joint(1e9, 1e9), 2000, 1e9, 0.2);
    scene.soft({0, 0, 0}, {0.2, 0.2, 0.2}, {1, 1, 1});
    auto m = scene.model(scaled(64.0));
    const auto own = [&axes](const Vector& v) { return Vector{v[axes[0]], v[axes[1]], v[axes[2]]}; };
    const std::vector<Vector> start(m->nodes.reference.begin(), m->nodes.reference.end());
    for (size_t i = 0; i < start.size(); ++i) {
      const Vector at = own(start[i]);
      if (at.x < 1e-9) hold_node(*m, int(i), uint8_t(1 << axes[0]));
      const Vector v{at.x * (0.3 * at.y - 0.2 * at.z), 0.2 * at.x - 0.4 * at.z, 0.5 * at.x + 0.4 * at.y};
      for (int c = 0; c < 3; ++c) m->nodes.v[i][axes[size_t(c)]] = v[c];
    }
    for (int i = 0; i < 200; ++i) m->step();
    double largest = 0.0, off = 0.0;
    for (size_t i = 0; i < start.size(); ++i) {
      const Vector at = own(start[i]), u = own(m->nodes.x[i] - start[i]);
      const std::array<long, 3> place{std::lround(1e3 * at.x), std::lround(1e3 * at.y), std::lround(1e3 * at.z)};
      largest = std::max(largest, norm(u)), off = std::max(off, norm(first.try_emplace(place, u).first->second - u));
    }
    ASSERT_EQ(first.size(), 8u);
    check_error("cube on a plane, axes in the order " + std::to_string(axes[0]) + std::to_string(axes[1]) +
                    std::to_string(axes[2]) + ": motion beside that of 012",
                off / largest, 1e-9, "-", "relative; rounding of 200 steps");
  }
}

double first_frequency(const SolverSettings& solver) {
  Scene scene(elastic_joint(1e9, 1e9), 2000, 1e9, 0.0);
  scene.soft({0, 0, 0}, {1.0, 0.2, 0.1}, {10, 2, 1});
  auto m = scene.model(solver);
  std::vector<int> tip;
  for (size_t i = 0; i < m->nodes.x.size(); ++i) {
    const double x = m->nodes.reference[i].x;
    if (x < 1e-9) hold_node(*m, int(i), 7);
    if (x > 1 - 1e-9) tip.push_back(int(i));
    m->nodes.v[i] = {0.0, x < 1e-9 ? 0.0 : 0.01 * x * x, 0.0};
  }
  const auto mean = [&] {
    double sum = 0.0;
    for (int i : tip) sum += m->nodes.x[size_t(i)].y - m->nodes.reference[size_t(i)].y;
    return sum;
  };
  double first = -1, last = -1, before = mean();
  int count = -1;
  while (count < 6) {
    m->step();
    const double now = mean();
    if (before < 0 && now >= 0) {
      last = m->stepping.time - m->stepping.dt * now / (now - before);
      if (++count == 0) first = last;
    }
    before = now;
  }
  return count / (last - first);
}

// A fixed block has no rigid motion: its vibration is deformation, slower by sqrt(s_b). Both runs have one fraction of
// 2/omega_max, so their errors of time integration are equal.
TEST(ScaledInertia, CantileverIsSlowedByTheRoot) {
  const double free = first_frequency(scaled(1.0)), slow = first_frequency(scaled(64.0));
  check("first frequency of a cantilever, s_b = 64, times 8", free, 8 * slow, 1e-4, "Hz", "slowed by sqrt(s_b)");
}

// The critical step does not depend on the rotation of a block; just below it vibrations are bounded, just above they
// grow.
TEST(ScaledInertia, StableJustBelowTheLimitUnstableJustAbove) {
  std::vector<Curve> curves;
  for (const int halves : {1, 2}) {
    double at_rest = 0.0;
    for (const bool turned : {false, true}) {
      const Quaternion turn = turned ? geometry::rotation({0.9, -1.7, 0.5}) : Quaternion{};
      for (const double fraction : {0.98, 1.02}) {
        auto m = unit_scene(halves, turn).model(scaled(64.0, 16.0, fraction));
        if (!turned) at_rest = m->stepping.critical_dt;
        EXPECT_NEAR(m->stepping.critical_dt, at_rest, 1e-5 * at_rest);
        add_noise(*m, 1e-6);
        double largest = 0.0;
        Curve growth{std::string(halves == 1 ? "block" : "unit") + ", step " + (fraction < 1 ? "0.98" : "1.02") +
                     " of the limit"};
        for (int i = 0; i < 3000 && largest < 1e3; ++i) {
          m->step();
          for (const Vector& v : m->nodes.v) largest = std::max(largest, norm(v));
          growth.add(i + 1, largest);
        }
        if (!turned) curves.push_back(growth);
        if (fraction < 1)
          EXPECT_LT(largest, 1e-3) << halves << turned;
        else
          EXPECT_GT(largest, 1e1) << halves << turned;
      }
    }
    if (halves == 1)
      check("critical step of a block, s_b = 64 over s = 1", 8.0,
            at_rest / unit_scene(1).model(scaled(1.0))->stepping.critical_dt, 1e-5, "-", "sqrt(s_b)");
  }
  write_figure("step_limit", "steps, -", "largest velocity so far, m/s", curves);
}

// Kinetic energy includes M'. The work of damping includes that in zones and that on rigid motions of blocks and units.
// `start` has the first half step of damping. What remains is in proportion to the step.
TEST(ScaledInertia, EnergyBalanceCloses) {
  const auto error = [](bool block, int halves, double fraction) {
    SolverSettings solver = block ? by_block(16.0, 5.0, fraction) : viscous(300.0, 2e-6, fraction);
    solver.deformation_inertia = 16.0, solver.unit_inertia = 5.0;
    auto m = unit_scene(halves, geometry::rotation({0.4, -0.7, 0.5})).model(solver);
    m->set_gravity({0, -9.81, 0});
    spin(*m, {3.0, -2.0, 5.0}, {1.0, 0.5, 0.0});
    add_noise(*m, 1.0);
    m->track_energy(true);
    m->step();
    const double start = m->step_sums.energies.balance_error(), kinetic = m->step_sums.energies.kinetic;
    while (m->stepping.time < 0.02) m->step();
    EXPECT_GT(m->step_sums.energies.damping, 0.02 * kinetic);
    return std::abs(m->step_sums.energies.balance_error(start)) / kinetic;
  };
  std::vector<Curve> curves;
  for (const bool block : {true, false}) {
    for (const int halves : {1, 2}) {
      const double coarse = error(block, halves, 0.2), fine = error(block, halves, 0.05);
      curves.push_back({std::string(halves == 1 ? "block" : "unit") + (block ? ", damping by block" : ", viscous"),
                        CurveKind::measured,
                        {{0.05, fine}, {0.1, error(block, halves, 0.1)}, {0.2, coarse}}});
      const std::string name = std::string(halves == 1 ? "block" : "unit") + (block ? ", block" : ", viscous") +
                               " damping, inertia scaled: ";
      check_error(name + "energy balance", fine, 5e-6, "-", "of the kinetic energy of the start");
      EXPECT_LT(fine, 0.3 * coarse) << name << "1/4 by the first order";
    }
  }
  const double least = curves[0].points[0][1];
  curves.insert(curves.begin(), reference("first order", 0.05, 0.2, [&](double step) { return least * step / 0.05; }));
  write_figure("balance_over_step", "step over the limit, -", "energy out of balance / kinetic energy, -", curves);
}

// Halves on a dry joint separate at 1 m/s each. When no point of their joint is closer than 0.01 of their height they
// become two blocks. Momenta are constant, and the balance includes the energy of the inertia that is removed,
// (s_u - 1)/2 m v^2 of both.
TEST(ScaledInertia, HalvesThatComeApartAreTwoBlocks) {
  auto m = unit_scene(2, {}, dry_joint(1e11, 5e10, 30)).model(scaled(64.0, 16.0));
  m->set_velocity(0, {-1.0, 0.2, 0.0}, {0.0, 0.0, 0.5});
  m->set_velocity(1, {1.0, 0.2, 0.0}, {0.0, 0.0, 0.5});
  m->track_energy(true);
  m->step();
  EXPECT_EQ(m->units.count, 1);
  const Vector linear = linear_momentum(*m), angular = angular_momentum(*m);
  const double start = m->step_sums.energies.balance_error(), step = m->stepping.dt;
  while (m->units.count == 1 && m->stepping.time < 0.01) m->step();
  EXPECT_EQ(m->units.count, 0);
  const double opening = position_of(*m, 1).x - position_of(*m, 0).x - 0.2;
  EXPECT_GT(opening, 0.010 * 0.12);
  EXPECT_LT(opening, 0.015 * 0.12);
  const double mass = 2000 * 0.2 * 0.12 * 0.2;
  m->step();
  check("unit that comes apart, s_u = 16: energy booked", 15 * mass, m->step_sums.energies.detection, 1e-2, "J",
        "(s_u - 1) m v^2; a little spin of the halves on each other");
  check_error("unit that comes apart, s_u = 16: energy balance",
              m->step_sums.energies.balance_error(start) / (16 * mass), 1e-3, "-");
  check_error("unit that comes apart, s_u = 16: momentum", norm(linear_momentum(*m) - linear) / norm(linear), 1e-12,
              "-");
  check_error("unit that comes apart, s_u = 16: angular momentum", norm(angular_momentum(*m) - angular) / norm(angular),
              1e-12, "-");
  EXPECT_EQ(m->stepping.dt, step);
}

// Halves that return have added inertia again before they touch, and lose it when they separate; the balance includes
// both changes. They do not separate faster than they approached. No time step is shorter than the first one; without
// added inertia a closing joint would make it four times shorter (sqrt(s_u)).
TEST(ScaledInertia, HalvesThatMeetAgainBounce) {
  auto m = unit_scene(2, {}, dry_joint(1e11, 5e10, 30)).model(scaled(64.0, 16.0, 0.1));
  const double v = 0.1, mass = 2000 * 0.2 * 0.12 * 0.2;
  const auto fly_apart = [&](double speed) {
    m->set_velocity(0, {-speed, 0.2, 0.1}), m->set_velocity(1, {speed, 0.2, 0.1});
  };
  const auto opening = [&] { return position_of(*m, 1).x - position_of(*m, 0).x - 0.2; };
  fly_apart(v);
  while (m->units.count == 1 && m->stepping.time < 0.1) m->step();
  fly_apart(-v);
  m->track_energy(true);
  m->step();
  const Vector linear = linear_momentum(*m), about = position_of(*m, 0), angular = angular_momentum(*m, about);
  const double start = m->step_sums.energies.balance_error(), step = m->stepping.dt;
  double deepest = 1.0;
  int meetings = 0;
  for (int before = 0; m->stepping.time < 0.2 && !(meetings == 1 && m->units.count == 0);) {
    before = m->units.count;
    m->step();
    if (m->units.count > before) {
      ++meetings;
      EXPECT_GT(opening(), 0.0) << "touched before they had their inertia";
    }
    deepest = std::min(deepest, opening());
  }
  EXPECT_EQ(meetings, 1);
  EXPECT_EQ(m->units.count, 0);
  EXPECT_LT(deepest, 0.0) << "did not touch";
  const double then = opening();
  m->step();
  const double after = 0.5 * (opening() - then) / m->stepping.dt;
  EXPECT_LE(after, v * (1 + 1e-3));
  EXPECT_GT(after, 0.1 * v);  // measured: 0.3, since much energy goes into vibration of such soft blocks
  check("halves that meet and part, s_u = 16: energy booked", 15 * mass * (after * after - v * v),
        m->step_sums.energies.detection, 2e-2, "J", "(s_u - 1) m (v'^2 - v^2)", 15 * mass * v * v);
  check_error("halves that meet and part, s_u = 16: energy balance",
              m->step_sums.energies.balance_error(start) / (16 * mass * v * v), 5e-3, "-");
  check_error("halves that meet and part, s_u = 16: momentum", norm(linear_momentum(*m) - linear) / norm(linear), 1e-12,
              "-");
  check_error("halves that meet and part, s_u = 16: angular momentum",
              norm(angular_momentum(*m, about) - angular) / (mass * 0.2 * v), 1e-10, "-");
  EXPECT_NEAR(m->stepping.dt, step, 1e-6 * step);
}

// Returns units far from each other, each of two halves that differ in length and zones.
Scene unlike_halves(int units) {
  Scene scene(dry_joint(1e11, 5e10, 30), 2000, 1e9, 0.2);
  scene.assembly.contact.small_displacement = 0.0, scene.assembly.contact.joint_motion = 0.05;
  for (int unit = 0; unit < units; ++unit) {
    for (int half = 0; half < 2; ++half) {
      Block b;
      b.rigid = false, b.divisions = {2 + half, 1, 1}, b.parity = half, b.unit = unit;
      b.position = {2.0 * unit, 0.0, 0.0};
      scene.assembly.add(box({-0.2 * (1 - half), -0.06, -0.1}, {0.2 + 0.1 * half, 0.12, 0.2}), b);
    }
  }
  return scene;
}

// The halves of several units share the stiffness of their shape, those of one unit alone have their own. So three
// units move as one does, while their halves hold together, when they are apart, and when they meet again. Sums of
// forces have other orders, so the motion agrees to rounding, which an impact amplifies.
TEST(ScaledInertia, UnlikeHalvesOfThreeUnitsMoveAsThoseOfOne) {
  auto one = unlike_halves(1).model(scaled(64.0, 16.0, 0.3)), three = unlike_halves(3).model(scaled(64.0, 16.0, 0.3));
  ASSERT_EQ(count_of(*one, Piece::Kind::distinct), 2);
  ASSERT_EQ(count_of(*three, Piece::Kind::congruent), 6);
  double apart = 0.0, moved = 0.0;  // largest difference, largest motion, m
  const auto run = [&](double speed, int units) {
    // Lanczos' method finds the frequency to some 1e-8.
    one->stepping.dt = three->stepping.dt = std::min(one->stepping.dt, three->stepping.dt);
    for (Model* m : {one.get(), three.get()}) {
      for (int i = 0; i < m->block_count(); ++i)
        m->set_velocity(i, {i % 2 == 0 ? -speed : speed, 0.2, 0.0}, {0.0, 0.0, 0.5});
    }
    for (int step = 0; step < 3000 && one->units.count != units; ++step) {
      one->step(), three->step();
      ASSERT_EQ(three->units.count, 3 * one->units.count);
      for (size_t n = 0; n < three->nodes.x.size(); ++n) {
        const size_t of_one = n % one->nodes.x.size();
        const Vector u = one->nodes.x[of_one] - one->nodes.reference[of_one];
        moved = std::max(moved, norm(u));
        apart = std::max(apart, norm(three->nodes.x[n] - three->nodes.reference[n] - u));
      }
    }
    ASSERT_EQ(one->units.count, units);
  };
  for (Model* m : {one.get(), three.get()}) m->track_energy(true);
  run(1.0, 0), run(-0.1, 1), run(0.1, 0);
  check_error("three units of unlike halves beside one", apart / moved, 1e-11, "-", "of the largest motion");
  const Energies &of_one = one->step_sums.energies, &of_three = three->step_sums.energies;
  for (const auto energy : {&Energies::kinetic, &Energies::strain, &Energies::detection})
    EXPECT_NEAR(of_three.*energy, 3.0 * (of_one.*energy), 1e-7 * of_three.kinetic);
}

// Halves that touch along an edge only, or have slid on each other, keep the added inertia and so the time step. In
// wall_2m_576 without it, eight rotated pairs would reduce the step from 22.3 to 8.8 us.
TEST(ScaledInertia, HalvesThatTurnOnAnEdgeKeepTheTimeStep) {
  auto m = unit_scene(2, {}, dry_joint(1e11, 5e10, 30)).model(scaled(64.0, 16.0));
  m->set_velocity(0, {-0.12, 0.2, 0.0}, {0.0, 0.0, -2.0});  // both about the upper edge of their joint
  m->set_velocity(1, {0.12, 0.2, 0.0}, {0.0, 0.0, 2.0});
  const double step = m->stepping.dt;
  double turned = 0.0;
  while (turned < 0.02 && m->stepping.time < 0.05) {
    m->step();
    turned = angle_between(orientation_of(*m, 1), orientation_of(*m, 0));
  }
  EXPECT_GT(turned, 0.013) << "the bound of small motion";
  EXPECT_EQ(m->units.count, 1);
  EXPECT_GT(m->stepping.dt, 0.99 * step);
}

// A change to viscous damping does not move a block at rest under load, since the strain rate is that of its
// velocities.
TEST(ScaledInertia, AChangeOfDampingIsNoJolt) {
  Scene scene(elastic_joint(1e9, 1e9), 2000, 1e9, 0.2);
  scene.soft({0, 0, 0}, {0.2, 0.1, 0.1}, {2, 1, 1});
  auto m = scene.model(local(0.8, 0.5));
  m->add(Pressure{0, 0, 1e6, {}, {}, {}});
  m->add(Pressure{0, 1, 1e6, {}, {}, {}});
  settle(*m, 1e-20);
  EXPECT_GT(strain_energy(*m), 0.5);
  m->set_solver(viscous(0.0, 1e-6));
  m->step();
  check_error("block under load, damping changed to viscous: kinetic over strain energy",
              kinetic_energy_of_all(*m) / strain_energy(*m), 1e-15, "-");
}

// Under damping by block vibration does not brake rigid motion.
TEST(ScaledInertia, VibrationBrakesNoMotion) {
  for (const int halves : {1, 2}) {
    auto m = unit_scene(halves).model(by_block(16.0, 16.0));
    spin(*m, {0, 2.0, 0}, {0.5, 0.2, 0.1});
    add_noise(*m, 0.5);
    m->step();
    const Vector linear = linear_momentum(*m), angular = angular_momentum(*m, position_of(*m, 0));
    const Vector about = position_of(*m, 0);
    for (int i = 0; i < 3000; ++i) m->step();
    const Vector drift = angular_momentum(*m, about) - angular;
    const std::string name = std::string(halves == 1 ? "block" : "unit") + ", damping by block, vibrating: ";
    check_error(name + "momentum", norm(linear_momentum(*m) - linear) / norm(linear), 1e-11, "-");
    check_error(name + "angular momentum", norm(drift) / norm(angular), 1e-9, "-");
  }
}

// Local damping (eq. 1) on rigid motion in free fall: (1 - gamma) g, for any rotation of the block.
TEST(ScaledInertia, DampedFallIsTheSameHoweverTheBlockIsTurned) {
  std::vector<Curve> curves{
      reference("(1 - gamma) g t^2/2", 0, 0.21, [](double t) { return 1e3 * 0.5 * 0.7 * 9.81 * t * t; })};
  for (const Vector& turn : {Vector{}, Vector{0.7, 0.3, -1.1}}) {
    for (const bool soft : {true, false}) {
      Scene scene(elastic_joint(1e9, 1e9), 2000, 1e9, 0.2);
      Block b;
      b.rigid = !soft, b.orientation = geometry::rotation(turn);
      if (soft) b.divisions = {2, 1, 1};
      scene.assembly.add(box({-0.1, -0.06, -0.1}, {0.2, 0.12, 0.2}), b);
      SolverSettings solver = by_block(64.0);
      auto m = scene.model(solver);
      m->set_velocity(0, {0, -1e-9, 0});
      m->set_gravity({0, -9.81, 0});
      const Vector start = position_of(*m, 0);
      Curve& fall = curves.emplace_back(std::string(soft ? "deformable block" : "rigid block") +
                                        (norm(turn) > 0 ? ", turned" : ""));
      for (int i = 0; i < 500; ++i) {
        m->step();
        fall.add(m->stepping.time, 1e3 * (start - position_of(*m, 0)).y);
      }
      const double t = m->stepping.time, dt = m->stepping.dt;
      check("damped fall, " + fall.name, 0.5 * 0.7 * 9.81 * t * (t + dt), (start - position_of(*m, 0)).y, 1e-6, "m",
            "(1 - gamma) g t (t + dt)/2");
    }
  }
  write_figure("damped_fall", "time, s", "fall, mm", curves);
}

}  // namespace
}  // namespace quoin::verification
