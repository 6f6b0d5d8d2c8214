#include "reproduce/building_layouts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdlib>

namespace quoin::reproduce {

namespace {

constexpr int kCourses = 40, kColumnsD = 30;
constexpr double kHalfUnit = 0.2, kCourse = 0.16, kThickness = 0.25;  // m
constexpr int kSill = 6, kFloor = 17;                                 // courses of pavia_window.toml
constexpr int kBeams = 22, kWindowWidth = 5, kBearing = 1;

// Blocks that one lintel saves compared with half units.
int saved(int opening_width) { return opening_width + 2 * kBearing - 1; }

// Half unit of walls A and C for 4 m from the back of the wall, or 4 m without the corner: the one nearer to 0.2 m.
double half_unit_a(int columns) {
  const double within = (4.0 - kThickness) / columns, beside = 4.0 / columns;
  return std::abs(within - kHalfUnit) <= std::abs(beside - kHalfUnit) ? within : beside;
}

}  // namespace

Count DoorLayout::count() const {
  const int half_units = kColumnsD * kCourses - 2 * (door_width * door_courses + window_width * window_courses);
  return {half_units - 2 * (saved(door_width) + saved(window_width)), half_units};
}

std::string DoorLayout::name() const {
  if (door_width == kWindowWidth && window_width == kWindowWidth)
    return fmt::format("wall D, doors {}, windows {} courses high", door_courses, window_courses);
  return fmt::format("wall D, doors {} x {}, windows {} x {}", door_width, door_courses, window_width, window_courses);
}

std::vector<std::string> DoorLayout::overrides() const {
  std::vector<std::string> settings;
  for (int i = 1; i <= 4; ++i) {
    const bool door = i <= 2;
    settings.push_back(fmt::format("building.wall.1.opening.{}.half_units={}", i, door ? door_width : window_width));
    settings.push_back(fmt::format("building.wall.1.opening.{}.courses={}", i, door ? door_courses : window_courses));
  }
  return settings;
}

std::vector<DoorLayout> door_layouts() {
  std::vector<DoorLayout> all;
  for (int door_width = 4; door_width <= 6; ++door_width) {
    for (int window_width = 4; window_width <= 6; ++window_width) {
      for (int door = 10; door <= 15; ++door) {
        for (int window = 1; window < door; ++window) {
          const DoorLayout layout{door_width, door, window_width, window};
          const Count c = layout.count();
          if (c.blocks == kTableD.blocks && c.half_units == kTableD.half_units) all.push_back(layout);
        }
      }
    }
  }
  return all;
}

std::string why_not(const DoorLayout& layout) {
  for (const int width : {layout.door_width, layout.window_width}) {
    if (std::abs(width * kHalfUnit - 0.94) > 0.5 * kHalfUnit)
      return fmt::format("openings {:.1f} m wide, 0.94 m recalled", width * kHalfUnit);
  }
  if (layout.door_courses * kCourse < 1.7) return fmt::format("doors {:.2f} m high", layout.door_courses * kCourse);
  if (layout.window_courses * kCourse < 0.7)
    return fmt::format("windows {:.2f} m high", layout.window_courses * kCourse);
  return {};
}

Count WindowLayout::count() const {
  const int windows = 6;
  const int half_units = (columns_b + 2 * columns_a + 2) * kCourses - windows * kWindowWidth * window_courses;
  const int beams = beams_besides ? kBeams : 0;
  return {half_units - windows * saved(kWindowWidth) + beams, half_units + beams};
}

double WindowLayout::depth() const { return kThickness + columns_a * half_unit_a(columns_a); }

std::string WindowLayout::name() const {
  return fmt::format("walls A + B + C, {} + {} + {} columns, windows {} courses high{}", columns_a, columns_b,
                     columns_a, window_courses, beams_besides ? ", beams besides" : "");
}

std::vector<std::string> WindowLayout::overrides() const {
  // Piers as equal as the columns allow; the outer two are equal.
  const int piers = columns_b - 3 * kWindowWidth, outer = piers / 4, left = piers - 2 * outer;
  const int inner[2] = {left / 2, left - left / 2};
  const int first[3] = {outer, outer + kWindowWidth + inner[0], outer + 2 * kWindowWidth + inner[0] + inner[1]};
  std::vector<std::string> settings;
  const auto set = [&](const char* key, const auto& value) {
    settings.push_back(fmt::format("building.{}={}", key, value));
  };
  set("wall.1.half_units", columns_b);
  set("wall.1.half_unit", half_unit_b());
  for (int i = 0; i < 6; ++i) {
    const std::string opening = fmt::format("wall.1.opening.{}.", i + 1);
    set((opening + "first_half_unit").c_str(), first[i % 3]);
    set((opening + "courses").c_str(), window_courses);
    set((opening + "bearing").c_str(), kBearing * half_unit_b());
  }
  for (const int wall : {2, 3}) {
    set(fmt::format("wall.{}.half_units", wall).c_str(), columns_a);
    set(fmt::format("wall.{}.half_unit", wall).c_str(), half_unit_a(columns_a));
  }
  // With an odd number of columns the corners alternate, so that wall B has whole units throughout.
  const bool odd = columns_b % 2 != 0;
  set("corner.2.first", odd ? "C" : "B");
  set("corner.2.second", odd ? "B" : "C");
  std::vector<int> beams;
  for (int i = 0; i < kBeams / 2; ++i)
    beams.push_back(static_cast<int>(std::lround(i * (columns_b - 1) / (kBeams / 2 - 1.0))));
  for (const int floor : {1, 2}) {
    set(fmt::format("floor.{}.half_units", floor).c_str(), fmt::format("[{}]", fmt::join(beams, ", ")));
    set(fmt::format("floor.{}.rigid_beams", floor).c_str(), beams_besides);
  }
  return settings;
}

std::vector<WindowLayout> window_layouts() {
  std::vector<WindowLayout> all;
  for (const bool besides : {false, true}) {
    for (int b = 24; b <= 32; ++b) {
      for (int a = 17; a <= 22; ++a) {
        for (int courses = 4; courses <= 12; ++courses) {
          const WindowLayout layout{b, a, courses, besides};
          const Count c = layout.count();
          if (std::abs(c.blocks - kTableABC.blocks) <= 2 && std::abs(c.half_units - kTableABC.half_units) <= 2)
            all.push_back(layout);
        }
      }
    }
  }
  return all;
}

std::string why_not(const WindowLayout& layout) {
  for (const double half_unit : {layout.half_unit_b(), half_unit_a(layout.columns_a)}) {
    if (std::abs(half_unit / kHalfUnit - 1) > 0.05) return fmt::format("half units of {:.3f} m", half_unit);
  }
  if (layout.window_courses * kCourse < 0.7)
    return fmt::format("windows {:.2f} m high", layout.window_courses * kCourse);
  if (kSill + layout.window_courses + 1 > kFloor)
    return fmt::format("no room for windows {:.2f} m high below the floor", layout.window_courses * kCourse);
  return {};
}

}  // namespace quoin::reproduce
