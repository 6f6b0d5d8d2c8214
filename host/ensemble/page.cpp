#include "ensemble/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "base/input_file.h"
#include "base/number_text.h"
#include "ensemble/figures.h"
#include "ensemble/no_number.h"
#include "ensemble/statistics.h"
#include "files/file.h"
#include "files/gnuplot.h"
#include "files/markup.h"
#include "files/notice.h"
#include "random/distribution.h"
#include "results/json_file.h"
#include "results/plots.h"
#include "scene/scatter_text.h"

namespace quoin::ensemble {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kGrid = 200;  // number of places of the bands along the displacement
constexpr std::array kBands{0.05, 0.16, 0.5, 0.84, 0.95};

Json pair(const Interval& i) { return Json::array({number_or_null(i.low), number_or_null(i.high)}); }

using Numbered = std::vector<std::pair<std::uint64_t, Sample>>;

struct Results {
  Numbered samples;
  std::optional<Sample> of_means;
  std::vector<std::string> inputs;
  std::map<std::string, std::vector<double>> column;  // inputs and outputs of all samples without failure
  std::vector<Curve> curves;
  Curve curve_of_means;
  std::optional<bool> vertical;  // whether curves are those of a vertical test, by the first run that has a peak
};

double value_of(const Values& values, const std::string& name) {
  for (const auto& [known, value] : values) {
    if (known == name) return value;
  }
  return kNone;
}

// The n-th cell of a CSV row, counted from `at`.
std::string_view cell(std::string_view row, std::size_t at, std::size_t n) {
  for (; n > 0; --n) {
    at = row.find(',', at);
    if (at++ == std::string_view::npos) return {};
  }
  return row.substr(at, row.find(',', at) - at);
}

// Whether the peak of a run is that of a vertical test; no value: it has no peak.
std::optional<bool> has_vertical_peak(const fs::path& sample) {
  const fs::path file = sample / "summary.json";
  if (!fs::exists(file)) return std::nullopt;
  const Json json = Json::parse(read_input_file(file.string()), nullptr, false);
  const auto has = [&](const char* key) { return json.is_object() && json.value(key, Json()).is_number(); };
  if (has("peak_vertical_force_N")) return true;
  return has("peak_horizontal_force_N") ? std::optional(false) : std::nullopt;
}

// Curve of the last stage: largest displacement so far in the sense of the push, and the force at it, of vertical tests
// its magnitude.
Curve read_curve(const fs::path& sample, bool vertical) {
  const std::size_t at_displacement = vertical ? 3 : 2, at_force = vertical ? 5 : 4;
  std::ifstream stream(sample / "history.csv");
  std::string line;
  std::vector<std::array<double, 3>> rows;  // stage, displacement, force
  std::getline(stream, line);
  while (std::getline(stream, line)) {
    const std::size_t first = line.find(','), quoted = line.find("\",", first + 2);  // the name of the stage
    if (quoted == std::string::npos) continue;
    double stage = 0.0, displacement = 0.0, force = 0.0;
    if (parse_number(std::string_view(line).substr(0, first), stage) &&
        parse_number(cell(line, quoted + 2, at_displacement), displacement) &&
        parse_number(cell(line, quoted + 2, at_force), force))
      rows.push_back({stage, displacement, force});
  }
  std::erase_if(rows, [last = rows.empty() ? 0.0 : rows.back()[0]](const auto& row) { return row[0] != last; });
  double lowest = 0.0, highest = 0.0;
  for (const auto& row : rows) lowest = std::min(lowest, row[1]), highest = std::max(highest, row[1]);
  const double sense = sense_of_push(lowest, highest);
  Curve curve;
  for (const auto& [stage, displacement, force] : rows) {
    const double u = sense * displacement;
    if (!curve.displacement.empty() && u <= curve.displacement.back()) continue;
    curve.displacement.push_back(u), curve.force.push_back(vertical ? std::abs(force) : sense * force);
  }
  return curve;
}

Results read_results(const StudyFolder& folder, std::uint64_t samples) {
  Results r;
  if (is_finished(folder.sample(0))) {
    r.of_means = read_sample(folder.sample(0));
    r.vertical = has_vertical_peak(folder.sample(0));
    r.curve_of_means = read_curve(folder.sample(0), r.vertical.value_or(false));
  }
  for (std::uint64_t i = 1; i <= samples; ++i) {
    if (is_finished(folder.sample(i))) r.samples.emplace_back(i, read_sample(folder.sample(i)));
  }
  const Values* inputs = nullptr;
  for (const auto& [i, sample] : r.samples) {
    if (!inputs || sample.inputs.size() > inputs->size()) inputs = &sample.inputs;
  }
  for (std::size_t k = 0; inputs && k < inputs->size(); ++k) r.inputs.push_back((*inputs)[k].first);
  for (const auto& [i, sample] : r.samples) {
    if (sample.status != "done") continue;
    for (const std::string& name : r.inputs) r.column[name].push_back(value_of(sample.inputs, name));
    for (const std::string& name : output_names()) r.column[name].push_back(value_of(sample.outputs, name));
    if (!r.vertical) r.vertical = has_vertical_peak(folder.sample(i));
    r.curves.push_back(read_curve(folder.sample(i), r.vertical.value_or(false)));
  }
  return r;
}

bool is_known(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

// ---- summary.json ---------------------------------------------------------------------------------------------------

Json output_json(const Results& r, const std::string& name) {
  const std::vector<double>& values = r.column.at(name);
  const Moments m = moments_of(values);
  Json json{{"count", m.count},
            {"mean", number_or_null(m.mean)},
            {"mean_95", pair(m.of_mean)},
            {"scatter", number_or_null(m.scatter)},
            {"scatter_95", pair(m.of_scatter)}};
  for (const double p : kBands) {
    json["quantiles"][fmt::format("{}", p)] = {{"value", number_or_null(quantile_of(values, p))},
                                               {"interval_95", pair(quantile_interval(values, p))}};
  }
  json["of_means"] = r.of_means ? number_or_null(value_of(r.of_means->outputs, name)) : Json(nullptr);
  // Convergence of the estimate with the number of samples.
  for (std::size_t n = 5; n <= values.size(); n = n < values.size() ? std::min(values.size(), n * 2) : n + 1) {
    const Moments then = moments_of({values.begin(), values.begin() + static_cast<std::ptrdiff_t>(n)});
    json["convergence"].push_back(
        {{"samples", n}, {"mean", number_or_null(then.mean)}, {"mean_95", pair(then.of_mean)}});
  }
  return json;
}

struct Influence {
  std::string input, output;
  Dependence dependence;
};
std::vector<Influence> influences_of(const Results& r) {
  std::vector<Influence> result;
  for (const char* output : {"peak_force_N", "displacement_at_peak_m", "work_J", "collapse_multiplier"}) {
    for (const std::string& input : r.inputs) {
      if (!r.column.contains(output)) continue;
      if (const auto d = dependence_of(r.column.at(input), r.column.at(output))) result.push_back({input, output, *d});
    }
  }
  return result;
}

struct Bands {
  std::vector<double> displacement, mean, of_means;
  std::array<std::vector<double>, kBands.size()> quantile;
};
Bands bands_of(const Results& r) {
  double end = HUGE_VAL;
  for (const Curve& c : r.curves) end = std::min(end, c.displacement.empty() ? 0.0 : c.displacement.back());
  Bands b;
  if (r.curves.empty() || end == 0.0) return b;
  for (int k = 0; k <= kGrid; ++k) {
    const double u = end * k / kGrid;
    std::vector<double> forces;
    for (const Curve& c : r.curves) forces.push_back(force_at(c, u));
    b.displacement.push_back(u);
    b.mean.push_back(moments_of(forces).mean);
    for (std::size_t q = 0; q < kBands.size(); ++q) b.quantile[q].push_back(quantile_of(forces, kBands[q]));
    b.of_means.push_back(force_at(r.curve_of_means, u));
  }
  return b;
}

// ---- Pictures -------------------------------------------------------------------------------------------------------

void draw_bands(const Bands& b, bool vertical, Pictures& pictures) {
  if (b.displacement.empty()) return;
  std::string data;
  for (std::size_t k = 0; k < b.displacement.size(); ++k) {
    data += fmt::format("{:.8g} {:.8g} {:.8g}", b.displacement[k] * 1e3, b.mean[k] / 1e3, b.of_means[k] / 1e3);
    for (const auto& q : b.quantile) data += fmt::format(" {:.8g}", q[k] / 1e3);
    data += '\n';
  }
  pictures.draw(
      "bands", data, "displacement, mm", vertical ? "vertical force, kN" : "horizontal force, kN",
      "plot 'bands.dat' using 1:4:8 with filledcurves linecolor rgb '#56b4e9' title '5 to 95 %', "
      "'' using 1:5:7 with filledcurves linecolor rgb '#0072b2' title '16 to 84 %', "
      "'' using 1:6 with lines linewidth 1.5 dashtype 2 linecolor rgb '#0072b2' title 'median', "
      "'' using 1:2 with lines linewidth 2.6 linecolor rgb '#0072b2' title 'mean', "
      "'' using 1:3 with lines linewidth 2.6 linecolor rgb '#d55e00' title 'everything at its mean'\n",
      "Quantiles of the force at each displacement, its mean, and the curve of a wall whose properties are all "
      "at their means.");
}

void draw_convergence(const std::vector<double>& peaks, Pictures& pictures) {
  std::string data;
  for (std::size_t n = 3; n <= peaks.size(); ++n) {
    const Moments m = moments_of({peaks.begin(), peaks.begin() + static_cast<std::ptrdiff_t>(n)});
    data += fmt::format("{} {:.8g} {:.8g} {:.8g}\n", n, m.mean / 1e3, m.of_mean.low / 1e3, m.of_mean.high / 1e3);
  }
  if (data.empty()) return;
  pictures.draw("convergence", data, "samples", "mean peak, kN",
                "plot 'convergence.dat' using 1:3:4 with filledcurves linecolor rgb '#56b4e9' title '95 % interval', "
                "'' using 1:2 with "
                "lines linewidth 2.6 linecolor rgb '#0072b2' title 'mean of the first samples'\n",
                "The mean of the peaks and its 95 % interval as samples are added.");
}

// Values of an output at which samples reach a limit; NaN: not reached. A force that is largest at the end of the run
// would have grown further, so such a sample has not reached its peak.
std::vector<double> capacities_of(const Study& study, const std::string& output, const Results& r) {
  std::vector<double> values = r.column.at(output);
  if (output != "displacement_at_peak_m" && output != "drift_at_peak") return values;
  const std::vector<double>&peak = r.column.at("peak_force_N"), &last = r.column.at("last_force_N");
  long rising = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(std::abs(last[i]) >= peak[i])) continue;
    values[i] = std::numeric_limits<double>::quiet_NaN(), ++rising;
  }
  if (rising > 0)
    notice(
        fmt::format("quoin: {}: fragility of '{}': {} of {} samples end with their largest force, so their peak is not "
                    "reached; push them farther",
                    study.file, output, rising, values.size()));
  return values;
}

