#include "results/plots.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "results/file.h"
#include "results/history.h"
#include "scene/generate.h"

namespace quoin {

namespace {

// Text of a title or label inside double quotes of gnuplot, with its enhanced mode switched off by noenhanced.
std::string gnuplot_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return "\"" + result + "\"";
}

// Runs DIR/plots/NAME.gp; the picture appears under its name only when gnuplot is content.
std::string draw(const std::filesystem::path& folder, const std::string& name, const std::string& script) {
  const std::filesystem::path plots = folder / "plots", picture = folder / (name + ".png");
  const std::string head = fmt::format(
      "# Run again, after changes, with: cd {} && gnuplot {}.gp\n"
      "if (!exists(\"target\")) target = \"../{}.png\"\n"
      "set output target\n",
      plots.string(), name, name);
  write_file(plots / (name + ".gp"), head + script);

  const std::string target = fmt::format("target='../{}.png.part'", name), file = name + ".gp";
  const pid_t child = fork();
  if (child == 0) {
    const int null = open("/dev/null", O_WRONLY);
    const int log = open((plots / (name + ".log")).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(null, STDOUT_FILENO);
    dup2(log >= 0 ? log : null, STDERR_FILENO);
    if (chdir(plots.c_str()) == 0) execlp("gnuplot", "gnuplot", "-e", target.c_str(), file.c_str(), nullptr);
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) < 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    std::error_code ignored;
    std::filesystem::remove(part_name(picture), ignored);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
      return fmt::format("no {}.png: gnuplot is not installed (apt-get install gnuplot-nox); its script is kept in {}",
                         name, plots.string());
    return fmt::format("no {}.png: gnuplot failed, see {}", name, (plots / (name + ".log")).string());
  }
  finish_file(picture);
  return {};
}

// A factor that people like: 1, 2 or 5 times a power of ten, not above x.
double round_down(double x) {
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  for (const double digit : {5.0, 2.0}) {
    if (x >= digit * power) return digit * power;
  }
  return power;
}

struct CrackStyle {
  Crack crack;
  const char* label;
  const char* colour;
  double width;
};
// From the least to the worst, the order of the legend and of drawing. Colours that stay apart for the colour-blind.
constexpr std::array<CrackStyle, kCrackCount> kCrackStyles{{{Crack::intact, "intact joint", "#8a7a68", 1.0},
                                                            {Crack::sliding_begun, "sliding begun", "#6baed6", 4.5},
                                                            {Crack::opening_begun, "opening begun", "#fdae2b", 4.5},
                                                            {Crack::slipped, "slipped", "#08519c", 5.5},
                                                            {Crack::open, "open crack", "#d7191c", 5.5},
                                                            {Crack::crushed, "crushed", "#7b1fa2", 5.5}}};

std::string title_of(const Scene& scene) {
  return scene.title.empty() ? std::filesystem::path(scene.file).stem().string() : scene.title;
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
                       const std::string& law) {
  make_folder(folder / "plots");
  const double area = scene.wall ? bed_area(*scene.wall) : 0.0;
  std::string data = "# displacement_mm horizontal_force_kN vertical_stress_MPa\n";
  double largest = 0.0, sign = 1.0;
  for (const HistoryRow& row : rows) {
    const Response r = response(row, scene.stages[static_cast<size_t>(row.stage)]);
    if (std::abs(r.displacement) > largest) {
      largest = std::abs(r.displacement);
      sign = r.displacement < 0 ? -1.0 : 1.0;
    }
  }
  for (const HistoryRow& row : rows) {
    const Response r = response(row, scene.stages[static_cast<size_t>(row.stage)]);
    data += fmt::format("{:.7g} {:.7g} {:.7g}\n", sign * r.displacement * 1e3, sign * r.horizontal_force / 1e3,
                        area > 0 ? r.vertical_force / area / 1e6 : 0.0);
  }
  write_file(folder / "plots" / "curve.dat", data);

  const Peak peak = find_peak(rows, scene);
  std::string script = fmt::format(R"gp(set terminal pngcairo size 1500,950 font "Sans,19" linewidth 1.5
set title {} noenhanced font "Sans,23"
set xlabel "horizontal displacement of the top beam (mm)"
set ylabel "horizontal force (kN)" textcolor rgb "#b3321e"
set border 11 linecolor rgb "#404040"
set xrange [0:*]
set yrange [0:*]
set xtics nomirror
set ytics nomirror textcolor rgb "#b3321e"
set grid xtics ytics linecolor rgb "#d8d8d8" linewidth 0.7
set key bottom right spacing 1.3 samplen 3 noenhanced
)gp",
                                   gnuplot_text(title_of(scene)));
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
    script += fmt::format(
        "set label 1 \"{0:.1f} kN at {1:.2f} mm\" at {1:.6g},{2:.6g} center offset 0,1.1 font \"Sans,19\" front\n"
        "set offsets graph 0, graph 0.02, graph 0.12, 0\n",
        peak.force / 1e3, peak.displacement * 1e3, peak.force / 1e3);
    script += fmt::format("$peak << EOD\n{:.6g} {:.6g}\nEOD\n", peak.displacement * 1e3, peak.force / 1e3);
    plot += ", \\\n     $peak with points pointtype 7 pointsize 1.6 linecolor rgb \"#b3321e\" notitle";
  }
  return draw(folder, "curve", script + plot + "\n");
}

