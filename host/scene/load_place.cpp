#include "scene/load_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "scene/generate_blocks.h"

namespace quoin::blocks {

namespace {

using geometry::Vector;

constexpr double kNever = 1e300;

// Distance along a ray to its entry into a block, m; 0 from inside, kNever where the ray misses it.
double way_to(const Assembly& assembly, const Block& block, const Vector& from, const Vector& direction) {
  const geometry::ConvexPolyhedron& shape = assembly.shapes[static_cast<std::size_t>(block.shape)];
  const geometry::Matrix turned = matrix(block.orientation);
  const Vector own = transposed_times(turned, from - block.position), along = transposed_times(turned, direction);
  double enters = 0.0, leaves = kNever;
  for (std::size_t f = 0; f < shape.faces.size(); ++f) {
    const Vector& on_face = shape.vertices[static_cast<std::size_t>(shape.faces[f].front())];
    const double off = dot(shape.normals[f], own - on_face), closing = -dot(shape.normals[f], along);
    constexpr double kParallel = 1e-12;
    if (std::abs(closing) < kParallel) {
      if (off > 0.0) return kNever;
    } else if (closing > 0.0) {
      enters = std::max(enters, off / closing);
    } else {
      leaves = std::min(leaves, off / closing);
    }
  }
  return enters <= leaves ? enters : kNever;
}

}  // namespace

Vector centre_of(const Assembly& assembly, int block) {
  const Block& b = assembly.blocks[static_cast<std::size_t>(block)];
  if (b.centre) return *b.centre;
  return b.position +
         matrix(b.orientation) * mass_properties(assembly.shapes[static_cast<std::size_t>(b.shape)]).centroid;
}

double distance_from(const Assembly& assembly, const Block& block, const Vector& point) {
  const geometry::ConvexPolyhedron& shape = assembly.shapes[static_cast<std::size_t>(block.shape)];
  const Vector own = transposed_times(matrix(block.orientation), point - block.position);
  double distance = -kNever;
  for (std::size_t f = 0; f < shape.faces.size(); ++f) {
    const Vector& on_face = shape.vertices[static_cast<std::size_t>(shape.faces[f].front())];
    distance = std::max(distance, dot(shape.normals[f], own - on_face));
  }
  return distance;
}

int block_at(const Assembly& assembly, const std::string& name, const Vector& point, const std::string& where) {
  const std::vector<int> named = find_blocks(assembly, name, where);
  return *std::ranges::min_element(named, {}, [&](int block) {
    return distance_from(assembly, assembly.blocks[static_cast<std::size_t>(block)], point);
  });
}

int face_towards(const Assembly& assembly, int block, const Vector& normal, const std::string& where) {
  const Block& of = assembly.blocks[static_cast<std::size_t>(block)];
  const std::vector<Vector>& normals = assembly.shapes[static_cast<std::size_t>(of.shape)].normals;
  const Vector along = transposed_times(matrix(of.orientation), normal);
  const auto face = std::ranges::max_element(normals, {}, [&](const Vector& of_face) { return dot(along, of_face); });
  constexpr double kSame = 1e-6;  // difference of cosines below which directions are the same
  const auto other = std::ranges::find_if(normals, [&](const Vector& of_face) {
    return dot(along, *face - of_face) < kSame * norm(along) && dot(*face, of_face) < 1.0 - kSame;
  });
  if (other != normals.end()) {
    const auto in_space = [&](const Vector& of_face) { return geometry::place(matrix(of.orientation) * of_face); };
    throw Error(
        Exit::bad_input,
        fmt::format("{}: normal: two faces of block {} are equally close to {}, with the normals {} and {}; give "
                    "the one that is meant",
                    where, label(assembly, block), geometry::place(normal), in_space(*face), in_space(*other)));
  }
  return static_cast<int>(face - normals.begin());
}

std::vector<BlockFace> outer_faces(const Assembly& assembly, const std::string& name, const Vector& towards,
                                   const std::string& where) {
  const Vector normal = normalized(towards);
  constexpr double kTolerance = 1e-6;  // m, rounding of places
  std::vector<BlockFace> outer;
  double furthest = -kNever;
  for (const int index : find_blocks(assembly, name, where)) {
    const Block& block = assembly.blocks[static_cast<std::size_t>(index)];
    const geometry::ConvexPolyhedron& shape = assembly.shapes[static_cast<std::size_t>(block.shape)];
    const Vector along = transposed_times(matrix(block.orientation), normal);
    double reach = -kNever;
    for (const Vector& vertex : shape.vertices) reach = std::max(reach, dot(along, vertex));
    reach += dot(normal, block.position);
    if (reach < furthest - kTolerance) continue;
    if (reach > furthest + kTolerance) outer.clear();
    furthest = std::max(furthest, reach);
    outer.push_back({index, face_towards(assembly, index, towards, where)});
  }
  return outer;
}

std::vector<LoadPlace> places_of(const MovingLoad& load, const Assembly& assembly, const std::string& where) {
  const Vector from = geometry::vector(load.from), to = geometry::vector(load.to);
  const Vector direction = normalized(geometry::vector(load.force));
  std::vector<LoadPlace> places;
  for (int k = 0; k < load.positions; ++k) {
    LoadPlace place;
    place.position = from + (load.positions > 1 ? static_cast<double>(k) / (load.positions - 1) : 0.0) * (to - from);
    double least = kNever;
    for (std::size_t b = 0; b < assembly.blocks.size(); ++b) {
      const double way = way_to(assembly, assembly.blocks[b], place.position, direction);
      if (way < least) least = way, place.block = static_cast<int>(b);
    }
    if (place.block < 0)
      throw Error(Exit::bad_input,
                  fmt::format("{}: moving_load meets no block from its position {} of {} at {}, along ({:.3g}, {:.3g}, "
                              "{:.3g}); move its line over the masonry",
                              where, k + 1, load.positions, geometry::place(place.position), direction.x, direction.y,
                              direction.z));
    place.at = place.position + least * direction;
    places.push_back(place);
  }
  return places;
}

}  // namespace quoin::blocks
