// Shared by the verification cases: short functions that build models, and the table of results.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "../stepped_model.h"
#include "model/world_results.h"

namespace quoin::verification {

using namespace quoin::blocks;
using blocks::Assembly;  // not the one of bricks
using Model = SteppedModel;
using geometry::box;
using geometry::ConvexPolyhedron;
using geometry::cross;
using geometry::dot;
using geometry::norm;
using geometry::normalized;
constexpr double pi = std::numbers::pi;
constexpr double gravity = 9.81;

// Adds a line to the verification table. The test fails when |measured - expected| > tolerance * scale, with scale =
// |expected| or, where that is 0, `scale`. Lines are written to standard output and to
// verification_records/SUITE.TEST.csv in the working folder, from which manual/verification.py makes pages.
void check(const std::string& what, double expected, double measured, double tolerance, const std::string& unit,
           const std::string& note = "", double scale = 0.0);
// Compares an error without a single expected value (a drift, an imbalance) with its bound.
void check_error(const std::string& what, double error, double bound, const std::string& unit,
                 const std::string& note = "");

// A curve of a figure, in the units of its axes.
enum class CurveKind { reference, measured };
struct Curve {
  std::string name;
  CurveKind kind = CurveKind::measured;
  std::vector<std::array<double, 2>> points{};  // x, y
  void add(double x, double y) { points.push_back({x, y}); }
};
// Returns y(x) at 201 positions between `from` and `to`.
Curve reference(const std::string& name, double from, double to, const std::function<double(double)>& y);
// Writes verification_records/NAME.figure.csv, the figure on the page of the running test. A curve has at most 200 of
// its points.
void write_figure(const std::string& name, const std::string& x, const std::string& y,
                  const std::vector<Curve>& curves);

// Runs until a time, s. The weight grows linearly from 0 over `ramp`, s. down: unit vector.
inline void apply_weight(Model& m, double ramp, double until, const geometry::Vector& down = {0, -1, 0}) {
  for (; m.stepping.time < until - 0.5 * m.stepping.dt; m.step())
    m.set_gravity(gravity * std::min(1.0, m.stepping.time / ramp) * down);
}
inline void run_steps(Model& m, long steps) {
  for (long i = 0; i < steps; ++i) m.step();
}
// Fix a gridpoint of a deformable block along the axes of bits 0..2 of `held`, or prescribe its velocity, m/s.
inline void hold_node(Model& m, int node, uint8_t held) { m.nodes.held[node] = held, m.pieces.any_held_changed = true; }
inline void hold_velocity(Model& m, int node, const geometry::Vector& v) {
  m.nodes.held_v[node] = v, m.pieces.any_held_changed = true;
}

// Energies of a run over time, and the external work.
struct EnergyCurves {
  Curve work{"work of weight and supports", CurveKind::reference}, kinetic{"kinetic"}, lost{"joints and damping"},
      sum{"sum of all"};  // J over s
  void add(const Model& m);
  void write(const std::string& figure) const;
};

JointFamily elastic_joint(double kn, double ks);
// Dry friction: no tension, no cohesion, from the shipped law coulomb_slip.
JointFamily dry_joint(double kn, double ks, double friction_angle_degrees);
// Returns weak lime mortar that softens and has a residual compressive strength.
JointFamily mortar(const std::string& initial_state);
JointFamily joint(const std::string& law, std::vector<std::pair<std::string, double>> properties);

SolverSettings undamped(double fraction = 0.5);
SolverSettings local(double gamma = 0.8, double fraction = 0.5);
SolverSettings viscous(double mass, double stiffness, double fraction = 0.5);

struct Scene {
  Assembly assembly;
  explicit Scene(JointFamily family, double density = 2000, double young = 10e9, double poisson = 0.2);
  // Adds a rigid box with lower corner and size, m.
  int brick(const Vector& lower, const Vector& size, bool fixed = false, const Quaternion& turn = {});
  int block(const ConvexPolyhedron& shape, bool fixed = false);
  int soft(const Vector& lower, const Vector& size, std::array<int, 3> divisions);
  std::unique_ptr<Model> model(const SolverSettings& solver) const { return std::make_unique<Model>(assembly, solver); }
};

// Reads a scene from text. Throws Error as read_scene does.
quoin::Scene scene_of(const std::string& toml);
// Returns the beginning of a scene: the material stone (Young's modulus in Pa), its dry joints, viscous damping, and a
// fixed ground of 60 by 60 m.
std::string stone_and_ground(double young_modulus);

// Runs until the kinetic energy is below `ratio` of its largest value so far, at most `most` steps.
void settle(Model& m, double ratio = 1e-10, long most = 200000);

}  // namespace quoin::verification
