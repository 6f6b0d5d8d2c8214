// Path tests as data: law, properties, a path of one contact point, and the answers that a formula gives.
//
//   title = "Tension softening encloses G1"
//   law = "fracture_energy"
//   initial = "bonded"                          # default: the law's first
//   tags = ["cyclic"]
//   about = "..."                               # where the closed form comes from
//   let = ["u0 = ft/kn", ...]                   # in order; properties are known by id and by the law's symbol
//   tolerance = 1e-12                           # of every check without its own
//   reason = "a few rounding errors"            # why that tolerance
//   plot = ["dn sigma"]                         # abscissa and ordinate; default by what the path moves
//   [properties]
//   tensile_strength = 0.16e6
//   [[point]]                                   # the path goes from zero to each point in turn
//   dn = "2*u0"                                 # dn (or sigma), ds, dt: number or formula; left out: stays. A formula
//   ds = 0.0                                    # with `part` (0 to 1 over the segment) is followed as a curve, any
//   other steps = 10                                  # target in equal parts. dn0, ds0, dt0, sigma0: start of the
//   segment along = ["sigma = kn*dn"]                   # checked after every step of the segment expect = ["sigma =
//   ft*f", {check = "xi_t = 0.5", value = 0.5, tolerance = 1e-10, scale = "ft", reason = "...",
//             source = "..."}]                  # checked at its end
//
// A check is `quantity = formula`, `<=` or `>=`. Quantities: dn ds dt sigma tau_s tau_t tau, every state of the law,
// energy_stored, dissipated (sum), dissipated_tension to dissipated_crushing, work. Then flags (bits) and open,
// slipping, tension_damaged, ... (0 or 1). A check holds when |got - formula| <= tolerance * max(|formula|, scale).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "law/formula.h"
#include "law/material_point.h"

namespace quoin {

struct PathCheck {
  std::string text;  // as written
  std::string quantity;
  std::string relation;  // "=", "<=", ">="
  Formula formula;
  std::optional<double> value;  // the formula must give this number too (to 1e-6 of it): a guard against slips in it
  double tolerance = 0.0;
  Formula scale;
  std::string reason, source;
  int line = 0;
};

struct PathPoint {
  std::map<std::string, Formula> targets;  // dn or sigma, ds, dt
  int steps = 1;
  std::vector<PathCheck> along, expect;
  bool plotted = true;
  int line = 0;
};

struct PathFile {
  std::string file, title, law, initial, about;
  std::vector<std::string> tags;
  std::vector<std::pair<std::string, Formula>> definitions;
  std::vector<PropertySetting> properties;
  std::vector<PathPoint> points;
  std::vector<std::pair<std::string, std::string>> plots;
};

// Throws Error(bad_input) with file, line and key.
PathFile read_path_file(const std::string& file);

struct PathOutcome {
  std::vector<PointResult> rows;                           // the start and every step
  std::vector<Variables> values;                           // every quantity by name, row by row
  std::vector<std::map<std::string, double>> closed_form;  // by quantity, where a check along the path gives it
  std::vector<bool> plotted;                               // by row
  int checks = 0;
  std::vector<std::string> failures;
  double worst = 0.0;  // largest error as a fraction of its tolerance
};

// law: a name or path used instead of the file's; empty: the file's. force: more steps, too, than the memory here
// holds. Throws Error as the loader and the law do.
PathOutcome run_path(const PathFile& path, const std::string& law = {}, bool force = false);

// Writes FOLDER/STEM.png with gnuplot: the law's points beside the closed form. Throws Error(bad_input) when gnuplot
// fails.
std::string plot_path(const PathFile& path, const PathOutcome& outcome, const std::string& folder);

// Every quantity of a point by name.
Variables quantities(const quoin_law& law, const PointResult& point);

// Header and rows of `quoin path --out`.
std::string path_header(const quoin_law& law);
std::string path_row(const quoin_law& law, const PointResult& point);

}  // namespace quoin
