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
#include "results/picture_text.h"
#include "step/results.h"

namespace quoin {

namespace {

using geometry::Vector;

// Projection of space onto the picture. A plane assembly is seen from the front; others from above to the right.
struct View {
  Vector right, up, towards;  // unit vectors; towards the viewer
  double x(const Vector& p) const { return dot(right, p); }
  double y(const Vector& p) const { return dot(up, p); }
  double depth(const Vector& p) const { return dot(towards, p); }
};

// A block in its current place.
struct Drawn {
  std::vector<std::vector<Vector>> faces;
  Vector displacement;  // mean displacement of its gridpoints, m
  bool fixed = false;
};

std::vector<Drawn> blocks_of(const Simulation& simulation) {
  std::vector<Drawn> blocks;
  for (int i = 0; i < simulation.block_count(); ++i) {
    const BlockMesh mesh = block_mesh(simulation, i);
    const std::vector<Vec3> moved = block_displacement(simulation, i);
    Drawn& block = blocks.emplace_back();
    block.fixed = mesh.fixed;
    for (const Vec3& u : moved) block.displacement += geometry::vector(u) / double(moved.size());
    for (const auto& face : mesh.face) {
      auto& corners = block.faces.emplace_back();
      for (const int k : face)
        corners.push_back(geometry::vector(mesh.gridpoint[size_t(k)]) + geometry::vector(moved[size_t(k)]));
    }
  }
  return blocks;
}

// Displacement of the ground, m: that of the fixed block whose displacement is closest to the ground's in the last row.
// That row is one step older than the blocks.
Vector ground_of(const std::vector<Drawn>& blocks, const std::vector<HistoryRow>& rows) {
  const Vector before = rows.empty() ? Vector{} : geometry::vector(rows.back().ground_displacement);
  Vector ground = before;
  double nearest = HUGE_VAL;
  for (const Drawn& block : blocks) {
    const double away = norm(block.displacement - before);
    if (block.fixed && away < nearest) nearest = away, ground = block.displacement;
  }
  return ground;
}

// Blocks that a picture shows whole: those that can move, or all where none can.
std::vector<const Drawn*> shown_whole(const std::vector<Drawn>& blocks) {
  const bool none_moves = std::ranges::all_of(blocks, &Drawn::fixed);
  std::vector<const Drawn*> whole;
  for (const Drawn& block : blocks) {
    if (none_moves || !block.fixed) whole.push_back(&block);
  }
  return whole;
}

View choose_view(const std::vector<Drawn>& blocks) {
  // Plane: all of these blocks share their middle plane.
  double low = HUGE_VAL, high = -HUGE_VAL, thickness = 0.0;
  for (const Drawn* block : shown_whole(blocks)) {
    geometry::Box box;
    for (const auto& face : block->faces) {
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
  size_t block, index;        // indices into Drawn::faces
  bool fixed;
  double depth, displacement;  // m; against the ground
};

// Visible faces from back to front. ground: displacement of the ground, m.
std::vector<Face> visible_faces(const std::vector<Drawn>& blocks, const View& view, const Vector& ground) {
  std::vector<Face> faces;
  for (size_t b = 0; b < blocks.size(); ++b) {
    const Drawn& block = blocks[b];
    for (size_t f = 0; f < block.faces.size(); ++f) {
      const auto& corners = block.faces[f];
      const Vector normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
      if (dot(normal, view.towards) <= 0.1 * norm(normal)) continue;
      Vector centre;
      for (const Vector& p : corners) centre += p / double(corners.size());
      Face& face =
          faces.emplace_back(Face{{}, b, f, block.fixed, view.depth(centre), norm(block.displacement - ground)});
      for (const Vector& p : corners) face.outline.push_back({view.x(p), view.y(p)});
    }
  }
  // From back to front. The ground and other supports come first, as the depth of their middle does not sort what
  // stands on them.
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Face& a, const Face& b) { return a.fixed != b.fixed ? a.fixed : a.depth < b.depth; });
  return faces;
}

// Contact of two blocks, as the line between those of its points that are furthest apart in the picture. It has the
// colour of the worst crack of the joint.
struct Line {
  Vector from, to;
  Crack crack = Crack::intact;
};

// Adds the line through the points of one joint, or of one side of it.
void add_line(const std::vector<Vector>& places, Crack crack, const View& view, std::vector<Line>& lines) {
  Line line;
  line.crack = crack;
  double longest = 0.0;
  for (const Vector& a : places) {
    for (const Vector& b : places) {
      // Prefers points on the viewer's side, where the joint is visible.
      const double length =
          std::hypot(view.x(b) - view.x(a), view.y(b) - view.y(a)) + 1e-6 * (view.depth(a) + view.depth(b));
      if (length > longest) longest = length, line.from = a, line.to = b;
    }
  }
  if (longest > 0.0) lines.push_back(line);
}

// Points of a joint: where its blocks touch, and on both sides where they have parted.
struct Joint {
  std::vector<Vector> touching, side_a, side_b;
  Crack crack = Crack::intact;
};

using Joints = std::map<std::pair<int, int>, Joint>;  // by pair of blocks, the lower number first

Joints joints_of(const Simulation& simulation, const Surfaces& surfaces) {
  Joints joints;
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
  for (auto& [pair, joint] : joints) {
    for (std::vector<Vector>* side : {&joint.side_a, &joint.side_b}) {
      if (!joint.side_a.empty()) side->insert(side->end(), joint.touching.begin(), joint.touching.end());
    }
  }
  return joints;
}

// Lines of a plane view.
std::vector<Line> crack_lines(const Joints& joints, const View& view) {
  std::vector<Line> lines;
  for (const auto& [pair, joint] : joints) {
    if (joint.side_a.empty()) add_line(joint.touching, joint.crack, view, lines);
    for (const std::vector<Vector>* side : {&joint.side_a, &joint.side_b}) add_line(*side, joint.crack, view, lines);
  }
  return lines;
}

// Part of an edge of a face that a joint covers, as shares of the edge. An empty interval: fewer than two of its points
// are there.
std::pair<double, double> interval_on(const Vector& from, const Vector& to, const std::vector<Vector>& places) {
  const Vector edge = to - from;
  const double length = norm(edge), near = 0.02 * length;  // more than the overlap of blocks under compression
  std::pair<double, double> interval{1.0, 0.0};
  for (const Vector& p : places) {
    const double t = dot(p - from, edge) / (length * length);
    if (t < -0.02 || t > 1.02 || norm(p - from - t * edge) > near) continue;
    interval.first = std::min(interval.first, std::max(t, 0.0));
    interval.second = std::max(interval.second, std::min(t, 1.0));
  }
  return interval;
}

// Lines of other views: joints that are not intact, along the edges of visible faces, by block.
class CrackedEdges {
 public:
  CrackedEdges(const Joints& joints, size_t blocks) : sides_(blocks) {
    for (const auto& [pair, joint] : joints) {
      if (joint.crack == Crack::intact) continue;
      const bool parted = !joint.side_a.empty();
      sides_[size_t(pair.first)].push_back({&(parted ? joint.side_a : joint.touching), joint.crack});
      sides_[size_t(pair.second)].push_back({&(parted ? joint.side_b : joint.touching), joint.crack});
    }
  }
  std::vector<Line> on(const Drawn& block, const Face& face) const {
    std::vector<Line> lines;
    const auto& corners = block.faces[face.index];
    for (size_t k = 0; k < corners.size(); ++k) {
      const Vector &from = corners[k], &to = corners[(k + 1) % corners.size()];
      for (const Side& side : sides_[face.block]) {
        const auto [begin, end] = interval_on(from, to, *side.places);
        if (end - begin > 0.02) lines.push_back({from + begin * (to - from), from + end * (to - from), side.crack});
      }
    }
    return lines;
  }