void draw_fragility(const std::vector<std::pair<std::string, std::vector<double>>>& limits, const std::string& x,
                    Pictures& pictures) {
  std::string data, plot;
  int block = 0;
  constexpr std::array<const char*, 4> colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7"};
  for (const auto& [name, values] : limits) {
    const Fragility f = fragility_of(values);
    if (f.fit == "none") continue;
    std::vector<double> reached;
    for (const double v : values) {
      if (std::isfinite(v)) reached.push_back(v);
    }
    std::sort(reached.begin(), reached.end());
    for (std::size_t i = 0; i < reached.size(); ++i)
      data += fmt::format("{:.8g} {:.8g} {:.8g}\n", reached[i],
                          (static_cast<double>(i) + 0.5) / static_cast<double>(values.size()),
                          random::normal_probability(std::log(reached[i] / f.median) / f.spread));
    data += "\n\n";
    const char* colour = colours[static_cast<std::size_t>(block) % colours.size()];
    plot += fmt::format(
        "{}'fragility.dat' index {} using 1:2 with points pointtype 7 linecolor rgb '{}' title {}, '' index {} using "
        "1:3 with lines linewidth 2.4 linecolor rgb '{}' title {}",
        plot.empty() ? "plot " : ", ", block, colour, gnuplot_text(name), block, colour,
        gnuplot_text(fmt::format("median {:.4g}, spread {:.3g}", f.median, f.spread)));
    ++block;
  }
  if (plot.empty()) return;
  pictures.draw("fragility", data, x, "probability of reaching it", "set yrange [0:1]\n" + plot + "\n",
                "Probability of having reached a limit: samples, and a lognormal distribution.");
}

