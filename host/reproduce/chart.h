// A chart by gnuplot: curves and reference values in one picture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reproduce/study.h"

namespace quoin::reproduce {

enum class Mark { line, dashed, points, level, band };

struct Series {
  std::string label;
  Mark mark = Mark::line;
  std::vector<double> x, y;  // level: y[0]; band: y[0] to y[1]
  int colour = 0;            // index into the palette; related curves share it
};

struct Chart {
  std::string name, title, x_label, y_label;
  std::string key = "below maxcols 3";  // place of the legend
  std::string extra{};                  // gnuplot commands before `plot`
  bool from_zero = true;
  std::vector<Series> series{};

  void add(const std::string& label, const Curve& curve, int colour, Mark mark = Mark::line);
  // Adds reference values, whose kind is in the legend.
  void add_level(const std::string& label, Kind kind, double y, int colour);
  void add_band(const std::string& label, Kind kind, double low, double high, int colour);
  void add_points(const std::string& label, std::vector<double> x, std::vector<double> y, int colour);
};

// Draws FOLDER/NAME.png and lists it in the report.
void draw(const Chart& chart, const Findings& findings, StudyReport& report, const std::string& caption);

}  // namespace quoin::reproduce
