#include "cli/fit_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "files/file.h"
#include "law/csv_table.h"
#include "law/fit.h"
#include "law/property_text.h"

namespace quoin {

namespace {

struct Options {
  std::vector<std::string> couplets, triplets, prisms, settings;
  std::string law = "fracture_energy", out, plot;
};

void run(const Options& options) {
  for (const auto* files : {&options.couplets, &options.triplets, &options.prisms})
    refuse_input_as_output(options.out, *files);
  const Law law = Law::find(options.law);
  std::vector<PropertySetting> given;
  for (const std::string& text : options.settings) given.push_back(parse_setting(*law.law, text, Source{"--set"}));
  std::vector<MeasuredCurve> curves;
  for (const std::string& file : options.couplets) curves.push_back(read_curve(TestKind::couplet, file));
  for (const std::string& file : options.triplets) curves.push_back(read_curve(TestKind::triplet, file));
  for (const std::string& file : options.prisms) curves.push_back(read_curve(TestKind::prism, file));
  if (curves.empty()) throw Error(Exit::usage, "fit: give at least one of --couplet, --triplet, --prism");

  const FitResult result = fit_properties(law, curves, given);
  fmt::print("{:<30} {:>6} {:>13}   {:^27} unit\n", "property", "", "value", "95 % confidence");
  std::string toml =
      fmt::format("# {} from {} curves by quoin fit; 95 % confidence behind each value\n", options.law, curves.size());
  for (const FittedProperty& p : result.properties) {
    fmt::print("{:<30} {:>6} {:>13.6g}   {:>13.6g} {:>13.6g} {}\n", p.id, p.symbol, p.value, p.low, p.high, p.unit);
    toml += fmt::format("{} = {:.9g}  # {}, {:.6g} to {:.6g}\n", p.id, p.value, p.unit, p.low, p.high);
  }
  if (result.no_cohesion) {
    fmt::print("cohesion: 0, as the curves show none beyond their noise\n");
    toml += "cohesion = 0  # Pa, the curves show none beyond their noise\n";
  }
  for (const std::string& note : result.notes) {
    fmt::print("{}\n", note);
    toml += fmt::format("# {}\n", note);
  }
  for (std::size_t k = 0; k < curves.size(); ++k) {
    fmt::print("{}: {} rows, standard deviation {:.4g} Pa\n", curves[k].file, curves[k].jump.size(), result.noise[k]);
  }
  if (!options.out.empty()) write_named_file(options.out, toml);
  if (!options.plot.empty()) fmt::print("{}\n", plot_fit(curves, result, options.plot));
}

}  // namespace

void add_fit_command(CLI::App& app, int&) {
  CLI::App* command = app.add_subcommand("fit", "Find properties of a law from couplet, triplet and prism curves");
  const auto options = std::make_shared<Options>();
  const auto list = [&](const char* name, std::vector<std::string>& target, const char* text) {
    command->add_option(name, target, text)->expected(1)->take_all();
  };
  list("--couplet", options->couplets, "CSV with the columns dn (m), sigma (Pa): opening under tension");
  list("--triplet", options->triplets,
       "CSV with the columns ds (m), tau (Pa), sigma (Pa): compression negative; once a test");
  list("--prism", options->prisms, "CSV with the columns dn (m), sigma (Pa): closing under compression, both negative");
  list("--set", options->settings, "id=value: the stiffnesses, and every property that is not to be found");
  command->add_option("--law", options->law, "Name or path of the law")->capture_default_str();
  command->add_option("--out", options->out, "TOML to write: the properties found");
  command->add_option("--plot", options->plot, "Folder for fit.png: measured and fitted (needs gnuplot)");
  command->footer("Couplets give ft and G1, triplets c0, phi and G2, prisms fc and Gc.");
  command->callback([options] { run(*options); });
}

}  // namespace quoin