void draw_influences(const std::vector<Influence>& influences, Pictures& pictures) {
  std::string data;
  int count = 0;
  for (const Influence& i : influences) {
    if (i.output != "peak_force_N") continue;
    data += fmt::format("{} {:.6g} {:.6g} \"{}\"\n", count++, i.dependence.spearman, i.dependence.correlation_ratio,
                        i.input);
  }
  if (count == 0) return;
  pictures.draw(
      "influence", data, "", "",
      fmt::format("set yrange [{}:-1]\nset xrange [-1:1]\nset lmargin 52\nset ytics noenhanced\nset xlabel 'of the "
                  "peak force'\n"
                  "set boxwidth 0.35\nplot 'influence.dat' using 2:1:(0):2:($1-0.2):($1):ytic(4) with boxxyerror "
                  "linecolor rgb '#0072b2' title 'rank correlation', '' using 3:1:(0):3:($1):($1+0.2) with boxxyerror "
                  "linecolor rgb '#d55e00' title 'share of variance (correlation ratio)'\n",
                  count),
      "How the peak follows each input.");
}

struct CrackMap {
  std::vector<OpenedJoint> joints;
  std::vector<double> probability;
};
CrackMap cracks_of(const StudyFolder& folder, const Results& r, double opening) {
  std::map<std::pair<int, int>, std::pair<OpenedJoint, double>> joints;
  double count = 0.0;
  for (const auto& [number, sample] : r.samples) {
    if (sample.status != "done") continue;
    ++count;
    for (const OpenedJoint& j : read_joints(folder.sample(number))) {
      auto& entry = joints.try_emplace({j.block_a, j.block_b}, j, 0.0).first->second;
      entry.second += j.opening >= opening ? 1.0 : 0.0;
    }
  }
  CrackMap map;
  for (const auto& [key, entry] : joints) {
    map.joints.push_back(entry.first);
    map.probability.push_back(entry.second / count);
  }
  return map;
}

