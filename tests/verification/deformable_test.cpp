// Deformable blocks: objectivity, waves, beams, patch tests.
#include "../momentum.h"
#include "support.h"

namespace quoin::verification {
namespace {

// A free deformable block in a hundred revolutions: no drift of momentum or energy, no shear stress in its own frame.
TEST(Objectivity, SpinningDeformableBlock) {
  Scene scene(elastic_joint(1e9, 1e9), 2000, 1e9, 0.2);
  scene.soft({-0.2, -0.1, -0.1}, {0.4, 0.2, 0.2}, {2, 1, 1});
  auto m = scene.model(undamped(0.7));
  const double omega = 200.0;
  m->set_velocity(0, {}, {0, 0, omega});
  m->track_energy(true);
  m->step();
  const double energy = m->step_sums.energies.kinetic + m->step_sums.energies.strain;
  const Vector momentum = angular_momentum(*m);
  double worst = 0.0, momentum_error = 0.0;
  const double end = 100 * 2 * pi / omega;
  while (m->stepping.time < end) {
    m->step();
    worst = std::max(worst, std::abs((m->step_sums.energies.kinetic + m->step_sums.energies.strain) / energy - 1));
    momentum_error = std::max(momentum_error, norm(angular_momentum(*m) - momentum) / norm(momentum));
  }
  check_error("spinning deformable block, 100 turns: angular momentum", momentum_error, 1e-11, "-", "relative");
  // The product of two velocities is less than the square of their mean by (a dt)^2/4. The radial acceleration a swings
  // between 0 and 2 omega^2 r.
  const double step = omega * m->stepping.dt;
  check_error("spinning deformable block, 100 turns: energy", worst, step * step, "-",
              "relative, oscillating, no drift; (omega dt)^2");
}

// A steadily rotating block (vibrations damped): the stress in its own frame does not change with the angle.
TEST(Objectivity, StressTurnsWithTheBlock) {
  Scene scene(elastic_joint(1e9, 1e9), 2000, 1e9, 0.2);
  scene.soft({-0.2, -0.1, -0.1}, {0.4, 0.2, 0.2}, {4, 2, 2});
  auto m = scene.model(viscous(0, 2e-5, 0.7));
  const double omega = 200.0;
  m->set_velocity(0, {}, omega * Vector{0, 0, 1});
  const auto stresses = [&] {
    std::vector<Matrix> all;
    const Matrix r = orientation_of(*m, 0);
    for (int z = 0; z < m->blocks[0].zone_count; ++z) all.push_back(transposed(r) * zone_stress(*m, 0, z) * r);
    return all;
  };
  m->run(20 * 2 * pi / omega);
  const std::vector<Matrix> before = stresses();
  m->run(80.37 * 2 * pi / omega);
  const std::vector<Matrix> after = stresses();
  double change = 0.0, largest = 0.0;
  for (size_t z = 0; z < before.size(); ++z) {
    for (int i = 0; i < 3; ++i) {
      change = std::max(change, norm(after[z].row[i] - before[z].row[i]));
      largest = std::max(largest, norm(before[z].row[i]));
    }
  }
  EXPECT_GT(largest, 0.5 * 2000 * omega * omega * 0.2 * 0.2 / 2);
  check_error("spinning deformable block: change of stress in its own frame over 80 turns", change / largest, 1e-6, "-",
              "relative to the largest");
}

// Two blocks with an elastic joint in a hundred revolutions about the joint's centre: tension m omega^2 r / A.
void spinning_pair(bool soft) {
  const double a = 0.2, omega = 200.0;
  Scene scene(elastic_joint(1e11, 5e10), 2000, 5e9, 0.0);
  for (double x : {-a, 0.0}) {
    if (soft)
      scene.soft({x, -a / 2, -a / 2}, {a, a, a}, {x < 0 ? 2 : 1, x < 0 ? 2 : 1, x < 0 ? 1 : 2});
    else
      scene.brick({x, -a / 2, -a / 2}, {a, a, a});
  }
  auto m = scene.model(viscous(0, 4e-6, 0.6));
  // about an axis that is not a symmetry axis of the frame (s, t): the frame rotates also about its normal
  const Vector axis = normalized(Vector{0.0, 0.6, 0.8});
  for (int i = 0; i < 2; ++i) {
    m->set_velocity(i, cross(omega * axis, position_of(*m, i)), omega * axis);
  }
  const Vector momentum = angular_momentum(*m);
  m->run(100 * 2 * pi / omega);
  const std::string name = soft ? "two deformable blocks on an elastic joint, 100 turns: "
                                : "two rigid blocks on an elastic joint, 100 turns: ";
  check_error(name + "angular momentum", norm(angular_momentum(*m) - momentum) / norm(momentum), soft ? 1e-10 : 1e-11,
              "-", "relative");
  double area = 0.0;
  for (const Family& f : m->contacts.families) {
    for (const Point& p : f.point) area += p.area;
  }
  EXPECT_NEAR(area, a * a, 1e-12);
  const Vector line = normalized(position_of(*m, 0) - position_of(*m, 1));
  m->step();  // the forces of a step belong to the positions at its start
  const Vector force = m->step_sums.contact_force[1];
  const double tension = dot(force, line);
  check(name + "joint tension", 2000 * a * a * a * omega * omega * a / 2, tension, soft ? 2e-3 : 2e-4, "N",
        "m omega^2 r; the joint opens");
  check_error(name + "net shear / tension", norm(force - tension * line) / tension, 1e-3, "-");
}
TEST(Objectivity, SpinningPairRigid) { spinning_pair(false); }
TEST(Objectivity, SpinningPairDeformable) { spinning_pair(true); }

// Two free blocks with initial velocities on a soft elastic joint. The joint opens and slides by millimetres, so that
// its shear force has a distance from the initial surface. Momenta of the pair are constant to rounding, for a joint
// plane of either block: both forces act at one point.
void free_pair(const char* name_of_pair, bool first_rigid, bool second_rigid) {
  const double a = 0.2;
  Scene scene(elastic_joint(2e7, 1e7), 2000, 1e9, 0.2);
  scene.assembly.contact.small_displacement = 0.0;
  for (const auto& [x, rigid] : {std::pair{-a, first_rigid}, {0.0, second_rigid}}) {
    if (rigid)
      scene.brick({x, -a / 2, -a / 2}, {a, a, a});
    else
      scene.soft({x, -a / 2, -a / 2}, {a, a, a}, {1, 2, x < 0 ? 2 : 1});
  }
  auto m = scene.model(undamped(0.3));
  m->set_velocity(0, {-0.6, 0.4, 0.2}, {3, -2, 4});
  m->set_velocity(1, {0.5, -0.3, 0.3}, {-2, 5, -3});
  const Vector linear = linear_momentum(*m), angular = angular_momentum(*m);
  double open = 0.0, shear = 0.0, moment_of_gap = 0.0, drift = 0.0;
  for (int i = 0; i < 3000; ++i) {
    m->step();
    drift = std::max(drift, norm(angular_momentum(*m) - angular) / norm(angular));
    for (const Family& f : m->contacts.families) {
      for (size_t k = 0; k < f.size(); ++k) {
        const double tau = std::hypot(f.traction[1][k], f.traction[2][k]), gap = f.normal_jump[k];
        open = std::max(open, gap), shear = std::max(shear, tau);
        moment_of_gap = std::max(moment_of_gap, f.point[k].area * tau * std::abs(gap));
      }
    }
  }
  const std::string name = name_of_pair + std::string(": ");
  EXPECT_GT(open, 1e-3);
  EXPECT_GT(moment_of_gap * m->stepping.time, 1e-4 * norm(angular)) << "what the gap turns must be seen";
  check_error(name + "momentum", norm(linear_momentum(*m) - linear) / norm(linear), 1e-11, "-", "relative");
  check_error(name + "angular momentum", drift, 1e-11, "-", "relative");
}
TEST(Conservation, RigidOnDeformableBlock) { free_pair("rigid and deformable block", true, false); }
TEST(Conservation, DeformableOnRigidBlock) { free_pair("deformable and rigid block", false, true); }
TEST(Conservation, DeformableBlocks) { free_pair("two deformable blocks", false, false); }
TEST(Conservation, RigidBlocks) { free_pair("two rigid blocks", true, true); }

// Returns the wave speed of a smooth pulse along a bar without lateral motion, from its peak at two stations.
double wave_speed(bool p_wave, int elements, double speed) {
  const double length = 4.0, h = length / elements;
  Scene scene(elastic_joint(1e9, 1e9), 2000, 10e9, 0.25);
  scene.soft({0, 0, 0}, {length, h, h}, {elements, 1, 1});
  auto m = scene.model(undamped(0.8));
  const int along = 0, across = 1, moving = p_wave ? along : across;
  const uint8_t held = uint8_t(7 & ~(1 << moving));
  const double duration = 4e-4;
  std::vector<int> driven;
  for (size_t i = 0; i < m->nodes.x.size(); ++i) {
    hold_node(*m, int(i), held);
    if (m->nodes.reference[i].x < 1e-9) hold_node(*m, int(i), 7), driven.push_back(int(i));
  }
  struct Station {
    double x;
    std::vector<int> nodes;
    Curve passing;  // mm/s over ms
    double peak = 0, when = 0, last = 0, older = 0;
  } station[2] = {{1.0, {}, {"at 1 m"}}, {3.0, {}, {"at 3 m"}}};
  for (auto& s : station) {
    for (size_t i = 0; i < m->nodes.reference.size(); ++i) {
      if (std::abs(m->nodes.reference[i].x - s.x) < 1e-6) s.nodes.push_back(int(i));
    }
  }
  const auto pulse = [&](double time) {
    return time > 0 && time < duration ? 1e-4 * std::pow(std::sin(pi * time / duration), 2) : 0.0;
  };
  const double end = 3.6e-3 * (p_wave ? 0.55 : 1.0);
  while (m->stepping.time < end) {
    const double v = pulse(m->stepping.time);
    for (int i : driven) hold_velocity(*m, i, p_wave ? Vector{v, 0, 0} : Vector{0, v, 0});
    m->step();
    for (auto& s : station) {
      double mean = 0;
      for (int i : s.nodes) mean += m->nodes.v[i][moving] / double(s.nodes.size());
      // parabola through three samples around the largest
      if (s.last > s.peak && s.last >= s.older && s.last >= mean) {
        const double curve = s.older - 2 * s.last + mean;
        s.peak = s.last;
        s.when =
            m->stepping.time - m->stepping.dt + (curve != 0 ? 0.5 * (s.older - mean) / curve * m->stepping.dt : 0.0);
      }
      s.older = s.last, s.last = mean;
      s.passing.add(1e3 * (m->stepping.time - 0.5 * m->stepping.dt), 1e3 * mean);
    }
  }
  const auto delayed = [&](const Station& s) {
    return reference("the pulse, x/c later, " + s.passing.name, 0, 1e3 * end,
                     [&](double ms) { return 1e3 * pulse(1e-3 * ms - s.x / speed); });
  };
  write_figure(p_wave ? "p_wave" : "s_wave", "time, ms",
               p_wave ? "velocity along the bar, mm/s" : "velocity across the bar, mm/s",
               {delayed(station[0]), station[0].passing, delayed(station[1]), station[1].passing});
  return 2.0 / (station[1].when - station[0].when);
}

TEST(Waves, SpeedsConverge) {
  const double e = 10e9, nu = 0.25, rho = 2000, lambda = e * nu / ((1 + nu) * (1 - 2 * nu)), mu = e / (2 * (1 + nu));
  const double cp = std::sqrt((lambda + 2 * mu) / rho), cs = std::sqrt(mu / rho);
  for (int n : {80, 160}) {
    check("P-wave speed, pulse over " + std::to_string(int(4e-4 * cp / 4 * n)) + " zones", cp, wave_speed(true, n, cp),
          n == 80 ? 1e-2 : 4e-3, "m/s", "sqrt((lambda+2mu)/rho)");
    check("S-wave speed, pulse over " + std::to_string(int(4e-4 * cs / 4 * n)) + " zones", cs, wave_speed(false, n, cs),
          n == 80 ? 3e-2 : 4e-3, "m/s", "sqrt(mu/rho)");
  }
}

// Returns the transmission of a harmonic wave through an elastic joint between two bars:
// |T| = (1 + (omega z / 2k)^2)^(-1/2).
std::pair<double, double> transmission(double ratio, int per_wave) {
  const double e = 10e9, rho = 2000, c = std::sqrt(e / rho), z = rho * c, frequency = 1000, omega = 2 * pi * frequency;
  const double k = omega * z / (2 * ratio), wave = c / frequency, h = wave / per_wave;
  const int waves = 5, n = waves * per_wave;
  Scene scene(elastic_joint(k, k), rho, e, 0.0);
  scene.soft({0, 0, 0}, {waves * wave, h, h}, {n, 1, 1});
  scene.soft({waves * wave, 0, 0}, {waves * wave, h, h}, {n, 1, 1});
  auto m = scene.model(undamped(0.6));
  std::vector<int> driven, far, near;
  for (size_t i = 0; i < m->nodes.x.size(); ++i) {
    hold_node(*m, int(i), 6);
    const double x = m->nodes.reference[i].x;
    if (x < 1e-9) hold_node(*m, int(i), 7), driven.push_back(int(i));
    if (std::abs(x - (waves + 1) * wave) < 1e-6) far.push_back(int(i));
    if (std::abs(x - wave) < 1e-6) near.push_back(int(i));
  }
  // steady about three periods after the arrival at the joint; measured before the reflection of the far end
  double sine = 0, cosine = 0;
  const double start = (waves + 1 + 3) / frequency, end = start + 2 / frequency;
  double incident_sine = 0, incident_cosine = 0;
  while (m->stepping.time < end) {
    const double t = m->stepping.time, ramp = std::min(1.0, t * frequency / 2);
    const double v = 1e-4 * ramp * ramp * (3 - 2 * ramp) * std::sin(omega * t);
    for (int i : driven) hold_velocity(*m, i, {v, 0, 0});
    m->step();
    const double now = m->stepping.time - 0.5 * m->stepping.dt;
    if (now >= start) {
      for (int i : far)
        sine += m->nodes.v[i].x * std::sin(omega * now), cosine += m->nodes.v[i].x * std::cos(omega * now);
    }
    // the incident wave only, before the reflection of the joint
    if (now >= 4 / frequency && now < 6 / frequency) {
      for (int i : near)
        incident_sine += m->nodes.v[i].x * std::sin(omega * now),
            incident_cosine += m->nodes.v[i].x * std::cos(omega * now);
    }
  }
  const double t = std::hypot(sine / double(far.size()), cosine / double(far.size()));
  const double incident = std::hypot(incident_sine / double(near.size()), incident_cosine / double(near.size()));
  return {t / incident, 1 / std::sqrt(1 + ratio * ratio)};
}

TEST(Waves, TransmissionAtElasticJoint) {
  const auto passes = [](double ratio) { return 1 / std::sqrt(1 + ratio * ratio); };
  Curve passed{"|T| measured"}, reflected{"|R| from energy"};
  for (double ratio : {0.5, 1.0, 2.0}) {
    const auto [measured, expected] = transmission(ratio, 32);
    passed.add(ratio, measured), reflected.add(ratio, std::sqrt(std::max(0.0, 1 - measured * measured)));
    check("transmission |T| at an elastic joint, omega z/2k = " + std::to_string(ratio).substr(0, 3), expected,
          measured, 0.015, "-", "(1+(omega z/2k)^2)^(-1/2)");
    check("reflection |R|, from energy, omega z/2k = " + std::to_string(ratio).substr(0, 3),
          std::sqrt(1 - expected * expected), std::sqrt(std::max(0.0, 1 - measured * measured)), 0.02, "-",
          "|R|^2 = 1 - |T|^2");
  }
  write_figure("transmission", "omega z/2k, -", "amplitude / incident amplitude, -",
               {reference("|T| = (1 + (omega z/2k)^2)^(-1/2)", 0, 3, passes), passed,
                reference("|R| = (1 - |T|^2)^(1/2)", 0, 3,
                          [&](double ratio) { return std::sqrt(1 - std::pow(passes(ratio), 2)); }),
                reflected});
}

// Cantilever: tip deflection under a tip load (Timoshenko), and first frequency after release of the load.
struct Beam {
  double deflection, frequency;
};
Beam cantilever(std::array<int, 3> n) {
  const double length = 1.0, depth = 0.2, width = 0.1, e = 1e9, rho = 2000;
  Scene scene(elastic_joint(1e9, 1e9), rho, e, 0.0);
  scene.soft({0, 0, 0}, {length, depth, width}, n);
  auto m = scene.model(viscous(150, 0, 0.8));
  std::vector<int> tip;
  for (size_t i = 0; i < m->nodes.x.size(); ++i) {
    if (m->nodes.reference[i].x < 1e-9) hold_node(*m, int(i), 7);
    if (m->nodes.reference[i].x > length - 1e-9) tip.push_back(int(i));
  }
  const double f1 = 1.8751 * 1.8751 / (2 * pi) * std::sqrt(e * depth * depth / 12 / rho) / (length * length);
  const double load = 1000.0;
  // shear traction over the tip, as nodal shares of the tip face
  std::vector<double> share(m->nodes.x.size(), 0.0);
  for (const auto& t : m->blocks[0].surface) {
    const auto& x = m->nodes.reference;
    if (x[t.node[0]].x < length - 1e-9 || x[t.node[1]].x < length - 1e-9 || x[t.node[2]].x < length - 1e-9) continue;
    const double area = 0.5 * norm(cross(x[t.node[1]] - x[t.node[0]], x[t.node[2]] - x[t.node[0]]));
    for (int k : t.node) share[k] += area / 3 / (depth * width);
  }
  for (int i : tip) {
    Load l{};
    l.block = 0, l.force = {0, -load * share[i], 0}, l.point = m->nodes.reference[i];
    m->add(l);
  }
  const auto mean = [&] {
    double sum = 0;
    for (int i : tip) sum += share[i] * (m->nodes.x[i].y - m->nodes.reference[i].y);
    return sum;
  };
  m->run(6 / f1);
  const double deflection = -mean();
  m->actions.loads.clear();
  m->set_solver(undamped(0.8));
  // upward zero crossings of the tip's displacement over some periods
  double first = -1, last = -1, before = mean();
  int count = 0;
  const double end = m->stepping.time + 5.2 / f1;
  while (m->stepping.time < end) {
    m->step();
    const double now = mean();
    if (before < 0 && now >= 0) {
      const double t = m->stepping.time - m->stepping.dt * now / (now - before);
      if (first < 0)
        first = t;
      else
        ++count;
      last = t;
    }
    before = now;
  }
  return {deflection, count / (last - first)};
}

// Returns the relative error of the deflection of a cantilever.
double cantilever_at(std::array<int, 3> n, double tolerance_w, double tolerance_f) {
  const double length = 1.0, depth = 0.2, width = 0.1, e = 1e9, rho = 2000, load = 1000;
  const double inertia = width * depth * depth * depth / 12, area = width * depth;
  const double deflection =
      load * length * length * length / (3 * e * inertia) + 6 * load * length / (5 * e / 2 * area);
  const double f1 = 1.8751 * 1.8751 / (2 * pi) * std::sqrt(e * inertia / (rho * area)) / (length * length);
  const Beam b = cantilever(n);
  const std::string mesh = std::to_string(n[0]) + "x" + std::to_string(n[1]) + "x" + std::to_string(n[2]);
  check("cantilever tip deflection, zones " + mesh, deflection, b.deflection, tolerance_w, "m", "PL^3/3EI + 6PL/5GA");
  check("cantilever first frequency, zones " + mesh, f1, b.frequency, tolerance_f, "Hz",
        "Euler-Bernoulli; L/h = 5: Timoshenko -2.5 %");
  return std::abs(b.deflection / deflection - 1);
}
TEST(Cantilever, ConstantStrainZonesConverge) {
  cantilever_at({10, 2, 1}, 0.55, 0.6);
  cantilever_at({20, 4, 2}, 0.25, 0.2);
}
TEST(Cantilever, DISABLED_Fine) {
  Curve error{"measured"};
  error.add(2, cantilever_at({10, 2, 1}, 0.55, 0.6));
  error.add(4, cantilever_at({20, 4, 2}, 0.25, 0.2));
  error.add(8, cantilever_at({40, 8, 4}, 0.1, 0.06));
  error.add(12, cantilever_at({60, 12, 6}, 0.06, 0.04));
  write_figure("cantilever", "zones over the depth, -", "relative error of the tip deflection, -",
               {reference("second order", 2, 12, [&](double n) { return error.points[2][1] * 64 / (n * n); }), error});
}

// Patch test: constant stress across a joint between non-matching meshes, for any orientation.
void patch(bool turned, bool with_rigid) {
  const double p = 1e6;
  Scene scene(elastic_joint(1e11, 1e11), 2000, 1e9, with_rigid ? 0.0 : 0.3);
  const Quaternion q = turned ? geometry::rotation({0.3, -0.7, 0.5}) : Quaternion{};
  const auto add = [&](const Vector& lower, const Vector& size, std::array<int, 3> n, bool soft) {
    Block b;
    b.rigid = !soft, b.divisions = n, b.orientation = q;
    return scene.assembly.add(box(lower, size), b);
  };
  // lower block; two upper blocks of other meshes and unequal widths
  const int low = add({0, 0, 0}, {0.3, 0.1, 0.2}, {3, 1, 2}, true);
  const int left = add({0, 0.1, 0}, {0.13, 0.1, 0.2}, {2, 2, 3}, true);
  const int right = add({0.13, 0.1, 0}, {0.17, 0.1, 0.2}, {1, 1, 1}, !with_rigid);
  scene.assembly.family_of = [&](const Meeting& meet) {
    const bool between = (meet.block_a == left && meet.block_b == right);
    return between ? -1 : 0;  // without the head joint, so that each column is in uniaxial stress
  };
  auto m = scene.model(local(0.8, 0.7));
  // faces of geometry::box: -x +x -y +y
  m->add(Pressure{low, 2, p, {}, {}, {}});
  m->add(Pressure{left, 3, p, {}, {}, {}});
  m->add(Pressure{right, 3, p, {}, {}, {}});
  settle(*m, 1e-22, 60000);
  const Matrix r = matrix(q);
  double worst = 0.0;
  for (int block = 0; block < m->block_count(); ++block) {
    for (int z = 0; z < m->blocks[block].zone_count; ++z) {
      const Matrix s = transposed(r) * zone_stress(*m, block, z) * r;
      Matrix expected = Matrix::zero();
      expected.row[1].y = -p;
      for (int i = 0; i < 3; ++i) worst = std::max(worst, norm(s.row[i] - expected.row[i]) / p);
    }
  }
  double traction = 0.0, area = 0.0;
  for (const Family& f : m->contacts.families) {
    for (size_t i = 0; i < f.size(); ++i) {
      area += f.point[i].area;
      traction = std::max(traction, std::hypot(f.traction[0][i] + p, f.traction[1][i], f.traction[2][i]) / p);
    }
  }
  EXPECT_NEAR(area, 0.06, 1e-9);
  const std::string name = std::string("patch test, non-conforming joint") + (turned ? ", turned" : "") +
                           (with_rigid ? ", one block rigid" : "");
  // second-order terms of finite strain: p/E = 1e-3
  check_error(name + ": zone stress", worst, 5e-3, "-", "p/E = 1e-3: second-order strain terms");
  check_error(name + ": joint traction", traction, 5e-3, "-");
}
TEST(Patch, NonConforming) { patch(false, false); }
TEST(Patch, NonConformingTurned) { patch(true, false); }
TEST(Patch, NonConformingWithRigid) { patch(true, true); }

}  // namespace
}  // namespace quoin::verification
