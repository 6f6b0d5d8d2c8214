#include "results/block_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "files/gnuplot.h"
#include "geometry/overlap.h"
#include "geometry/vector.h"
#include "results/colours.h"
#include "results/parted_joints.h"

namespace quoin {

namespace {

using geometry::Vector;

// Where space goes on paper. A plane assembly is seen from the front; others from above to the right.
struct View {
  Vector right, up, towards;  // unit vectors; towards the viewer
  double x(const Vector& p) const { return dot(right, p); }
  double y(const Vector& p) const { return dot(up, p); }
  double depth(const Vector& p) const { return dot(towards, p); }
};

// A block as it stands.
struct Drawn {
  std::vector<std::vector<Vector>> faces;
  double displacement = 0.0;  // of its gridpoints on average, m
  bool fixed = false;
};

std::vector<Drawn> blocks_of(const Simulation& simulation) {
  std::vector<Drawn> blocks;
  for (int i = 0; i < simulation.block_count(); ++i) {
    const Simulation::BlockMesh mesh = simulation.block_mesh(i);
    const std::vector<Vec3> moved = simulation.block_displacement(i);
    Drawn& block = blocks.emplace_back();
    block.fixed = mesh.fixed;
    Vector mean;
    for (const Vec3& u : moved) mean += geometry::vector(u) / double(moved.size());
    block.displacement = norm(mean);
    for (const auto& face : mesh.face) {
      auto& corners = block.faces.emplace_back();
      for (const int k : face)
        corners.push_back(geometry::vector(mesh.gridpoint[size_t(k)]) + geometry::vector(moved[size_t(k)]));
    }
  }
  return blocks;
}

View choose_view(const std::vector<Drawn>& blocks) {
  // Plane: all blocks that can move share their middle plane.
  double low = HUGE_VAL, high = -HUGE_VAL, thickness = 0.0;
  for (const Drawn& block : blocks) {
    if (block.fixed) continue;
    geometry::Box box;
    for (const auto& face : block.faces) {
      for (const Vector& p : face) box.include(p);
    }
    const double middle = 0.5 * (box.lower.z + box.upper.z);
    low = std::min(low, middle), high = std::max(high, middle);
    thickness = std::max(thickness, box.upper.z - box.lower.z);
  }
  if (high - low < 0.25 * thickness) return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Vector towards = normalized(Vector{0.55, 0.45, 1.0});
  const Vector right = normalized(cross(Vector{0, 1, 0}, towards));
  return {right, cross(towards, right), towards};
}

struct Face {
  geometry::Polygon outline;  // on paper, m
  bool fixed;
  double depth, displacement;
};

std::vector<Face> visible_faces(const std::vector<Drawn>& blocks, const View& view) {
  std::vector<Face> faces;
  for (const Drawn& block : blocks) {
    for (const auto& corners : block.faces) {
      const Vector normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
      if (dot(normal, view.towards) <= 0.1 * norm(normal)) continue;
      Vector centre;
      for (const Vector& p : corners) centre += p / double(corners.size());
      Face& face = faces.emplace_back(Face{{}, block.fixed, view.depth(centre), block.displacement});
      for (const Vector& p : corners) face.outline.push_back({view.x(p), view.y(p)});
    }
  }
  // From back to front; first the ground and other supports, whose middle says nothing of what stands on them.
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Face& a, const Face& b) { return a.fixed != b.fixed ? a.fixed : a.depth < b.depth; });
  return faces;
}

// Where two blocks touch, as a line between the two points of the contact that are furthest apart on paper, in the
// colour of the worst crack on it.
struct Line {
  Vector from, to;
  Crack crack = Crack::intact;
};

// By the points on one joint, or on one side of it.
void add_line(const std::vector<Vector>& places, Crack crack, const View& view, std::vector<Line>& lines) {
  Line line;
  line.crack = crack;
  double longest = 0.0;
  for (const Vector& a : places) {
    for (const Vector& b : places) {
      // On the side of the viewer, where the joint is seen.
      const double length =
          std::hypot(view.x(b) - view.x(a), view.y(b) - view.y(a)) + 1e-6 * (view.depth(a) + view.depth(b));
      if (length > longest) longest = length, line.from = a, line.to = b;
    }
  }
  if (longest > 0.0) lines.push_back(line);
}

// The points of a joint: where its blocks touch, and on both sides of where they have come apart.
struct Joint {
  std::vector<Vector> touching, side_a, side_b;
  Crack crack = Crack::intact;
};

std::vector<Line> crack_lines(const Simulation& simulation, const Surfaces& surfaces, const View& view) {
  std::map<std::pair<int, int>, Joint> joints;
  const auto joint_of = [&](const JointPoint& p) -> Joint& {
    Joint& joint = joints[std::minmax(p.contact.block_a, p.contact.block_b)];
    joint.crack = std::max(joint.crack, p.crack);
    return joint;
  };
  for (const JointPoint& p : surfaces.joint_points(simulation))
    joint_of(p).touching.push_back(geometry::vector(p.contact.position) + geometry::vector(p.displacement));
  for (const PartedPoint& p : parted_points(simulation)) {
    Joint& joint = joint_of(p.joint);
    const Vector on_a = geometry::vector(p.joint.contact.position), on_b = on_a + geometry::vector(p.joint.gap);
    const bool in_order = p.joint.contact.block_a < p.joint.contact.block_b;
    joint.side_a.push_back(in_order ? on_a : on_b), joint.side_b.push_back(in_order ? on_b : on_a);
  }
  std::vector<Line> lines;
  for (auto& [pair, joint] : joints) {
    if (joint.side_a.empty()) add_line(joint.touching, joint.crack, view, lines);
    for (std::vector<Vector>* side : {&joint.side_a, &joint.side_b}) {
      if (side->empty()) continue;
      side->insert(side->end(), joint.touching.begin(), joint.touching.end());
      add_line(*side, joint.crack, view, lines);
    }
  }
  return lines;
}

