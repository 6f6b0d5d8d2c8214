// Pressures on faces of blocks.
#include "scene/actions/action.h"
#include "scene/load_place.h"
#include "scene/read_ground.h"

namespace quoin {

using namespace reader;

namespace {

void read_pressures(Table& t, Stage& stage, const std::string&, const std::vector<std::string>& names) {
  t.each("pressure", [&](Table& p) {
    FacePressure& added = stage.pressures.emplace_back();
    read_block_name(p, added.block, names);
    read_direction(p, "normal", added.normal, "outward, of the face that is meant", true);
    p.number("pressure", added.pressure, kAny, "Pa, > 0 pushes on the block", true);
  });
}

std::string text_of_pressure(const Stage& stage) {
  std::string text;
  for (const FacePressure& p : stage.pressures)
    text += fmt::format("{}{} Pa on {} of {}", text.empty() ? "" : ", ", p.pressure, fmt::join(p.normal, " "), p.block);
  return text;
}

void check_pressures(const Stage& stage, const blocks::Assembly& assembly) {
  for (const FacePressure& pressure : stage.pressures) {
    for (const blocks::BlockFace& face :
         blocks::outer_faces(assembly, pressure.block, geometry::vector(pressure.normal), stage.source.text)) {
      const blocks::Block& block = assembly.blocks[static_cast<std::size_t>(face.block)];
      refuse_on_fixed(block, "pressure", stage.source);
      const geometry::Vector& normal =
          assembly.shapes[static_cast<std::size_t>(block.shape)].normals[static_cast<std::size_t>(face.face)];
      refuse_on_driven(block, geometry::array(matrix(block.orientation) * normal), "pressure", stage);
    }
  }
}

}  // namespace

extern const StageAction kFacePressures{"pressure",       "has pressures on faces",
                                        read_pressures,   [](const Stage& s) { return !s.pressures.empty(); },
                                        text_of_pressure, check_pressures};

}  // namespace quoin