// Draws joints as seen along the thinner way of the masonry, z or x.
void draw_cracks(const CrackMap& map, double opening, Pictures& pictures) {
  if (map.joints.empty()) return;
  const auto extent = [&](std::size_t c) {
    const auto begin = std::ranges::min(map.joints, {}, [c](const OpenedJoint& j) { return j.low[c]; });
    const auto end = std::ranges::max(map.joints, {}, [c](const OpenedJoint& j) { return j.high[c]; });
    return end.high[c] - begin.low[c];
  };
  const std::size_t along = extent(2) > extent(0) ? 2 : 0;
  std::string data;
  for (std::size_t k = 0; k < map.joints.size(); ++k) {
    const OpenedJoint& j = map.joints[k];
    data += fmt::format("{:.8g} {:.8g} {:.4g}\n{:.8g} {:.8g} {:.4g}\n\n", j.low[along], j.low[1], map.probability[k],
                        j.high[along], j.high[1], map.probability[k]);
  }
  pictures.draw("crack_probability", data, along == 2 ? "z, m" : "x, m", "y, m",
                "set size ratio -1\nset nokey\nset style fill solid 1 noborder\nset cbrange [0:1]\nset cblabel "
                "'probability'\nset palette defined (0 "
                "'#e8e8e8', 0.3 "
                "'#56b4e9', 0.6 '#e69f00', 1 '#b3321e')\nplot 'crack_probability.dat' using 1:2:3 with lines linewidth "
                "5 palette\n",
                fmt::format("Probability that a joint is open by {:g} mm or more at the end.", opening * 1e3));
}

