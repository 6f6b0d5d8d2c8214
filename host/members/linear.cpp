#include "members/linear.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "members/members.h"

namespace quoin::members {

namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// Axial strains at both edges of a panel are coupled by the integration in floor.cpp; shear is not.
void add_panel(const Floor& floor, int first, int i, int j, std::vector<Deformation>* out) {
  const Floor::Grid& grid = floor.grid();
  const Membrane& membrane = floor.membrane();
  const double a = grid.size[0] / grid.pieces[0], b = grid.size[1] / grid.pieces[1];
  const int low = first + floor.place_at(i, j), right = low + 1, high = first + floor.place_at(i, j + 1);
  const auto stretch = [&](int from, int to, const Vector& way, double stiffness, bool second) {
    Deformation d;
    d.shares = {{true, from, -1.0 * way, {}}, {true, to, way, {}}};
    d.stiffness = stiffness / 3.0, d.coupling = second ? stiffness / 6.0 : 0.0;
    out->push_back(d);
  };
  stretch(low, right, grid.along, membrane.along * b / a, false);
  stretch(high, high + 1, grid.along, membrane.along * b / a, true);
  stretch(low, high, grid.across, membrane.across * a / b, false);
  stretch(right, high + 1, grid.across, membrane.across * a / b, true);
  // The deformation is the mean shear strain times the area, so that its force is the shear flow.
  const Vector along = 0.5 * a * grid.along, across = 0.5 * b * grid.across;
  Deformation shear;
  shear.shares = {{true, low, -1.0 * along - across, {}},
                  {true, right, across - along, {}},
                  {true, high + 1, along + across, {}},
                  {true, high, along - across, {}}};
  shear.stiffness = membrane.shear / (a * b);
  shear.low = -membrane.shear_yield, shear.high = membrane.shear_yield, shear.what = "shear_N_per_m";
  out->push_back(shear);
}

void add_connector(const Floor& floor, int first, const Floor::Connector& c, double weight,
                   std::vector<Deformation>* out) {
  const Floor::Grid& grid = floor.grid();
  const ConnectorLaw& law = floor.law();
  const Vector away = c.out.along * grid.along + c.out.across * grid.across;
  const Vector edge = c.out.along * grid.across - c.out.across * grid.along;
  const int place = first + c.place;
  Deformation open;
  open.shares = {{true, place, -1.0 * away, {}}, {false, c.node, away, {}}};
  open.stiffness = law.axial * c.length;
  open.low = law.bearing ? -kUnbounded : 0.0, open.high = law.axial_strength * c.length;
  open.what = "anchor_N_per_m", open.over = c.length;
  out->push_back(open);
  if (!(law.shear > 0.0)) return;
  Deformation slip;
  slip.shares = {{true, place, -1.0 * edge, {}}, {false, c.node, edge, {}}};
  slip.stiffness = law.shear * c.length;
  slip.high = law.shear_strength * c.length + law.friction * weight * c.carried, slip.low = -slip.high;
  slip.what = "connector_shear_N_per_m", slip.over = c.length;
  out->push_back(slip);
}

void add_floor(const Floor& floor, const Vector& gravity, LinearMembers* out) {
  const Floor::Grid& grid = floor.grid();
  const auto& [n, m] = grid.pieces;
  OwnBody body{
      fmt::format("floor '{}'", floor.name()), static_cast<int>(out->nodes.size()), 0, out->deformations.size(), 0, {}};
  const Vector normal = cross(grid.along, grid.across);
  const double mass = floor.membrane().mass, load = floor.membrane().load / kGravityOfLoads;  // kg/m2
  const Vector in_plane = gravity - dot(gravity, normal) * normal;
  for (int place = 0; place < (n + 1) * (m + 1); ++place) {
    const double area = floor.share_of(place);
    out->nodes.push_back(
        {floor.start_of(place), mass * area, 0.0, {grid.along, grid.across}, {}, load * area * in_plane});
  }
  body.end = static_cast<int>(out->nodes.size());
  for (int j = 0; j < m; ++j) {
    for (int i = 0; i < n; ++i) {
      add_panel(floor, body.first, i, j, &out->deformations);
      body.faces.push_back(
          {floor.place_at(i, j), floor.place_at(i + 1, j), floor.place_at(i + 1, j + 1), floor.place_at(i, j + 1)});
    }
  }
  for (const Floor::Connector& c : floor.connectors()) {
    const double along = dot(gravity, normal);
    add_connector(floor, body.first, c, (mass + load) * std::abs(along), &out->deformations);
    out->carried.push_back({c.node, mass * c.carried, normal, load * c.carried * along * normal});
  }
  body.end_deformation = out->deformations.size();
  out->bodies.push_back(body);
}

// Rotations of the ends of a piece relative to its chord, and their moments, by Timoshenko's beam.
void add_bending(const Section& section, const Beam::Piece& piece, int plane, int first,
                 std::vector<Deformation>* out) {
  const auto p = static_cast<std::size_t>(plane);
  const double l = piece.length, ei = section.bending[p];
  const double phi = std::isfinite(section.shear_area[p]) ? 12.0 * ei / (section.shear_area[p] * l * l) : 0.0;
  const Vector side = piece.frame.column(plane == 0 ? 2 : 1), along = piece.frame.column(0);
  const Vector chord = cross(side, along) / l;  // rotation of the chord per displacement of the far end
  for (int end = 0; end < 2; ++end) {
    Deformation d;
    d.shares = {{true, first, chord, end == 0 ? side : Vector{}},
                {true, first + 1, -1.0 * chord, end == 1 ? side : Vector{}}};
    d.stiffness = ei / l * (4.0 + phi) / (1.0 + phi);
    d.coupling = end == 1 ? ei / l * (2.0 - phi) / (1.0 + phi) : 0.0;
    d.low = -section.yield_moment[p], d.high = section.yield_moment[p];
    d.what = plane == 0 ? "moment_up_Nm" : "moment_side_Nm";
    out->push_back(d);
  }
}

void add_piece(const Beam& beam, std::size_t i, int first, std::vector<Deformation>* out) {
  const Section& section = beam.section();
  const Beam::Piece& piece = beam.pieces()[i];
  const int from = first + static_cast<int>(i);
  const Vector along = piece.frame.column(0);
  Deformation axial;
  axial.shares = {{true, from, -1.0 * along, {}}, {true, from + 1, along, {}}};
  axial.stiffness = section.axial / piece.length;
  axial.low = section.compression ? -section.yield_force : 0.0, axial.high = section.yield_force;
  axial.what = "force_N";
  out->push_back(axial);
  if (section.torsion > 0.0) {
    Deformation twist;
    twist.shares = {{true, from, {}, -1.0 * along}, {true, from + 1, {}, along}};
    twist.stiffness = section.torsion / piece.length;
    out->push_back(twist);
  }
  for (int plane = 0; plane < 2; ++plane) add_bending(section, piece, plane, from, out);
}

void add_support(const Beam::Support& s, int first, LinearMembers* out) {
  if (s.rests) {
    out->rests.push_back({first + s.place, s.node, s.law.normal, s.out, s.law.friction});
    return;
  }
  for (const Vector& axis : {Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, 1}}) {
    Deformation d;
    d.shares = {{true, first + s.place, -1.0 * axis, -1.0 * cross(s.arm, axis)}, {false, s.node, axis, {}}};
    d.stiffness = s.law.normal;
    out->deformations.push_back(d);
  }
}

