#include "results/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "files/file.h"
#include "files/gnuplot.h"
#include "results/crack_styles.h"
#include "results/history.h"
#include "scene/generate.h"

namespace quoin {

namespace {

// A factor that people like: 1, 2 or 5 times a power of ten, not above x.
double round_down(double x) {
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  for (const double digit : {5.0, 2.0}) {
    if (x >= digit * power) return digit * power;
  }
  return power;
}

std::string title_of(const Scene& scene) {
  return scene.title.empty() ? std::filesystem::path(scene.file).stem().string() : scene.title;
}

// Whose displacement the history shows: "top beam", "top course", "roof".
std::string moved_part(const Scene& scene) {
  if (scene.building && !scene.blocks) return "roof";
  std::string name = scene.stages.empty() ? "" : scene.stages.back().monitor;
  std::replace(name.begin(), name.end(), '_', ' ');
  return name.empty() ? "wall" : name;
}

}  // namespace

Peak find_peak(const std::vector<HistoryRow>& rows, const Scene& scene) {
  Peak peak;
  for (size_t i = 0; i < rows.size(); ++i) {
    const Response r = response(rows[i], scene.stages[static_cast<size_t>(rows[i].stage)]);
    if (peak.row >= 0 && std::abs(r.horizontal_force) <= peak.force) continue;
    peak = {static_cast<int>(i), std::abs(r.horizontal_force), std::abs(r.displacement), r.vertical_force};
  }
  return peak;
}

std::string plot_curve(const std::filesystem::path& folder, const std::vector<HistoryRow>& rows, const Scene& scene,
                       const std::string& law, const std::string& label) {
  make_folder(folder / "plots");
  const double area = bed_area(scene);
  std::string data = "# displacement_mm horizontal_force_kN vertical_stress_MPa\n";
  double lowest = 0.0, highest = 0.0;
  for (const HistoryRow& row : rows) {
    const double x = response(row, scene.stages[static_cast<size_t>(row.stage)]).displacement;
    lowest = std::min(lowest, x);
    highest = std::max(highest, x);
  }
  // One way the curve goes to the right, whichever way that was. Noise about 0 is no reason for another quadrant.
  const double largest = std::max(highest, -lowest);
  const bool turns = std::min(highest, -lowest) > 0.01 * largest;
  const double sign = !turns && -lowest > highest ? -1.0 : 1.0;
  double low_force = 0.0, high_force = 0.0;
  bool moving = false;  // pressing comes first, and would be a vertical line at 0
  for (size_t i = 0; i < rows.size(); ++i) {
    const HistoryRow& row = rows[i];
    const Response r = response(row, scene.stages[static_cast<size_t>(row.stage)]);
    const bool next_is_still = i + 1 < rows.size() && rows[i + 1].stage == row.stage;
    moving = moving || std::abs(r.displacement) > 1e-9 * largest;
    if (!moving && next_is_still) continue;
    low_force = std::min(low_force, sign * r.horizontal_force);
    high_force = std::max(high_force, sign * r.horizontal_force);
    data += fmt::format("{:.7g} {:.7g} {:.7g}\n", sign * r.displacement * 1e3, sign * r.horizontal_force / 1e3,
                        area > 0 ? r.vertical_force / area / 1e6 : 0.0);
  }
  write_file(folder / "plots" / "curve.dat", data);

  const bool pushed_back = low_force < -0.02 * high_force;
  const Peak peak = find_peak(rows, scene);
  std::string script =
      fmt::format(R"gp(set terminal pngcairo size 1500,950 font "Sans,19" linewidth 1.5
set title {} noenhanced font "Sans,23"
set xlabel {} noenhanced
set ylabel "horizontal force (kN)" textcolor rgb "#b3321e"
set border 11 linecolor rgb "#404040"
set xrange [{:.6g}:{:.6g}]
set yrange [{}:*]
set xtics nomirror
set ytics nomirror textcolor rgb "#b3321e"
set grid xtics ytics linecolor rgb "#b8b8b8" linewidth 0.8
set key bottom right spacing 1.3 samplen 3 noenhanced
)gp",
                  gnuplot_text(title_of(scene)),
                  gnuplot_text(fmt::format("horizontal displacement of the {} (mm)", moved_part(scene))),
                  turns ? 1.02 * lowest * 1e3 : 0.0, largest > 0 ? 1.02 * (turns ? highest : largest) * 1e3 : 1.0,
                  pushed_back ? "*" : "0");
  if (turns) script += "set yzeroaxis linecolor rgb \"#606060\" linewidth 1.2\n";
  if (pushed_back) script += "set xzeroaxis linecolor rgb \"#606060\" linewidth 1.2\n";
  std::string plot =
      fmt::format("plot \"curve.dat\" using 1:2 with lines linewidth 3 linecolor rgb \"#b3321e\" title {}",
                  gnuplot_text("horizontal force, law " + law));
  if (area > 0) {
    script +=
        "set y2label \"mean vertical stress (MPa)\" textcolor rgb \"#5a7186\"\nset y2range [0:*]\n"
        "set y2tics nomirror textcolor rgb \"#5a7186\"\n";
    plot +=
        ", \\\n     \"curve.dat\" using 1:3 axes x1y2 with lines linewidth 1.7 dashtype (8,5) linecolor rgb "
        "\"#5a7186\" "
        "title \"mean vertical stress (right axis)\"";
  }
  if (peak.row >= 0 && peak.force > 0) {
    const HistoryRow& row = rows[static_cast<size_t>(peak.row)];
    const Response r = response(row, scene.stages[static_cast<size_t>(row.stage)]);
    const double at = sign * r.displacement * 1e3, force = sign * r.horizontal_force / 1e3;
    script += fmt::format(
        "set label 1 \"{0:.1f} kN at {1:.2f} mm\" at {1:.6g},{0:.6g} center offset 0,{2} font \"Sans,19\" front\n"
        "set offsets 0, 0, graph 0.1, {3}\n",
        force, at, force < 0 ? -1.1 : 1.1, pushed_back ? "graph 0.1" : "0");
    script += fmt::format("$peak << EOD\n{:.6g} {:.6g}\nEOD\n", at, force);
    plot += ", \\\n     $peak with points pointtype 7 pointsize 1.6 linecolor rgb \"#b3321e\" notitle";
  }
  return draw_picture(folder, "curve", script + label + plot + "\n");
}

