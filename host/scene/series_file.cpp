#include "scene/series_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/error.h"
#include "base/input_file.h"
#include "base/number_text.h"

namespace quoin {
namespace {

std::vector<std::string> words_of(std::string line) {
  line.erase(std::min(line.size(), line.find_first_of("#%")));
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace

TimeSeries read_series_file(const std::string& file) {
  const auto refuse = [&](const std::string& why) { throw Error(Exit::bad_input, fmt::format("{}: {}", file, why)); };
  std::istringstream stream(read_input_file(file));

  constexpr size_t listed = 5;
  std::vector<std::string> faults;
  size_t bad = 0;
  TimeSeries series;
  double latest = 0.0;  // time of the last line that has one
  bool first = true, timed = false;
  std::string line;
  for (size_t number = 1; std::getline(stream, line); ++number) {
    if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) continue;
    const bool header = first && (words[0][0] == 't' || words[0][0] == 'T');
    first = false;
    if (header) continue;
    const auto wrong = [&](const std::string& what) {
      if (++bad <= listed) faults.push_back(fmt::format("{}:{}: '{}': {}", file, number, line.substr(0, 80), what));
    };
    double time = 0.0, value = 0.0;
    if (words.size() != 2) {
      wrong(fmt::format("{} entries; allowed: two numbers, time (s) and value", words.size()));
      continue;
    }
    if (!parse_number(words[0], time) || !std::isfinite(time) || time < 0.0) {
      wrong(fmt::format("the time '{}'; allowed: a finite number, 0 or more, s", words[0]));
      continue;
    }
    if (timed && time <= latest)
      wrong(fmt::format("the time {} s does not lie after {} s before it; allowed: times that increase", time, latest));
    else if (!parse_number(words[1], value) || !std::isfinite(value))
      wrong(fmt::format("the value '{}'; allowed: a finite number", words[1]));
    latest = time, timed = true;
    series.time.push_back(time);
    series.value.push_back(value);
  }
  if (bad > listed) faults.push_back(fmt::format("{}: {} more lines like these", file, bad - listed));
  if (bad > 0) throw Error(Exit::bad_input, fmt::format("{}", fmt::join(faults, "\n")));
  if (series.time.empty()) refuse("has no row; allowed: lines of two numbers, time (s) and value");
  return series;
}

}  // namespace quoin
