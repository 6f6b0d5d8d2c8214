// Positions of strips: nodes on faces along the line in a scene.
#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "members/strip.h"
#include "scene/generate_blocks.h"

namespace quoin::members {

namespace {

// Tolerance of a strip's distance from its face, over the block's largest extent: scenes have rounded coordinates.
constexpr double kOffFace = 2e-3;

struct OnFace {
  int block = -1;
  Vector normal;       // outward, in space
  double off = 1e300;  // m
};

// Distance of a point from the planes of a block's faces, m; > 0 in front.
std::vector<double> in_front_of(const geometry::ConvexPolyhedron& shape, const Vector& own) {
  std::vector<double> distance;
  for (std::size_t f = 0; f < shape.faces.size(); ++f) {
    const Vector& on_face = shape.vertices[static_cast<std::size_t>(shape.faces[f].front())];
    distance.push_back(dot(shape.normals[f], own - on_face));
  }
  return distance;
}

// The face of any block at a point; at an edge, the face along which the strip runs.
OnFace face_at(const blocks::Assembly& assembly, const Vector& point, const Vector& along) {
  OnFace best;
  for (std::size_t i = 0; i < assembly.blocks.size(); ++i) {
    const blocks::Block& b = assembly.blocks[i];
    const geometry::ConvexPolyhedron& shape = assembly.shapes[static_cast<std::size_t>(b.shape)];
    const geometry::Matrix turned = matrix(b.orientation);
    const std::vector<double> distance = in_front_of(shape, transposed_times(turned, point - b.position));
    const double outside = *std::max_element(distance.begin(), distance.end());
    const double extent = geometry::longest_extent(shape.vertices), off = std::abs(outside) / extent;
    if (off >= best.off) continue;
    best = {static_cast<int>(i), {}, off};
    double across = 1e300;
    for (std::size_t f = 0; f < distance.size(); ++f) {
      const Vector normal = turned * shape.normals[f];
      if (distance[f] < outside - kOffFace * extent || std::abs(dot(normal, along)) >= across) continue;
      across = std::abs(dot(normal, along)), best.normal = normal;
    }
  }
  return best;
}

}  // namespace

Strip placed(const StripSpec& spec, Placing& placing) {
  const blocks::Assembly& assembly = placing.assembly;
  const auto family = std::find_if(assembly.families.begin(), assembly.families.end(),
                                   [&](const JointFamily& f) { return f.name == spec.joint; });
  std::vector<Strip::Place> places;
  for (std::size_t k = 0; k + 1 < spec.points.size(); ++k) {
    const Vector from = geometry::vector(spec.points[k]), to = geometry::vector(spec.points[k + 1]);
    const double length = norm(to - from);
    const auto pieces = static_cast<int>(std::ceil(length / spec.spacing - 1e-9));
    for (int i = 0; i < pieces; ++i) {
      Strip::Place place;
      place.at = from + ((i + 0.5) / pieces) * (to - from);
      const OnFace on = face_at(assembly, place.at, normalized(to - from));
      constexpr double kSteepest = 0.5;  // largest sine of the angle between a strip and its face
      if (!(on.off <= kOffFace) || std::abs(dot(on.normal, normalized(to - from))) > kSteepest)
        throw Error(Exit::bad_input,
                    fmt::format("{}: strip '{}' leaves the masonry at {}: the nearest face is that of block {}; its "
                                "points are to lie on faces",
                                spec.source.text, spec.name, geometry::place(place.at), label(assembly, on.block)));
      place.normal = on.normal;
      place.along = normalized((to - from) - dot(to - from, on.normal) * on.normal);
      place.area = spec.width * length / pieces;
      place.node = placing.add(on.block, place.at, true);
      places.push_back(place);
    }
  }
  if (places.size() < 2)
    throw Error(Exit::bad_input, fmt::format("{}: strip '{}' has one node; allowed: a spacing of at most half of its "
                                             "length",
                                             spec.source.text, spec.name));
  const double area = spec.width * spec.thickness;
  return Strip(spec.name, std::move(places),
               Strip::Fibres{spec.young_modulus * area, spec.strength * area, spec.compression},
               std::make_shared<const Material>(Law::find(family->law), family->properties), family->initial_state);
}

std::vector<std::string> column_names(const StripSpec& spec) {
  return {fmt::format("strip_{}_N", spec.name), fmt::format("strip_{}_debonded_m", spec.name)};
}

}  // namespace quoin::members
