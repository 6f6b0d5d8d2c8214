#include "ensemble/sensitivity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ensemble/no_number.h"
#include "files/csv_text.h"
#include "files/file.h"
#include "files/gnuplot.h"
#include "files/notice.h"

namespace quoin::ensemble {

namespace {

double output_of(const StudyFolder& folder, std::uint64_t number, const std::string& name) {
  if (!is_finished(folder.sample(number))) return kNone;
  const Sample sample = read_sample(folder.sample(number));
  for (const auto& [known, value] : sample.outputs) {
    if (known == name && sample.status == "done") return value;
  }
  return kNone;
}

struct Trial {
  std::string input;
  double x_low, x_mean, x_high;  // values of the input
  double low, mean, high;        // values of the output
  double half() const { return 0.5 * (high - low); }
  // Relative change of the output over that of the input.
  double elasticity() const { return (high - low) / mean * x_mean / (x_high - x_low); }
  // Distance of the mean from the straight line between low and high, over their difference; 0: straight.
  double bend() const {
    const double share = (x_mean - x_low) / (x_high - x_low);
    return std::abs(mean - (low + share * (high - low))) / std::abs(high - low);
  }
};

std::vector<Trial> trials_of(const StudyFolder& folder, const Study& study, const std::string& output) {
  const std::vector<StudyQuantity> inputs = study.inputs();
  const std::vector<double> means = study.values(0);
  std::vector<Trial> trials;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    const std::uint64_t low = 2 * k + 1, high = 2 * k + 2;
    trials.push_back({inputs[k].name, study.values(low)[k], means[k], study.values(high)[k],
                      output_of(folder, low, output), output_of(folder, 0, output), output_of(folder, high, output)});
  }
  return trials;
}

void draw_tornado(const StudyFolder& folder, const Study& study, const std::vector<Trial>& sorted,
                  const std::string& output) {
  std::string data;
  int row = 0;
  for (const Trial& t : sorted) {
    if (std::isfinite(t.half()))
      data += fmt::format("{} {:.8g} {:.8g} {:.8g} \"{}\"\n", row++, t.low, t.mean, t.high, t.input);
  }
  if (row == 0) return;
  make_folder(folder.path() / "plots");
  write_file(folder.path() / "plots" / "sensitivity.dat", data);
  // One bar below the other: both results may lie on one side of the mean.
  const std::string script = fmt::format(
      "set terminal pngcairo size 1500,950 font \"Sans,19\" linewidth 1.5\nset title {} noenhanced\nset xlabel {} "
      "noenhanced\n"
      "set yrange [{}:-1]\nset ytics noenhanced\nset xtics rotate by -35\nset rmargin 6\nset lmargin 52\nset key below "
      "noenhanced\nset grid xtics\nset style fill solid "
      "0.7 noborder\n"
      "plot 'sensitivity.dat' using 2:1:2:3:($1-0.3):($1):ytic(5) with boxxyerror linecolor rgb '#0072b2' title "
      "'at the 16 % "
      "quantile', '' using 4:1:3:4:($1):($1+0.3) with boxxyerror linecolor rgb '#d55e00' title 'at the 84 % "
      "quantile'\n",
      gnuplot_text(study.title), gnuplot_text(output), row);
  const std::string fault = draw_picture(folder.path(), "sensitivity", script);
  if (!fault.empty()) notice("quoin: " + fault);
}

}  // namespace

std::string write_sensitivity(const StudyFolder& folder, const Study& study, bool pictures) {
  std::string csv = "input,output,input_low,input_mean,input_high,low,mean,high,elasticity,share_of_variance,bend\n";
  std::string words;
  for (const std::string& output : output_names()) {
    std::vector<Trial> trials = trials_of(folder, study, output);
    double total = 0.0;
    for (const Trial& t : trials) total += std::isfinite(t.half()) ? t.half() * t.half() : 0.0;
    if (total == 0.0) continue;
    for (const Trial& t : trials) {
      csv += fmt::format("{},{}", csv_text(t.input), output);
      for (const double v :
           {t.x_low, t.x_mean, t.x_high, t.low, t.mean, t.high, t.elasticity(), t.half() * t.half() / total, t.bend()})
        csv += "," + csv_number(v);
      csv += '\n';
    }
    if (!words.empty() || (output != "peak_force_N" && output != "collapse_multiplier")) continue;
    std::sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
      return std::isfinite(a.half()) && !(std::abs(a.half()) <= std::abs(b.half()));
    });
    words = fmt::format("{:<44} {:>12} {:>12} {:>12} {:>12} {:>10}\n", output, "at 16 %", "at its mean", "at 84 %",
                        "elasticity", "variance");
    for (const Trial& t : trials)
      words += fmt::format("{:<44} {:>12.5g} {:>12.5g} {:>12.5g} {:>12.3f} {:>8.1f} %\n", t.input, t.low, t.mean,
                           t.high, t.elasticity(), 100 * t.half() * t.half() / total);
    if (pictures) draw_tornado(folder, study, trials, output);
  }
  write_file(folder.path() / "sensitivity.csv", csv);
  return words;
}

}  // namespace quoin::ensemble
