// histories.png: displacements, forces, multiplier and energies over time, a panel each.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "files/file.h"
#include "files/gnuplot.h"
#include "results/colours.h"
#include "results/history.h"
#include "results/picture_text.h"
#include "results/plots.h"

namespace quoin {

namespace {

struct PlottedLine {
  std::string name;
  std::function<double(const HistoryRow&)> value;  // in the unit of the panel
};
struct Panel {
  std::string label;
  std::vector<PlottedLine> lines;
};

bool is_shaken(const Scene& scene) {
  return std::any_of(scene.stages.begin(), scene.stages.end(), [](const Stage& s) { return s.ground.has_value(); });
}

// Values of the part that the title names; NaN, a gap, in rows of stages that watch another.
std::function<double(const HistoryRow&)> of_part(const Scene& scene, std::function<double(const HistoryRow&)> value) {
  std::vector<bool> has_part;
  for (const Stage& stage : scene.stages) has_part.push_back(watches_part_of_curve(scene, stage));
  return [has_part, value = std::move(value)](const HistoryRow& row) {
    return has_part[static_cast<std::size_t>(row.stage)] ? value(row) : std::nan("");
  };
}

Panel displacements(const Scene& scene) {
  Panel panel{"displacement (mm)", {}};
  const auto part = is_shaken(scene) ? &HistoryRow::monitor_relative : &HistoryRow::monitor_displacement;
  for (std::size_t c = 0; c < 3; ++c)
    panel.lines.push_back(
        {fmt::format("along {}", "xyz"[c]), of_part(scene, [=](const HistoryRow& r) { return (r.*part)[c] * 1e3; })});
  return panel;
}

Panel forces(const Scene& scene) {
  const auto horizontal = [&scene](const HistoryRow& r) {
    return response(r, scene.stages[static_cast<std::size_t>(r.stage)]).horizontal_force / 1e3;
  };
  const auto vertical = [](const HistoryRow& r) { return r.vertical_force / 1e3; };
  return {"force (kN)", {{"horizontal", of_part(scene, horizontal)}, {"vertical", of_part(scene, vertical)}}};
}

Panel energies(bool all) {
  Panel panel{"energy (J)", {{"kinetic", [](const HistoryRow& r) { return r.kinetic_energy; }}}};
  if (!all) return panel;
  const auto add = [&](const char* name, double (*part)(const Energies&)) {
    panel.lines.push_back(
        {name, [part](const HistoryRow& r) { return r.energies ? part(*r.energies) : std::nan(""); }});
  };
  add("strain", [](const Energies& e) { return e.strain; });
  add("stored in joints", [](const Energies& e) { return e.contact_stored; });
  add("stored in members", [](const Energies& e) { return e.members_stored; });
  add("spent in joints", [](const Energies& e) { return e.dissipated_total(); });
  add("spent in members", [](const Energies& e) { return e.members_dissipated; });
  add("damping", [](const Energies& e) { return e.damping; });
  add("external work", [](const Energies& e) { return e.external; });
  return panel;
}

std::string title_text(const Scene& scene) {
  if (scene.stages.empty() || watches_nothing(scene, stage_of_curve(scene))) return title_of(scene);
  return fmt::format("{}: motion of {}{}", title_of(scene), moved_part(scene, stage_of_curve(scene)),
                     is_shaken(scene) ? ", relative to the ground" : "");
}

// Panels without lines that stay at 0, and without panels that have no other line.
std::vector<Panel> panels_of(const std::vector<HistoryRow>& rows, const Scene& scene) {
  std::vector<Panel> panels{displacements(scene),
                            forces(scene),
                            {"multiplier", {{"of the weight", [](const HistoryRow& r) { return r.multiplier; }}}},
                            energies(scene.output.energy || (!rows.empty() && rows.back().energies))};
  for (Panel& panel : panels) {
    std::erase_if(panel.lines, [&](const PlottedLine& line) {
      return std::all_of(rows.begin(), rows.end(), [&](const HistoryRow& r) {
        const double value = line.value(r);
        return value == 0.0 || !std::isfinite(value);
      });
    });
  }
  std::erase_if(panels, [](const Panel& panel) { return panel.lines.empty(); });
  return panels;
}

}  // namespace

std::string plot_histories(const std::filesystem::path& folder, const std::vector<HistoryRow>& rows, const Scene& scene,
                           const std::string& label) {
  make_folder(folder / "plots");
  const std::vector<Panel> panels = panels_of(rows, scene);
  if (panels.empty()) return "no histories.png: nothing has moved";
  std::string data = "# time_s, then the lines of the panels\n";
  for (const HistoryRow& row : rows) {
    data += fmt::format("{:.7g}", row.time);
    for (const Panel& panel : panels)
      for (const PlottedLine& line : panel.lines) data += fmt::format(" {:.7g}", line.value(row));
    data += '\n';
  }
  write_file(folder / "plots" / "histories.dat", data);

  const double height = 280.0 * static_cast<double>(panels.size()) + 160.0;
  std::string script = fmt::format(
      "set terminal pngcairo size 1500,{:.0f} font \"Sans,15\" linewidth 1.5\n"
      "set multiplot layout {},1 margins 0.09,0.80,{:.4f},{:.4f} spacing 0,{:.4f}\n"
      "set label 1 {} at screen 0.45,{:.4f} center noenhanced font \"Sans,19\"\n"
      "set border 3 linecolor rgb \"#404040\"\nset tics nomirror\nset format x \"%g\"\nset xrange [{:.6g}:{:.6g}]\n"
      "set grid xtics ytics linecolor rgb \"#b8b8b8\" linewidth 0.8\n"
      "set key at graph 1.02,0.98 left top reverse Left samplen 2 noenhanced\n",
      height, panels.size(), 100.0 / height, 1.0 - 70.0 / height, 50.0 / height,
      fitting_text(title_text(scene), 1300, 19), 1.0 - 30.0 / height, rows.front().time,
      std::max(rows.back().time, rows.front().time + 1e-9));
  int arrow = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].stage != rows[i - 1].stage)
      script += fmt::format(
          "set arrow {0} from first {1:.6g}, graph 0 to first {1:.6g}, graph 1 nohead linecolor rgb \"#888888\"\n",
          ++arrow, rows[i - 1].time);
  }
  int column = 1;
  for (std::size_t p = 0; p < panels.size(); ++p) {
    std::string plot;
    for (std::size_t k = 0; k < panels[p].lines.size(); ++k)
      plot += fmt::format(
          "{}\"histories.dat\" using 1:{} with lines linewidth {} dashtype {} linecolor rgb \"{}\" title {}",
          k == 0 ? "plot " : ", ", ++column, k % 2 == 0 ? 2.5 : 1.5, k < 3 ? "solid" : "(8,4)", kPens[k % kPens.size()],
          fitting_text(panels[p].lines[k].name, 230, 15));
    const bool last = p + 1 == panels.size();
    script += fmt::format("set ylabel {} noenhanced\nset xlabel {}\n{}{}\nunset label 1\n",
                          fitting_text(panels[p].label, 260, 13),
                          last ? "\"time (s), lines where a stage begins\"" : "\"\"", last ? label : "", plot);
  }
  return draw_picture(folder, "histories", script + "unset multiplot\n");
}

}  // namespace quoin
