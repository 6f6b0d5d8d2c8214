// One or a few rigid blocks: free motion, incline, bouncing, stacking, friction work.
#include "support.h"

namespace quoin::verification {
namespace {

// Torque-free symmetric top: omega precesses about the figure axis in the body frame at (I3 - I1) omega3 / I1.
TEST(FreeMotion, SymmetricTop) {
  Scene scene(elastic_joint(1e9, 1e9));
  scene.brick({0, 0, 0}, {0.2, 0.2, 0.6});
  auto m = scene.model(undamped());
  m->set_velocity(0, {0.3, -0.2, 0.1}, {3.0, 0.0, 20.0});
  Body& body = body_of(*m, 0);
  m->track_energy(true);
  // figure axis: the one with the different moment
  int axis = 0;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(body.inertia[k] - body.inertia[(k + 1) % 3]) > 1e-9 &&
        std::abs(body.inertia[k] - body.inertia[(k + 2) % 3]) > 1e-9)
      axis = k;
  }
  const int p = (axis + 1) % 3, q = (axis + 2) % 3;
  const double i1 = body.inertia[p], i3 = body.inertia[axis];
  const Vector start = geometry::transposed_times(body.r, body.omega), momentum = body.momentum;
  m->step();
  const double energy = m->step_sums.energies.kinetic;
  const double rate = (i3 - i1) * start[axis] / i1;
  double phase = std::atan2(start[q], start[p]), turned = 0.0, energy_error = 0.0;
  const double duration = 100 * 2 * pi / 20.0;  // a hundred revolutions
  const double t0 = m->stepping.time;
  Curve across{"measured"};
  while (m->stepping.time < duration) {
    m->step();
    const Vector w = geometry::transposed_times(body.r, body.omega);
    const double now = std::atan2(w[q], w[p]);
    turned += std::remainder(now - phase, 2 * pi);
    const double t = m->stepping.time + 0.5 * m->stepping.dt;  // time of the angular velocity
    if (t < 1.0) across.add(t, w[p]);
    phase = now;
    energy_error = std::max(energy_error, std::abs(m->step_sums.energies.kinetic / energy - 1));
  }
  check("free symmetric top: precession rate over 100 turns", rate,
        turned / (m->stepping.time - t0 + 1.5 * m->stepping.dt), 1e-4, "rad/s", "(I3 - I1) omega3 / I1");
  write_figure("symmetric_top", "time, s", "transverse spin in the body, rad/s",
               {reference("omega_1 cos(Omega t)", 0, 1,
                          [&](double t) {
                            return std::hypot(start[p], start[q]) * std::cos(std::atan2(start[q], start[p]) + rate * t);
                          }),
                across});
  check_error("free symmetric top: angular momentum, relative", norm(body.momentum - momentum) / norm(momentum), 1e-13,
              "-");
  check_error("free symmetric top: energy, largest relative", energy_error, 1e-6, "-");
}

// Pressure on a short side of a right-angled prism, whose centre is at a third of its sides from the corner:
//   m a = p A, I alpha = p A (h/2 - h/3) with I = m (b^2 + h^2)/18.
// The work is the kinetic energy of the block.
// All components count, but for those that are held.
TEST(FreeMotion, KineticEnergyIsThatOfAllFreeComponents) {
  Scene scene(dry_joint(1e9, 1e9, 30));
  const int rigid = scene.brick({0, 0, 0}, {1, 1, 1}), soft = scene.soft({3, 0, 0}, {1, 1, 1}, {2, 2, 2});
  auto m = scene.model(undamped());
  for (const int block : {rigid, soft}) {
    m->set_velocity(block, {1, 2, 4});
    EXPECT_NEAR(kinetic_energy_of(*m, block), 0.5 * 2000 * 21, 1e-8) << block;
  }
  m->prescribe(rigid, {1, 0, 0}, {}, 0x1);
  EXPECT_NEAR(kinetic_energy_of(*m, rigid), 0.5 * 2000 * 20, 1e-8) << "held along x";
}

