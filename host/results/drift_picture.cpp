// drifts.png: the envelope of drifts between monitors over their height.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "files/file.h"
#include "files/gnuplot.h"
#include "results/colours.h"
#include "results/picture_text.h"
#include "results/plots.h"

namespace quoin {

namespace {

using Column = std::vector<StoreyDrift>;  // storeys one upon the other, from the lowest

std::vector<Column> columns_of(const std::vector<StoreyDrift>& storeys) {
  std::vector<Column> columns;
  for (const StoreyDrift& storey : storeys) {
    const auto continued = std::find_if(columns.begin(), columns.end(),
                                        [&](const Column& column) { return column.back().name == storey.below; });
    if (continued != columns.end())
      continued->push_back(storey);
    else
      columns.push_back({storey});
  }
  return columns;
}

using Extremes = std::array<double, 2> StoreyDrift::*;

double largest_of(const std::vector<StoreyDrift>& storeys, std::size_t axis) {
  double largest = 0.0;
  for (const StoreyDrift& s : storeys) largest = std::max({largest, -s.least[axis], s.most[axis]});
  return largest;
}

}  // namespace

std::string plot_drifts(const std::filesystem::path& folder, const std::vector<StoreyDrift>& storeys,
                        const Scene& scene, const std::string& label) {
  if (storeys.empty()) return {};
  const double largest = std::max(largest_of(storeys, 0), largest_of(storeys, 1));
  if (!(largest > 0.0)) return "no drifts.png: nothing has moved";
  constexpr double kStill = 1e-3;  // share of the largest drift below which an axis has no line
  const std::vector<Column> columns = columns_of(storeys);
  std::string data = "# drift_percent height_m", plot;
  int lines = 0;
  for (const Column& column : columns) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (largest_of(column, axis) < kStill * largest) continue;
      for (const Extremes extreme : {&StoreyDrift::least, &StoreyDrift::most}) {
        data += '\n';
        for (const StoreyDrift& s : column)
          data += fmt::format("{0:.7g} {1:.7g}\n{0:.7g} {2:.7g}\n", 100.0 * (s.*extreme)[axis], s.bottom, s.top);
      }
      data += '\n';
      const std::string name =
          fmt::format("along {}{}", "xz"[axis], columns.size() > 1 ? ", up to " + column.back().name : "");
      plot += fmt::format("{}\"drifts.dat\" index {} with lines linewidth 3 dashtype {} linecolor rgb \"{}\" title {}",
                          lines == 0 ? "plot " : ", \\\n     ", lines, axis == 0 ? "solid" : "(8,4)",
                          kPens[static_cast<std::size_t>(lines) % kPens.size()], fitting_text(name, 420, 17));
      ++lines;
    }
  }
  make_folder(folder / "plots");
  write_file(folder / "plots" / "drifts.dat", data);
  return draw_picture(
      folder, "drifts",
      fmt::format("set terminal pngcairo size 1100,1000 font \"Sans,17\" linewidth 1.5\n"
                  "set tmargin at screen 0.88\nset rmargin at screen 0.94\n{}"
                  "set title {} noenhanced font \"Sans,21\" offset 0,1.6\n"
                  "set xlabel \"least and largest drift between monitors (%)\" noenhanced\n"
                  "set ylabel \"height (m)\" noenhanced\n"
                  "set border 3 linecolor rgb \"#404040\"\nset format \"%g\"\nset tics nomirror\n"
                  "set grid xtics ytics linecolor rgb \"#b8b8b8\" linewidth 0.8\n"
                  "set yzeroaxis linecolor rgb \"#606060\" linewidth 1.2\n"
                  "set offsets graph 0.05, graph 0.05, 0, 0\n"
                  "set key at screen 0.5,0.915 center horizontal samplen 3 reverse Left noenhanced\n",
                  label.empty() ? "" : "set bmargin at screen 0.2\n", fitting_text(title_of(scene), 1000, 21)) +
          label + plot + "\n");
}

}  // namespace quoin