namespace {

// The wall moves by millimetres: magnified so that the largest movement is about 6 % of its height.
struct Magnified {
  Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};  // of all blocks, m
  std::vector<std::vector<Vec3>> displacement;                                    // by block and gridpoint, m
  double largest = 0.0;                                                           // of them, m
  double factor = 1.0;

  // A line of a gnuplot file, mm.
  std::string moved(const Vec3& x, const Vec3& u) const {
    return fmt::format("{:.6g} {:.6g}\n", (x[0] + factor * u[0]) * 1e3, (x[1] + factor * u[1]) * 1e3);
  }
};

Magnified magnified(const Simulation& simulation) {
  const auto& bricks = simulation.assembly().bricks;
  Magnified view;
  for (size_t b = 0; b < bricks.size(); ++b) {
    view.displacement.push_back(simulation.block_displacement(static_cast<int>(b)));
    for (const Vec3& u : view.displacement.back()) view.largest = std::max(view.largest, std::hypot(u[0], u[1]));
    for (size_t axis = 0; axis < 3; ++axis) {
      view.low[axis] = std::min(view.low[axis], bricks[b].origin[axis]);
      view.high[axis] = std::max(view.high[axis], bricks[b].origin[axis] + bricks[b].size[axis]);
    }
  }
  if (view.largest > 1e-12) view.factor = round_down(0.075 * (view.high[1] - view.low[1]) / view.largest);
  return view;
}