TEST(FreeMotion, PressureMovesAndTurnsAPrism) {
  const double b = 0.3, h = 0.4, depth = 0.2, p = 100.0;
  Scene scene(elastic_joint(1e9, 1e9));
  scene.block(
      geometry::from_vertices({{0, 0, 0}, {b, 0, 0}, {0, h, 0}, {0, 0, depth}, {b, 0, depth}, {0, h, depth}}, "prism"));
  const auto& normals = scene.assembly.shapes[0].normals;
  const auto side = std::find_if(normals.begin(), normals.end(), [](const Vector& n) { return n.x < -0.99; });
  auto m = scene.model(undamped());
  m->track_energy(true);
  m->add(Pressure{0, int(side - normals.begin()), p, {}, {}, {}});
  m->step();
  const Vector v = body_of(*m, 0).v, momentum = body_of(*m, 0).momentum;
  const double start = m->stepping.time, lead = m->step_sums.energies.balance_error(), mass = 2000 * b * h / 2 * depth,
               force = p * h * depth;
  while (m->stepping.time < 1e-3) m->step();
  const double duration = m->stepping.time - start;
  check("prism under pressure: acceleration", force / mass, (body_of(*m, 0).v.x - v.x) / duration, 1e-6, "m/s2",
        "p A / m");
  check("prism under pressure: angular acceleration", -force * h / 6 / (mass * (b * b + h * h) / 18),
        (body_of(*m, 0).momentum.z - momentum.z) / duration / (mass * (b * b + h * h) / 18), 1e-6, "1/s2",
        "p A h/6 over m (b^2 + h^2)/18");
  check_error("prism under pressure: work less kinetic energy", std::abs(m->step_sums.energies.balance_error(lead)),
              1e-6 * m->step_sums.energies.kinetic, "J");
}

// The work of loads and pressures on gridpoints is the kinetic and strain energy of a free block.
TEST(FreeMotion, WorkOfLoadsOnGridpointsIsItsEnergy) {
  Scene scene(elastic_joint(1e9, 1e9));
  scene.soft({0, 0, 0}, {0.2, 0.1, 0.1}, {2, 1, 1});
  auto m = scene.model(undamped());
  m->track_energy(true);
  m->add(Pressure{0, 0, 1e3, {}, {}, {}});  // on -x
  m->add(Load{0, {0.2, 0.1, 0.0}, {0, 30, 0}, {}, {}, {}});
  m->step();
  const double lead = m->step_sums.energies.balance_error();
  for (int i = 0; i < 400; ++i) m->step();
  const auto& e = m->step_sums.energies;
  // Strain oscillates about its mean under loads that come at once; leapfrog keeps energy to (omega dt)^2 of that part.
  check_error("loads on gridpoints: work less energy", std::abs(e.balance_error(lead)), 0.2 * e.strain, "J");
  check_error("loads on gridpoints: strain energy beside kinetic", e.strain, 0.01 * e.kinetic, "J");
}

