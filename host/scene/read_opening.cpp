#include "scene/generate.h"
#include "scene/openings.h"
#include "scene/read_tables.h"

namespace quoin {

using namespace reader;

namespace {

using Opening = WallSpec::Opening;

constexpr int kManyHalfUnits = 20000, kManyCourses = 10000;  // limits where those of the wall are at fault
constexpr double kBearingTolerance = 1e-3;                   // over a half unit: bearings are written with few digits

void read_bearing(Table& o, Opening& opening, const Lattice& lattice,
                  const std::map<std::string, BlockMaterial>& materials) {
  double bearing = 0.0;
  const bool given = o.number("bearing", bearing, kNotNegative, "m of lintel on either side (0: no lintel)");
  if (given && lattice.half_unit > 0.0) {
    const double count = bearing / lattice.half_unit;
    const int most = lattice.half_units > 0 ? lattice.half_units : kManyHalfUnits;
    if (count > most + kBearingTolerance)
      o.refuse("bearing",
               fmt::format("at most the length of the wall, {:g} m; lintels end inside it", most * lattice.half_unit));
    else if (std::abs(count - std::round(count)) > kBearingTolerance)
      o.refuse("bearing", fmt::format("whole half units of {:g} m, as a lintel ends where a half unit does: {:g} or "
                                      "{:g}",
                                      lattice.half_unit, std::floor(count) * lattice.half_unit,
                                      std::ceil(count) * lattice.half_unit));
    else
      opening.bearing = static_cast<int>(std::lround(count));
  }
  if (!o.has("lintel_material")) return o.accept("lintel_material");
  o.choice("lintel_material", opening.lintel_material, names_of(materials));
  if (bearing == 0.0) o.refuse("lintel_material", "only with a lintel; give bearing > 0 too, or remove it");
}

// Adds faults of the lintel of opening i.
void check_lintel(Table& o, const std::vector<Opening>& openings, std::size_t i, const Lattice& lattice) {
  const Opening& opening = openings[i];
  const int course = opening.lintel_course(), first = opening.lintel_first();
  const int last = first + opening.lintel_length() - 1;
  if (course >= lattice.courses) {
    o.refuse("bearing",
             fmt::format("0 here: the opening ends with course {}, the top of the wall, and leaves no course "
                         "for a lintel",
                         lattice.courses - 1));
    return;
  }
  const int left = opening.first_half_unit;
  const int right = lattice.half_units - opening.first_half_unit - opening.half_units;
  if (opening.bearing > std::min(left, right)) {
    o.refuse("bearing", fmt::format("at most {:g} m: the wall has {} half units of {:g} m left of the opening and {} "
                                    "right of it",
                                    std::min(left, right) * lattice.half_unit, left, lattice.half_unit, right));
    return;
  }
  for (std::size_t j = 0; j < openings.size(); ++j) {
    if (j == i) continue;
    const Opening& other = openings[j];
    const auto any_cell = [&](auto taken) {
      for (int half_unit = first; half_unit <= last; ++half_unit) {
        if (taken(half_unit)) return true;
      }
      return false;
    };
    if (any_cell([&](int half_unit) { return other.covers(course, half_unit); })) {
      o.refuse("bearing", fmt::format("a lintel clear of other openings: this one, half units {} to {} of course {}, "
                                      "runs into opening {}",
                                      first, last, course, j + 1));
    } else if (any_cell([&](int half_unit) {
                 return !opening.covers(course - 1, half_unit) && other.covers(course - 1, half_unit);
               })) {
      o.refuse("bearing", fmt::format("a lintel borne by masonry: below its half units {} to {} of course {} lies "
                                      "opening {}",
                                      first, last, course, j + 1));
    } else if (j < i && any_cell([&](int half_unit) { return other.lintel_covers(course, half_unit); })) {
      o.refuse("bearing",
               fmt::format("lintels side by side: this one, half units {} to {} of course {}, runs into that "
                           "of opening {}",
                           first, last, course, j + 1));
    }
  }
}

}  // namespace

std::vector<Opening> read_openings(Table& wall, const Lattice& lattice,
                                   const std::map<std::string, BlockMaterial>& materials) {
  const int half_units = lattice.half_units > 0 ? lattice.half_units : kManyHalfUnits;
  const int courses = lattice.courses > 0 ? lattice.courses : kManyCourses;
  std::vector<Opening> openings;
  std::vector<Table> tables;
  bool placed = lattice.half_units > 0 && lattice.courses > 0 && lattice.half_unit > 0.0;
  wall.each("opening", [&](Table& o) {
    Opening& opening = openings.emplace_back();
    // Both keys are read before the check, so that one report has the faults of both.
    const bool has_column = o.integer("first_half_unit", opening.first_half_unit, 0, half_units - 1, true);
    const bool has_course = o.integer("first_course", opening.first_course, 0, courses - 1, true);
    if (has_column && has_course) {
      const bool has_width = o.integer("half_units", opening.half_units, 1, half_units - opening.first_half_unit, true);
      const bool has_height = o.integer("courses", opening.courses, 1, courses - opening.first_course, true);
      placed = placed && has_width && has_height;
    } else {
      o.accept("half_units");
      o.accept("courses");
      placed = false;
    }
    read_bearing(o, opening, lattice, materials);
    tables.push_back(o);
  });
  for (std::size_t i = 0; placed && i < openings.size(); ++i) {
    if (openings[i].bearing > 0) check_lintel(tables[i], openings, i, lattice);
  }
  return openings;
}

std::vector<WallSpec::Changed> read_changed(Table& wall, const Lattice& lattice, const WallSpec& spec,
                                            const std::map<std::string, BlockMaterial>& materials) {
  std::vector<WallSpec::Changed> changed;
  wall.each("changed", [&](Table& u) {
    WallSpec::Changed unit;
    const int courses = lattice.courses > 0 ? lattice.courses : kManyCourses;
    const int half_units = lattice.half_units > 0 ? lattice.half_units : kManyHalfUnits;
    const bool in_course = u.integer("course", unit.course, 0, courses - 1, true);
    const bool placed = u.integer("half_unit", unit.half_unit, 0, half_units - 1, true) && in_course;
    bool missing = false;
    u.boolean("missing", missing);
    u.choice("material", unit.material, names_of(materials));
    if (missing == u.has("material"))
      u.context().fault(u.where() + ": give one of missing = true and material, the name of another one");
    if (!placed) return;
    if (in_opening(spec.openings, unit.course, unit.half_unit))
      u.refuse("half_unit", "one that is there: an opening takes this one");
    const auto before = std::find_if(changed.begin(), changed.end(), [&](const WallSpec::Changed& c) {
      return c.course == unit.course && same_unit(spec, unit.course, c.half_unit, unit.half_unit);
    });
    if (before != changed.end())
      u.refuse("half_unit", fmt::format("each unit once, and a table before has this one, with half_unit = {}; remove "
                                        "one of the two",
                                        before->half_unit));
    changed.push_back(unit);
  });
  return changed;
}

}  // namespace quoin