// Outlines of the front faces, counter-clockwise, along the gridpoints of their edges.
void write_outlines(const std::filesystem::path& folder, const Simulation& simulation, const Magnified& view) {
  const std::vector<Brick>& bricks = simulation.assembly().bricks;
  std::string brick_data, beam_data;
  for (size_t b = 0; b < bricks.size(); ++b) {
    const Brick& brick = bricks[b];
    const auto mesh = simulation.block_mesh(static_cast<int>(b));
    const double x0 = brick.origin[0], y0 = brick.origin[1], x1 = x0 + brick.size[0], y1 = y0 + brick.size[1];
    const double tolerance = 1e-6 * (brick.size[0] + brick.size[1]), front = brick.origin[2] + brick.size[2];
    std::vector<std::pair<double, size_t>> outline;  // place along the edge, gridpoint
    for (size_t i = 0; i < mesh.gridpoint.size(); ++i) {
      const Vec3& p = mesh.gridpoint[i];
      if (std::abs(p[2] - front) > tolerance) continue;
      const double fx = (p[0] - x0) / brick.size[0], fy = (p[1] - y0) / brick.size[1];
      if (std::abs(p[1] - y0) < tolerance)
        outline.emplace_back(fx, i);
      else if (std::abs(p[0] - x1) < tolerance)
        outline.emplace_back(1 + fy, i);
      else if (std::abs(p[1] - y1) < tolerance)
        outline.emplace_back(3 - fx, i);
      else if (std::abs(p[0] - x0) < tolerance)
        outline.emplace_back(4 - fy, i);
    }
    std::sort(outline.begin(), outline.end());
    std::string& data = brick.beam ? beam_data : brick_data;
    for (const auto& [place, i] : outline) data += view.moved(mesh.gridpoint[i], view.displacement[b][i]);
    if (!outline.empty())
      data += view.moved(mesh.gridpoint[outline[0].second], view.displacement[b][outline[0].second]);
    data += "\n";
  }
  write_file(folder / "plots" / "bricks.dat", brick_data.empty() ? "NaN NaN\n" : brick_data);
  write_file(folder / "plots" / "beams.dat", beam_data.empty() ? "NaN NaN\n" : beam_data);
}

// Files of gnuplot, a quad half a segment of a joint.
struct JointQuads {
  std::array<std::string, kCrackCount> of_crack;
  std::string inside_unit;  // intact joints inside a unit, to be drawn so that the unit reads as one brick
};

// Joints as seen from the front: of the points behind each other the most damaged one counts. Each point colours the
// line half-way to its neighbours.
JointQuads joint_quads(const Simulation& simulation, const Surfaces& surfaces, const Magnified& view) {
  const auto& bricks = simulation.assembly().bricks;
  struct Seen {
    const JointPoint* worst;
    const JointPoint* front;
  };
  const auto points = surfaces.joint_points(simulation);
  std::map<int, std::map<long long, Seen>> joints;  // joint -> place along it
  for (const JointPoint& p : points) {
    const size_t along = std::abs(p.contact.normal[0]) > 0.5 ? 1 : 0;
    if (std::abs(p.contact.normal[2]) > 0.5) continue;  // joints seen from above
    auto [place, fresh] =
        joints[p.contact.joint].try_emplace(std::llround(p.contact.position[along] * 1e6), Seen{&p, &p});
    if (p.crack > place->second.worst->crack) place->second.worst = &p;
    if (p.contact.position[2] > place->second.front->contact.position[2]) place->second.front = &p;
  }
  // Each half segment is drawn as the quad between its two sides: an open crack is a coloured gap, a closed one a line.
  JointQuads quads;
  auto add_half = [&](const JointPoint& worst, const JointPoint& a, const JointPoint& b, double from, double to) {
    auto corner = [&](double t, Vec3 JointPoint::*side) {
      Vec3 x{}, u{};
      for (size_t axis = 0; axis < 2; ++axis) {
        x[axis] = a.contact.position[axis] + t * (b.contact.position[axis] - a.contact.position[axis]);
        u[axis] = (a.*side)[axis] + t * ((b.*side)[axis] - (a.*side)[axis]);
      }
      return view.moved(x, u);
    };
    const int unit = bricks[static_cast<size_t>(worst.contact.block_a)].unit;
    const bool inside = unit >= 0 && unit == bricks[static_cast<size_t>(worst.contact.block_b)].unit;
    std::string& data =
        inside && worst.crack == Crack::intact ? quads.inside_unit : quads.of_crack[static_cast<size_t>(worst.crack)];
    data += corner(from, &JointPoint::side_a) + corner(to, &JointPoint::side_a) + corner(to, &JointPoint::side_b) +
            corner(from, &JointPoint::side_b) + corner(from, &JointPoint::side_a) + "\n";
  };
  for (const auto& [joint, places] : joints) {
    for (auto it = places.begin(); it != places.end() && std::next(it) != places.end(); ++it) {
      const Seen &a = it->second, &b = std::next(it)->second;
      add_half(*a.worst, *a.front, *b.front, 0.0, 0.5);
      add_half(*b.worst, *a.front, *b.front, 0.5, 1.0);
    }
  }
  return quads;
}