// ---- The page -------------------------------------------------------------------------------------------------------

std::string table_of(const Results& r) {
  std::string rows;
  for (const std::string& name : output_names()) {
    const std::vector<double>& values = r.column.at(name);
    if (!is_known(values) || name == "large_motion") continue;
    const Moments m = moments_of(values);
    rows += fmt::format(
        "<tr><td>{}</td><td>{} of {}</td><td>{:.5g}</td><td>{:.5g} to "
        "{:.5g}</td><td>{:.4g}</td><td>{:.5g}</td><td>{:.5g}</td><td>{:.5g}</td>"
        "<td>{:.5g}</td></tr>\n",
        name, std::ranges::count_if(values, [](double v) { return std::isfinite(v); }), values.size(), m.mean,
        m.of_mean.low, m.of_mean.high, m.scatter, quantile_of(values, 0.05), quantile_of(values, 0.5),
        quantile_of(values, 0.95), r.of_means ? value_of(r.of_means->outputs, name) : kNone);
  }
  return "<table><tr><th></th><th>samples that have it</th><th>mean</th><th>interval of the mean, 95 "
         "%</th><th>scatter</th><th>5 "
         "%</th><th>median</th><th>95 "
         "%</th>"
         "<th>everything at its mean</th></tr>\n" +
         rows + "</table>\n";
}

void write_page(const fs::path& folder, const Study& study, const Results& r, std::uint64_t samples,
                const std::string& figures) {
  std::uint64_t failed = 0;
  std::string failures;
  for (const auto& [number, sample] : r.samples) {
    if (sample.status == "done") continue;
    if (++failed <= 20) failures += fmt::format("<li>{}: {}</li>\n", number, escaped(sample.reason));
  }
  std::string set;
  for (const std::string& o : study.overrides) set += "<li><code>" + escaped(o) + "</code></li>\n";
  for (const StudyQuantity& q : study.quantities)
    set += fmt::format("<li><code>{}</code>: {}</li>\n", escaped(q.key), escaped(text_of(q.distribution)));
  const std::string body = fmt::format(
      R"(<p>{} of {} samples finished, {} of them failed. Numbers: <a href="samples.csv">samples.csv</a>,
<a href="summary.json">summary.json</a>, <a href="curve_bands.csv">curve_bands.csv</a>,
<a href="crack_probability.csv">crack_probability.csv</a>.</p>
<h2>Results</h2>
{}{}<details><summary>What scatters, and what is set</summary>
<ul>
{}</ul>
</details>
{})",
      r.samples.size(), samples, failed, table_of(r), figures, set,
      failures.empty() ? "" : "<h2>Samples that failed</h2>\n<ul>\n" + failures + "</ul>\n");
  write_page_of(folder, study.title.empty() ? study.scene : study.title, body);
}

// Numbers of limit states, and the capacities of the samples for each.
using Limits = std::vector<std::pair<std::string, std::vector<double>>>;
Limits limits_of(const Study& study, const Results& r, Json& json) {
  Limits limits;
  for (const LimitState& asked : study.limits) {
    if (!r.column.contains(asked.output)) {
      notice(fmt::format("quoin: {}: fragility of '{}': samples.csv has no such column", study.file, asked.output));
      continue;
    }
    const std::vector<double> capacities = capacities_of(study, asked.output, r);
    const Fragility f = fragility_of(capacities);
    json["fragility"].push_back({{"name", asked.name},
                                 {"output", asked.output},
                                 {"samples", f.samples},
                                 {"reached", f.reached},
                                 {"median", number_or_null(f.median)},
                                 {"median_95", pair(f.of_median)},
                                 {"spread", number_or_null(f.spread)},
                                 {"fit", f.fit}});
    limits.emplace_back(asked.name, capacities);
  }
  return limits;
}

