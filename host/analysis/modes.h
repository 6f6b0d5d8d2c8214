// Natural frequencies and mode shapes of masonry at the start, with the participation factors of earthquake
// engineering.
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
  int count = 10;                              // number of lowest frequencies, zero ones included
  std::array<double, 2> ratios{0.05, 0.05};    // damping ratios at two frequencies
  std::array<double, 2> at_frequencies{0, 0};  // Hz; both 0: the lowest and the highest computed
};

// Damping C = mass_damping M + stiffness_damping K, as the keys of [solver].
struct Rayleigh {
  double mass_damping = 0.0, stiffness_damping = 0.0;  // 1/s, s
  std::array<double, 2> frequencies{}, ratios{};       // Hz
};

struct Mode {
  double frequency = 0.0;  // Hz; 0: without stiffness
  // Factors for ground motion along x, y, z, with shapes scaled to a largest displacement of 1.
  std::array<double, 3> participation{}, effective_mass{};  // -, kg
};

struct Modes {
  std::vector<Mode> mode;             // ascending
  Eigen::MatrixXd shape;              // by unknown and mode; the largest displacement of a corner or gridpoint is 1
  int zero = 0;                       // number of modes without stiffness
  std::vector<int> loose;             // blocks that move in them
  std::array<double, 3> free_mass{};  // kg
  Rayleigh rayleigh;
  double factor_entries = 0.0;  // entries of the Cholesky factor; 0: solved as a full matrix
};

// Throws Error(bad_input) for settings out of range, Error(numerical) where iterations do not converge.
Modes find_modes(const Vibrating& v, const ModesSettings& settings = {});

// Rayleigh coefficients for two damping ratios at two frequencies, Hz.
Rayleigh rayleigh(const std::array<double, 2>& frequencies, const std::array<double, 2>& ratios);

// Displacement of the corners or gridpoints of a block; the largest of all blocks is 1.
std::vector<geometry::Vector> shape_of_block(const Vibrating& v, const Modes& modes, int block, int mode);

// Shapes of all blocks, by mode and then block: rows of x, y, z.
std::vector<std::vector<std::vector<std::array<double, 3>>>> shapes_of(const Vibrating& v, const Modes& modes);

// Contents of modes.json.
nlohmann::ordered_json json_of(const std::string& scene, const Vibrating& v, const Modes& modes);

}  // namespace quoin
