// Stress run of the fracture-energy law (contact_models/fracture_energy/LAW.md, statements 3 and 5) and of the two laws
// of its section "The other laws that ship". Also of the cyclic joint law (contact_models/cyclic_joint/LAW.md,
// statements 4 and 7). Random steps have extreme admissible parameters, jumps from 1e-15 to 1 m, and sometimes NaN or
// infinity as input. For finite input all outputs must be finite, tractions within the strength, dissipation not
// negative, states within their bounds. Other input must fail its point and return the old state. The strengths are
// computed here from the new states, not by the law.
//
//   law_stress [--law fracture_energy] [--steps 1e8] [--seed 20261121] [--set AVX2]
//
// --set: an instruction set of this machine (SCALAR, SSE4, AVX2, AVX3); default: the best one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <random>

#include "hwy/highway.h"
#include "hwy/targets.h"
#include "plugin.h"
#include "tests/cyclic_joint/joints.h"

namespace {

using quoin::test::Batch;
using quoin::test::Values;
using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) { return std::uniform_real_distribution<>(low, high)(random); }
double log_uniform(Random& random, double low, double high) {
  return std::exp(uniform(random, std::log(low), std::log(high)));
}
bool chance(Random& random, double probability) { return uniform(random, 0.0, 1.0) < probability; }

struct Excess {
  double over;       // excess of the traction over the strengths, Pa
  double tolerance;  // allowed excess, Pa
  double scale;      // scale of rounding, Pa
};
double trial_shear(const Batch& b, std::size_t i, double ks) {
  return std::hypot(b.in[4][i] + ks * b.in[1][i], b.in[5][i] + ks * b.in[2][i]);
}

// A joint of one law. values: an admissible material. strength(b, i): excess of the new tractions over the new
// strength.
struct ElasticJoint {
  static constexpr const char* kLaw = "elastic";
  static constexpr bool kYields = false;
  double kn, ks;

  Values draw(Random& random) {
    kn = log_uniform(random, 1e6, 1e14), ks = log_uniform(random, 1e6, 1e14);
    return {{{"normal_stiffness", kn}, {"shear_stiffness", ks}}, {}, {}};
  }
  void make_dry(Batch&) const {}
  // Without a strength: the distance from the elastic traction.
  Excess strength(const Batch& b, std::size_t i) const {
    const double line[3] = {kn * b.in[0][i], b.in[4][i] + ks * b.in[1][i], b.in[5][i] + ks * b.in[2][i]};
    Excess e{0.0, 0.0, std::numeric_limits<double>::min()};
    for (std::size_t k = 0; k < 3; ++k) {
      e.over = std::max(e.over, std::abs(b.out[k][i] - line[k]));
      e.scale = std::max(e.scale, k == 0 ? std::abs(line[0]) : std::abs(b.in[3 + k][i]) + ks * std::abs(b.in[k][i]));
    }
    e.tolerance = 4 * std::numeric_limits<double>::epsilon() * e.scale;
    return e;
  }
  const char* beyond_bounds(const Batch& b, std::size_t i) const {
    return b.out[3][i] < 0.0 ? "negative energy stored" : nullptr;
  }
};

struct CoulombSlipJoint {
  static constexpr const char* kLaw = "coulomb_slip";
  static constexpr bool kYields = true;
  double kn, ks, ft, ftr, c0, cr, mu0, mur;

  Values draw(Random& random) {
    const auto below = [&](double value) { return value * (chance(random, 0.3) ? 0.0 : uniform(random, 0.0, 1.0)); };
    const auto tangent = [](double degrees) { return std::tan(degrees * (M_PI / 180.0)); };
    kn = log_uniform(random, 1e6, 1e14), ks = log_uniform(random, 1e6, 1e14);
    ft = chance(random, 0.2) ? 0.0 : log_uniform(random, 1.0, 1e9), ftr = below(ft);
    c0 = chance(random, 0.2) ? 0.0 : log_uniform(random, 1.0, 1e9), cr = below(c0);
    const double phi0 = chance(random, 0.2) ? 0.0 : uniform(random, 0.0, 80.0), phir = below(phi0);
    mu0 = tangent(phi0), mur = tangent(phir);
    return {{{"normal_stiffness", kn},
             {"shear_stiffness", ks},
             {"tensile_strength", ft},
             {"tensile_strength_residual", ftr},
             {"cohesion", c0},
             {"cohesion_residual", cr},
             {"friction_angle", phi0},
             {"friction_angle_residual", phir}},
            {},
            {}};
  }
  void make_dry(Batch& b) const { b.in[6].assign(b.count, 1.0); }
  Excess strength(const Batch& b, std::size_t i) const {
    const double sigma = b.out[0][i], tau = std::hypot(b.out[1][i], b.out[2][i]), d_n = b.in[0][i];
    const bool failed = b.out[3][i] > 0.0;
    const double cohesion = !failed ? c0 : d_n > 0.0 ? 0.0 : cr;
    const double S = std::max(0.0, cohesion - sigma * (failed ? mur : mu0));
    const double scale = std::max({ft, c0, kn * std::abs(d_n), trial_shear(b, i, ks)});
    const double over = std::max({sigma - (failed ? ftr : ft), tau - S, std::min(0.0, kn * d_n) - sigma});
    return {over, 1e3 * std::numeric_limits<double>::epsilon() * scale, scale};
  }
  const char* beyond_bounds(const Batch& b, std::size_t i) const {
    return b.out[3][i] != 0.0 && b.out[3][i] != 1.0 ? "'failed' is neither 0 nor 1" : nullptr;
  }
};

