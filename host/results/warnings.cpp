#include "results/warnings.h"

#include <fmt/format.h>

#include <algorithm>

#include "files/gnuplot.h"
#include "results/colours.h"

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
  constexpr size_t kLongest = 86;  // characters that fit below the narrowest picture
  std::string text = "Warnings, see summary.json:";
  for (size_t i = 0; i < warnings.size(); ++i) {
    std::string about = warnings[i].about == "quasi_static" ? "not known to be quasi-static" : warnings[i].about;
    std::replace(about.begin(), about.end(), '_', ' ');
    if (text.size() + about.size() > kLongest) {
      text += fmt::format(" and {} more", warnings.size() - i);
      break;
    }
    text += (i == 0 ? " " : ", ") + about;
  }
  return fmt::format("set label 99 {} at screen 0.01,0.015 noenhanced font \"Sans,13\" textcolor rgb \"{}\" front\n",
                     gnuplot_text(text), kPens[0]);
}

}  // namespace quoin
