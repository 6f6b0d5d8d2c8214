// Stress run of the fracture-energy law (contact_models/fracture_energy/LAW.md, statements 3 and 5): random steps with
// extreme admissible parameters, jumps from 1e-15 to 1 m, not a number and infinity among the inputs. For finite input
// nothing but finite numbers may come out, no traction outside the current strength, no negative dissipation; bad input
// must fail its point and return the old state. The strengths are computed here from the states that come back, not by
// the law.
//
//   law_stress [--steps 1e8] [--seed 20261121]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <random>

#include "plugin.h"

namespace {

using quoin::test::Batch;
using quoin::test::Values;

struct Drawn {
  double kn, ks, ft, c0, cr, mu0, mur, fc, fcr, end = 1.0;
  double G1, G2, Gc, A = 0.5, m = 1.0;
  std::string shape = "linear";
  bool shared = true;
  std::vector<double> table;

  double f(double xi) const {
    if (xi >= end) return 0.0;
    if (shape == "exponential") return std::exp(-xi);
    if (shape == "linear") return 1.0 - xi;
    for (std::size_t k = 2; k < table.size(); k += 2) {
      if (xi < table[k]) {
        return table[k - 1] + (table[k + 1] - table[k - 1]) * (xi - table[k - 2]) / (table[k] - table[k - 2]);
      }
    }
    return 0.0;
  }
};

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) { return std::uniform_real_distribution<>(low, high)(random); }
double log_uniform(Random& random, double low, double high) {
  return std::exp(uniform(random, std::log(low), std::log(high)));
}
bool chance(Random& random, double probability) { return uniform(random, 0.0, 1.0) < probability; }

// Admissible by statement 6 there, with energies from 1.001 times their bound.
Values draw(Random& random, Drawn& d) {
  const auto tangent = [](double degrees) { return std::tan(degrees * (M_PI / 180.0)); };
  d.kn = log_uniform(random, 1e6, 1e14);
  d.ks = log_uniform(random, 1e6, 1e14);
  d.ft = chance(random, 0.2) ? 0.0 : log_uniform(random, 1.0, 1e9);
  d.c0 = chance(random, 0.2) ? 0.0 : log_uniform(random, 1.0, 1e9);
  d.cr = chance(random, 0.5) ? 0.0 : chance(random, 0.2) ? d.c0 : d.c0 * uniform(random, 0.0, 0.99);
  const double phi0 = chance(random, 0.2) ? 0.0 : uniform(random, 0.0, 80.0);
  const double phir = chance(random, 0.5) ? phi0 : phi0 * uniform(random, 0.0, 1.0);
  double psi0 = chance(random, 0.6) ? 0.0 : phi0 * uniform(random, 0.0, 0.5);
  d.mu0 = tangent(phi0), d.mur = tangent(phir);
  const bool crushes = chance(random, 0.6);
  d.fc = crushes ? log_uniform(random, 1.0, 1e9) : std::numeric_limits<double>::infinity();
  d.fcr = chance(random, 0.4) ? 0.0 : crushes ? d.fc * uniform(random, 0.0, 1.0) : 0.0;
  d.shared = chance(random, 0.5);
  const int shape = static_cast<int>(uniform(random, 0.0, 3.0));
  if (shape == 1) {
    d.shape = "exponential";
    d.A = 1.0, d.end = 746.0;
  } else if (shape == 2) {
    d.shape = "table";
    d.table = {0.0, 1.0, 0.3, 0.5, 0.9, 0.2, 2.0, 0.0};
    d.A = 0.3 * 0.75 + 0.6 * 0.35 + 1.1 * 0.1;
    d.m = 0.5 / 0.3, d.end = 2.0;
  }
  const auto energy = [&](double bound) {
    return bound * (chance(random, 0.3) ? 1.001 : log_uniform(random, 1.001, 1e6));
  };
  const double P = crushes ? d.fc : 0.0;
  d.G1 = energy(0.5 * d.ft * d.ft / d.kn);
  d.G2 = energy(d.m * std::max(d.c0, d.c0 - d.cr + P * (d.mu0 - d.mur)) * (d.c0 - d.cr) * d.A / d.ks);
  const double lowest_Gc = crushes ? d.m * (d.fc - d.fcr) * (d.fc - d.fcr) * d.A / d.kn : 0.0;
  d.Gc = energy(lowest_Gc);
  // Uplift that crushes the joint takes from ks: kn mu0 tan(psi0) q/(1 - q), with q as large as Gc is close to its
  // bound.
  const double by_uplift = lowest_Gc > 0.0 ? d.kn * d.mu0 * tangent(psi0) * lowest_Gc / (d.Gc - lowest_Gc) : 0.0;
  if (by_uplift < 0.999 * d.ks) {
    d.G2 *= d.ks / (d.ks - by_uplift) * 1.000001;
  } else {
    psi0 = 0.0;
  }
  Values v;
  v.numbers = {{"normal_stiffness", d.kn},           {"shear_stiffness", d.ks},
               {"tensile_strength", d.ft},           {"cohesion", d.c0},
               {"cohesion_residual", d.cr},          {"friction_angle", phi0},
               {"friction_angle_residual", phir},    {"dilation_angle", psi0},
               {"compressive_strength", d.fc},       {"compressive_strength_residual", d.fcr},
               {"fracture_energy_tension", d.G1},    {"fracture_energy_shear", d.G2},
               {"fracture_energy_compression", d.Gc}};
  v.words = {{"softening", d.shape}, {"coupling", d.shared ? "shared" : "none"}};
  if (d.shape == "table") v.table = d.table;
  return v;
}