struct FractureEnergyJoint {
  static constexpr const char* kLaw = "fracture_energy";
  static constexpr bool kYields = true;
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
  Values draw(Random& random);
  void make_dry(Batch& b) const { b.in[6].assign(b.count, end), b.in[7].assign(b.count, end); }
  Excess strength(const Batch& b, std::size_t i) const;
  const char* beyond_bounds(const Batch&, std::size_t) const { return nullptr; }
};

// Returns properties that are admissible by statement 6 of the law's page, with energies from 1.001 times their bound.
Values FractureEnergyJoint::draw(Random& random) {
  const auto tangent = [](double degrees) { return std::tan(degrees * (M_PI / 180.0)); };
  kn = log_uniform(random, 1e6, 1e14);
  ks = log_uniform(random, 1e6, 1e14);
  ft = chance(random, 0.2) ? 0.0 : log_uniform(random, 1.0, 1e9);
  c0 = chance(random, 0.2) ? 0.0 : log_uniform(random, 1.0, 1e9);
  cr = chance(random, 0.5) ? 0.0 : chance(random, 0.2) ? c0 : c0 * uniform(random, 0.0, 0.99);
  const double phi0 = chance(random, 0.2) ? 0.0 : uniform(random, 0.0, 80.0);
  const double phir = chance(random, 0.5) ? phi0 : phi0 * uniform(random, 0.0, 1.0);
  double psi0 = chance(random, 0.6) ? 0.0 : phi0 * uniform(random, 0.0, 0.5);
  mu0 = tangent(phi0), mur = tangent(phir);
  const bool crushes = chance(random, 0.6);
  fc = crushes ? log_uniform(random, 1.0, 1e9) : std::numeric_limits<double>::infinity();
  fcr = chance(random, 0.4) ? 0.0 : crushes ? fc * uniform(random, 0.0, 1.0) : 0.0;
  shared = chance(random, 0.5);
  const int choice = static_cast<int>(uniform(random, 0.0, 3.0));
  if (choice == 1) {
    shape = "exponential";
    A = 1.0, end = 746.0;
  } else if (choice == 2) {
    shape = "table";
    table = {0.0, 1.0, 0.3, 0.5, 0.9, 0.2, 2.0, 0.0};
    A = 0.3 * 0.75 + 0.6 * 0.35 + 1.1 * 0.1;
    m = 0.5 / 0.3, end = 2.0;
  }
  const auto energy = [&](double bound) {
    return bound * (chance(random, 0.3) ? 1.001 : log_uniform(random, 1.001, 1e6));
  };
  const double P = crushes ? fc : 0.0;
  G1 = energy(0.5 * ft * ft / kn);
  G2 = energy(m * std::max(c0, c0 - cr + P * (mu0 - mur)) * (c0 - cr) * A / ks);
  const double lowest_Gc = crushes ? m * (fc - fcr) * (fc - fcr) * A / kn : 0.0;
  Gc = energy(lowest_Gc);
  // Uplift that crushes the joint reduces ks by kn mu0 tan(psi0) q/(1 - q), where q is the bound of Gc over Gc.
  const double by_uplift = lowest_Gc > 0.0 ? kn * mu0 * tangent(psi0) * lowest_Gc / (Gc - lowest_Gc) : 0.0;
  if (by_uplift < 0.999 * ks) {
    G2 *= ks / (ks - by_uplift) * 1.000001;
  } else {
    psi0 = 0.0;
  }
  Values v;
  v.numbers = {{"normal_stiffness", kn},           {"shear_stiffness", ks},
               {"tensile_strength", ft},           {"cohesion", c0},
               {"cohesion_residual", cr},          {"friction_angle", phi0},
               {"friction_angle_residual", phir},  {"dilation_angle", psi0},
               {"compressive_strength", fc},       {"compressive_strength_residual", fcr},
               {"fracture_energy_tension", G1},    {"fracture_energy_shear", G2},
               {"fracture_energy_compression", Gc}};
  v.words = {{"softening", shape}, {"coupling", shared ? "shared" : "none"}};
  if (shape == "table") v.table = table;
  return v;
}

