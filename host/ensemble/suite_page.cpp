#include "ensemble/suite_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "ensemble/figures.h"
#include "ensemble/no_number.h"
#include "ensemble/shake.h"
#include "ensemble/statistics.h"
#include "files/csv_text.h"
#include "files/file.h"
#include "files/gnuplot.h"
#include "files/markup.h"
#include "results/json_file.h"

namespace quoin::ensemble {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kCurvePoints = 60;
constexpr double kCurveEnds = 2.5;  // ends of a curve, in spreads on either side of the median

struct ShakenWall {
  std::uint64_t task;
  Sample sample;
  std::vector<ShakenRun> runs;
};

struct SuiteFragility {
  const LimitState* limit;
  IntensityMeasure measure;
  std::size_t observations = 0, reached = 0;
  std::vector<Capacity> capacities;
  std::optional<FittedFragility> fit;
};

std::vector<ShakenWall> read_walls(const StudyFolder& folder, const Study& study) {
  std::vector<ShakenWall> walls;
  for (std::uint64_t task = study.first_task(); task <= study.tasks(); ++task) {
    const fs::path place = folder.sample(task);
    if (is_finished(place)) walls.push_back({task, read_sample(place), read_runs(place)});
  }
  return walls;
}

// Capacities. Incremental: one for each wall and record. Otherwise each run is a bound on one side.
std::vector<Capacity> capacities_of(const Study& study, const std::vector<ShakenWall>& walls, double displacement,
                                    IntensityMeasure measure) {
  const auto m = static_cast<std::size_t>(measure);
  std::vector<Capacity> all;
  for (const ShakenWall& wall : walls) {
    if (wall.sample.status != "done") continue;
    const std::size_t record = study.record_of(wall.task);
    if (study.suite.method == RecordSuite::Method::incremental) {
      const Bracket b = bracket_of(wall.runs, measure, displacement);
      all.push_back({b.low, b.high, record});
      continue;
    }
    for (const ShakenRun& run : wall.runs) {
      const bool reached = run.collapsed() || (displacement > 0.0 && run.largest >= displacement);
      all.push_back(reached ? Capacity{0.0, run.intensity[m], record} : Capacity{run.intensity[m], HUGE_VAL, record});
    }
  }
  return all;
}

std::vector<SuiteFragility> fragilities_of(const Study& study, const std::vector<ShakenWall>& walls) {
  std::vector<SuiteFragility> all;
  for (const LimitState& limit : study.limits) {
    for (std::size_t m = 0; m < kMeasures; ++m) {
      const auto measure = static_cast<IntensityMeasure>(m);
      if (measure == IntensityMeasure::sa && study.suite.period <= 0.0) continue;
      SuiteFragility f{&limit, measure, 0, 0, capacities_of(study, walls, limit.displacement, measure), {}};
      f.observations = f.capacities.size();
      for (const Capacity& c : f.capacities) f.reached += std::isfinite(c.high) ? 1 : 0;
      f.fit = FittedFragility::of(f.capacities, study.seed);
      all.push_back(std::move(f));
    }
  }
  return all;
}

std::string runs_text(const Study& study, const std::vector<ShakenWall>& walls) {
  std::string text =
      "sample,record,name,wall,run,status,factor,pga_m_s2,pgv_m_s,sa_m_s2,largest_displacement_m,"
      "residual_displacement_m,largest_base_shear_N,time_s,reason\n";
  for (const ShakenWall& wall : walls) {
    const std::size_t record = study.record_of(wall.task);
    for (std::size_t i = 0; i < wall.runs.size(); ++i) {
      const ShakenRun& run = wall.runs[i];
      text += fmt::format("{},{},{},{},{},{},{}", wall.task, record + 1, csv_text(study.suite.records[record].name),
                          study.wall_of(wall.task), i + 1, run.status, csv_number(run.factor));
      for (const double intensity : run.intensity) text += "," + csv_number(intensity);
      for (const double value : {run.largest, run.residual, run.base_shear, run.time}) text += "," + csv_number(value);
      text += "," + (run.reason.empty() ? "" : csv_text(run.reason)) + "\n";
    }
  }
  return text;
}

std::string fragility_text(const std::vector<SuiteFragility>& all) {
  std::string text =
      "limit,intensity,median,median_low_95,median_high_95,spread,spread_low_95,spread_high_95,observations,reached\n";
  for (const SuiteFragility& f : all) {
    text += fmt::format("{},{}", csv_text(f.limit->name), names_of(f.measure).column);
    if (f.fit)
      for (const double value : {f.fit->median, f.fit->of_median.low, f.fit->of_median.high, f.fit->spread,
                                 f.fit->of_spread.low, f.fit->of_spread.high})
        text += "," + csv_number(value);
    else
      text += ",,,,,,";
    text += fmt::format(",{},{}\n", f.observations, f.reached);
  }
  return text;
}

// Intensities of the points of a fitted curve.
std::vector<double> grid_of(const FittedFragility& fit) {
  std::vector<double> grid;
  for (int k = 0; k <= kCurvePoints; ++k)
    grid.push_back(fit.median * std::exp(fit.spread * kCurveEnds * (2.0 * k / kCurvePoints - 1.0)));
  return grid;
}

std::string curve_text(const std::vector<SuiteFragility>& all) {
  std::string text = "limit,intensity,value,probability,probability_low_95,probability_high_95\n";
  for (const SuiteFragility& f : all) {
    if (!f.fit) continue;
    for (const double x : grid_of(*f.fit)) {
      const Interval band = f.fit->probability_interval(x);
      text += fmt::format("{},{},{},{},{},{}\n", csv_text(f.limit->name), names_of(f.measure).column, csv_number(x),
                          csv_number(f.fit->probability(x)), csv_number(band.low), csv_number(band.high));
    }
  }
  return text;
}

// Draws walls and records by their intensity at collapse, or runs by their end.
void draw_runs(const Study& study, const std::vector<ShakenWall>& walls, Pictures& pictures) {
  const auto m = static_cast<std::size_t>(study.suite.measure);
  std::string lines, collapses;
  for (const ShakenWall& wall : walls) {
    std::vector<ShakenRun> runs = wall.runs;
    std::sort(runs.begin(), runs.end(),
              [&](const ShakenRun& a, const ShakenRun& b) { return a.intensity[m] < b.intensity[m]; });
    for (const ShakenRun& run : runs) {
      if (run.failed()) continue;
      const double shown = std::min(run.largest, study.suite.displacement);
      (run.collapsed() ? collapses : lines) += fmt::format("{:.8g} {:.8g}\n", shown * 1e3, run.intensity[m]);
    }
    lines += '\n';
  }
  if (lines.find_first_not_of('\n') == std::string::npos) lines = "0 0\n";
  if (collapses.empty()) collapses = "NaN NaN\n";
  const bool joined = study.suite.method == RecordSuite::Method::incremental;
  pictures.draw("runs", lines + "\n\n" + collapses, "largest displacement against the ground, mm",
                names_of(study.suite.measure).label,
                fmt::format("set xrange [0:*]\nset yrange [0:*]\nplot 'runs.dat' index 0 using 1:2 with {} pointtype 7 "
                            "pointsize 0.8 linecolor rgb '#0072b2' title 'stands', '' index 1 using 1:2 with points "
                            "pointtype 2 linewidth 2 linecolor rgb '#d55e00' title 'collapsed'\n",
                            joined ? "linespoints" : "points"),
                "Every run by its intensity and how far any block has moved against the ground; what moved farther "
                "than the displacement of collapse is drawn there.");
}

void draw_fragilities(const std::vector<SuiteFragility>& all, IntensityMeasure measure, Pictures& pictures) {
  constexpr std::array<const char*, 4> kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7"};
  std::string data, plot;
  int block = 0;
  for (const SuiteFragility& f : all) {
    if (f.measure != measure || !f.fit) continue;
    for (const double x : grid_of(*f.fit)) {
      const Interval band = f.fit->probability_interval(x);
      data += fmt::format("{:.8g} {:.8g} {:.8g} {:.8g}\n", x, f.fit->probability(x), band.low, band.high);
    }
    data += "\n\n";
    const char* colour = kColours[static_cast<std::size_t>(block) % kColours.size()];
    plot += fmt::format(
        "{}'fragility_{}.dat' index {} using 1:3:4 with filledcurves linecolor rgb '{}' notitle, '' index {} using 1:2 "
        "with lines linewidth 2.4 linecolor rgb '{}' title {}",
        plot.empty() ? "plot " : ", ", names_of(measure).key, block, colour, block, colour,
        gnuplot_text(fmt::format("{}: median {:.3g}, spread {:.2g}", f.limit->name, f.fit->median, f.fit->spread)));
    ++block;
  }
  if (plot.empty()) return;
  pictures.draw(fmt::format("fragility_{}", names_of(measure).key), data, names_of(measure).label, "probability",
                "set yrange [0:1]\nset xrange [0:*]\n" + plot + "\n",
                "Probability that a record of this intensity makes a wall reach a limit, with its band of 95 %.");
}

constexpr const char* kNoFit = "none has reached it, all have at the least level, or as many have at lower levels";

std::string interval_text(const Interval& interval, int digits) {
  if (std::isnan(interval.low)) return "not known from fewer than 3 records";
  return fmt::format("{:.{}g} to {:.{}g}", interval.low, digits, interval.high, digits);
}

std::string spread_text(const FittedFragility& fit) {
  return fit.spread_is_bound ? fmt::format("not determined: every one below {:.2g} is as likely", fit.spread)
                             : fmt::format("{:.3g}", fit.spread);
}

std::string page_body(const Study& study, const std::vector<ShakenWall>& walls, const SuiteResults& results,
                      const std::vector<SuiteFragility>& fragilities, const std::string& figures) {
  std::string rows, failures;
  for (const SuiteFragility& f : fragilities) {
    rows += fmt::format("<tr><td>{}</td><td>{}</td>", escaped(f.limit->name), names_of(f.measure).label);
    rows += f.fit ? fmt::format("<td>{:.4g}</td><td>{}</td><td>{}</td><td>{}</td>", f.fit->median,
                                interval_text(f.fit->of_median, 4), spread_text(*f.fit),
                                f.fit->spread_is_bound ? "" : interval_text(f.fit->of_spread, 3))
                  : fmt::format("<td colspan=\"4\">no distribution fits: {}</td>", kNoFit);
    rows += fmt::format("<td>{} of {}</td></tr>\n", f.reached, f.observations);
  }
  int listed = 0;
  for (const ShakenWall& wall : walls) {
    if (wall.sample.status == "done" || ++listed > 20) continue;
    failures += fmt::format("<li>{}: {}</li>\n", wall.task, escaped(wall.sample.reason));
  }
  return fmt::format(
      R"(<p>{} of {} finished (records times walls), {} of them failed, {} runs. Numbers:
<a href="samples.csv">samples.csv</a>, <a href="runs.csv">runs.csv</a>, <a href="fragility.csv">fragility.csv</a>,
<a href="fragility_curves.csv">fragility_curves.csv</a>, <a href="summary.json">summary.json</a>.</p>
<table><tr><th>limit</th><th>intensity</th><th>median</th><th>95 %</th><th>spread</th><th>95 %</th><th>reached</th></tr>
{}</table>
{}{})",
      results.finished, study.tasks(), results.failed, results.runs, rows, figures,
      failures.empty() ? "" : "<h2>Failed</h2>\n<ul>\n" + failures + "</ul>\n");
}

