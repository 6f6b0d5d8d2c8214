// Parameters of the fracture-energy law, derived once when a material is made. Symbols as in LAW.md.
#pragma once

#include <array>
#include <cstdint>

namespace quoin::fracture_energy {

enum class Shape : std::uint8_t { linear, exponential, table };

// Softening function given by points: f falls linearly between (x[k], f[k]) and (x[k+1], f[k+1]), f[0] = 1, f[last] =
// 0.
struct SofteningTable {
  static constexpr int kMaxPoints = 32;
  int points = 0;
  std::array<double, kMaxPoints> x{}, f{};
  std::array<double, kMaxPoints> area{};  // integral of f from 0 to x[k]
};

// What a user gives. Friction as coefficients: angles are turned into tangents before anything is interpolated.
struct Properties {
  double kn, ks;      // stiffness, Pa/m
  double ft, c0, cr;  // strengths, Pa
  double mu0, mur;    // friction coefficients
  double tan_psi;     // dilation
  double fc, fcr;     // compressive strength and residual, Pa
  double G1, G2, Gc;  // fracture energies, J/m2
};

struct Parameters {
  Properties given;
  Shape shape = Shape::linear;
  bool shared = true;     // one internal variable for tension and shear
  bool crushing = false;  // fc is finite
  bool dilation = false;
  double A = 0.5;      // integral of f from 0 to infinity
  double slope = 1.0;  // m = max |f'|
  double end = 1.0;    // f(xi >= end) = 0
  SofteningTable table;
};

// exp(-xi) is 0 in double precision from here on: the end of exponential softening.
inline constexpr double kExponentialEnd = 746.0;

}  // namespace quoin::fracture_energy
