// Points with constant inputs: old and new columns are different memory, so that every call starts from equal states.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "hwy/aligned_allocator.h"
#include "tests/kernels/plugin.h"
#include "tests/mortar.h"

namespace quoin::benchmarks {

namespace mortar = quoin::test::mortar;

constexpr double kFriction = 0.7002075382;  // tan 35 deg

// Returns a material of the law in a file, with the properties of the mortar of Table 1 of the paper.
inline api::Material mortar_joint(const std::string& path, const char* softening = nullptr) {
  const quoin_law& law = test::load_law_file(path);
  test::Values values;
  for (const auto& property : mortar::properties) {
    const auto known = [&](const quoin_property_info* info) { return std::string(info->id) == property.first; };
    if (std::any_of(law.properties, law.properties + law.property_count, known)) values.numbers.push_back(property);
  }
  if (softening != nullptr) values.words.emplace_back("softening", softening);
  return test::make_material(law, values);
}

// States and increments of points. softening: alternately joints of eight points that slide with decreasing cohesion,
// and joints of eight points that open on the envelope. crushing: on the softening branch without slip. corner: a slip
// far beyond both surfaces of cyclic_joint, for which crushing alone returns the stress. both: from the edge of both
// surfaces, with pressure and slip for which the point slips and crushes in the same step.
enum class Population { elastic, sliding, opening, softening, damaged, crushing, corner, both, mixed, random };

// Columns aligned to cache lines, since a vector that crosses a line costs two accesses. They are an odd number of
// lines apart, so that they do not compete for the sets of a cache.
struct Points {
  std::size_t states, length;
  hwy::AlignedFreeUniquePtr<double[]> memory;
  double *jump, *slip_s, *slip_t, *traction[3], *traction_new[3];
  std::vector<double*> state, state_new;
  std::vector<quoin_in> old_columns;
  std::vector<quoin_out> new_columns;
  quoin_batch batch{};