std::string text_of(const Bands& bands) {
  std::string text = "displacement_m,mean_N,of_means_N,q05_N,q16_N,q50_N,q84_N,q95_N\n";
  for (std::size_t k = 0; k < bands.displacement.size(); ++k) {
    text += fmt::format("{},{},{}", bands.displacement[k], bands.mean[k],
                        std::isfinite(bands.of_means[k]) ? fmt::format("{}", bands.of_means[k]) : "");
    for (const auto& q : bands.quantile) text += fmt::format(",{}", q[k]);
    text += '\n';
  }
  return text;
}

std::string text_of(const CrackMap& cracks) {
  std::string text = "block_a,block_b,x0_m,y0_m,x1_m,y1_m,probability,z0_m,z1_m\n";
  for (std::size_t k = 0; k < cracks.joints.size(); ++k) {
    const OpenedJoint& j = cracks.joints[k];
    text += fmt::format("{},{},{},{},{},{},{},{},{}\n", j.block_a, j.block_b, j.low[0], j.low[1], j.high[0], j.high[1],
                        cracks.probability[k], j.low[2], j.high[2]);
  }
  return text;
}

}  // namespace

Gathered gather(const StudyFolder& folder, const Study& study, std::uint64_t samples, bool pictures) {
  const std::unique_ptr<Claim> alone = Claim::wait_for(folder.gathering());
  const Results r = read_results(folder, samples);
  write_file(folder.path() / "samples.csv", table_text(r.samples, output_names()));
  Gathered gathered;
  gathered.finished = r.samples.size();
  for (const auto& [number, sample] : r.samples) gathered.failed += sample.status == "done" ? 0 : 1;
  gathered.of_means = r.of_means ? value_of(r.of_means->outputs, "peak_force_N") : kNone;

  Json json{{"study", study.title},     {"scene", fs::path(study.scene).filename().string()},
            {"seed", study.seed},       {"method", random::method_name(study.method)},
            {"samples", samples},       {"finished", gathered.finished},
            {"failed", gathered.failed}};
  if (r.curves.empty()) {
    gathered.peak = gathered.scatter = kNone;
    write_json(folder.path() / "summary.json", json);
    return gathered;
  }
  const std::vector<double>& peaks = r.column.at("peak_force_N");
  const Moments of_peaks = moments_of(peaks);
  gathered.peak = of_peaks.mean, gathered.scatter = of_peaks.scatter;
  for (const std::string& name : output_names()) {
    if (is_known(r.column.at(name))) json["outputs"][name] = output_json(r, name);
  }
  const std::vector<Influence> influences = influences_of(r);
  for (const Influence& i : influences)
    json["sensitivity"].push_back({{"input", i.input},
                                   {"output", i.output},
                                   {"correlation", number_or_null(i.dependence.pearson)},
                                   {"rank_correlation", number_or_null(i.dependence.spearman)},
                                   {"correlation_ratio", number_or_null(i.dependence.correlation_ratio)}});
  const Limits limits = limits_of(study, r, json);
  const Bands bands = bands_of(r);
  write_file(folder.path() / "curve_bands.csv", text_of(bands));
  const CrackMap cracks = cracks_of(folder, r, study.crack_opening);
  write_file(folder.path() / "crack_probability.csv", text_of(cracks));
  write_json(folder.path() / "summary.json", json);
  std::string figures;
  if (pictures) {
    make_folder(folder.path() / "plots");
    Pictures drawn(folder.path(), study.title);
    draw_bands(bands, r.vertical.value_or(false), drawn);
    draw_convergence(peaks, drawn);
    draw_fragility(limits, limits.empty() ? "" : study.limits[0].output, drawn);
    draw_influences(influences, drawn);
    draw_cracks(cracks, study.crack_opening, drawn);
    figures = drawn.figures();
  }
  write_page(folder.path(), study, r, samples, figures);
  return gathered;
}

}  // namespace quoin::ensemble
