// Lines of TOML that are written from a table give this table when toml++ reads them.
#include "scene/inline_toml.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace {

using quoin::inline_toml;
using quoin::toml_lines;

TEST(InlineToml, ReadsBackToTheSameTable) {
  const toml::table table = toml::parse(R"toml(
title = "a \"quoted\" \\ name\nof two lines, \u00e9 = 1"
small = [0.0625, -1e-300, 1e300, 0.0, -0.05]
counts = [-9223372036854775808, 0, 9223372036854775807]
mixed = [[1, 2], [], [0.5, "x", true, {}]]
when = 1979-05-27T07:32:00.999-07:00
day = 1979-05-27
hour = 07:32:00
"a key.with = signs" = { "" = false, b = { c = [1] } }
empty = []
[tables.of.tables]
value = 1
[[stage]]
name = "one"
[[stage]]
name = "two"
[stage.collapse]
start = 0.05
)toml");
  const std::string lines = toml_lines(table);
  EXPECT_TRUE(toml::parse(lines) == table) << lines;
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), static_cast<long>(table.size())) << "a line a key\n" << lines;
}

TEST(InlineToml, NumbersThatAreNone) {
  toml::table table;
  const double infinity = std::numeric_limits<double>::infinity();
  table.insert("list", toml::array{infinity, -infinity, std::nan("")});
  const toml::table again = toml::parse(toml_lines(table));
  const toml::array& list = *again["list"].as_array();
  EXPECT_EQ(list[0].value<double>(), infinity);
  EXPECT_EQ(list[1].value<double>(), -infinity);
  EXPECT_TRUE(std::isnan(*list[2].value<double>()));
}

TEST(InlineToml, OnOneLine) {
  EXPECT_EQ(inline_toml(toml::array{0.0625, -0.5}), "[ 0.0625, -0.5 ]");
  EXPECT_EQ(inline_toml(toml::table{}), "{}");
  EXPECT_EQ(inline_toml(toml::value<bool>(true)), "true");
}

}  // namespace
