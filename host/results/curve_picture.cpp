// curve.png: the curve of a run, by curve_kind of its last stage. It is force against displacement of a driven part,
// displacement over time in an earthquake and at rest, or the multiplier in a collapse.
// base_shear.png: the hysteresis of an earthquake, base shear against displacement.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "files/file.h"
#include "files/gnuplot.h"
#include "results/colours.h"
#include "results/history.h"
#include "results/picture_text.h"
#include "results/plots.h"
#include "scene/generate.h"

namespace quoin {

namespace {

using Row = HistoryRow;

struct Curve {
  std::string columns;  // columns of curve.dat
  std::string x_label, y_label, name;
  std::string x_unit, y_unit;  // as in "54.1 kN at 1.97 mm"
  double width = 3.0;          // of the line
  bool over_time = false;
  bool pressed = false;                       // the third number is drawn, too
  std::vector<std::array<double, 3>> points;  // mm or s; kN, mm or 1; MPa
  int peak = -1;                              // index of a point; -1: none
};

}  // namespace

double sense_of_push(double lowest, double highest) {
  // Noise about 0 must not select another quadrant.
  return -lowest > highest && highest <= 0.01 * -lowest ? -1.0 : 1.0;
}

namespace {

// Curve of the rows of stages_on_curve. A push in one direction is drawn to the right.
Curve push_curve(const std::vector<Row>& rows, const Scene& scene, const std::string& law) {
  const double area = bed_area(scene);
  const bool upright = is_vertical(scene);
  const char* axis = upright ? "vertical" : "horizontal";
  Curve curve;
  curve.columns = fmt::format("displacement_mm {}_force_kN vertical_stress_MPa", axis);
  curve.y_label = fmt::format("{} force{} (kN)", axis, upright ? " that resists" : "");
  curve.name = fmt::format("{} force, law {}", axis, law);
  curve.x_unit = " mm", curve.y_unit = " kN";
  curve.pressed = area > 0;
  const std::vector<bool> on_curve = stages_on_curve(scene);
  const auto is_drawn = [&](const Row& row) { return on_curve[static_cast<size_t>(row.stage)]; };
  double lowest = 0.0, highest = 0.0;
  for (const Row& row : rows) {
    if (!is_drawn(row)) continue;
    const double x = shown(row, scene).displacement;
    lowest = std::min(lowest, x), highest = std::max(highest, x);
  }
  const double largest = std::max(highest, -lowest);
  const double sign = sense_of_push(lowest, highest);
  const Stage& measured = stage_of_curve(scene);
  curve.x_label = fmt::format("{} displacement of the {}{} (mm)", axis, moved_part(scene, measured),
                              axis_of(measured) == 2  ? " along z"
                              : upright && sign < 0.0 ? ", downwards"
                                                      : "");
  const Peak peak = find_peak(rows, scene);
  bool moving = false;  // before it moves, only pressure grows: a vertical line at 0
  for (size_t i = 0; i < rows.size(); ++i) {
    if (!is_drawn(rows[i])) continue;
    const Shown r = shown(rows[i], scene);
    const bool next_is_still = i + 1 < rows.size() && rows[i + 1].stage == rows[i].stage;
    moving = moving || std::abs(r.displacement) > 1e-9 * largest;
    const bool is_peak = static_cast<int>(i) == peak.row && peak.force > 0;
    if (is_peak) curve.peak = static_cast<int>(curve.points.size());
    if (!moving && next_is_still && !is_peak) continue;
    curve.points.push_back(
        {sign * r.displacement * 1e3, sign * r.force / 1e3, area > 0 ? rows[i].vertical_force / area / 1e6 : 0.0});
  }
  return curve;
}

// Curve of the rows of stages of the kind of this one that watch the same; the peak is the value farthest from 0.
template <class X, class Y>
void add_points(const std::vector<Row>& rows, const Scene& scene, const Stage& of, const X& x, const Y& y,
                Curve& curve) {
  std::vector<bool> on_same_curve;  // by stage
  for (const Stage& stage : scene.stages)
    on_same_curve.push_back(std::string_view(curve_kind(stage)) == curve_kind(of) && same_curve(scene, stage, of));
  double largest = 0.0;
  for (const Row& row : rows) {
    if (!on_same_curve[static_cast<size_t>(row.stage)]) continue;
    if (std::abs(y(row)) > largest) largest = std::abs(y(row)), curve.peak = static_cast<int>(curve.points.size());
    curve.points.push_back({x(row), y(row), 0.0});
  }
}

double seconds(const Row& row) { return row.time; }

Curve earthquake_curve(const std::vector<Row>& rows, const Scene& scene) {
  const Stage& last = scene.stages.back();
  const ResponseAxis axis = response_axis(last);
  Curve curve;
  if (watches_nothing(scene, last)) return curve;
  curve.columns = fmt::format("time_s relative_displacement_{}_mm", axis.name.size() > 1 ? "oblique" : axis.name);
  curve.x_label = "time (s)";
  curve.y_label = fmt::format("displacement along {} (mm)", axis.name);
  curve.name = fmt::format("of {}, relative to the ground", moved_part(scene, last));
  curve.x_unit = " s", curve.y_unit = " mm";
  curve.over_time = true;
  add_points(
      rows, scene, last, seconds, [&](const Row& row) { return dot(row.monitor_relative, axis.direction) * 1e3; },
      curve);
  return curve;
}

// Base shear and displacement relative to the ground, along the axis of the response.
Curve base_shear_curve(const std::vector<Row>& rows, const Scene& scene, const Stage& shaken) {
  const ResponseAxis axis = response_axis(shaken);
  Curve curve;
  curve.columns = "relative_displacement_mm base_shear_kN";
  curve.x_label =
      fmt::format("displacement of {} along {}, relative to the ground (mm)", moved_part(scene, shaken), axis.name);
  curve.y_label = fmt::format("base shear along {} (kN)", axis.name);
  curve.x_unit = " mm", curve.y_unit = " kN";
  curve.width = 1.2;
  add_points(
      rows, scene, shaken, [&](const Row& row) { return dot(row.monitor_relative, axis.direction) * 1e3; },
      [&](const Row& row) { return dot(row.base_force, axis.direction) / 1e3; }, curve);
  return curve;
}

Curve collapse_curve(const std::vector<Row>& rows, const Scene& scene) {
  Curve curve;
  curve.columns = "largest_displacement_mm multiplier";
  curve.x_label = "largest displacement of a block (mm)";
  curve.y_label = "multiplier of the weight";
  curve.x_unit = " mm";
  const auto moved = [](const Row& row) { return row.largest_displacement * 1e3; };
  add_points(
      rows, scene, scene.stages.back(), moved, [](const Row& row) { return row.multiplier; }, curve);
  return curve;
}

Curve rest_curve(const std::vector<Row>& rows, const Scene& scene) {
  Curve curve;
  const Stage& last = scene.stages.back();
  const bool of_largest = watches_nothing(scene, last);
  if (of_largest && !has_actions(scene)) return curve;
  const char* quantity = of_largest ? "largest" : "vertical";
  curve.columns = fmt::format("time_s {}_displacement_mm", quantity);
  curve.x_label = "time (s)";
  curve.y_label = fmt::format("{} displacement{} (mm)", quantity, of_largest ? " of a block" : "");
  if (!of_largest) curve.name = fmt::format("of {}", moved_part(scene, last));
  curve.x_unit = " s", curve.y_unit = " mm";
  curve.over_time = true;
  add_points(
      rows, scene, last, seconds,
      [&](const Row& row) { return 1e3 * (of_largest ? row.largest_displacement : row.monitor_displacement[1]); },
      curve);
  return curve;
}

Curve curve_of(const std::vector<Row>& rows, const Scene& scene, const std::string& law) {
  const std::string_view kind = scene.stages.empty() ? "push" : curve_kind(scene.stages.back());
  if (kind == "earthquake") return earthquake_curve(rows, scene);
  if (kind == "collapse") return collapse_curve(rows, scene);
  // Without a driven part, forces of walls are those that press them.
  if (kind == "rest" && !is_vertical(scene.stages.back()) &&
      (scene.blocks || watches_nothing(scene, stage_of_curve(scene))))
    return rest_curve(rows, scene);
  return push_curve(rows, scene, law);
}

struct Range {
  double low = 0.0, high = 0.0;
};

Range range_of(const Curve& curve, size_t column) {
  Range range;
  if (column == 0 && curve.over_time && !curve.points.empty())
    range = {curve.points.front()[0], curve.points.front()[0]};
  for (const auto& point : curve.points)
    range.low = std::min(range.low, point[column]), range.high = std::max(range.high, point[column]);
  return range;
}

// Label of the peak, on the side with free space, above or below the curve.
std::string peak_label(const Curve& curve, const Range& x) {
  const auto& at = curve.points[static_cast<size_t>(curve.peak)];
  const double place = (at[0] - x.low) / std::max(x.high - x.low, 1e-300);
  const char* side = place < 0.2 ? "left" : place > 0.8 ? "right" : "center";
  const std::string text = fmt::format(
      "{}{} at {}{}", curve.y_unit == " kN" ? fmt::format("{:.1f}", at[1]) : fmt::format("{:.4g}", at[1]), curve.y_unit,
      curve.x_unit == " mm" ? fmt::format("{:.2f}", at[0]) : fmt::format("{:.4g}", at[0]), curve.x_unit);
  // Opaque, as other curves may pass behind it.
  return fmt::format(
             "set style textbox opaque noborder fillcolor rgb \"#ffffff\" margins 0.3,0.2\n"
             "set label 1 \"{}\" at {:.6g},{:.6g} {} offset 0,{} font \"Sans,19\" front boxed\n",
             text, at[0], at[1], side, at[1] < 0 ? -1.1 : 1.1) +
         fmt::format("$peak << EOD\n{:.6g} {:.6g}\nEOD\n", at[0], at[1]);
}

// name: of the file of points.
std::string script_of(const std::string& name, const Curve& curve, const Scene& scene, const std::string& label) {
  const char* pen = kPens[0];
  const char* second = kPens[1];
  Range x = range_of(curve, 0);
  const Range y = range_of(curve, 1);
  const bool both_x = x.low < -0.01 * x.high, both_y = y.low < -0.02 * y.high;
  if (curve.over_time)
    x.high += x.high > x.low ? 0.0 : 1.0;
  else
    x = {both_x ? 1.02 * x.low : 0.0, x.high > 0 ? 1.02 * x.high : 1.0};
  std::string script = fmt::format(R"gp(set terminal pngcairo size 1500,950 font "Sans,19" linewidth 1.5
set tmargin at screen 0.86
set title {} noenhanced font "Sans,23" offset 0,1.7
set xlabel {} noenhanced
set ylabel {} noenhanced textcolor rgb "{}"
set border {} linecolor rgb "#404040"
set xrange [{:.6g}:{:.6g}]
set yrange [{}:*]
set format "%g"
set xtics nomirror
set ytics nomirror textcolor rgb "{}"
set grid xtics ytics linecolor rgb "#b8b8b8" linewidth 0.8
set key at screen 0.5,0.895 center horizontal samplen 3 reverse Left noenhanced
{})gp",
                                   fitting_text(title_of(scene), 1400, 23), fitting_text(curve.x_label, 1200, 19),
                                   fitting_text(curve.y_label, 700, 19), pen, curve.pressed ? 11 : 3, x.low, x.high,
                                   both_y ? "*" : "0", pen, label.empty() ? "" : "set bmargin at screen 0.13\n");
  if (both_x) script += "set yzeroaxis linecolor rgb \"#606060\" linewidth 1.2\n";
  if (both_y) script += "set xzeroaxis linecolor rgb \"#606060\" linewidth 1.2\n";
  std::string plot =
      fmt::format("plot \"{}.dat\" using 1:2 with lines linewidth {} linecolor rgb \"{}\" {}", name, curve.width, pen,
                  curve.name.empty() ? "notitle" : "title " + fitting_text(curve.name, curve.pressed ? 750 : 1300, 19));
  if (curve.pressed) {
    script += fmt::format(
        "set y2label \"mean vertical stress (MPa)\" textcolor rgb \"{0}\"\nset y2range [{1}:*]\n"
        "set y2tics nomirror textcolor rgb \"{0}\"\n",
        second, range_of(curve, 2).low < 0.0 ? "*" : "0");
    plot += fmt::format(
        ", \\\n     \"{}.dat\" using 1:3 axes x1y2 with lines linewidth 1.7 dashtype (8,5) linecolor rgb \"{}\" "
        "title \"mean vertical stress (right axis)\"",
        name, second);
  }
  if (curve.peak >= 0) {
    script += peak_label(curve, x) + fmt::format("set offsets 0, 0, graph 0.1, {}\n", both_y ? "graph 0.1" : "0");
    plot += fmt::format(", \\\n     $peak with points pointtype 7 pointsize 1.6 linecolor rgb \"{}\" notitle", pen);
  }
  return script + label + plot + "\n";
}

std::string draw_curve(const std::filesystem::path& folder, const std::string& name, const Curve& curve,
                       const Scene& scene, const std::string& label) {
  std::string data = "# " + curve.columns + "\n";
  for (const auto& point : curve.points) data += fmt::format("{:.7g} {:.7g} {:.7g}\n", point[0], point[1], point[2]);
  make_folder(folder / "plots");
  write_file(folder / "plots" / (name + ".dat"), data);
  return draw_picture(folder, name, script_of(name, curve, scene, label));
}

}  // namespace

