// Positions of beams: their nodes along a line, and the blocks that support them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "members/beam.h"
#include "scene/generate_blocks.h"

namespace quoin::members {

namespace {

constexpr double kSame = 1e-6;  // distance in m below which points are the same

Section section_of(const BeamSpec& spec) {
  const double shear = spec.young_modulus / (2.0 * (1.0 + spec.poisson_ratio));
  Section s;
  s.axial = spec.young_modulus * spec.area, s.torsion = shear * spec.torsion;
  for (std::size_t c = 0; c < 2; ++c) {
    s.bending[c] = spec.young_modulus * spec.inertia[c];
    s.shear_area[c] = shear * spec.shear_area[c];
  }
  s.mass = spec.density * spec.area, s.polar = spec.density * (spec.inertia[0] + spec.inertia[1]);
  s.yield_force = spec.yield_force, s.yield_moment = spec.yield_moment;
  s.compression = spec.compression;
  return s;
}

// Positions of nodes, at most `spacing` apart, with nodes at corners of the line and at supports.
std::vector<Vector> places_along(const BeamSpec& spec) {
  std::vector<Vector> nodes{geometry::vector(spec.points.front())};
  std::vector<bool> found(spec.supports.size());
  for (std::size_t k = 0; k + 1 < spec.points.size(); ++k) {
    const Vector from = geometry::vector(spec.points[k]), to = geometry::vector(spec.points[k + 1]);
    const double length = norm(to - from);
    std::vector<double> stops{length};
    for (std::size_t i = 0; i < spec.supports.size(); ++i) {
      const Vector at = geometry::vector(spec.supports[i].point) - from;
      const double way = dot(at, to - from) / length;
      if (norm(at - (way / length) * (to - from)) > kSame || way < -kSame || way > length + kSame) continue;
      found[i] = true;
      if (way > kSame && way < length - kSame) stops.push_back(way);
    }
    std::sort(stops.begin(), stops.end());
    double last = 0.0;
    for (const double stop : stops) {
      if (stop - last <= kSame) continue;
      const auto pieces = std::max(1, static_cast<int>(std::ceil((stop - last) / spec.spacing - 1e-9)));
      for (int i = 1; i <= pieces; ++i)
        nodes.push_back(from + ((last + (stop - last) * i / pieces) / length) * (to - from));
      last = stop;
    }
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i])
      throw Error(Exit::bad_input,
                  fmt::format("{}: the support at {} is not on the line of beam '{}'; allowed: a point "
                              "of it, to {:g} m",
                              spec.supports[i].source.text, geometry::place(geometry::vector(spec.supports[i].point)),
                              spec.name, kSame));
  }
  return nodes;
}

// Face of a block in space: outward normal and corners.
struct Face {
  Vector normal;
  std::vector<Vector> corners;
};

// The face of a block that is nearest to a point of a piece. On an edge it is the face along the piece, then the one
// towards its `up`.
Face nearest_face(const blocks::Assembly& assembly, int block, const Vector& point, const Beam::Piece& piece) {
  const blocks::Block& b = assembly.blocks[static_cast<std::size_t>(block)];
  const geometry::ConvexPolyhedron& shape = assembly.shapes[static_cast<std::size_t>(b.shape)];
  const geometry::Matrix turned = matrix(b.orientation);
  const Vector own = transposed_times(turned, point - b.position);
  constexpr double kSlope = 1e-6;  // difference of cosines below which directions are the same
  double nearest = -1e300;
  std::size_t found = 0;
  const auto lies_better = [&](const Vector& other) {
    const Vector normal = turned * shape.normals[found];
    const auto cosine = [&](const Vector& n, int column) { return std::abs(dot(n, piece.frame.column(column))); };
    const double across = cosine(other, 0) - cosine(normal, 0);
    return across < -kSlope || (across <= kSlope && cosine(other, 1) > cosine(normal, 1) + kSlope);
  };
  for (std::size_t f = 0; f < shape.faces.size(); ++f) {
    const double off = dot(shape.normals[f], own - shape.vertices[static_cast<std::size_t>(shape.faces[f].front())]);
    if (off > nearest + kSame || (off > nearest - kSame && lies_better(turned * shape.normals[f])))
      nearest = std::max(nearest, off), found = f;
  }
  Face face{turned * shape.normals[found], {}};
  for (const int corner : shape.faces[found])
    face.corners.push_back(b.position + turned * shape.vertices[static_cast<std::size_t>(corner)]);
  return face;
}

