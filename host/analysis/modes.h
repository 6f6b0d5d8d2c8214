// Natural frequencies and mode shapes of masonry as it is at the start, and what earthquake engineers read from them.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/undamaged.h"

namespace quoin {

struct ModesSettings {
  int count = 10;                              // number of the lowest frequencies, those that are zero included
  std::array<double, 2> ratios{0.05, 0.05};    // damping ratios at two frequencies
  std::array<double, 2> at_frequencies{0, 0};  // Hz; 0: the lowest and the highest that are found
};

// C = mass_damping M + stiffness_damping K: keys of [solver].
struct Rayleigh {
  double mass_damping = 0.0, stiffness_damping = 0.0;  // 1/s, s
  std::array<double, 2> frequencies{}, ratios{};       // Hz
};

struct Mode {
  double frequency = 0.0;  // Hz; 0: moves without any stiffness
  // Factors for ground motion along x, y, z, with shapes whose largest displacement is 1.
  std::array<double, 3> participation{}, effective_mass{};  // -, kg
};

struct Modes {
  std::vector<Mode> mode;             // ascending
  Eigen::MatrixXd shape;              // by unknown and mode; largest displacement of a corner or gridpoint 1
  int zero = 0;                       // number of frequencies without stiffness
  std::vector<int> loose;             // blocks that move in these
  std::array<double, 3> free_mass{};  // kg
  Rayleigh rayleigh;
  double factor_entries = 0.0;  // entries of the Cholesky factor; 0: solved as a full matrix
};

// Throws Error(bad_input) for settings out of range, Error(numerical) where iterations do not settle.
Modes find_modes(const Vibrating& v, const ModesSettings& settings = {});

// alpha and beta that give two ratios at two frequencies, Hz.
Rayleigh rayleigh(const std::array<double, 2>& frequencies, const std::array<double, 2>& ratios);

// Displacement of the corners or gridpoints of a block, largest 1 in all blocks.
std::vector<geometry::Vector> shape_of_block(const Vibrating& v, const Modes& modes, int block, int mode);

// The same of all blocks, by mode and then block: rows of x, y, z.
std::vector<std::vector<std::vector<std::array<double, 3>>>> shapes_of(const Vibrating& v, const Modes& modes);

// What modes.json holds.
nlohmann::ordered_json json_of(const std::string& scene, const Vibrating& v, const Modes& modes);

}  // namespace quoin
