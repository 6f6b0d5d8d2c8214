#include "model/scattered_points.h"

#include <algorithm>
#include <map>

#include "base/index.h"
#include "model/point_finder.h"

namespace quoin {

namespace {

bool is_correlated(const JointFamily& family) {
  return std::any_of(family.properties.begin(), family.properties.end(),
                     [](const PropertySetting& p) { return p.scatter && p.scatter->correlation_length > 0.0; });
}

// Lists of all points of the joints, or courses, of these points, to be drawn one list at a time. by_course: properties
// are correlated along courses.
std::vector<std::vector<std::int32_t>> drawn_together(const Model& m, const ContactFamily& family,
                                                      const std::vector<std::int32_t>& points, bool by_course,
                                                      std::span<const PlacedBlock> blocks) {
  if (!by_course) return {points_of_same_joints(m, family, points)};
  const auto course_of = [&](std::int32_t p) {
    const Joint& joint = m.assembly.joints[at(m.point_joint[at(p)])];
    return blocks[at(block_laid(joint.block_a, joint.block_b, blocks))].course;
  };
  std::map<int, std::vector<std::int32_t>> of_course;
  for (const std::int32_t p : points) of_course[course_of(p)];
  for (std::int32_t p = family.first_point; p < family.first_point + family.point_count; ++p) {
    if (const auto found = of_course.find(course_of(p)); found != of_course.end()) found->second.push_back(p);
  }
  std::vector<std::vector<std::int32_t>> rows;
  for (auto& [course, of_one] : of_course) rows.push_back(std::move(of_one));
  return rows;
}

}  // namespace

void make_columns(Model& m) {
  for (std::size_t f = 0; f < m.families.size(); ++f) {
    ContactFamily& family = m.families[f];
    if (family.point_count == 0) continue;
    family.columns = scattered_columns(m.assembly.families[f], *family.material);
    for (PropertyColumn& column : family.columns) column.values.resize(at(family.point_count));
  }
}

void draw_columns(Model& m, std::span<const int> chunks) {
  std::vector<PlacedBlock> blocks;
  for (std::size_t f = 0; f < m.families.size(); ++f) {
    ContactFamily& family = m.families[f];
    if (family.columns.empty()) continue;
    const JointFamily& description = m.assembly.families[f];
    std::vector<std::int32_t> wanted;
    for (const int c : chunks) {
      const ContactChunk& chunk = m.chunks[at(c)];
      for (std::int32_t i = 0; at(chunk.family) == f && i < chunk.point_count; ++i)
        wanted.push_back(chunk.first_point + i);
    }
    if (wanted.empty()) continue;
    if (blocks.empty()) {
      for (const Brick& brick : m.assembly.bricks) blocks.push_back({brick.unit, brick.course});
    }
    for (const auto& row : drawn_together(m, family, wanted, is_correlated(description), blocks)) {
      const std::vector<PropertyColumn> drawn =
          draw_properties(description, *family.material, placed_points(m, row), blocks);
      for (std::size_t k = 0; k < drawn.size(); ++k) {
        PropertyColumn& column = family.columns[k];
        column.most = std::max(column.most, drawn[k].most);
        for (std::size_t i = 0; i < row.size(); ++i) {
          if (std::binary_search(wanted.begin(), wanted.end(), row[i]))
            column.values[at(row[i] - family.first_point)] = drawn[k].values[i];
        }
      }
    }
  }
}

void release_columns(Model& m, std::size_t first, std::size_t end) {
  for (ContactFamily& family : m.families) {
    const std::size_t begin = at(family.first_point), count = at(family.point_count);
    const std::size_t from = std::max(first, begin), to = std::min(end, begin + count);
    for (PropertyColumn& column : family.columns) {
      if (from < to) release_part(column.values, from - begin, to - begin);
    }
  }
}

void bound_stiffness(Model& m) {
  for (std::size_t f = 0; f < m.families.size(); ++f) {
    ContactFamily& family = m.families[f];
    if (family.columns.empty()) continue;
    const quoin_stiffness_bounds bounds = stiffness_bounds_of(m.assembly.families[f], *family.material, family.columns);
    family.normal_stiffness = bounds.normal, family.shear_stiffness = bounds.shear;
  }
}

}  // namespace quoin