// Way from a point on a face to each of its edges.
std::vector<Beam::ToEdge> ways_to_edges(const Face& face, const Vector& point) {
  std::vector<Beam::ToEdge> ways;
  for (std::size_t i = 0; i < face.corners.size(); ++i) {
    const Vector& corner = face.corners[i];
    const Vector out = normalized(cross(face.corners[(i + 1) % face.corners.size()] - corner, face.normal));
    ways.push_back({out, dot(corner - point, out)});
  }
  return ways;
}

// Points at which a block holds a built-in node. They lie about it as corners of the block do about their mean, at half
// the distance. So forces at the node do not turn it. Some may lie outside; there a deformable block moves on linearly.
std::vector<Vector> grips(const blocks::Assembly& assembly, int block, const Vector& point) {
  const blocks::Block& b = assembly.blocks[static_cast<std::size_t>(block)];
  const std::vector<Vector>& corners = assembly.shapes[static_cast<std::size_t>(b.shape)].vertices;
  const Vector mean = std::accumulate(corners.begin(), corners.end(), Vector{}) / static_cast<double>(corners.size());
  std::vector<Vector> at;
  for (const Vector& corner : corners) at.push_back(point + 0.5 * (matrix(b.orientation) * (corner - mean)));
  return at;
}

void hold(Beam& beam, int place, int block, const BeamSpec& spec, const std::string& how, Placing& placing) {
  const Vector at = beam.nodes()[static_cast<std::size_t>(place)];
  const std::vector<Vector> points = how == "built_in" ? grips(placing.assembly, block, at) : std::vector<Vector>{at};
  const double whole =
      spec.support_stiffness > 0.0 ? spec.support_stiffness : beam.section().axial / beam.piece_at(place);
  for (const Vector& point : points) {
    Beam::Support support;
    support.place = place, support.node = placing.add(block, point);
    const Beam::Piece& piece = beam.pieces()[std::min(static_cast<std::size_t>(place), beam.pieces().size() - 1)];
    const Face face = nearest_face(placing.assembly, block, at, piece);
    support.arm = point - at, support.out = face.normal;
    support.rests = how == "resting";
    support.law.normal = support.law.shear = whole / static_cast<double>(points.size());
    support.law.tension = !support.rests;
    if (support.rests) support.law.friction = spec.friction;
    if (support.rests) beam.seats().push_back({beam.supports().size(), ways_to_edges(face, at)});
    beam.supports().push_back(support);
  }
}

}  // namespace

Beam placed(const BeamSpec& spec, Placing& placing) {
  Beam beam(spec.name, places_along(spec), geometry::vector(spec.up), section_of(spec));
  std::vector<bool> held(beam.nodes().size());
  for (const BeamSupportSpec& support : spec.supports) {
    const Vector point = geometry::vector(support.point);
    const auto closer = [&](const Vector& a, const Vector& b) { return norm(a - point) < norm(b - point); };
    const auto place =
        static_cast<int>(std::min_element(beam.nodes().begin(), beam.nodes().end(), closer) - beam.nodes().begin());
    const int block = placing.block_of({support.block, support.point, {}, support.source});
    hold(beam, place, block, spec, support.hold, placing);
    held[static_cast<std::size_t>(place)] = true;
  }
  for (std::size_t k = 0; spec.bedding != "none" && k < held.size(); ++k) {
    double off = 0.0;
    const int block = held[k] ? -1 : placing.block_at(beam.nodes()[k], &off);
    if (block >= 0) hold(beam, static_cast<int>(k), block, spec, spec.bedding, placing);
  }
  if (beam.supports().empty())
    throw Error(
        Exit::bad_input,
        fmt::format("{}: beam '{}' from {} to {} is held by no block; give it [[beam.support]], or bedding with "
                    "nodes in or on blocks",
                    spec.source.text, spec.name, geometry::place(beam.nodes().front()),
                    geometry::place(beam.nodes().back())));
  return beam;
}

std::vector<std::string> column_names(const BeamSpec& spec) {
  return {fmt::format("beam_{}_N", spec.name), fmt::format("beam_{}_Nm", spec.name),
          fmt::format("beam_{}_hinge_rad", spec.name)};
}

}  // namespace quoin::members
