// Approved texts: complete outputs of programs that people have read, in files beside the tests. Tests of single
// numbers would miss a wrong word, unit, label or colour. QUOIN_APPROVE=1 writes the files: read the difference (git
// diff) before a commit.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

namespace quoin_test {

struct Approved {
  std::filesystem::path file;
  double tolerance = 1e-9;  // relative, for numbers with a decimal point or exponent; plus a unit of the last digit
  double noise = 0.0;       // numbers below this are rounding and may have any value
};

// True if two printed numbers are equal but for rounding. Integers are counts, which must be equal.
inline bool same_number(const std::string& a, const std::string& b, const Approved& within) {
  if (a == b) return true;
  // Noise may be printed as 0 and with any sign.
  if (within.noise > 0.0 && std::max(std::abs(std::stod(a)), std::abs(std::stod(b))) < within.noise) return true;
  const std::size_t point = a.find('.'), exponent = a.find_first_of("eE");
  if (point == std::string::npos && exponent == std::string::npos) return false;
  const double x = std::stod(a), y = std::stod(b);
  const std::size_t digits = point == std::string::npos ? 0 : std::min(exponent, a.size()) - point - 1;
  const double power = exponent == std::string::npos ? 0.0 : std::stod(a.substr(exponent + 1));
  const double last = std::pow(10.0, power - static_cast<double>(digits));
  const double larger = std::max(std::abs(x), std::abs(y));
  return std::abs(x - y) <= within.tolerance * larger + 1.01 * last;
}

// Returns the first difference of two texts; empty if they are equal but for rounding.
inline std::string first_difference(const std::string& approved, const std::string& now, const Approved& within) {
  static const std::regex number(R"(-?[0-9]+\.?[0-9]*(?:[eE][-+]?[0-9]+)?)");
  std::istringstream then(approved), today(now);
  std::string a, b;
  for (int line = 1;; ++line) {
    const bool more = static_cast<bool>(std::getline(then, a)), more_now = static_cast<bool>(std::getline(today, b));
    if (!more && !more_now) return "";
    const std::sregex_iterator end;
    std::sregex_iterator i(a.begin(), a.end(), number), j(b.begin(), b.end(), number);
    bool same = more == more_now && std::regex_replace(a, number, "#") == std::regex_replace(b, number, "#");
    for (; same && i != end; ++i, ++j) same = same_number(i->str(), j->str(), within);
    if (!same)
      return "line " + std::to_string(line) + "\n  approved: " + (more ? a : "(ends)") +
             "\n  now:      " + (more_now ? b : "(ends)");
  }
}

inline void expect_approved(const Approved& approved, const std::string& now) {
  if (std::getenv("QUOIN_APPROVE")) {
    std::filesystem::create_directories(approved.file.parent_path());
    std::ofstream(approved.file) << now;
    return;
  }
  std::ifstream stream(approved.file);
  ASSERT_TRUE(stream) << approved.file << " is not there: QUOIN_APPROVE=1 writes it";
  std::ostringstream then;
  then << stream.rdbuf();
  EXPECT_EQ(first_difference(then.str(), now, approved), "") << approved.file;
}

}  // namespace quoin_test
