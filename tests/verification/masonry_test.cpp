// Structures of rigid blocks with known strength: rocking, overturning, piers, triplet, arch, dry-joint walls.
#include <cstdio>

#include "support.h"

namespace quoin::verification {
namespace {

using geometry::rotation;

// Rocking block on a stiff base, released at an angle. Compares the time to the first impact with two solutions. These
// are the exact one of theta'' = -p^2 sin(alpha - theta), by quadrature, and Housner's for slender blocks:
//   T/4 = acosh(1/(1 - theta0/alpha)) / p
double quarter_period(double ratio, double kn) {
  const double b = 0.1, h = 0.5, depth = 0.2, alpha = std::atan2(b, h);
  Scene scene(dry_joint(kn, kn, 60));
  scene.brick({-1, -0.2, -1}, {2, 0.2, 2}, true);
  const double theta0 = ratio * alpha;
  Block block;
  // rotated about the edge at the origin, above the base: the block extends to negative x
  block.orientation = rotation({0, 0, -theta0});
  const int i = scene.assembly.add(box({-2 * b, 0, -depth / 2}, {2 * b, 2 * h, depth}), block);
  auto m = scene.model(viscous(0, 0, 0.3));
  m->set_gravity({0, -gravity, 0});
  double landed = -1;
  while (m->stepping.time < 2 && landed < 0) {
    m->step();
    const Matrix o = orientation_of(*m, i);
    const double angle = -std::atan2(o.row[1].x, o.row[0].x);
    // orientation is relative to the start: impact after a rotation by theta0
    if (-angle >= theta0) landed = m->stepping.time;
  }
  return landed;
}
double quarter_exact(double ratio) {
  const double b = 0.1, h = 0.5, r = std::hypot(b, h), alpha = std::atan2(b, h), p2 = 3 * gravity / (4 * r);
  // time from theta0 to 0: integral of dtheta / sqrt(2 p^2 (cos(alpha - theta0) - cos(alpha - theta))); substitution
  // removes the root
  const double theta0 = ratio * alpha;
  double sum = 0;
  const int n = 20000;
  for (int k = 0; k < n; ++k) {
    const double u = (k + 0.5) / n, theta = theta0 * (1 - u * u);
    sum += 2 * u * theta0 / n / std::sqrt(2 * p2 * (std::cos(alpha - theta0) - std::cos(alpha - theta)));
  }
  return sum;
}

TEST(Rocking, QuarterPeriodAgainstAmplitude) {
  const double p = std::sqrt(3 * gravity / (4 * std::hypot(0.1, 0.5)));
  Curve measured[2] = {{"kn 1e9 Pa/m"}, {"kn 1e11 Pa/m"}};
  for (double ratio : {0.3, 0.6, 0.9}) {
    const std::string at = ", theta0/alpha = " + std::to_string(ratio).substr(0, 3);
    for (double kn : {1e9, 1e11}) {
      const double quarter = quarter_period(ratio, kn);
      measured[kn > 1e10].add(ratio, quarter);
      check("rocking block: T/4" + at + (kn < 1e10 ? ", kn 1e9" : ", kn 1e11"), quarter_exact(ratio), quarter,
            kn < 1e10 ? 2e-2 : 5e-3, "s", "theta'' = -p^2 sin(alpha - theta)");
    }
    EXPECT_NEAR(std::acosh(1 / (1 - ratio)) / p / quarter_exact(ratio), 1, 0.02)
        << "Housner's formula for slender blocks";
  }
  write_figure("rocking", "theta0/alpha, -", "quarter period, s",
               {reference("theta'' = -p^2 sin(alpha - theta)", 0.05, 0.95, quarter_exact),
                reference("Housner, slender: acosh(1/(1 - theta0/alpha))/p", 0.05, 0.95,
                          [&](double ratio) { return std::acosh(1 / (1 - ratio)) / p; }),
                measured[0], measured[1]});
}

// Returns the ratio of angular velocities after and before the first impact of a rocking block, released at half of
// alpha. kn = 1e10 Pa/m.
double restitution(double slenderness, double stiffness_damping) {
  const double h = 0.5, b = h / slenderness, depth = 0.2, theta0 = 0.5 * std::atan2(b, h);
  Scene scene(dry_joint(1e10, 1e10, 60));
  scene.brick({-3, -0.2, -1}, {6, 0.2, 2}, true);
  Block block;
  block.orientation = rotation({0, 0, -theta0});
  const int i = scene.assembly.add(box({-2 * b, 0, -depth / 2}, {2 * b, 2 * h, depth}), block);
  auto m = scene.model(viscous(0, stiffness_damping, 0.3));
  m->set_gravity({0, -gravity, 0});
  double before = 0, turned = 0;
  while (turned < 1.05 * theta0 && m->stepping.time < 2) {  // until vibration of the joint has decayed
    m->step();
    const Matrix o = orientation_of(*m, i);
    turned = std::atan2(o.row[1].x, o.row[0].x);
    if (turned < theta0) before = std::max(before, spin_of(*m, i).z);
  }
  return spin_of(*m, i).z / before;
}
// Housner's block conserves the angular momentum about its other edge: ratio 1 - 1.5 sin(alpha)^2. Here only stiffness
// damping of the joint dissipates: without it the ratio is 1, with 2e-4 s it is near Housner's.
TEST(Rocking, VelocityOverTheImpact) {
  const auto housner = [](double slenderness) { return 1 - 1.5 / (1 + slenderness * slenderness); };
  std::vector<Curve> curves{reference("Housner: 1 - 1.5 sin(alpha)^2", 2, 8, housner),
                            {"elastic: 1", CurveKind::reference, {{2, 1}, {8, 1}}}};
  for (double damping : {2e-4, 0.0}) {
    Curve& curve = curves.emplace_back(damping > 0 ? "stiffness damping 2e-4 s" : "no damping");
    for (double slenderness : {2.0, 3.0, 4.0, 5.0, 6.0, 8.0}) {
      curve.add(slenderness, restitution(slenderness, damping));
      check("rocking block: velocity ratio of the impact, h/b = " + std::to_string(slenderness).substr(0, 1) +
                (damping > 0 ? ", stiffness damping 2e-4 s" : ", undamped"),
            damping > 0 ? housner(slenderness) : 1.0, curve.points.back()[1], 0.03, "-",
            damping > 0 ? "1 - 1.5 sin(alpha)^2" : "energy is kept; 1.05 of the angle of the impact");
    }
  }
  write_figure("rocking_impact", "slenderness h/b, -", "velocity after / before the impact, -", curves);
}

// Slowly rotated gravity: a block with high friction overturns when tan(theta) exceeds b/h.
TEST(Toppling, Threshold) {
  const double b = 0.1, h = 0.3;
  std::vector<Curve> curves{{"tan(theta) = b/h", CurveKind::reference, {{b / h, 0}, {b / h, 2}}}};
  for (double kn : {1e9, 1e10}) {
    Curve& curve = curves.emplace_back(kn < 5e9 ? "kn 1e9 Pa/m" : "kn 1e10 Pa/m");
    Scene scene(dry_joint(kn, kn, 60));
    scene.brick({-1, -0.2, -1}, {4, 0.2, 2}, true);
    const int i = scene.brick({0, 0, 0}, {2 * b, 2 * h, 0.2});
    auto m = scene.model(viscous(0, 5e-5));
    double theta = 0.98 * std::atan(b / h);
    apply_weight(*m, 0.2, 0.4, {std::sin(theta), -std::cos(theta), 0});
    // after the threshold the rotation is p^2 rate t^3 / 6: at 0.005 rad/s the lag is 0.7 % of the angle
    while (theta < 1.2 * std::atan(b / h)) {
      theta += 1e-5;
      m->set_gravity(gravity * Vector{std::sin(theta), -std::cos(theta), 0});
      m->run(0.002);
      const Matrix o = orientation_of(*m, i);
      const double turned = -std::atan2(o.row[1].x, o.row[0].x);
      curve.add(std::tan(theta), 1e3 * turned);
      if (turned > 2e-3) break;
    }
    check(std::string("toppling threshold, kn ") + (kn < 5e9 ? "1e9" : "1e10"), b / h, std::tan(theta), 1.5e-2, "-",
          "tan(theta) = b/h");
  }
  write_figure("toppling", "slope, tan(theta), -", "rotation of the block, 1e-3 rad", curves);
}

// A dry pier of rigid courses between a fixed base and a cap with prescribed velocity. V = N D / (2 H0), with
// corrections for the finite stiffness of the joint. A triangular stress block of length c = sqrt(2 N / (kn theta
// depth)) moves the pivot inwards by c/3, and the cap's displacement u moves N.
struct Pier {
  double force, ideal, expected;  // N
  std::vector<Curve> curves;      // kN over mm
};
Pier pier(bool fixed_fixed, double kn) {
  const double width = 1.0, course = 0.2, depth = 0.25, load = 50e3;
  const int courses = 8;
  Scene scene(dry_joint(kn, kn, 45));
  scene.brick({-0.5, -0.2, 0}, {2, 0.2, depth}, true);
  for (int i = 0; i < courses; ++i) scene.brick({0, course * i, 0}, {width, course, depth});
  const double height = courses * course;
  const int cap = scene.brick({0, height, 0}, {width, 0.1, depth});
  scene.assembly.contact.point_spacing = 0.025;
  auto m = scene.model(viscous(30.0, 2e-5, 0.6));
  Load l{};
  l.block = cap, l.point = {width / 2, height + 0.05, depth / 2}, l.force = {0, -load, 0};
  m->add(l);
  for (double end = 0.04; m->stepping.time < end - 0.5 * m->stepping.dt; m->step())
    m->actions.loads[0].scale = std::min(1.0, m->stepping.time / 0.02);
  // velocity prescribed along x, free along y; no rotation with a fixed head. The cap's centre is 0.05 m above the
  // pier.
  const double v = 0.01, x0 = position_of(*m, cap).x;
  const uint8_t held = fixed_fixed ? 0x3d : 0x05;
  double force = 0.0;
  const double h0 = fixed_fixed ? height : height + 0.05, hinges = fixed_fixed ? 2 : 1;
  const auto expected = [&](double u) {
    const double c = std::sqrt(2 * load / (kn * (u / h0) * depth));
    return load * (hinges * (width / 2 - c / 3) - u) / h0;
  };
  Curve curve{kn < 5e10 ? "kn 1e10 Pa/m" : "kn 1e11 Pa/m"};
  for (int k = 0; k < 100; ++k) {
    m->prescribe(cap, {v * std::min(1.0, k / 20.0), 0, 0}, {}, held);
    double mean = 0;
    for (int s = 0; s < 40; ++s) {
      m->run(0.0001);
      mean -= m->step_sums.contact_force[cap].x / 40;
    }
    force = mean;
    curve.add(1e3 * (position_of(*m, cap).x - x0), 1e-3 * force);
  }
  const double u = position_of(*m, cap).x - x0;
  // From the displacement at which half of the joint is open.
  const double begin = 2 * load * h0 / (kn * depth * 0.25 * width * width);
  return {force,
          load * width * hinges / (2 * h0),
          expected(u),
          {reference("N (D/2 - c/3 - u)/H0, " + curve.name, 1e3 * begin, 1e3 * u,
                     [&](double mm) { return 1e-3 * expected(1e-3 * mm); }),
           curve}};
}
TEST(Pier, RockingStrength) {
  for (bool fixed_fixed : {false, true}) {
    std::vector<Curve> curves;
    for (double kn : {1e10, 1e11}) {
      const Pier p = pier(fixed_fixed, kn);
      const std::string name = std::string("pier, ") + (fixed_fixed ? "fixed-fixed" : "cantilever") +
                               (kn < 5e10 ? ", kn 1e10" : ", kn 1e11");
      check(name + ": rocking force", p.expected, p.force, 0.015, "N",
            "N (D/2 - c/3 - u)/H0, joint of finite stiffness");
      check(name + ": against the rigid limit", p.ideal, p.force, kn < 5e10 ? 0.12 : 0.045, "N", "N D/(2 H0)");
      curves.insert(curves.end(), p.curves.begin(), p.curves.end());
    }
    write_figure(fixed_fixed ? "pier_fixed_fixed" : "pier_cantilever", "displacement of the cap, mm",
                 "lateral force, kN", curves);
  }
}

// Triplet: the middle brick is pushed out between two fixed ones under confinement; two joints share the force.
double triplet(double confinement, double c, double angle, double& residual) {
  Scene scene(joint("fracture_energy", {{"normal_stiffness", 8e10},
                                        {"shear_stiffness", 3.6e10},
                                        {"tensile_strength", 0.5 * c},
                                        {"cohesion", c},
                                        {"friction_angle", angle},
                                        {"fracture_energy_tension", 20.0},
                                        {"fracture_energy_shear", 150.0}}));
  const Vector size{0.2, 0.05, 0.1};
  const int low = scene.brick({0, 0, 0}, size, true), middle = scene.brick({0, 0.05, 0}, size),
            top = scene.brick({0, 0.1, 0}, size);
  (void)low;
  auto m = scene.model(local(0.8, 0.5));
  const double area = size.x * size.z;
  m->add(Pressure{top, 3, confinement, {}, {}, {}});
  m->prescribe(top, {}, {}, 0x3d);  // free along y only
  m->prescribe(middle, {}, {}, 0x3d);
  m->run(0.02);
  double peak = 0.0;
  const double v = 0.01;
  const double end = m->stepping.time + 0.15;
  while (m->stepping.time < end) {
    m->prescribe(middle, {v, 0, 0}, {}, 0x3d);
    run_steps(*m, 10);
    residual = -m->step_sums.contact_force[middle].x / (2 * area);
    peak = std::max(peak, residual);
  }
  return peak;
}
TEST(Triplet, RecoversCohesionAndFriction) {
  const double c = 0.3e6, angle = 35, mu = std::tan(angle * pi / 180);
  double peak[3], residual[3];
  const double sigma[3] = {0.2e6, 0.6e6, 1.0e6};
  for (int i = 0; i < 3; ++i) peak[i] = triplet(sigma[i], c, angle, residual[i]);
  Curve peaks{"peak"}, residuals{"after full decohesion"};
  for (int i = 0; i < 3; ++i)
    peaks.add(1e-6 * sigma[i], 1e-6 * peak[i]), residuals.add(1e-6 * sigma[i], 1e-6 * residual[i]);
  write_figure("triplet", "confinement, MPa", "shear strength, MPa",
               {reference("c + mu sigma", 0, 1.2, [&](double at) { return 1e-6 * c + mu * at; }),
                reference("mu sigma", 0, 1.2, [&](double at) { return mu * at; }), peaks, residuals});
  check("triplet: cohesion from the line through three confinements", c,
        peak[0] - (peak[2] - peak[0]) / (sigma[2] - sigma[0]) * sigma[0], 5e-3, "Pa");
  check("triplet: friction coefficient from the line", mu, (peak[2] - peak[0]) / (sigma[2] - sigma[0]), 5e-3, "-");
  for (int i = 0; i < 3; ++i) {
    check("triplet: residual strength at " + std::to_string(sigma[i] / 1e6).substr(0, 3) + " MPa", mu * sigma[i],
          residual[i], 2e-3, "Pa", "mu sigma, after full decohesion");
  }
}

// Semicircular arch of dry voussoirs under its weight: stands if thickness / mean radius is above 0.1075.
bool arch_stands(double ratio, int voussoirs, double kn, Curve& settlement) {
  Scene scene(dry_joint(kn, kn, 50));
  const double radius = 1.0, t = ratio * radius, depth = 0.2;
  const double step = pi / voussoirs;
  const auto wedge = [&](double a0, double a1) {
    std::vector<Vector> p;
    for (double a : {a0, a1}) {
      for (double r : {radius - t / 2, radius + t / 2}) {
        for (double z : {0.0, depth}) p.push_back({r * std::cos(a), r * std::sin(a), z});
      }
    }
    return geometry::from_vertices(p, "voussoir");
  };
  scene.block(wedge(-step, 0), true);
  for (int i = 0; i < voussoirs; ++i) scene.block(wedge(step * i, step * (i + 1)));
  scene.block(wedge(pi, pi + step), true);
  auto m = scene.model(local(0.5, 0.6));
  const int crown = 1 + voussoirs / 2;
  const double y0 = position_of(*m, crown).y;
  for (int k = 0; k < 40; ++k) {
    apply_weight(*m, 0.2, 0.05 * (k + 1));  // the ramp avoids vibration
    settlement.add(m->stepping.time, 1e3 * (y0 - position_of(*m, crown).y));
    if (y0 - position_of(*m, crown).y > 0.05 * radius) return false;
  }
  // true at rest, false while it still sinks
  return norm(velocity_of(*m, crown)) < 1e-4;
}
TEST(Arch, LeastThickness) {
  Curve stands{"t/R = 0.112"}, falls{"t/R = 0.102"};
  const bool thick = arch_stands(0.112, 36, 1e11, stands), thin = arch_stands(0.102, 36, 1e11, falls);
  write_figure("arch_least_thickness", "time, s", "settlement of the crown, mm", {stands, falls});
  EXPECT_TRUE(thick);
  EXPECT_FALSE(thin);
  check("semicircular arch: least thickness/radius, bracket 0.102 to 0.112", 0.1075, thick && !thin ? 0.107 : 0.0, 0.05,
        "-", "middle of the bracket");
}

// Dry-joint walls of Ferris and Tin-Loi: running bond of blocks 0.4 x 0.175 m, five wide, friction 0.65; the bottom
// course starts with a half block. A horizontal body force alpha * weight grows until the wall fails.
struct DryWall {
  double multiplier;      // multiplier at which the first block has moved by `mark`
  double slip_at_uplift;  // slip of the bottom course on the base when a joint first opens by 0.1 mm
  Curve path;             // multiplier over the largest displacement, mm
};
DryWall ferris_tin_loi(int courses, double rate, double kn, double start, bool head_friction = true,
                       double mark = 1e-2) {
  const double length = 0.4, height = 0.175, depth = 0.2;
  Scene scene(dry_joint(kn, 0.5 * kn, std::atan(0.65) * 180 / pi));
  scene.assembly.families.push_back(dry_joint(kn, 0.5 * kn, 0.0));
  if (!head_friction) {
    scene.assembly.family_of = [](const Meeting& meet) { return std::abs(meet.normal.x) > 0.9 ? 1 : 0; };
  }
  scene.brick({-1, -0.2, 0}, {4, 0.2, depth}, true);
  std::vector<int> bottom;
  for (int c = 0; c < courses; ++c) {
    const bool halves = c % 2 == 0;
    for (double x = 0, width; x < 2.0 - 1e-9; x += width) {
      width = halves && (x < 1e-9 || x > 2.0 - 0.3) ? length / 2 : length;
      const int b = scene.brick({x, c * height, 0}, {width, height, depth});
      if (c == 0) bottom.push_back(b);
    }
  }
  auto m = scene.model(viscous(2.0, 1e-4, 0.6));
  apply_weight(*m, 0.2, 0.4);
  std::vector<Vector> rest;
  for (int i = 0; i < m->block_count(); ++i) rest.push_back(position_of(*m, i));
  double alpha = 0.0, slip_at_uplift = -1;
  Curve path{"measured"};
  // fast up to `start`, then at the given rate
  while (alpha < 1.0) {
    alpha += (alpha < start ? 0.2 : rate) * 0.002;
    m->set_gravity({alpha * gravity, -gravity, 0});
    m->run(0.002);
    double moved = 0;
    for (int i = 1; i < m->block_count(); ++i) moved = std::max(moved, norm(position_of(*m, i) - rest[i]));
    if (alpha > 0.45) path.add(1e3 * moved, alpha);
    if (slip_at_uplift < 0) {
      double opened = 0;
      for (size_t k = 0; k < m->contacts.list.size(); ++k) {
        const Contact& c = m->contacts.list[k];
        if (c.count == 0 || std::abs(m->contacts.place[k].separation.normal.y) < 0.9) continue;
        for (uint32_t i = c.first; i < c.first + c.count; ++i)
          opened = std::max(opened, m->contacts.families[c.family].normal_jump[i]);
      }
      if (opened > 1e-4) {
        slip_at_uplift = 0;
        for (int b : bottom) slip_at_uplift = std::max(slip_at_uplift, std::abs(position_of(*m, b).x - rest[b].x));
      }
    }
    if (moved > mark) break;
  }
  return {alpha, slip_at_uplift, path};
}
TEST(DryWalls, FerrisTinLoiWall2) {
  const DryWall w = ferris_tin_loi(10, 0.02, 1e10, 0.54);
  check("Ferris and Tin-Loi wall 2 (5 x 10): multiplier, 0.02 /s, kn 1e10", 0.5675, w.multiplier, 0.0175 / 0.5675, "-",
        "0.55 to 0.585");
  write_figure("dry_wall", "largest displacement of a block, mm", "multiplier of the horizontal force, -",
               {{"limit analysis, associated: 0.580", CurveKind::reference, {{0, 0.580}, {10, 0.580}}}, w.path});
  check_error("Ferris and Tin-Loi wall 2: base slip before uplift", w.slip_at_uplift, 1e-3, "m");
}
TEST(DryWalls, DISABLED_FerrisTinLoiConvergence) {
  Curve measured[2] = {{"wall 1, kn 1e10 Pa/m"}, {"wall 2, kn 1e10 Pa/m"}};
  for (double kn : {2e9, 1e10, 5e10}) {
    for (double rate : {0.04, 0.02, 0.01, 0.005}) {
      if (kn != 1e10 && rate != 0.02) continue;
      for (int courses : {10, 6}) {
        const DryWall w = ferris_tin_loi(courses, rate, kn, courses == 10 ? 0.5 : 0.58);
        char name[120];
        std::snprintf(name, sizeof name, "Ferris and Tin-Loi wall %d: multiplier, %g /s, kn %.0e",
                      courses == 10 ? 2 : 1, rate, kn);
        check(name, courses == 10 ? 0.580 : 0.643, w.multiplier, 0.05, "-", "linear programming, associated");
        if (kn == 1e10) measured[courses == 10].add(rate, w.multiplier);
      }
    }
  }
  write_figure("dry_wall_rate", "rate of the multiplier, 1/s", "multiplier at 10 mm, -",
               {{"wall 1, limit analysis: 0.643", CurveKind::reference, {{0, 0.643}, {0.04, 0.643}}},
                {"wall 2, limit analysis: 0.580", CurveKind::reference, {{0, 0.580}, {0.04, 0.580}}},
                measured[0],
                measured[1]});
}

}  // namespace
}  // namespace quoin::verification