Json summary_of(const Study& study, const SuiteResults& results, const std::vector<SuiteFragility>& fragilities) {
  Json json{{"study", study.title},      {"scene", fs::path(study.scene).filename().string()},
            {"seed", study.seed},        {"records", study.suite.records.size()},
            {"walls", study.samples},    {"finished", results.finished},
            {"failed", results.failed},  {"runs", results.runs},
            {"fragility", Json::array()}};
  for (const SuiteFragility& f : fragilities) {
    Json one{{"name", f.limit->name},
             {"intensity", names_of(f.measure).column},
             {"observations", f.observations},
             {"reached", f.reached}};
    one["median"] = f.fit ? number_or_null(f.fit->median) : Json(nullptr);
    one["spread"] = f.fit ? number_or_null(f.fit->spread) : Json(nullptr);
    if (f.fit) {
      one["spread_is_bound"] = f.fit->spread_is_bound;
      one["median_95"] = {number_or_null(f.fit->of_median.low), number_or_null(f.fit->of_median.high)};
      one["spread_95"] = {number_or_null(f.fit->of_spread.low), number_or_null(f.fit->of_spread.high)};
    }
    json["fragility"].push_back(one);
  }
  return json;
}

}  // namespace

SuiteResults gather_suite(const StudyFolder& folder, const Study& study, bool pictures) {
  const std::unique_ptr<Claim> alone = Claim::wait_for(folder.gathering());
  const std::vector<ShakenWall> walls = read_walls(folder, study);
  SuiteResults results;
  std::vector<std::pair<std::uint64_t, Sample>> samples;
  for (const ShakenWall& wall : walls) {
    samples.emplace_back(wall.task, wall.sample);
    ++results.finished, results.failed += wall.sample.status == "done" ? 0 : 1, results.runs += wall.runs.size();
  }
  const std::vector<SuiteFragility> fragilities = fragilities_of(study, walls);
  for (const SuiteFragility& f : fragilities) {
    const std::string what = fmt::format("{}, {}: ", f.limit->name, names_of(f.measure).label);
    if (!f.fit) {
      results.text += what + "no distribution fits: " + kNoFit + "\n";
      continue;
    }
    results.text +=
        fmt::format("{}median {:.3g} (95 %: {}), spread {}{}\n", what, f.fit->median,
                    interval_text(f.fit->of_median, 3), spread_text(*f.fit),
                    f.fit->spread_is_bound ? "" : fmt::format(" (95 %: {})", interval_text(f.fit->of_spread, 2)));
  }
  const fs::path& place = folder.path();
  write_file(place / "samples.csv", table_text(samples, suite_output_names(study.suite)));
  write_file(place / "runs.csv", runs_text(study, walls));
  write_file(place / "fragility.csv", fragility_text(fragilities));
  write_file(place / "fragility_curves.csv", curve_text(fragilities));
  write_json(place / "summary.json", summary_of(study, results, fragilities));
  const std::string title = study.title.empty() ? study.scene : study.title;
  Pictures drawn(place, study.title);
  if (pictures && !walls.empty()) {
    make_folder(place / "plots");
    draw_runs(study, walls, drawn);
    for (std::size_t m = 0; m < kMeasures; ++m) draw_fragilities(fragilities, static_cast<IntensityMeasure>(m), drawn);
  }
  write_page_of(place, title, page_body(study, walls, results, fragilities, drawn.figures()));
  return results;
}

}  // namespace quoin::ensemble