  // in_place: new states overwrite the old ones, as in a host; new tractions do not.
  Points(const api::Material& material, std::size_t count, Population population, bool exponential = false,
         bool in_place = false)
      : states(material.law().state_count),
        length(8 * (((count + 7) / 8 | 1) + 4)),
        memory(hwy::AllocateAligned<double>((3 + 2 * (3 + states)) * length)),
        state(states),
        state_new(states),
        old_columns(states),
        new_columns(states) {
    std::fill_n(memory.get(), (3 + 2 * (3 + states)) * length, 0.0);
    double* next = memory.get();
    const auto place = [&](double*& column) { column = next, next += length; };
    place(jump), place(slip_s), place(slip_t);
    for (int k = 0; k < 3; ++k) place(traction[k]), place(traction_new[k]);
    for (std::size_t k = 0; k < states; ++k) place(state[k]), place(state_new[k]);
    const quoin_law& law = material.law();
    const std::vector<double> bonded = material.initial_state("bonded");
    for (std::size_t k = 0; k < states; ++k) std::fill_n(state[k], count, bonded[k]);
    // Sets the state that has one of these ids in this law; does nothing if it has none.
    const auto set = [&](std::initializer_list<const char*> ids, std::size_t i, double value) {
      for (std::size_t k = 0; k < states; ++k) {
        for (const char* id : ids) {
          if (std::string(law.states[k]->id) == id) state[k][i] = value;
        }
      }
    };
    const double u0 = mortar::ft / mortar::kn, area = exponential ? 1.0 : 0.5;  // area: integral of f
    const double lt = (mortar::G1 - 0.5 * mortar::ft * u0) / (mortar::ft * area), wu = mortar::Gc / (mortar::fc * area);
    const auto damage = [&](std::size_t i, double xi) {
      set({"xi_t", "xi_s", "xi"}, i, xi);
      set({"kappa"}, i, u0 + std::min(xi, 1.0) * lt);
    };
    std::mt19937_64 random(20261121);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (std::size_t i = 0; i < count; ++i) {
      Population kind = population;
      // mixed: one point in eight softens, the rest is elastic, in blocks as in a wall with a crack; random: any state.
      if (kind == Population::mixed) kind = i / 64 % 8 == 0 ? Population::softening : Population::elastic;
      if (kind == Population::softening) kind = i / 8 % 2 == 0 ? Population::sliding : Population::opening;
      const double u = unit(random);
      if (kind == Population::elastic) {
        jump[i] = -1e-5 * unit(random);
        slip_s[i] = 1e-9 * u;
        traction[1][i] = 1e4 * unit(random);
      } else if (kind == Population::sliding || kind == Population::opening) {
        const double xi = 0.2 + 0.5 * u;
        damage(i, xi);
        if (kind == Population::sliding) {
          jump[i] = -1e-5 * unit(random);
          const double sigma = mortar::kn * jump[i];
          traction[1][i] = mortar::c0 * (exponential ? std::exp(-xi) : 1.0 - xi) - kFriction * sigma;
          slip_s[i] = 1e-7;
        } else {
          jump[i] = u0 + (xi + 1e-3) * lt;
          slip_s[i] = 1e-9;
        }
      } else if (kind == Population::damaged) {
        // A crack after complete softening, with friction only: joints of eight points, one in four of them open
        damage(i, 1.0 + u);
        jump[i] = i / 8 % 4 == 0 ? 1e-4 * unit(random) : -1e-5 * unit(random);
        traction[1][i] = std::max(0.0, -kFriction * mortar::kn * jump[i]);
        slip_s[i] = 1e-7;
      } else if (kind == Population::crushing || kind == Population::corner) {
        const double x = 0.1 + 0.4 * u, w = x * wu;
        const double left = mortar::fc * (exponential ? std::exp(-x) : 1.0 - x);
        set({"w", "l"}, i, w);
        damage(i, 0.3);
        jump[i] = -w - 1.001 * left / mortar::kn;
        slip_s[i] = kind == Population::corner ? 2.0 * left / mortar::ks : 0.0;
      } else if (kind == Population::both) {
        const double x = 0.1 + 0.4 * u, w = x * wu, xi = 0.3;
        const double F = mortar::fc * (exponential ? std::exp(-x) : 1.0 - x);
        const double c = mortar::c0 * (F / mortar::fc) * (exponential ? std::exp(-xi) : 1.0 - xi);
        // p^2 + Cs (c + mu p)^2 = F^2
        constexpr double kCs = 9.0, kA = 1.0 + kCs * kFriction * kFriction;
        const double half_b = kCs * kFriction * c;
        const double p = (std::sqrt(half_b * half_b + kA * (F * F - kCs * c * c)) - half_b) / kA;
        set({"w", "l"}, i, w);
        damage(i, xi);
        jump[i] = -w - (p + 2e3) / mortar::kn;
        traction[1][i] = c + kFriction * p;
        slip_s[i] = 1e-7;
      } else {
        damage(i, unit(random) < 0.5 ? 0.0 : 1.2 * unit(random));
        set({"w", "l"}, i, unit(random) < 0.9 ? 0.0 : 1e-4 * unit(random));
        jump[i] = unit(random) < 0.5 ? -7e-5 * unit(random) : 1e-4 * unit(random);
        traction[1][i] = 0.2e6 * unit(random);
        slip_s[i] = 1e-6 * (u - 0.5);
        slip_t[i] = 1e-6 * (unit(random) - 0.5);
      }
    }
    for (std::size_t k = 0; k < states; ++k) {
      const bool history = law.states[k]->role == QUOIN_ROLE_HISTORY;
      old_columns[k] = {history ? state[k] : nullptr, 1};
      new_columns[k] = {history ? in_place ? state[k] : state_new[k] : nullptr, 1};
    }
    batch.struct_size = sizeof(quoin_batch);
    batch.count = count;
    batch.normal_jump = {jump, 1};
    batch.slip_increment[0] = {slip_s, 1};
    batch.slip_increment[1] = {slip_t, 1};
    for (int k = 0; k < 3; ++k) {
      batch.traction_old[k] = {traction[k], 1};
      batch.traction_new[k] = {traction_new[k], 1};
    }
    batch.state_old = old_columns.data();
    batch.state_new = new_columns.data();
  }
};

}  // namespace quoin::benchmarks
