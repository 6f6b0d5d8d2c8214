#include "ensemble/sobol_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ensemble/statistics.h"
#include "files/csv_text.h"
#include "files/file.h"

namespace quoin::ensemble {

namespace {

struct Indices {
  std::string input;
  SobolIndex index;
};

// Indices of one output. Samples have their places in rows.
std::vector<Indices> indices_of(const Study& study, const std::vector<Values>& outputs, std::size_t output) {
  const std::vector<StudyQuantity> inputs = study.inputs();
  const std::size_t length = inputs.size() + 2;
  const auto column = [&](std::size_t place) {
    std::vector<double> values;
    for (std::size_t first = 0; first < outputs.size(); first += length) {
      const Values& sample = outputs[first + place];
      values.push_back(sample.empty() ? std::nan("") : sample[output].second);
    }
    return values;
  };
  const std::vector<double> a = column(0), b = column(1);
  std::vector<Indices> all;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    if (const auto index = sobol_index_of(a, b, column(k + 2))) all.push_back({inputs[k].name, *index});
  }
  return all;
}

}  // namespace

std::string write_sobol_table(const StudyFolder& folder, const Study& study, std::uint64_t rows) {
  std::vector<Values> outputs;  // outputs of each sample; empty: not finished
  for (std::uint64_t i = 1; i <= rows * (study.inputs().size() + 2); ++i) {
    outputs.emplace_back();
    if (!is_finished(folder.sample(i))) continue;
    const Sample sample = read_sample(folder.sample(i));
    if (sample.status == "done") outputs.back() = sample.outputs;
  }
  std::string csv = "input,output,rows,first,first_low,first_high,total,total_low,total_high\n", words;
  const std::vector<std::string> names = output_names();
  for (std::size_t output = 0; output < names.size(); ++output) {
    std::vector<Indices> all = indices_of(study, outputs, output);
    for (const auto& [input, s] : all) {
      csv += fmt::format("{},{},{}", csv_text(input), names[output], s.rows);
      for (const double v : {s.first, s.of_first.low, s.of_first.high, s.total, s.of_total.low, s.of_total.high})
        csv += "," + csv_number(v);
      csv += '\n';
    }
    if (all.empty() || !words.empty() || (names[output] != "peak_force_N" && names[output] != "collapse_multiplier"))
      continue;
    std::sort(all.begin(), all.end(), [](const Indices& x, const Indices& y) { return x.index.total > y.index.total; });
    words = fmt::format("{:<44} {:>8} {:>18} {:>8} {:>18}\n", names[output] + ": share of variance", "alone", "95 %",
                        "in all", "95 %");
    for (const auto& [input, s] : all)
      words += fmt::format("{:<44} {:>8.3f} {:>8.3f} to {:>6.3f} {:>8.3f} {:>8.3f} to {:>6.3f}\n", input, s.first,
                           s.of_first.low, s.of_first.high, s.total, s.of_total.low, s.of_total.high);
  }
  write_file(folder.path() / "sobol.csv", csv);
  return words;
}

}  // namespace quoin::ensemble
