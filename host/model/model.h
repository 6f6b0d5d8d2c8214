// The discretised assembly of the lattice, as flat arrays that steps read and write. It is built once from an Assembly.
// Displacements are small, so geometry, areas and normals never change.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "law/law_library.h"
#include "model/brick_template.h"
#include "model/lanes.h"
#include "model/property_columns.h"
#include "scene/assembly.h"

namespace quoin {

// Up to 8 blocks of one template, one a lane. Lanes without a block have zero inverse mass and never move.
struct BlockGroup {
  int brick_template = 0;
  Vec3 offset{};                    // from the first block of the unit to this block, m
  std::int32_t first_line = 0;      // gridpoint i of the template is line first_line + i
  int block_count = 0;              // lanes in use, from lane 0
  std::array<int, kLanes> block{};  // index into Assembly::bricks
  std::int32_t first_slot = 0;      // into Model::slot_point, in units of 8 lanes
};

// Consecutive groups whose lanes hold the blocks of the same masonry units: two halves, or one block that is a unit by
// itself. Consecutive units of the assembly are in the same lane of consecutive unit groups.
inline constexpr int kUnitBlocks = 2;
struct UnitGroup {
  int first_group = 0, group_count = 0;
};

// Contact slots of the gridpoints of a template, the same for all its groups. A slot holds one possible contact point.
// The sign is the side of the block (normals point along +axis, so a +face is always side a).
struct ContactSlots {
  std::vector<std::int32_t> slot_end;  // per gridpoint: slots [slot_end[i-1], slot_end[i])
  std::vector<double> sign;            // per slot: +1 side a, -1 side b
  std::vector<std::uint8_t> face;      // per slot: 2 axis + 1 on side a, 2 axis on side b
  int slot_count() const { return static_cast<int>(sign.size()); }
};

// A rigid block: 6 degrees of freedom, fewer under a BodyControl. Its gridpoints (slaves) exist only where it has
// contact points.
struct RigidBody {
  int block = -1;
  std::string name;
  Vec3 centre{};               // reference position, m
  double mass = 0.0;           // kg, without scaling
  Vec3 inertia{};              // about the centre and the axes of the box, kg m2, without scaling
  std::array<bool, 6> held{};  // by the symmetry plane: translations, rotations
  // Its contact points in fixed order, each with a gridpoint of its own.
  std::vector<std::int32_t> point;
  std::vector<std::int32_t> slave;  // offset of the gridpoint
  std::vector<Vec3> arm;            // places of the gridpoints from the centre, m
  std::vector<double> sign;         // +1 side a, -1 side b
};

// Up to 8 rigid bodies with contact points at the same places, one a lane. Lanes without a body repeat the body of lane
// 0.
struct BodyGroup {
  int slots = 0;                   // index into Model::body_slots
  std::int32_t first_line = 0;     // the slave of slot i is in line first_line + i
  int body_count = 0;              // lanes in use, from lane 0
  std::array<int, kLanes> body{};  // index into Model::bodies
  std::int32_t first_slot = 0;     // into Model::slot_point, in units of 8 lanes
};

// Places of contact points, the same for all bodies of some groups, face after face. A body may lack the points of
// whole faces. Face 2 axis + 1 is on the positive side, which is side a of its joints.
struct BodySlots {
  struct Face {
    int slot_end = 0;         // its slots are [slot_end of the face before, slot_end)
    double normal_arm = 0.0;  // distance of the face from the centre along the axis, m
  };
  std::array<Face, 6> face{};
  std::vector<std::array<double, 2>> arm;  // per slot: from the centre along the two axes after the normal, m
  int slot_count() const { return static_cast<int>(arm.size()); }
};

// Contact points of one joint family: the law and its states.
struct ContactFamily {
  std::string name;
  std::shared_ptr<const Material> material;
  std::int32_t first_point = 0, point_count = 0;
  double normal_stiffness = 0.0, shear_stiffness = 0.0;  // upper bounds, Pa/m
  std::vector<PropertyColumn> columns{};                 // properties that scatter, by point of the family
};

// A run of contact points with one law and one normal axis, small enough for the first-level cache. s and t are the
// next axes in right-handed order.
struct ContactChunk {
  int family = 0;
  int axis = 0;
  std::int32_t first_point = 0, point_count = 0;
};
inline constexpr int kChunk = 256;  // points; a larger chunk's columns do not fit the first-level cache

// A rank has an outline of the whole model, some hundred bytes a block: places and numbers of all items. Arrays by
// gridpoint, slot and contact point have their whole length. Only the part that the rank works on is laid out and takes
// memory.
enum class LayOut { all, nothing };

struct Model {
  Model() = default;
  Model(Assembly assembly, std::vector<std::shared_ptr<const Material>> family_materials,
        LayOut laid_out = LayOut::all);

