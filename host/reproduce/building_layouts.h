// Layouts of the Pavia building with the numbers of blocks and zones of the paper's Table 2. Blocks have 80 zones per
// half unit, so that zones count half units. There are fewer blocks than half units, as each lintel is one block.
#pragma once

#include <string>
#include <vector>

namespace quoin::reproduce {

struct Count {
  int blocks = 0, half_units = 0;
};
inline constexpr int kZonesPerHalfUnit = 80;
inline constexpr Count kTableD{996, 1020}, kTableABC{2506, 2542};

// Two doors and two windows in wall D, 30 half units long and 40 courses high.
struct DoorLayout {
  int door_width, door_courses, window_width, window_courses;  // half units, courses; bearing of lintels: one half unit
  bool operator==(const DoorLayout&) const = default;
  Count count() const;
  std::string name() const;
  std::vector<std::string> overrides() const;  // overrides of pavia_door.toml
};
// All layouts with the numbers of Table 2. Openings have 4 to 6 half units (0.8 to 1.2 m; 0.94 m recalled), doors 10 to
// 15 courses (1.6 to 2.4 m; 2.14 m recalled). Doors are higher than windows.
std::vector<DoorLayout> door_layouts();
// Reason why a layout is unlikely; empty: none. Widths are within half of a half unit of the recalled 0.94 m, doors at
// least 1.7 m, windows at least 0.7 m.
std::string why_not(const DoorLayout& layout);

// Six equal windows of 5 half units in wall B between corners with walls A and C.
struct WindowLayout {
  int columns_b, columns_a, window_courses;  // half units of B; of A and of C; courses
  bool beams_besides;                        // whether the 22 floor beams are additional to the blocks of the walls
  bool operator==(const WindowLayout&) const = default;
  Count count() const;
  double half_unit_b() const { return 5.5 / columns_b; }  // m, for 6.00 m in total
  double depth() const;                                   // outer depth of walls A and C, m
  std::string name() const;
  std::vector<std::string> overrides() const;  // overrides of pavia_window.toml
};
// All layouts within two half units and two blocks of Table 2, with windows of 4 to 12 courses.
std::vector<WindowLayout> window_layouts();
// Reason why a layout is unlikely: half units more than 5 % from the 0.2 m of wall D, windows lower than 0.7 m or
// higher than the storey. Empty: none.
std::string why_not(const WindowLayout& layout);

}  // namespace quoin::reproduce