// Axes about which a node turns. Without torsional stiffness, a straight line does not turn about itself, unless a
// support holds it.
std::vector<Vector> turns_of(const Beam& beam, std::size_t node) {
  const std::vector<Beam::Piece>& pieces = beam.pieces();
  const geometry::Matrix& before = pieces[node > 0 ? node - 1 : 0].frame;
  const geometry::Matrix& after = pieces[std::min(node, pieces.size() - 1)].frame;
  constexpr double kParallel = 1e-9;
  bool turns = beam.section().torsion > 0.0 || norm(cross(before.column(0), after.column(0))) > kParallel;
  for (const Beam::Support& s : beam.supports())
    turns = turns || (s.place == static_cast<int>(node) && norm(s.arm) > 0.0);
  std::vector<Vector> about{before.column(1), before.column(2)};
  if (turns) about.push_back(before.column(0));
  return about;
}

void add_beam(const Beam& beam, LinearMembers* out) {
  OwnBody body{
      fmt::format("beam '{}'", beam.name()), static_cast<int>(out->nodes.size()), 0, out->deformations.size(), 0, {}};
  const std::size_t count = beam.nodes().size();
  for (std::size_t k = 0; k < count; ++k) {
    double half = 0.0;  // length of the node, m
    if (k > 0) half += 0.5 * beam.pieces()[k - 1].length;
    if (k + 1 < count) half += 0.5 * beam.pieces()[k].length;
    out->nodes.push_back({beam.nodes()[k],
                          beam.section().mass * half,
                          beam.section().polar * half,
                          {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                          turns_of(beam, k),
                          {}});
  }
  body.end = static_cast<int>(out->nodes.size());
  for (std::size_t i = 0; i + 1 < count; ++i) {
    add_piece(beam, i, body.first, &out->deformations);
    const auto from = static_cast<int>(i);
    body.faces.push_back({from, from + 1, from});
  }
  for (const Beam::Support& s : beam.supports()) add_support(s, body.first, out);
  body.end_deformation = out->deformations.size();
  out->bodies.push_back(body);
}

}  // namespace

LinearMembers linear_of(const Members& members, const std::string& file, const Vector& gravity) {
  LinearMembers out;
  for (const Floor& floor : members.floors()) add_floor(floor, gravity, &out);
  for (const Beam& beam : members.beams()) {
    if (!(beam.section().bending[0] > 0.0 && beam.section().bending[1] > 0.0))
      throw Error(Exit::bad_input,
                  fmt::format("{}: beam '{}' does not bend both ways (inertia), so nothing holds its line before "
                              "it sags; give inertia, or a [[tie]] in its place",
                              file, beam.name()));
    add_beam(beam, &out);
  }
  return out;
}

}  // namespace quoin::members