Excess FractureEnergyJoint::strength(const Batch& b, std::size_t i) const {
  const double sigma = b.out[0][i], tau = std::hypot(b.out[1][i], b.out[2][i]);
  const double xi_t = b.out[3][i], xi_s = b.out[4][i], w = b.out[5][i], v = b.out[6][i], d_n = b.in[0][i];
  const double scale = std::max({ft, c0, kn * (std::abs(d_n) + w + v), trial_shear(b, i, ks)});
  const double f_s = f(xi_s), mu = mu0 + (mur - mu0) * (1.0 - f_s);
  // Where the opening e is 0 to rounding, both closed (with residual cohesion) and open are admissible.
  const double e = d_n + b.in[8][i] - b.in[9][i];
  const bool open = e > 1e-14 * (std::abs(d_n) + b.in[8][i] + b.in[9][i]);
  const double cohesion = open ? c0 * f_s : cr + (c0 - cr) * f_s;
  const double drop = fc - fcr;
  const double F = std::isinf(fc) ? fc : fcr + drop * f(drop > 0.0 ? w * drop * A / Gc : 0.0);
  const double over = std::max({sigma - ft * f(xi_t), -F - sigma, tau - std::max(0.0, cohesion - sigma * mu)});
  return {over, 1e3 * std::numeric_limits<double>::epsilon() * scale, scale};
}

struct CyclicJoint {
  static constexpr const char* kLaw = "cyclic_joint";
  static constexpr bool kYields = true;
  quoin::cyclic::Joint joint;

  Values draw(Random& random) {
    joint = quoin::cyclic::random_joint(random, chance(random, 0.5) ? 1.001 : 1.3, 1e3);
    return quoin::cyclic::values_of(joint);
  }
  void make_dry(Batch& b) const { b.in[6].assign(b.count, static_cast<double>(joint.end())); }
  quoin::cyclic::History state(const Batch& b, std::size_t i) const {
    const auto out = [&](std::size_t k) { return static_cast<quoin::cyclic::Real>(b.out[k][i]); };
    return {out(3), out(4), out(5), out(6), out(7), {out(8), out(9)}, out(10), out(11), {out(1), out(2)}};
  }
  Excess strength(const Batch& b, std::size_t i) const {
    const double tau = std::hypot(b.out[1][i], b.out[2][i]);
    const auto at = quoin::cyclic::beyond_surfaces(joint, state(b, i), b.out[0][i], tau, b.in[0][i],
                                                   trial_shear(b, i, static_cast<double>(joint.ks)));
    return {at.over, 1e-11 * at.scale, at.scale};
  }
  const char* beyond_bounds(const Batch& b, std::size_t i) const {
    return quoin::cyclic::beyond_bounds(joint, state(b, i));
  }
};

double jump_size(Random& random) {
  const double sign = chance(random, 0.5) ? 1.0 : -1.0;
  return sign * log_uniform(random, 1e-15, 1.0);
}

