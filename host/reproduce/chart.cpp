#include "reproduce/chart.h"

#include <fmt/format.h>

#include <array>

#include "files/file.h"
#include "files/gnuplot.h"

namespace quoin::reproduce {

namespace {

// Colours of Okabe and Ito, distinct for the colour-blind, and two more.
constexpr std::array<const char*, 8> kPalette{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                              "#8c6d1f", "#56b4e9", "#404040", "#e69f00"};
const char* colour_of(const Series& s) { return kPalette[static_cast<std::size_t>(s.colour) % kPalette.size()]; }

}  // namespace

void Chart::add(const std::string& label, const Curve& curve, int colour, Mark mark) {
  series.push_back({label, mark, curve.displacement, curve.force, colour});
}
void Chart::add_level(const std::string& label, Kind kind, double y, int colour) {
  series.push_back({fmt::format("{} {}", label, kind_tag(kind)), Mark::level, {}, {y}, colour});
}
void Chart::add_band(const std::string& label, Kind kind, double low, double high, int colour) {
  series.push_back({fmt::format("{} {}", label, kind_tag(kind)), Mark::band, {}, {low, high}, colour});
}
void Chart::add_points(const std::string& label, std::vector<double> x, std::vector<double> y, int colour) {
  series.push_back({label, Mark::points, std::move(x), std::move(y), colour});
}

void draw(const Chart& chart, const Findings& findings, StudyReport& report, const std::string& caption) {
  make_folder(findings.folder() / "plots");
  std::string bands, plot;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const Series& s = chart.series[i];
    const std::string file = fmt::format("{}_{}.dat", chart.name, i + 1);
    const std::string title = gnuplot_text(s.label);
    std::string item;
    switch (s.mark) {
      case Mark::level:
        item = fmt::format("{} with lines linewidth 1.6 dashtype (3,4) linecolor rgb \"{}\" title {}", s.y[0],
                           colour_of(s), title);
        break;
      case Mark::band:
        bands += fmt::format(
            "set object rectangle from graph 0, first {} to graph 1, first {} fillcolor rgb \"{}\" fillstyle "
            "transparent solid 0.18 noborder behind\n",
            s.y[0], s.y[1], colour_of(s));
        item = fmt::format("NaN with lines linewidth 9 linecolor rgb \"#c8{}\" title {}", colour_of(s) + 1, title);
        // the opacity c8 of ff is close to that of the rectangle
        break;
      default: {
        std::string data;
        for (std::size_t k = 0; k < s.x.size(); ++k) data += fmt::format("{:.8g} {:.8g}\n", s.x[k], s.y[k]);
        if (s.x.empty()) data += "NaN NaN\n";
        write_file(findings.folder() / "plots" / file, data);
        const char* how = s.mark == Mark::points   ? "points pointtype 7 pointsize 1.7"
                          : s.mark == Mark::dashed ? "lines linewidth 2 dashtype (10,5)"
                                                   : "lines linewidth 2.6";
        item = fmt::format("\"{}\" using 1:2 with {} linecolor rgb \"{}\" title {}", file, how, colour_of(s), title);
      }
    }
    plot += (plot.empty() ? "plot " : ", \\\n     ") + item;
  }
  const std::string script = fmt::format(
      R"gp(set terminal pngcairo size 1500,950 font "Sans,19" linewidth 1.5
set title {} noenhanced font "Sans,23"
set xlabel {} noenhanced
set ylabel {} noenhanced
set border 3 linecolor rgb "#404040"
set tics nomirror
set grid xtics ytics linecolor rgb "#d0d0d0" linewidth 0.8
set key {} font "Sans,16" spacing 1.25 samplen 3 noenhanced reverse Left
set autoscale xfix
{}set offsets 0, 0, graph 0.05, 0
{}{})gp",
      gnuplot_text(chart.title), gnuplot_text(chart.x_label), gnuplot_text(chart.y_label), chart.key,
      chart.from_zero ? "set xrange [0:*] noextend\nset yrange [0:*]\n" : "", bands, chart.extra);
  const std::string notice = draw_picture(findings.folder(), chart.name, script + plot + "\n");
  if (!notice.empty()) report.notices.push_back(notice);
  report.pictures.push_back({findings.relative(findings.folder() / (chart.name + ".png")), caption});
}

}  // namespace quoin::reproduce