// Returns what plots them, and the legend.
std::string write_joints(const std::filesystem::path& folder, const JointQuads& quads) {
  std::string plot;
  auto add_quads = [&](const std::string& file, const std::string& data, const char* colour, double width) {
    write_file(folder / "plots" / file, data.empty() ? "NaN NaN\n" : data);
    for (const char* how : {"filledcurves closed fillcolor", "lines linecolor"})
      plot += fmt::format(", \\\n     \"{}\" with {} rgb \"{}\"{} notitle", file, how, colour,
                          *how == 'l' ? fmt::format(" linewidth {}", width) : std::string());
  };
  add_quads("joints_unit.dat", quads.inside_unit, "#d3bfa4", 0.7);
  for (const CrackStyle& style : kCrackStyles)
    add_quads(fmt::format("joints_{}.dat", static_cast<int>(style.crack)),
              quads.of_crack[static_cast<size_t>(style.crack)], style.colour, style.width);
  for (const CrackStyle& style : kCrackStyles)
    plot += fmt::format(", \\\n     NaN with lines linewidth {} linecolor rgb \"{}\" title \"{}\"",
                        style.crack == Crack::intact ? 2.0 : 7.0, style.colour, style.label);
  return plot;
}

}  // namespace

std::string plot_cracks(const std::filesystem::path& folder, const Simulation& simulation, const Surfaces& surfaces,
                        const std::vector<HistoryRow>& rows, const std::string& law, const std::string& label) {
  make_folder(folder / "plots");
  const Scene& scene = simulation.scene();
  const Magnified view = magnified(simulation);
  write_outlines(folder, simulation, view);
  const std::string plot = write_joints(folder, joint_quads(simulation, surfaces, view));

  std::string state = "law " + law;
  if (!rows.empty()) {
    const Response r = response(rows.back(), scene.stages[static_cast<size_t>(rows.back().stage)]);
    state = fmt::format("{} moved {:.2f} mm, horizontal force {:.1f} kN, law {}", moved_part(scene),
                        std::abs(r.displacement) * 1e3, std::abs(r.horizontal_force) / 1e3, law);
  }
  // One scale on both axes; the picture is as high as the wall asks for, with room for title and legend.
  const Vec3 &low = view.low, &high = view.high;
  const double width = (high[0] - low[0]) * 1e3, height = (high[1] - low[1]) * 1e3,
               sway = view.largest * view.factor * 1e3;
  const double margin = 0.03 * std::max(width, height);
  const double range_x = width + 2 * (margin + sway), range_y = height + 2 * margin + 0.3 * sway;
  const double scale = 1200.0 / std::max(range_x, range_y), above = 150.0, below = 110.0;
  const double pixels_x = std::max(1000.0, range_x * scale + 40), pixels_y = range_y * scale + above + below;
  const std::string script = fmt::format(
      R"gp(set terminal pngcairo size {:.0f},{:.0f} font "Sans,17"
set label 1 {} at screen 0.5,{:.4f} center noenhanced font "Sans,21"
set label 2 {} at screen 0.5,{:.4f} center noenhanced font "Sans,16"
set label 3 "displacements drawn {:g} times larger" at screen 0.5,{:.4f} center font "Sans,16"
set size ratio -1
set tmargin at screen {:.4f}
set bmargin at screen {:.4f}
set lmargin at screen 0.02
set rmargin at screen 0.98
set xrange [{:.6g}:{:.6g}]
set yrange [{:.6g}:{:.6g}]
unset border
unset tics
{}set key outside bottom center horizontal maxrows 2 samplen 2.5 spacing 1.4 width 3 reverse Left
set style fill solid 1.0 noborder
plot "beams.dat" with filledcurves closed fillcolor rgb "#b9c0c8" notitle, \
     "beams.dat" with lines linewidth 1.0 linecolor rgb "#808890" notitle, \
     "bricks.dat" with filledcurves closed fillcolor rgb "#ecdcc8" notitle{}
)gp",
      pixels_x, pixels_y, gnuplot_text(title_of(scene)), 1.0 - 0.27 * above / pixels_y, gnuplot_text(state),
      1.0 - 0.53 * above / pixels_y, view.factor, 1.0 - 0.76 * above / pixels_y, 1.0 - above / pixels_y,
      below / pixels_y, low[0] * 1e3 - margin - sway, high[0] * 1e3 + margin + sway, low[1] * 1e3 - margin,
      high[1] * 1e3 + margin + sway * 0.3, label, plot);
  return draw_picture(folder, "cracks", script);
}

}  // namespace quoin