 private:
  struct Side {
    const std::vector<Vector>* places;
    Crack crack;
  };
  std::vector<std::vector<Side>> sides_;
};

std::string point_text(const View& view, const Vector& p) { return fmt::format("{:.6g} {:.6g}", view.x(p), view.y(p)); }

// Fill and outline of faces, in gnuplot's syntax. Without a fill, colour shows the displacement. below, right: pixels
// left free on these sides of the model.
struct Paint {
  std::string fill, outline;
  double below, right;
  const CrackedEdges* edges = nullptr;  // drawn with the faces, so that nearer faces hide them
};

// A scale in place of axes: a length at the lower left, in the margin.
std::string scale_bar(double x0, double y0, double margin, double width) {
  double length = std::pow(10.0, std::floor(std::log10(0.3 * width)));
  for (const double digit : {5.0, 2.0}) {
    if (digit * length > 0.3 * width) continue;
    length *= digit;
    break;
  }
  const double x = x0 + 0.3 * margin, y = y0 + 0.3 * margin;
  return fmt::format(
      "unset tics\nunset border\nset arrow 1 from {0:.6g},{2:.6g} to {1:.6g},{2:.6g} nohead linewidth 3\n"
      "set label 1 \" {3:g} m\" at {1:.6g},{2:.6g} left\n",
      x, x + length, y, length);
}

// Extent of the blocks that can move, with a margin around it, m.
struct Frame {
  double x0 = HUGE_VAL, x1 = -HUGE_VAL, y0 = HUGE_VAL, y1 = -HUGE_VAL, margin = 0.0;
};

Frame frame_of(const View& view, const std::vector<Drawn>& blocks) {
  Frame f;
  for (const Drawn* block : shown_whole(blocks)) {
    for (const auto& face : block->faces) {
      for (const Vector& p : face) {
        f.x0 = std::min(f.x0, view.x(p)), f.x1 = std::max(f.x1, view.x(p));
        f.y0 = std::min(f.y0, view.y(p)), f.y1 = std::max(f.y1, view.y(p));
      }
    }
  }
  f.margin = 0.1 * std::max(f.x1 - f.x0, f.y1 - f.y0);
  f.x0 -= f.margin, f.x1 += f.margin, f.y0 -= f.margin, f.y1 += f.margin;
  return f;
}

// Every face as a polygon with its outline and its cracks, from back to front. Numbers give the order of drawing.
// gnuplot searches all lower numbers to set an object, so the highest is set first.
std::string polygons_of(const Frame& f, const View& view, const std::vector<Drawn>& blocks,
                        const std::vector<Face>& faces, const Paint& paint) {
  // Clipped here: gnuplot distorts filled polygons that reach beyond the picture.
  const geometry::Polygon paper{{f.x0, f.y0}, {f.x1, f.y0}, {f.x1, f.y1}, {f.x0, f.y1}};
  std::vector<std::string> polygons;
  for (const Face& face : faces) {
    geometry::Polygon seen, scratch;
    clip(face.outline, paper, 0.0, seen, scratch);
    if (seen.empty()) continue;
    std::string& polygon = polygons.emplace_back();
    for (const geometry::Point2& p : seen) polygon += fmt::format("{:.6g},{:.6g} to ", p.x, p.y);
    polygon += fmt::format("{:.6g},{:.6g} fillcolor {} fillstyle solid 1.0 border linecolor {}\n", seen[0].x, seen[0].y,
                           paint.fill.empty() ? fmt::format("palette cb {:.6g}", face.displacement * 1e3) : paint.fill,
                           paint.outline);
    if (paint.edges == nullptr) continue;
    for (const Line& line : paint.edges->on(blocks[face.block], face)) {
      const CrackStyle& style = kCrackStyles[size_t(line.crack)];
      const auto place = [&](const Vector& p) { return fmt::format("{:.6g},{:.6g}", view.x(p), view.y(p)); };
      polygons.push_back(fmt::format("{} to {} to {} fillstyle empty border linecolor rgb '{}' linewidth {}\n",
                                     place(line.from), place(line.to), place(line.from), style.colour, style.width));
    }
  }
  std::string script;
  for (size_t number = polygons.size(); number > 0; --number)
    script += fmt::format("set object {} polygon from {}", number, polygons[number - 1]);
  return script;
}

// Script before the plot command. The height of the picture follows from the model at a width of 1200 pixels.
std::string scene_of(const Scene& scene, const std::vector<HistoryRow>& rows, const View& view,
                     const std::vector<Drawn>& blocks, const std::vector<Face>& faces, const Paint& paint) {
  const Frame f = frame_of(view, blocks);
  const bool plane = view.towards.z == 1.0;
  const double width = 1200.0, above = 100.0, left = plane ? 120.0 : 30.0, below = paint.below + (plane ? 90.0 : 10.0);
  const double of_model = (width - left - paint.right) * (f.y1 - f.y0) / (f.x1 - f.x0);
  const double height = std::clamp(of_model + above + below, 500.0, 1400.0);
  const std::string moment = moment_of(rows, scene);
  return fmt::format(
             "set terminal pngcairo size {:.0f},{:.0f} font 'Sans,16'\nset size ratio -1\nset lmargin at screen "
             "{:.4f}\n"
             "set rmargin at screen {:.4f}\nset tmargin at screen {:.4f}\nset bmargin at screen {:.4f}\n"
             "set title {}.\"\\n\".{} noenhanced\n{}set xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\n{}",
             width, height, left / width, 1.0 - paint.right / width, 1.0 - above / height, below / height,
             fitting_text(title_of(scene), 1000, 16),
             fitting_text(moment + (moment.empty() ? "true to scale" : "; true to scale"), 1000, 16),
             plane ? "set xlabel 'x (m)'\nset ylabel 'y (m)'\n" : scale_bar(f.x0, f.y0, f.margin, f.x1 - f.x0), f.x0,
             f.x1, f.y0, f.y1, polygons_of(f, view, blocks, faces, paint)) +
         fmt::format("set key at screen 0.5,{:.4f} center top horizontal maxrows 2 reverse Left noenhanced\n",
                     (paint.below - 10.0) / height);
}

}  // namespace

std::string plot_mechanism(const std::filesystem::path& folder, const Simulation& simulation,
                           const std::vector<HistoryRow>& rows, const std::string& label) {
  if (simulation.block_count() > kMostBlocks)
    return fmt::format("mechanism.png: left out for more than {} blocks; use blocks.pvd", kMostBlocks);
  const bool shaken = std::any_of(simulation.scene().stages.begin(), simulation.scene().stages.end(),
                                  [](const Stage& s) { return s.ground.has_value(); });
  const std::vector<Drawn> blocks = blocks_of(simulation);
  const View view = choose_view(blocks);
  const std::vector<Face> faces = visible_faces(blocks, view, shaken ? ground_of(blocks, rows) : Vector{});
  double largest = 1e-12;
  for (const Face& face : faces) largest = std::max(largest, face.displacement);
  const std::string script = scene_of(simulation.scene(), rows, view, blocks, faces,
                                      {"", "rgb '#333333' linewidth 1.5", label.empty() ? 10.0 : 40.0, 210.0}) +
                             label;
  return draw_picture(folder, "mechanism",
                      script + fmt::format("unset key\nset cblabel 'displacement{} (mm)'\nset cbrange [0:{:.6g}]\n"
                                           "set cbtics\nset palette defined (0 '{}', 1 '{}')\n"
                                           "plot NaN with lines linecolor palette cb 0\n",
                                           shaken ? " relative to the ground" : "", largest * 1e3,
                                           kQuantityColours.middle, kQuantityColours.warm));
}

std::string plot_block_cracks(const std::filesystem::path& folder, const Simulation& simulation,
                              const Surfaces& surfaces, const std::vector<HistoryRow>& rows, const std::string& label) {
  if (simulation.block_count() > kMostBlocks)
    return fmt::format("cracks.png: left out for more than {} blocks; use joints.pvd", kMostBlocks);
  const std::vector<Drawn> blocks = blocks_of(simulation);
  const View view = choose_view(blocks);
  const bool plane = view.towards.z == 1.0;
  const Joints joints = joints_of(simulation, surfaces);
  const CrackedEdges edges(joints, blocks.size());
  const Paint paint{fmt::format("rgb '{}'", kBlockColours.face), fmt::format("rgb '{}'", kBlockColours.edge),
                    label.empty() ? 80.0 : 110.0, 30.0, plane ? nullptr : &edges};
  std::string script = scene_of(simulation.scene(), rows, view, blocks, visible_faces(blocks, view, {}), paint);
  std::array<std::string, kCrackCount> data;  // lines of a plane view
  std::array<bool, kCrackCount> seen{};
  for (const auto& [pair, joint] : joints) seen[size_t(joint.crack)] = plane || joint.crack != Crack::intact;
  if (plane) {
    for (const Line& line : crack_lines(joints, view))
      data[size_t(line.crack)] += point_text(view, line.from) + "\n" + point_text(view, line.to) + "\n\n";
  }
  std::string plot = "plot NaN notitle";
  for (const CrackStyle& style : kCrackStyles) {
    const std::string& lines = data[size_t(style.crack)];
    if (!seen[size_t(style.crack)] || (plane && lines.empty())) continue;
    if (!lines.empty()) script += fmt::format("$crack{} << EOD\n{}EOD\n", int(style.crack), lines);
    plot += fmt::format(", {} with lines linewidth {} linecolor rgb '{}' title '{}'",
                        lines.empty() ? "NaN" : fmt::format("$crack{} using 1:2", int(style.crack)), style.width,
                        style.colour, style.label);
  }
  return draw_picture(folder, "cracks", script + label + plot + "\n");
}

}  // namespace quoin