double jump_size(Random& random) {
  const double sign = chance(random, 0.5) ? 1.0 : -1.0;
  return sign * log_uniform(random, 1e-15, 1.0);
}

}  // namespace

int main(int argc, char** argv) {
  double steps = 1e6;
  std::uint64_t seed = 20261121;
  for (int k = 1; k + 1 < argc; k += 2) {
    if (std::strcmp(argv[k], "--steps") == 0) steps = std::atof(argv[k + 1]);
    if (std::strcmp(argv[k], "--seed") == 0) seed = std::strtoull(argv[k + 1], nullptr, 10);
  }
  const quoin_law& law = quoin::test::load_law("fracture_energy");
  Random random(seed);
  constexpr std::size_t kPoints = 64;
  constexpr int kStepsPerMaterial = 200;
  const long materials = static_cast<long>(steps / (kPoints * kStepsPerMaterial)) + 1;
  long done = 0, failures = 0, bad_inputs = 0, yields = 0;
  double worst_strength = 0.0, worst_dissipation = 0.0;

  const auto report = [&](const char* what, const Drawn& d, const Batch& b, std::size_t i) {
    if (++failures > 10) return;
    fmt::print(
        "FAILED {}: shape {}, shared {}, kn {:.17g} ks {:.17g} ft {:.17g} c0 {:.17g} cr {:.17g} mu0 {:.17g} mur "
        "{:.17g} fc {:.17g} "
        "fcr {:.17g} G1 {:.17g} G2 {:.17g} Gc {:.17g}\n  in",
        what, d.shape, d.shared, d.kn, d.ks, d.ft, d.c0, d.cr, d.mu0, d.mur, d.fc, d.fcr, d.G1, d.G2, d.Gc);
    for (const auto& column : b.in) fmt::print(" {:.17g}", column[i]);
    fmt::print("\n  out");
    for (const auto& column : b.out) fmt::print(" {:.17g}", column[i]);
    fmt::print("\n");
  };

  for (long material_index = 0; material_index < materials; ++material_index) {
    Drawn d;
    const Values values = draw(random, d);
    std::optional<quoin::api::Material> material;
    try {
      material = quoin::test::make_material(law, values);
    } catch (const quoin::api::Error& error) {
      fmt::print("FAILED: admissible material refused: {}\n", error.what());
      ++failures;
      continue;
    }
    Batch b(law, kPoints);
    if (chance(random, 0.2)) b.in[6].assign(kPoints, d.end), b.in[7].assign(kPoints, d.end);  // dry
    const double reach = log_uniform(random, 1e-12, 1.0);
    for (int step = 0; step < kStepsPerMaterial; ++step) {
      std::vector<bool> bad(kPoints, false);
      for (std::size_t i = 0; i < kPoints; ++i) {
        // Mostly around one size, so that states are visited again; sometimes any size.
        if (chance(random, 0.5))
          b.in[0][i] = chance(random, 0.9) ? reach * uniform(random, -1.0, 1.0) : jump_size(random);
        for (int k = 1; k < 3; ++k) {
          b.in[k][i] = chance(random, 0.2)   ? 0.0
                       : chance(random, 0.9) ? reach * uniform(random, -1.0, 1.0)
                                             : jump_size(random);
        }
        if (chance(random, 1e-3)) {
          bad[i] = true;
          const double poison[] = {std::nan(""), std::numeric_limits<double>::infinity(),
                                   -std::numeric_limits<double>::infinity()};
          b.in[static_cast<std::size_t>(uniform(random, 0.0, 3.0))][i] =
              poison[static_cast<int>(uniform(random, 0.0, 3.0))];
        }
      }
      b.evaluate(*material);
      for (std::size_t i = 0; i < kPoints; ++i) {
        ++done;
        const auto out = [&](std::size_t k) { return b.out[k][i]; };
        if (bad[i]) {
          ++bad_inputs;
          bool kept = b.status[i] == QUOIN_POINT_FAILED;
          for (std::size_t k = 0; k < 3 + b.states; ++k) kept = kept && out(k) == b.in[3 + k][i];
          if (!kept) report("bad input did not fail its point with the old state", d, b, i);
          b.in[0][i] = 0.0;
          continue;
        }
        bool finite = b.status[i] == QUOIN_POINT_OK;
        for (std::size_t k = 0; k < b.out.size(); ++k) finite = finite && std::isfinite(out(k));
        if (!finite) {
          report("not finite or not ok", d, b, i);
          continue;
        }
        yields += (b.flags[i] & QUOIN_FLAG_YIELDING) != 0;
        const double sigma = out(0), tau = std::hypot(out(1), out(2));
        const double xi_t = out(3), xi_s = out(4), w = out(5), v = out(6);
        const double d_n = b.in[0][i];
        const double trial = std::hypot(b.in[4][i] + d.ks * b.in[1][i], b.in[5][i] + d.ks * b.in[2][i]);
        const double scale = std::max({d.ft, d.c0, d.kn * (std::abs(d_n) + w + v), trial});
        const double tolerance = 1e3 * std::numeric_limits<double>::epsilon() * scale;
        const double f_s = d.f(xi_s);
        const double mu = d.mu0 + (d.mur - d.mu0) * (1.0 - f_s);
        // Where e is 0 to rounding the joint may count as closed, with its residual cohesion, or as open.
        const double e = d_n + b.in[8][i] - b.in[9][i];
        const bool open = e > 1e-14 * (std::abs(d_n) + b.in[8][i] + b.in[9][i]);
        const double cohesion = open ? d.c0 * f_s : d.cr + (d.c0 - d.cr) * f_s;
        const double drop = d.fc - d.fcr;
        const double F = std::isinf(d.fc) ? d.fc : d.fcr + drop * d.f(drop > 0.0 ? w * drop * d.A / d.Gc : 0.0);
        const double over =
            std::max({sigma - d.ft * d.f(xi_t), -F - sigma, tau - std::max(0.0, cohesion - sigma * mu)});
        worst_strength = std::max(worst_strength, over / scale);
        if (over > tolerance) report("outside the strength", d, b, i);
        for (std::size_t k = 0; k < 4; ++k) {
          worst_dissipation = std::min(worst_dissipation, out(4 + b.states + k));
          if (out(4 + b.states + k) < 0.0) report("negative dissipation", d, b, i);
        }
        for (std::size_t k = 3; k < 3 + b.states; ++k) {
          if (out(k) < b.in[3 + k][i]) report("an internal variable decreased", d, b, i);
        }
      }
      b.advance();
    }
  }
  fmt::print(
      "{} steps of {} materials, seed {}: {} yielding, {} bad inputs, worst excess over strength {:.2e} of scale, "
      "least "
      "dissipation {:.2e}, {} failures\n",
      done, materials, seed, yields, bad_inputs, worst_strength, worst_dissipation, failures);
  if (yields < done / 20 || bad_inputs == 0) {
    fmt::print("FAILED: the run did not reach what it is for\n");
    return 1;
  }
  return failures == 0 ? 0 : 1;
}
