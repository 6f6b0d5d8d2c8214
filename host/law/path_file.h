// Path tests as data: law, properties, the path of one contact point, and the expected results by formulas.
//
//   title = "Tension softening encloses G1"
//   law = "fracture_energy"
//   initial = "bonded"                          # default: the law's first
//   tags = ["cyclic"]
//   about = "..."                               # source of the closed form
//   let = ["u0 = ft/kn", ...]                   # in order; properties by id and by the law's symbol
//   tolerance = 1e-12                           # of every check without its own
//   reason = "a few rounding errors"            # of that tolerance
//   plot = ["dn sigma"]                         # abscissa and ordinate; default by the moving components
//   [properties]
//   tensile_strength = 0.16e6
//   [[point]]                                   # the path goes from zero to each point in turn
//   dn = "2*u0"                                 # dn (or sigma), ds, dt: number or formula; default: constant
//   ds = 0.0
//   steps = 10                                  # number of increments
//   along = ["sigma = kn*dn"]                   # checks after every step of the segment
//   expect = ["sigma = ft*f",                   # checks at its end
//             {check = "xi_t = 0.5", value = 0.5, tolerance = 1e-10, scale = "ft", reason = "...", source = "..."}]
//
// A target formula with `part` (0 to 1 over the segment) describes a curve; other targets are reached in equal parts.
// Formulas may use dn0, ds0, dt0, sigma0, the values at the start of the segment. A check is `quantity = formula`, `<=`
// or `>=`. Quantities: dn ds dt sigma tau_s tau_t tau, every state of the law, energy_stored, dissipated (sum),
// dissipated_tension to dissipated_crushing, work. Also flags (bits) and open, slipping, tension_damaged, ... (0 or 1).
// A check holds when |got - formula| <= tolerance * max(|formula|, scale).
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
  // Number that the formula must give too (to 1e-6 of it): a guard against errors in the formula.
  std::optional<double> value;
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

// Reads a path file. Throws Error(bad_input) with file, line and key.
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

// Runs a path. law: a name or path in place of the file's; empty: the file's. force: permits more steps than fit the
// memory. Throws Error as the loader and the law do.
PathOutcome run_path(const PathFile& path, const std::string& law = {}, bool force = false);

// Plots FOLDER/STEM.png with gnuplot: points of the law and the closed form. Throws Error(bad_input) when gnuplot
// fails.
std::string plot_path(const PathFile& path, const PathOutcome& outcome, const std::string& folder);

// All quantities of a point by name.
Variables quantities(const quoin_law& law, const PointResult& point);

// Header and rows of `quoin path --out`.
std::string path_header(const quoin_law& law);
std::string path_row(const quoin_law& law, const PointResult& point);

}  // namespace quoin
