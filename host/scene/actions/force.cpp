// Forces at points of blocks.
#include "base/error.h"
#include "geometry/polyhedron.h"
#include "scene/actions/action.h"
#include "scene/load_place.h"

namespace quoin {

using namespace reader;

namespace {

void read_forces(Table& t, Stage& stage, const std::string&, const std::vector<std::string>& names) {
  t.each("force", [&](Table& f) {
    PointForce& added = stage.forces.emplace_back();
    read_block_name(f, added.block, names);
    f.numbers("point", added.point, kPlace, "m, where it acts at the start; it moves with the block", true);
    f.numbers("force", added.force, kAny, "N", true);
  });
}

std::string text_of_force(const Stage& stage) {
  std::string text;
  for (const PointForce& f : stage.forces)
    text += fmt::format("{}{} N at {} of {}", text.empty() ? "" : ", ", fmt::join(f.force, " "),
                        fmt::join(f.point, " "), f.block);
  return text;
}

// Gridpoints of the zone at the point carry the force of a deformable block, so the point must lie in the block.
void check_forces(const Stage& stage, const blocks::Assembly& assembly) {
  constexpr double kTolerance = 1e-6;  // m
  for (const PointForce& force : stage.forces) {
    const geometry::Vector point = geometry::vector(force.point);
    const int nearest = blocks::block_at(assembly, force.block, point, stage.source.text);
    const blocks::Block& block = assembly.blocks[static_cast<std::size_t>(nearest)];
    refuse_on_fixed(block, "force", stage.source);
    refuse_on_driven(block, force.force, "force", stage);
    const double distance = distance_from(assembly, block, point);
    if (block.rigid || distance <= kTolerance) continue;
    throw Error(
        Exit::bad_input,
        fmt::format("{}: force on block '{}': its point {} lies {:.3g} m outside the block, which deforms; give "
                    "a point in it or on it, or make the block rigid",
                    stage.source.text, force.block, geometry::place(point), distance));
  }
}

}  // namespace

extern const StageAction kPointForces{"force",       "has forces at points",
                                      read_forces,   [](const Stage& s) { return !s.forces.empty(); },
                                      text_of_force, check_forces};

}  // namespace quoin
