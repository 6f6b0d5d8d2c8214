#include "results/warnings.h"

#include <fmt/format.h>

#include <algorithm>

#include "files/gnuplot.h"

namespace quoin {

std::vector<Warning> warnings_of(const Simulation& simulation, const QuasiStatic& check,
                                 const CrushedOut& crushed_out) {
  std::vector<Warning> all;
  const auto add = [&](Warning warning) {
    const auto same = [&](const Warning& w) { return w.about == warning.about; };
    if (!warning.text.empty() && std::none_of(all.begin(), all.end(), same)) all.push_back(std::move(warning));
  };
  add({"time_step", simulation.time_step_report().warning()});
  for (const Warning& warning : simulation.outcome().warnings) add(warning);
  const int last = std::max(0, static_cast<int>(simulation.scene().stages.size()) - 1);
  add({"crushed_out", crushed_out.warning(), last, simulation.step(), simulation.time()});
  add({"quasi_static", check.warning(), last, simulation.step(), simulation.time()});
  return all;
}

std::string warning_label(const std::vector<Warning>& warnings) {
  if (warnings.empty()) return {};
  std::string text = "Warnings, see summary.json:";
  for (const Warning& warning : warnings) {
    std::string about = warning.about == "quasi_static" ? "not known to be quasi-static" : warning.about;
    std::replace(about.begin(), about.end(), '_', ' ');
    text += (&warning == &warnings.front() ? " " : ", ") + about;
  }
  return fmt::format(
      "set label 99 {} at screen 0.01,0.015 noenhanced font \"Sans,13\" textcolor rgb \"#b3321e\" front\n",
      gnuplot_text(text));
}

}  // namespace quoin