std::string point_text(const View& view, const Vector& p) { return fmt::format("{:.6g} {:.6g}", view.x(p), view.y(p)); }

// Script up to the plot command: sizes, title, and every face as a polygon with its outline, the nearer over the
// further. fill: of faces that have no displacement to show; empty: by displacement, as a place in the colour bar.
std::string scene_of(const Scene& scene, const View& view, const std::vector<Drawn>& blocks,
                     const std::vector<Face>& faces, const std::string& fill, const std::string& outline) {
  double x0 = HUGE_VAL, x1 = -HUGE_VAL, y0 = HUGE_VAL, y1 = -HUGE_VAL;
  for (const Drawn& block : blocks) {
    if (block.fixed) continue;
    for (const auto& face : block.faces) {
      for (const Vector& p : face) {
        x0 = std::min(x0, view.x(p)), x1 = std::max(x1, view.x(p));
        y0 = std::min(y0, view.y(p)), y1 = std::max(y1, view.y(p));
      }
    }
  }
  const double margin = 0.1 * std::max(x1 - x0, y1 - y0);
  x0 -= margin, x1 += margin, y0 -= margin, y1 += margin;
  // Cut here: gnuplot garbles filled polygons that reach beyond the picture.
  const geometry::Polygon paper{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  std::string polygons;
  int number = 0;
  for (const Face& face : faces) {
    geometry::Polygon seen, scratch;
    clip(face.outline, paper, 0.0, seen, scratch);
    if (seen.empty()) continue;
    polygons += fmt::format("set object {} polygon from ", ++number);
    for (const geometry::Point2& p : seen) polygons += fmt::format("{:.6g},{:.6g} to ", p.x, p.y);
    polygons +=
        fmt::format("{:.6g},{:.6g} fillcolor {} fillstyle solid 1.0 border linecolor {}\n", seen[0].x, seen[0].y,
                    fill.empty() ? fmt::format("palette cb {:.6g}", face.displacement * 1e3) : fill, outline);
  }
  const bool plane = view.towards.z == 1.0;
  return fmt::format(
      "set terminal pngcairo size 1200,1000 font 'Sans,16'\nset size ratio -1\nset title {} noenhanced\n{}"
      "set xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\n{}",
      gnuplot_text(scene.title.empty() ? scene.file : scene.title),
      plane ? "set xlabel 'x, m'\nset ylabel 'y, m'\n" : "unset tics\nunset border\n", x0, x1, y0, y1, polygons);
}

}  // namespace

std::string plot_mechanism(const std::filesystem::path& folder, const Simulation& simulation,
                           const std::string& label) {
  if (simulation.block_count() > kMostBlocks)
    return fmt::format("mechanism.png: left out for more than {} blocks; use blocks.pvd", kMostBlocks);
  const std::vector<Drawn> blocks = blocks_of(simulation);
  const View view = choose_view(blocks);
  const std::vector<Face> faces = visible_faces(blocks, view);
  double largest = 1e-12;
  for (const Face& face : faces) largest = std::max(largest, face.displacement);
  return draw_picture(folder, "mechanism",
                      scene_of(simulation.scene(), view, blocks, faces, "", "rgb '#333333' linewidth 1.5") + label +
                          fmt::format("unset key\nset cblabel 'displacement, mm'\nset cbrange [0:{:.6g}]\n"
                                      "set palette defined (0 '{}', 1 '{}')\n"
                                      "plot NaN with lines linecolor palette cb 0\n",
                                      largest * 1e3, kQuantityColours.middle, kQuantityColours.warm));
}

std::string plot_block_cracks(const std::filesystem::path& folder, const Simulation& simulation,
                              const Surfaces& surfaces, const std::string& label) {
  if (simulation.block_count() > kMostBlocks)
    return fmt::format("cracks.png: left out for more than {} blocks; use joints.pvd", kMostBlocks);
  const std::vector<Drawn> blocks = blocks_of(simulation);
  const View view = choose_view(blocks);
  std::array<std::string, kCrackCount> data;
  for (const Line& line : crack_lines(simulation, surfaces, view))
    data[size_t(line.crack)] += point_text(view, line.from) + "\n" + point_text(view, line.to) + "\n\n";
  std::string script =
      scene_of(simulation.scene(), view, blocks, visible_faces(blocks, view), "rgb '#f1ece0'", "rgb '#b5aa98'");
  std::string plot = "plot NaN notitle";
  for (const CrackStyle& style : kCrackStyles) {
    const std::string& lines = data[size_t(style.crack)];
    if (lines.empty()) continue;
    script += fmt::format("$crack{} << EOD\n{}EOD\n", int(style.crack), lines);
    plot += fmt::format(", $crack{} using 1:2 with lines linewidth {} linecolor rgb '{}' title '{}'", int(style.crack),
                        style.width, style.colour, style.label);
  }
  return draw_picture(folder, "cracks", script + label + "set key outside below noenhanced\n" + plot + "\n");
}

}  // namespace quoin