// Dzhanibekov effect: rotation about the intermediate axis is unstable; momentum and energy are constant.
TEST(FreeMotion, UnstableAxisKeepsMomentumAndEnergy) {
  Scene scene(elastic_joint(1e9, 1e9));
  scene.brick({0, 0, 0}, {0.1, 0.25, 0.6});
  auto m = scene.model(undamped());
  m->set_velocity(0, {}, {0.01, 15.0, 0.01});
  const Vector momentum = body_of(*m, 0).momentum;
  m->track_energy(true);
  m->step();
  const double energy = m->step_sums.energies.kinetic;
  const auto spin = [&] { return geometry::transposed_times(body_of(*m, 0).r, body_of(*m, 0).omega); };
  const Vector& inertia = body_of(*m, 0).inertia;
  // Euler's equations without moment, by steps of the classical Runge-Kutta method.
  const auto rate = [&](const Vector& w) {
    return Vector{(inertia.y - inertia.z) * w.y * w.z / inertia.x, (inertia.z - inertia.x) * w.z * w.x / inertia.y,
                  (inertia.x - inertia.y) * w.x * w.y / inertia.z};
  };
  Vector expected = spin();
  int middle = 0;
  for (int k = 1; k < 3; ++k) middle = std::abs(expected[k]) > std::abs(expected[middle]) ? k : middle;
  Curve measured{"measured"}, euler{"Euler's equations", CurveKind::reference};
  double flips = 0, before = 1, worst = 0;
  for (int i = 0; i < 60000; ++i) {
    if (i % 10 == 0 && m->stepping.time < 4.0) {
      measured.add(m->stepping.time, spin()[middle]), euler.add(m->stepping.time, expected[middle]);
    }
    const double dt = m->stepping.dt;
    m->step();
    const Vector a = rate(expected), b = rate(expected + 0.5 * dt * a), c = rate(expected + 0.5 * dt * b),
                 d = rate(expected + dt * c);
    expected = expected + dt / 6 * (a + 2 * b + 2 * c + d);
    const double now = spin()[middle];
    if (now * before < 0) ++flips;
    before = now;
    worst = std::max(worst, std::abs(m->step_sums.energies.kinetic / energy - 1));
  }
  write_figure("tumbling", "time, s", "spin about the middle axis, rad/s", {euler, measured});
  check_error("tumbling block: angular momentum, relative", norm(body_of(*m, 0).momentum - momentum) / norm(momentum),
              1e-12, "-");
  check_error("tumbling block: energy, largest relative", worst, 1e-6, "-");
  EXPECT_GT(flips, 0);
}

// A block on an incline of angle theta: gravity rotates slowly in place of the plane.
struct Slide {
  double creep;         // displacement between 0.6 and 1 s after the rotation, m
  double acceleration;  // between 0.2 and 0.6 s after the rotation, m/s2
};
Slide incline(double theta, double mu) {
  Scene scene(dry_joint(1e9, 1e9, std::atan(mu) * 180 / pi));
  scene.brick({-1, -0.2, -1}, {30, 0.2, 2}, true);
  const int b = scene.brick({0, 0, -0.1}, {0.4, 0.2, 0.2});
  auto m = scene.model(viscous(0, 2e-4));
  m->set_gravity({0, -gravity, 0});
  m->run(0.05);
  const double turn_time = 0.2;
  for (double t = 0; t < 1; t += 0.005) {
    m->set_gravity(gravity * Vector{std::sin(t * theta), -std::cos(t * theta), 0});
    m->run(0.005 * turn_time);
  }
  m->set_gravity(gravity * Vector{std::sin(theta), -std::cos(theta), 0});
  m->run(0.2);
  const double v1 = velocity_of(*m, b).x, t1 = m->stepping.time;
  m->run(0.4);
  const double a = (velocity_of(*m, b).x - v1) / (m->stepping.time - t1);
  const double x1 = position_of(*m, b).x;
  m->run(0.4);
  return {position_of(*m, b).x - x1, a};
}

TEST(Incline, SticksBelowSlidesAbove) {
  const double mu = 0.6, limit = std::atan(mu);
  const auto expected = [&](double factor) {
    return std::max(0.0, gravity * (std::sin(factor * limit) - mu * std::cos(factor * limit)));
  };
  const Slide held = incline(0.99 * limit, mu);
  check_error("incline at 0.99 of the friction angle: creep in 0.4 s", held.creep, 1e-8, "m");
  Curve measured{"measured", CurveKind::measured, {{0.99, held.acceleration}}};
  for (double factor : {1.05, 1.15, 1.3}) {
    measured.add(factor, incline(factor * limit, mu).acceleration);
    check("incline at " + std::to_string(factor).substr(0, 4) + " of the friction angle: acceleration",
          expected(factor), measured.points.back()[1], 1e-3, "m/s2", "g (sin - mu cos)");
  }
  write_figure("incline", "slope angle / friction angle, -", "acceleration down the slope, m/s2",
               {reference("g (sin - mu cos)", 0.9, 1.4, expected), measured});
}