template <class Joint>
int stress(double steps, std::uint64_t seed) {
  const quoin_law& law = quoin::test::load_law(Joint::kLaw);
  Random random(seed);
  constexpr std::size_t kPoints = 64;
  constexpr int kStepsPerMaterial = 200;
  const long materials = static_cast<long>(steps / (kPoints * kStepsPerMaterial)) + 1;
  long done = 0, failures = 0, bad_inputs = 0, yields = 0;
  double worst_strength = 0.0, least_dissipation = 0.0;

  const auto report = [&](const std::string& what, const Values& values, const Batch& b, std::size_t i) {
    if (++failures > 10) return;
    fmt::print("FAILED {}:", what);
    for (const auto& [id, value] : values.numbers) fmt::print(" --set {}={:.17g}", id, value);
    for (const auto& [id, word] : values.words) fmt::print(" --set {}={}", id, word);
    for (const double number : values.table) fmt::print(" {:.17g}", number);
    fmt::print("\n  in");
    for (const auto& column : b.in) fmt::print(" {:.17g}", column[i]);
    fmt::print("\n  out");
    for (const auto& column : b.out) fmt::print(" {:.17g}", column[i]);
    fmt::print("\n");
  };

  for (long material_index = 0; material_index < materials; ++material_index) {
    Joint joint;
    const Values values = joint.draw(random);
    std::optional<quoin::api::Material> material;
    try {
      material = quoin::test::make_material(law, values);
    } catch (const quoin::api::Error& error) {
      fmt::print("FAILED: admissible material refused: {}\n", error.what());
      ++failures;
      continue;
    }
    Batch b(law, kPoints);
    if (chance(random, 0.2)) joint.make_dry(b);
    const double reach = log_uniform(random, 1e-12, 1.0);
    for (int step = 0; step < kStepsPerMaterial; ++step) {
      std::vector<bool> bad(kPoints, false);
      for (std::size_t i = 0; i < kPoints; ++i) {
        // Mostly jumps of one size, so that states recur; sometimes of any size.
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
          if (!kept) report("bad input did not fail its point with the old state", values, b, i);
          b.in[0][i] = 0.0;
          continue;
        }
        bool finite = b.status[i] == QUOIN_POINT_OK;
        for (std::size_t k = 0; k < b.out.size(); ++k) finite = finite && std::isfinite(out(k));
        if (!finite) {
          report("not finite or not ok", values, b, i);
          continue;
        }
        yields += (b.flags[i] & QUOIN_FLAG_YIELDING) != 0;
        const Excess excess = joint.strength(b, i);
        worst_strength = std::max(worst_strength, excess.over / excess.scale);
        if (excess.over > excess.tolerance) report("outside the strength", values, b, i);
        if (const char* what = joint.beyond_bounds(b, i)) report(what, values, b, i);
        for (std::size_t k = 0; k < 4; ++k) {
          least_dissipation = std::min(least_dissipation, out(4 + b.states + k));
          if (out(4 + b.states + k) < 0.0) report("negative dissipation", values, b, i);
        }
        for (std::size_t k = 0; k < b.states; ++k) {
          const bool monotonic = (law.states[k]->flags & QUOIN_STATE_MONOTONIC) != 0;
          if (monotonic && out(3 + k) < b.in[6 + k][i])
            report(fmt::format("{} decreased", law.states[k]->id), values, b, i);
        }
      }
      b.advance();
    }
  }
  fmt::print(
      "{}: {} steps of {} materials, seed {}: {} yielding, {} bad inputs, worst excess over strength {:.2e} of scale, "
      "least dissipation {:.2e}, {} failures\n",
      Joint::kLaw, done, materials, seed, yields, bad_inputs, worst_strength, least_dissipation, failures);
  if ((Joint::kYields ? yields < done / 20 : yields > 0) || bad_inputs == 0) {
    fmt::print("FAILED: the run did not reach what it is for\n");
    return 1;
  }
  return failures == 0 ? 0 : 1;
}

// Enables one instruction set. Materials have the kernels of the best set that is enabled at their creation.
bool enable(const std::string& set) {
  std::string here;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    here += fmt::format(" {}", hwy::TargetName(target));
    if (set != hwy::TargetName(target)) continue;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return true;
  }
  fmt::print(stderr, "--set {}: here are{}\n", set, here);
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  double steps = 1e6;
  std::uint64_t seed = 20261121;
  std::string law = "fracture_energy", set;
  for (int k = 1; k + 1 < argc; k += 2) {
    if (std::strcmp(argv[k], "--law") == 0) law = argv[k + 1];
    if (std::strcmp(argv[k], "--set") == 0) set = argv[k + 1];
    if (std::strcmp(argv[k], "--steps") == 0) steps = std::atof(argv[k + 1]);
    if (std::strcmp(argv[k], "--seed") == 0) seed = std::strtoull(argv[k + 1], nullptr, 10);
  }
  if (!set.empty() && !enable(set)) return 2;
  if (law == ElasticJoint::kLaw) return stress<ElasticJoint>(steps, seed);
  if (law == CoulombSlipJoint::kLaw) return stress<CoulombSlipJoint>(steps, seed);
  if (law == FractureEnergyJoint::kLaw) return stress<FractureEnergyJoint>(steps, seed);
  if (law == CyclicJoint::kLaw) return stress<CyclicJoint>(steps, seed);
  fmt::print(stderr, "--law {}: elastic, coulomb_slip, fracture_energy or cyclic_joint\n", law);
  return 2;
}
