#include "cli/spectrum_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/printable.h"
#include "files/csv_text.h"
#include "files/file.h"
#include "files/gnuplot.h"
#include "files/notice.h"
#include "files/result_folder.h"
#include "records/baseline.h"
#include "records/read_record.h"
#include "records/response_spectrum.h"
#include "results/colours.h"
#include "results/json_file.h"
#include "results/picture_text.h"

namespace quoin {
namespace {

struct Options {
  std::vector<std::string> files;
  std::vector<double> dampings{0.05};
  std::vector<double> periods;
  std::string baseline = "none", out;
  double scale = 1.0;
  int order = 4;
  double corner = 0.0;
  bool svg = false;
};

struct ComponentSpectrum {
  std::string name;
  TimeSeries acceleration;  // m/s2
  RecordMeasures measures;
  std::vector<std::vector<SpectralOrdinates>> by_damping;
};

BaselineCorrection correction_of(const Options& options) {
  using Kind = BaselineCorrection::Kind;
  if (options.baseline == "linear") return {Kind::polynomial, 1, 0.0};
  if (options.baseline == "polynomial") return {Kind::polynomial, options.order, 0.0};
  if (options.baseline == "high-pass") return {Kind::high_pass, options.order, options.corner};
  return {};
}

std::string csv_of(const std::vector<ComponentSpectrum>& spectra, const std::vector<double>& dampings) {
  std::string csv =
      "component,damping,period_s,displacement_m,velocity_m_s,pseudo_velocity_m_s,pseudo_acceleration_m_s2,"
      "absolute_acceleration_m_s2\n";
  for (const ComponentSpectrum& component : spectra) {
    for (std::size_t d = 0; d < dampings.size(); ++d) {
      for (const SpectralOrdinates& o : component.by_damping[d]) {
        csv += fmt::format("{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", csv_text(component.name), dampings[d],
                           o.period, o.displacement, o.velocity, o.pseudo_velocity, o.pseudo_acceleration,
                           o.absolute_acceleration);
      }
    }
  }
  return csv;
}

nlohmann::ordered_json json_of(const GroundRecord& record, const std::vector<ComponentSpectrum>& spectra,
                               const Options& options) {
  nlohmann::ordered_json json;
  json["record"] = record.source;
  json["recorded_as"] = recorded_units(record);
  json["samples"] = record.time.size();
  json["duration_s"] = record.time.back() - record.time.front();
  json["scale"] = options.scale;
  json["baseline"] = options.baseline;
  json["assumptions"] = record.assumptions;
  for (const ComponentSpectrum& c : spectra) {
    const RecordMeasures& m = c.measures;
    json["components"].push_back({{"name", c.name},
                                  {"pga_m_s2", m.pga},
                                  {"pgv_m_s", m.pgv},
                                  {"pgd_m", m.pgd},
                                  {"end_velocity_m_s", m.end_velocity},
                                  {"end_displacement_m", m.end_displacement},
                                  {"arias_intensity_m_s", m.arias},
                                  {"significant_duration_s", m.significant_duration}});
  }
  return json;
}

// Script with acceleration over time on the left, a row per component, and pseudo-acceleration over period on the
// right. Line widths distinguish two pens of equal grey.
std::string script_of(const GroundRecord& record, const std::vector<ComponentSpectrum>& spectra,
                      const std::vector<double>& dampings) {
  std::string script = fmt::format("set terminal pngcairo size 1400,{} font 'Sans,11' noenhanced\nset grid\n",
                                   340 * spectra.size() + 60);
  for (std::size_t c = 0; c < spectra.size(); ++c) {
    const TimeSeries& a = spectra[c].acceleration;
    script += fmt::format("$a{} << EOD\n", c);
    for (std::size_t i = 0; i < a.time.size(); ++i) script += fmt::format("{:.6g} {:.6g}\n", a.time[i], a.value[i]);
    script += "EOD\n";
    for (std::size_t d = 0; d < dampings.size(); ++d) {
      script += fmt::format("$s{}_{} << EOD\n", c, d);
      for (const SpectralOrdinates& o : spectra[c].by_damping[d])
        script += fmt::format("{:.6g} {:.6g}\n", o.period, o.pseudo_acceleration);
      script += "EOD\n";
    }
  }
  script += fmt::format("set multiplot layout {},2 title {}\n", spectra.size(),
                        fitting_text(std::filesystem::path(record.source).filename().string(), 1300, 11));
  for (std::size_t c = 0; c < spectra.size(); ++c) {
    script += fmt::format(
        "set title {}\nset xlabel 'time (s)'\nset ylabel 'acceleration (m/s2)'\nunset logscale\nset key off\n"
        "plot $a{} using 1:2 with lines lc rgb '{}'\n",
        fitting_text(spectra[c].name, 560, 11), c, kPens[1]);
    std::string plots;
    for (std::size_t d = 0; d < dampings.size(); ++d)
      plots += fmt::format("{}$s{}_{} using 1:2 with lines lw {} lc rgb '{}' title '{:g} % damping'", d > 0 ? ", " : "",
                           c, d, d % 2 == 0 ? 2 : 1, kPens[d % kPens.size()], 100.0 * dampings[d]);
    script += fmt::format(
        "set title 'elastic response spectrum'\nset xlabel 'period (s)'\nset ylabel 'pseudo-acceleration (m/s2)'\n"
        "set logscale x\nset xrange [*:*]\nset yrange [0:*]\nset key top right\nplot {}\nset yrange [*:*]\n",
        plots);
  }
  return script + "unset multiplot\n";
}

void require_finite(const GroundRecord& record, const ComponentSpectrum& of) {
  const RecordMeasures& m = of.measures;
  double sum = m.pga + m.pgv + m.pgd + m.end_velocity + m.end_displacement + m.arias;
  for (const auto& spectrum : of.by_damping) {
    for (const SpectralOrdinates& o : spectrum) sum += o.velocity + o.pseudo_acceleration + o.absolute_acceleration;
  }
  if (!std::isfinite(sum))
    throw Error(Exit::bad_input, fmt::format("{}: component '{}' has values too large for a spectrum; check its units",
                                             printable(record.source), printable(of.name)));
}

std::vector<ComponentSpectrum> spectra_of(const GroundRecord& record, const Options& options) {
  std::vector<ComponentSpectrum> spectra;
  for (std::size_t c = 0; c < record.components.size(); ++c) {
    ComponentSpectrum component;
    component.name = record.components[c].name;
    component.acceleration = correct_baseline(acceleration_of(record, c), correction_of(options));
    for (double& a : component.acceleration.value) a *= options.scale;
    component.measures = measure_record(component.acceleration);
    for (const double damping : options.dampings)
      component.by_damping.push_back(response_spectrum(component.acceleration, damping, options.periods));
    require_finite(record, component);
    spectra.push_back(std::move(component));
  }
  return spectra;
}

void run(Options options) {
  if (!std::isfinite(options.scale)) throw Error(Exit::usage, "spectrum: --scale must be finite");
  if (options.baseline == "high-pass" && options.corner <= 0.0)
    throw Error(Exit::usage, "spectrum: --baseline high-pass needs --corner, the corner frequency in Hz");
  for (const char* name : {"spectrum.csv", "spectrum.json"})
    if (!options.out.empty()) refuse_input_as_output(std::filesystem::path(options.out) / name, options.files);
  std::vector<std::string> written{"spectrum.csv", "spectrum.json", "spectrum.png", "plots/spectrum.gp"};
  if (options.svg) written.emplace_back("spectrum.svg");
  if (!options.out.empty()) refuse_files_of_others(options.out, written);
  if (options.periods.empty()) options.periods = default_periods();
  std::sort(options.periods.begin(), options.periods.end());
  const GroundRecord record = read_record(options.files);
  for (const std::string& assumption : record.assumptions) notice(fmt::format("quoin: assumed: {}", assumption));
  const std::vector<ComponentSpectrum> spectra = spectra_of(record, options);

  fmt::print("{}: {} samples, {:g} s, recorded in {}\n", printable(record.source), record.time.size(),
             record.time.back() - record.time.front(), recorded_units(record));
  fmt::print("{:<16} {:>9} {:>9} {:>9} {:>12} {:>12} {:>9} {:>9}\n", "component", "PGA m/s2", "PGV m/s", "PGD m",
             "v at end m/s", "u at end m", "Arias m/s", "D5-95 s");
  for (const ComponentSpectrum& c : spectra) {
    const RecordMeasures& m = c.measures;
    fmt::print("{:<16} {:>9.4g} {:>9.4g} {:>9.4g} {:>12.3g} {:>12.3g} {:>9.3g} {:>9.3g}\n", printable(c.name), m.pga,
               m.pgv, m.pgd, m.end_velocity, m.end_displacement, m.arias, m.significant_duration);
  }
  if (options.out.empty()) return;
  const std::filesystem::path folder = options.out;
  list_own_files(folder, written);
  write_file(folder / "spectrum.csv", csv_of(spectra, options.dampings));
  write_json(folder / "spectrum.json", json_of(record, spectra, options));
  if (const std::string missing = draw_picture(folder, "spectrum", script_of(record, spectra, options.dampings));
      !missing.empty())
    notice(missing);
  else if (const std::string none = options.svg ? draw_as_svg(folder, "spectrum") : ""; !none.empty())
    notice(none);
  fmt::print("{}\n", (folder / "spectrum.csv").string());
}

}  // namespace

void add_spectrum_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("spectrum", "Elastic response spectra and measures of ground motion");
  const auto options = std::make_shared<Options>();
  command->add_option("record", options->files, "File of a record, or a file for each of its components")
      ->type_name("FILE")
      ->required();
  command->add_option("--damping", options->dampings, "Shares of critical damping, 0 to below 1")
      ->capture_default_str();
  command->add_option("--period", options->periods, "Periods in s; otherwise 200 from 0.02 to 5 s");
  command->add_option("--scale", options->scale, "Factor on the record")->capture_default_str();
  command->add_option("--baseline", options->baseline, "Correction of the acceleration before anything else")
      ->check(CLI::IsMember({"none", "linear", "polynomial", "high-pass"}))
      ->capture_default_str();
  CLI::Option* const order =
      command->add_option("--order", options->order, "Of the polynomial or of the Butterworth filter")
          ->capture_default_str();
  CLI::Option* const corner =
      command->add_option("--corner", options->corner, "Corner frequency of the high-pass filter, Hz");
  CLI::Option* const out =
      command->add_option("--out", options->out, "Folder for spectrum.csv, spectrum.json and spectrum.png")
          ->type_name("DIR");
  command->add_flag("--svg", options->svg, "Write spectrum.svg beside spectrum.png")->needs(out);
  command->footer(
      "Reads PEER .AT2, .VT2 and .DT2, ESM and ITACA ASCII, and CSV whose columns name their units (time_s, x_g).\n"
      "Exact for accelerations that are linear between samples; extremes within about 0.05 %.\n"
      "Examples:\n"
      "  quoin spectrum RECORD.AT2 --damping 0.05 --out out/spectrum\n"
      "  quoin spectrum east.asc north.asc up.asc --damping 0.02 0.05 --out out/spectrum\n"
      "  quoin spectrum record.csv --baseline high-pass --order 4 --corner 0.1");
  command->callback([options, order, corner] {
    const bool filters = options->baseline == "high-pass";
    if (order->count() > 0 && !filters && options->baseline != "polynomial")
      throw Error(Exit::usage, "spectrum: --order goes with --baseline polynomial or high-pass");
    if (corner->count() > 0 && !filters) throw Error(Exit::usage, "spectrum: --corner goes with --baseline high-pass");
    run(*options);
  });
}

}  // namespace quoin