std::string plot_cracks(const std::filesystem::path& folder, const Simulation& simulation, const Surfaces& surfaces,
                        const std::vector<HistoryRow>& rows, const std::string& law) {
  make_folder(folder / "plots");
  const Scene& scene = simulation.scene();
  const auto& bricks = simulation.assembly().bricks;

  // The wall moves by millimetres: magnify so that the largest movement is about 6 % of its height.
  Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  std::vector<std::vector<Vec3>> displacement;
  double largest = 0.0;
  for (size_t b = 0; b < bricks.size(); ++b) {
    displacement.push_back(simulation.block_displacement(static_cast<int>(b)));
    for (const Vec3& u : displacement.back()) largest = std::max(largest, std::hypot(u[0], u[1]));
    for (size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], bricks[b].origin[axis]);
      high[axis] = std::max(high[axis], bricks[b].origin[axis] + bricks[b].size[axis]);
    }
  }
  const double factor = largest > 1e-12 ? round_down(0.075 * (high[1] - low[1]) / largest) : 1.0;
  auto moved = [&](const Vec3& x, const Vec3& u) {
    return fmt::format("{:.6g} {:.6g}\n", (x[0] + factor * u[0]) * 1e3, (x[1] + factor * u[1]) * 1e3);
  };

  // Outlines of the front faces, counter-clockwise, along the gridpoints of their edges.
  std::string brick_data, beam_data;
  for (size_t b = 0; b < bricks.size(); ++b) {
    const Brick& brick = bricks[b];
    const auto& mesh = surfaces.mesh(static_cast<int>(b));
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
    std::string& data = brick.rigid ? beam_data : brick_data;
    for (const auto& [place, i] : outline) data += moved(mesh.gridpoint[i], displacement[b][i]);
    if (!outline.empty()) data += moved(mesh.gridpoint[outline[0].second], displacement[b][outline[0].second]);
    data += "\n";
  }
  write_file(folder / "plots" / "bricks.dat", brick_data.empty() ? "NaN NaN\n" : brick_data);
  write_file(folder / "plots" / "beams.dat", beam_data.empty() ? "NaN NaN\n" : beam_data);

  // Joints as seen from the front: of the points behind each other the most damaged one counts. Each point colours the
  // line half-way to its neighbours.
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
  std::array<std::string, kCrackCount> lines;
  for (const auto& [joint, places] : joints) {
    for (auto it = places.begin(); it != places.end() && std::next(it) != places.end(); ++it) {
      const JointPoint *a = it->second.front, *b = std::next(it)->second.front;
      Vec3 middle{}, shift{};
      for (size_t axis = 0; axis < 3; ++axis) {
        middle[axis] = (a->contact.position[axis] + b->contact.position[axis]) / 2;
        shift[axis] = (a->displacement[axis] + b->displacement[axis]) / 2;
      }
      lines[static_cast<size_t>(it->second.worst->crack)] +=
          moved(a->contact.position, a->displacement) + moved(middle, shift) + "\n";
      lines[static_cast<size_t>(std::next(it)->second.worst->crack)] +=
          moved(middle, shift) + moved(b->contact.position, b->displacement) + "\n";
    }
  }
  std::string plot;
  for (const CrackStyle& style : kCrackStyles) {
    const std::string& data = lines[static_cast<size_t>(style.crack)];
    const std::string file = fmt::format("joints_{}.dat", static_cast<int>(style.crack));
    write_file(folder / "plots" / file, data.empty() ? "NaN NaN\n" : data);
    plot += fmt::format(", \\\n     \"{}\" with lines linewidth {} linecolor rgb \"{}\" notitle", file, style.width,
                        style.colour);
  }
  for (const CrackStyle& style : kCrackStyles)
    plot += fmt::format(", \\\n     NaN with lines linewidth {} linecolor rgb \"{}\" title \"{}\"",
                        style.crack == Crack::intact ? 2.0 : 7.0, style.colour, style.label);

  std::string subtitle = "law " + law;
  if (!rows.empty()) {
    const Response r = response(rows.back(), scene.stages[static_cast<size_t>(rows.back().stage)]);
    subtitle += fmt::format(", top beam moved {:.2f} mm, horizontal force {:.1f} kN", std::abs(r.displacement) * 1e3,
                            std::abs(r.horizontal_force) / 1e3);
  }
  subtitle += fmt::format("; displacements drawn {:g} times larger", factor);
  const double width = (high[0] - low[0]) * 1e3, height = (high[1] - low[1]) * 1e3;
  const double margin = 0.05 * std::max(width, height);
  const double sway = largest * factor * 1e3;
  // A picture as wide or as high as the wall asks for, at one scale on both axes.
  const double inner = 1150.0, scale = inner / std::max(width + 2 * sway + 2 * margin, height + 2 * margin);
  const int pixels_x = static_cast<int>(std::max(1000.0, (width + 2 * sway + 2 * margin) * scale + 60));
  const int pixels_y = static_cast<int>((height + sway + 2 * margin) * scale + 250);
  const std::string script = fmt::format(
      R"gp(set terminal pngcairo size {},{} font "Sans,17"
set title {} . "\n" . {} noenhanced font "Sans,18"
set size ratio -1
set xrange [{:.6g}:{:.6g}]
set yrange [{:.6g}:{:.6g}]
unset border
unset tics
set key outside bottom center horizontal maxrows 2 samplen 2.5 spacing 1.3 width 2
set style fill solid 1.0 border linecolor rgb "#a08a72"
plot "beams.dat" with filledcurves closed fillcolor rgb "#b9c0c8" notitle, \
     "bricks.dat" with filledcurves closed fillcolor rgb "#ecdcc8" notitle, \
     "bricks.dat" with lines linewidth 0.8 linecolor rgb "#b09a80" notitle{}
)gp",
      pixels_x, pixels_y, gnuplot_text(title_of(scene)), gnuplot_text(subtitle), low[0] * 1e3 - margin - sway,
      high[0] * 1e3 + margin + sway, low[1] * 1e3 - margin, high[1] * 1e3 + margin + sway * 0.3, plot);
  return draw(folder, "cracks", script);
}

}  // namespace quoin