  // Lays out these unit groups and chunks in arrays; what is laid out already stays. Both lists ascend. All contact
  // points of the unit groups must lie in the chunks.
  void lay_out(std::span<const int> units, std::span<const int> chunks);
  void lay_out_all();
  void weigh(int unit);  // computes the masses alone, of a unit group that is not laid out
  // Releases the memory of all other unit groups and chunks.
  void keep_alone(std::span<const int> units, std::span<const int> chunks);

  Assembly assembly;
  std::vector<BrickTemplate> templates;
  std::vector<ContactSlots> slots;  // per template
  std::vector<BlockGroup> groups;
  std::vector<UnitGroup> unit_groups;  // all groups, in order
  std::vector<RigidBody> bodies;
  std::vector<BodySlots> body_slots;
  std::vector<BodyGroup> body_groups;
  std::vector<int> lone_bodies;  // bodies in no group
  std::vector<ContactFamily> families;
  std::vector<ContactChunk> chunks;

  // Position of each block of the assembly. Deformable: group and lane. Rigid: body.
  struct BlockPlace {
    int group = -1, lane = -1, body = -1;
  };
  std::vector<BlockPlace> place;
  // [group][slot][lane]: contact point, or point_count, a dummy without force. Block groups come first, then body
  // groups.
  LaneVector<std::int32_t> slot_point;
  // [group][slot]: point of lane 0 when the 8 lanes have 8 points in a row; kEmptySlot when they have none; else -1.
  LaneVector<std::int32_t> slot_run;
  static constexpr std::int32_t kEmptySlot = -2;

  // Gridpoints, in lane layout.
  std::int32_t line_count = 0;
  std::int32_t block_line_count = 0;  // lines of deformable blocks; slaves of body groups follow, then of lone bodies
  LaneVector<double> node_mass;       // kg, per component; without scaling; 0: no gridpoint, or a slave
  LaneVector<double> node_free;       // 1 free, 0 held (symmetry plane, padding, slaves)

  // Contact points: by family, then by axis; points of neighbouring lanes are consecutive.
  std::int32_t point_count = 0;
  LaneVector<std::int32_t> node_a, node_b;  // offsets of the two gridpoints
  LaneVector<double> area;                  // m2
  // Number of the chunk's points from this one on, at most 8, whose gridpoints are consecutive in memory on both sides.
  // They need no gathers.
  LaneVector<std::uint8_t> point_run;
  LaneVector<Vec3> point_position;  // reference, m
  LaneVector<std::uint8_t> point_axis;
  // Joints of all points, laid out or not: index into Assembly::joints, and number of the point in its joint.
  LaneVector<std::int32_t> point_joint, point_in_joint;

  // Blocks on the negative and on the positive side of a contact point, along its normal.
  struct Sides {
    int a, b;
  };
  Sides sides_of(std::int32_t point) const {
    return sides_of(assembly.joints[static_cast<std::size_t>(point_joint[static_cast<std::size_t>(point)])]);
  }
  // A joint whose face_a is a negative face changes sides.
  static Sides sides_of(const Joint& joint) {
    return joint.face_a % 2 == 1 ? Sides{joint.block_a, joint.block_b} : Sides{joint.block_b, joint.block_a};
  }

  const BrickTemplate& template_of(int block) const {  // shape and zones of a deformable block
    const BlockPlace& where = place[static_cast<std::size_t>(block)];
    return templates[static_cast<std::size_t>(groups[static_cast<std::size_t>(where.group)].brick_template)];
  }
  Vec3 gridpoint_position(int block, int node) const {  // of a deformable block, at the start, m
    return assembly.bricks[static_cast<std::size_t>(block)].origin +
           template_of(block).node[static_cast<std::size_t>(node)];
  }

  std::vector<int> blocks_named(const std::string& name) const;  // rigid ones first
  // Visits the gridpoints of a deformable block: visit(offset, mass in kg without scaling).
  template <class Visit>
  void for_each_gridpoint(int block, Visit visit) const {
    const BlockPlace& where = place[static_cast<std::size_t>(block)];
    const BlockGroup& group = groups[static_cast<std::size_t>(where.group)];
    const auto& mass = templates[static_cast<std::size_t>(group.brick_template)].node_mass;
    for (std::size_t n = 0; n < mass.size(); ++n)
      visit((static_cast<std::size_t>(group.first_line) + n) * kLine + static_cast<std::size_t>(where.lane), mass[n]);
  }
  bool has_laid_out(int chunk) const { return chunk_laid_out_[static_cast<std::size_t>(chunk)]; }
  long layouts() const { return layouts_; }  // counter that changes whenever other chunks are laid out

  // Range of gridpoint lines and slots of consecutive unit groups.
  struct Extent {
    std::size_t first_line, end_line, first_slot, end_slot;
  };
  Extent extent_of_units(std::size_t first, std::size_t end) const;
  double total_mass() const;  // kg, without mass scaling
  std::size_t zone_count() const;

 private:
  std::vector<bool> unit_laid_out_, chunk_laid_out_;
  long layouts_ = 0;
};

// Materials of the families of an assembly: loads the laws, validates the properties.
std::vector<std::shared_ptr<const Material>> make_materials(const Assembly& assembly);

}  // namespace quoin