std::string plot_curve(const std::filesystem::path& folder, const std::vector<HistoryRow>& rows, const Scene& scene,
                       const std::string& law, const std::string& label) {
  const Curve curve = curve_of(rows, scene, law);
  if (curve.points.empty())
    return watches_nothing(scene, stage_of_curve(scene))
               ? fmt::format("no curve.png: no block is watched ({})", key_of_monitor(scene))
               : "no curve.png: the run has not come to the stages that it shows";
  return draw_curve(folder, "curve", curve, scene, label);
}

std::string plot_base_shear(const std::filesystem::path& folder, const std::vector<HistoryRow>& rows,
                            const Scene& scene, const std::string& label) {
  const auto shaken = std::find_if(scene.stages.rbegin(), scene.stages.rend(),
                                   [](const Stage& stage) { return stage.ground.has_value(); });
  if (shaken == scene.stages.rend()) return {};
  if (watches_nothing(scene, *shaken))
    return fmt::format("no base_shear.png: no block is watched ({})", key_of_monitor(scene));
  const Curve curve = base_shear_curve(rows, scene, *shaken);
  if (curve.points.empty()) return "no base_shear.png: the run has not come to the stage that moves the ground";
  return draw_curve(folder, "base_shear", curve, scene, label);
}

}  // namespace quoin