// Elastic bounce of a flat block without damping: it returns to its height; contact time pi sqrt(m / (kn A)).
TEST(Bouncing, HeightAndContactTime) {
  std::vector<Curve> curves;
  for (double fraction : {0.4, 0.1}) {
    Scene scene(dry_joint(1e8, 1e8, 30));
    scene.brick({-1, -0.2, -1}, {2, 0.2, 2}, true);
    const double drop = 0.05;
    const int b = scene.brick({-0.1, drop, -0.1}, {0.2, 0.2, 0.2});
    auto m = scene.model(undamped(fraction));
    m->set_gravity({0, -gravity, 0});
    const double y0 = position_of(*m, b).y;
    double touched = -1, left = -1, highest = 0;
    const double mass = 2000 * 0.008, k = 1e8 * 0.04, lands = std::sqrt(2 * drop / gravity);
    if (curves.empty()) {
      curves.push_back(reference("fall, spring, flight", 0, 0.3, [&](double t) {
        const double flight = t - lands - pi * std::sqrt(mass / k), speed = gravity * lands;
        if (t < lands) return 1e3 * (drop - 0.5 * gravity * t * t);
        if (flight < 0) return -1e3 * speed * std::sqrt(mass / k) * std::sin((t - lands) * std::sqrt(k / mass));
        return 1e3 * (speed * flight - 0.5 * gravity * flight * flight);
      }));
    }
    Curve& curve = curves.emplace_back("step " + std::to_string(fraction).substr(0, 3) + " of the limit");
    while (m->stepping.time < 0.3) {
      m->step();
      curve.add(m->stepping.time, 1e3 * (position_of(*m, b).y - y0 + drop));
      const double pushed = norm(m->step_sums.contact_force[b]);
      if (pushed > 0 && touched < 0) touched = m->stepping.time;
      if (pushed == 0 && touched > 0 && left < 0) left = m->stepping.time;
      if (left > 0) highest = std::max(highest, position_of(*m, b).y - (y0 - drop));
    }
    check("bounce: height regained, step " + std::to_string(fraction).substr(0, 3) + " of the limit", drop, highest,
          0.02, "m", "undamped");
    check("bounce: contact time, step " + std::to_string(fraction).substr(0, 3), pi * std::sqrt(mass / k),
          left - touched, fraction < 0.2 ? 0.06 : 0.2, "s", "pi sqrt(m/(kn A))");
  }
  write_figure("bounce", "time, s", "height above the floor, mm", curves);
}

// A spike so steep that none of its faces is above the floor within contact distance. Only its tip has contact, at 5 m,
// with the area of a corner: a third of the surface over the corners. It penetrates by x with m g (h + x) = k x^2/2,
// plus part of an interval of contact detection; then it rebounds.
TEST(Bouncing, ATipBetweenSteepFacesBears) {
  Scene scene(dry_joint(1e7, 1e7, 30));
  scene.brick({-1, 4, -1}, {2, 1, 2}, true);
  const double drop = 0.05, wide = 0.02, tall = 1.0;  // m; faces at 1.1 degrees from the vertical
  std::vector<Vector> corners{{0.3, 5 + drop, 0.2}};
  for (const auto& [x, z] : {std::pair{-wide, -wide}, {wide, -wide}, {wide, wide}, {-wide, wide}})
    corners.push_back({0.3 + x, 5 + drop + tall, 0.2 + z});
  const int b = scene.block(geometry::from_vertices(corners, "spike"));
  auto m = scene.model(undamped(0.1));
  m->set_gravity({0, -gravity, 0});
  const double start = position_of(*m, b).y;
  double lowest = 0.0, most = 0.0, highest = -drop;
  Curve pressed{"measured, in and out"};
  while (m->stepping.time < 0.25) {
    m->step();
    const double way = position_of(*m, b).y - start;
    most = std::max(most, m->step_sums.contact_force[b].y);
    if (m->step_sums.contact_force[b].y > 0) pressed.add(-1e3 * (way + drop), m->step_sums.contact_force[b].y);
    highest = way > lowest ? std::max(highest, way) : -drop;
    lowest = std::min(lowest, way);
  }
  const double surface = 4 * wide * wide + 4 * wide * std::hypot(tall, wide), k = 1e7 * surface / (3 * 5),
               weight = 2000 * 4 * wide * wide * tall / 3 * gravity;
  const double sinks = (weight + std::sqrt(weight * weight + 2 * k * weight * drop)) / k;
  write_figure(
      "spike", "tip below the floor, mm", "force on the tip, N",
      {reference("k x, until m g (h + x) = k x^2/2", 0, 1e3 * sinks, [&](double x) { return 1e-3 * k * x; }), pressed});
  check("spike on its tip: sinks in by", sinks, -lowest - drop, 0.05, "m", "energy of a spring");
  check("spike on its tip: largest force", k * sinks, most, 0.05, "N", "energy of a spring");
  check_error("spike on its tip: height not regained, relative", -highest / drop, 1e-4, "-");
}

// A tower of ten blocks comes to rest: each joint carries the weight above it.
TEST(Stacking, JointForcesAreWeightsAbove) {
  Scene scene(dry_joint(1e10, 5e9, 35));
  scene.brick({-1, -0.2, -1}, {2, 0.2, 2}, true);
  const int n = 10;
  for (int i = 0; i < n; ++i) scene.brick({0, 0.1 * i, 0}, {0.2, 0.1, 0.2});
  auto m = scene.model(local(0.8));
  m->set_gravity({0, -gravity, 0});
  settle(*m, 1e-22, 20000);
  const double weight = 2000 * 0.2 * 0.2 * 0.1 * gravity;
  double worst = 0.0;
  Curve carried{"measured"};
  for (const Contact& c : m->contacts.list) {
    if (c.count == 0) continue;
    const Family& f = m->contacts.families[c.family];
    double force = 0.0;
    for (uint32_t i = c.first; i < c.first + c.count; ++i) force -= f.traction[0][i] * f.point[i].area;
    carried.add(c.pair.b, force);
    worst = std::max(worst, std::abs(force / (weight * (n - c.pair.b + 1)) - 1));
  }
  write_figure("stack", "joint, from the floor, -", "force, N",
               {reference("weight above", 1, n, [&](double j) { return weight * (n - j + 1); }), carried});
  check_error("stack of 10: joint force against weight above, worst relative", worst, 1e-6, "-");
}

// A block with an initial velocity along a plane: friction dissipates its kinetic energy; distance v^2 / (2 mu g).
TEST(Friction, SlidingWork) {
  const double mu = 0.5, v = 1.0;
  Scene scene(dry_joint(1e9, 1e9, std::atan(mu) * 180 / pi));
  scene.brick({-1, -0.2, -1}, {4, 0.2, 2}, true);
  const int b = scene.brick({0, 0, -0.2}, {0.4, 0.1, 0.4});
  auto m = scene.model(viscous(0, 2e-4));
  m->set_gravity({0, -gravity, 0});
  m->run(0.05);
  m->track_energy(true);
  m->set_velocity(b, {v, 0, 0});
  const double x0 = position_of(*m, b).x, mass = 2000 * 0.4 * 0.1 * 0.4;
  m->step();
  const auto start = m->step_sums.energies;
  const double before = start.kinetic + start.contact_stored + start.damping + start.detection +
                        start.dissipated_total() - start.external;
  Curve way{"measured"};
  for (const double began = m->stepping.time; m->stepping.time < began + 0.4;) {
    m->step();
    way.add(m->stepping.time - began, 1e3 * (position_of(*m, b).x - x0));
  }
  write_figure("sliding", "time, s", "distance, mm",
               {reference("v t - mu g t^2/2, until it rests", 0, 0.4,
                          [&](double t) {
                            t = std::min(t, v / (mu * gravity));
                            return 1e3 * (v * t - 0.5 * mu * gravity * t * t);
                          }),
                way});
  check("sliding block: stopping distance", v * v / (2 * mu * gravity), position_of(*m, b).x - x0, 5e-3, "m",
        "v^2/(2 mu g)");
  check("sliding block: friction work", 0.5 * mass * v * v, m->step_sums.energies.dissipated[QUOIN_DISSIPATED_FRICTION],
        5e-3, "J", "m v^2/2");
  check_error("sliding block: energy balance / kinetic energy",
              m->step_sums.energies.balance_error(before) / (0.5 * mass * v * v), 2e-3, "-");
}

}  // namespace
}  // namespace quoin::verification
