// bond_slip against its the law's page: statements 1 to 6, and debonding of a long strip.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>

#include "base/error.h"
#include "law/material_point.h"

namespace quoin {
namespace {

constexpr double kKn = 5e10, kKs = 2e10, kTau = 1.2e6, kPeel = 0.4e6, kGf = 180.0;
constexpr double kS0 = kTau / kKs, kN0 = kPeel / kKn, kRatio = 2.0 * kGf / (kTau * kS0);

PropertySetting number(const char* id, double value) {
  PropertySetting setting;
  setting.id = id, setting.numbers = {value};
  return setting;
}

std::shared_ptr<const Material> bond(double fracture_energy = kGf) {
  return std::make_shared<Material>(
      Law::find("bond_slip"),
      std::vector<PropertySetting>{number("normal_stiffness", kKn), number("shear_stiffness", kKs),
                                   number("bond_strength", kTau), number("peel_strength", kPeel),
                                   number("fracture_energy", fracture_energy)});
}

TEST(BondSlip, PureSlipIsBilinearAndDissipatesItsFractureEnergy) {
  for (const int steps : {7, 100, 3000}) {
    MaterialPoint point(bond(), "bonded");
    for (int i = 1; i <= steps; ++i) {
      const double s = 1.2 * kRatio * kS0 * i / steps, lambda = s / kS0;
      const PointResult& r = point.move_to(0.0, 0.6 * s, -0.8 * s);
      const double expected = lambda <= 1.0 ? kKs * s : std::max(0.0, kTau * (kRatio - lambda) / (kRatio - 1.0));
      EXPECT_NEAR(r.traction[1], 0.6 * expected, 1e-9 * kTau) << lambda;
      EXPECT_NEAR(r.traction[2], -0.8 * expected, 1e-9 * kTau) << lambda;
    }
    EXPECT_NEAR(point.now().dissipated[QUOIN_DISSIPATED_COHESION], kGf, 1e-9 * kGf) << steps;
    EXPECT_EQ(point.now().dissipated[QUOIN_DISSIPATED_TENSION], 0.0);
  }
}

TEST(BondSlip, PurePeel) {
  MaterialPoint point(bond(), "bonded");
  EXPECT_NEAR(point.move_to(kN0, 0.0, 0.0).traction[0], kPeel, 1e-9 * kPeel);
  for (int i = 1; i <= 50; ++i) point.move_to(kN0 * (1.0 + 0.022 * i * (kRatio - 1.0)), 0.0, 0.0);
  const double expected = 0.5 * kPeel * kN0 * kRatio;
  EXPECT_NEAR(point.now().dissipated[QUOIN_DISSIPATED_TENSION], expected, 1e-9 * expected);
  // Debonded: the joint carries pressure only.
  EXPECT_EQ(point.move_to(kN0, kS0, 0.0).traction[1], 0.0);
  EXPECT_NEAR(point.move_to(-1e-6, kS0, 0.0).traction[0], -1e-6 * kKn, 1e-6);
}

// Random paths: tractions are within the strength, damage never decreases, and stored plus dissipated energy is the
// work, to first order in the steps.
TEST(BondSlip, StaysWithinStrengthAndBooksItsEnergy) {
  std::mt19937_64 random(20261123);
  std::uniform_real_distribution<double> way(-1.0, 1.0);
  for (int path = 0; path < 40; ++path) {
    MaterialPoint point(bond(), "bonded");
    std::array<double, 3> from{};
    for (int corner = 0; corner < 12; ++corner) {
      const std::array<double, 3> to{0.7 * kRatio * kN0 * way(random), 0.5 * kRatio * kS0 * way(random),
                                     0.5 * kRatio * kS0 * way(random)};
      constexpr int kSteps = 4000;
      for (int i = 1; i <= kSteps; ++i) {
        std::array<double, 3> x{};
        for (std::size_t c = 0; c < 3; ++c) x[c] = from[c] + (to[c] - from[c]) * i / kSteps;
        const PointResult& r = point.move_to(x[0], x[1], x[2]);
        for (const double e : r.dissipated_now) EXPECT_GE(e, 0.0);
        EXPECT_LE(std::hypot(r.traction[1], r.traction[2]), kTau * (1.0 + 1e-9));
        EXPECT_LE(r.traction[0], kPeel * (1.0 + 1e-9));
      }
      from = to;
    }
    const PointResult& r = point.now();
    const double booked = r.energy_stored + std::accumulate(r.dissipated.begin(), r.dissipated.end(), 0.0);
    EXPECT_NEAR(booked, r.work, 2e-3 * kGf) << path;
  }
}

// Integration along the strip from the free end, where the strain is 0. The equation of the strip is of second order,
// so each slip of the free end has one solution.
TEST(BondSlip, LongStripCarriesTheRootOfItsFractureEnergy) {
  const double stiffness = 240e9 * 0.17e-3;  // E t, N/m
  const double w1 = std::sqrt(kKs / stiffness), w2 = w1 / std::sqrt(kRatio - 1.0);
  const double expected = std::sqrt(2.0 * stiffness * kGf);
  const auto material = bond();
  const auto shear = [&](double slip) { return MaterialPoint(material, "bonded").move_to(0.0, slip, 0.0).traction[1]; };
  const auto largest_force = [&](double length) {
    constexpr int kPieces = 150, kStates = 300;
    const double piece = length / kPieces;
    double most = 0.0;
    for (int k = 1; k <= kStates; ++k) {
      double u = 1.3 * kRatio * kS0 * std::pow(static_cast<double>(k) / kStates, 8.0), strain = 0.0;
      for (int i = 0; i < kPieces; ++i) {
        const double middle = u + 0.5 * piece * strain;
        strain += piece * shear(middle) / stiffness;
        u = middle + 0.5 * piece * strain;
      }
      most = std::max(most, stiffness * strain);
    }
    return most;
  };
  const double effective = M_PI / (2.0 * w2) + 2.0 / w1;
  const double of_long = largest_force(3.0 * effective) / expected, of_effective = largest_force(effective) / expected;
  std::printf("  | strip over b sqrt(2 E t G_f): long %.4f, of effective length %.4f\n", of_long, of_effective);
  EXPECT_NEAR(of_long, 1.0, 0.02);  // pieces of 0.05/w1: the error is of the order of their square
  EXPECT_GT(of_effective, 0.97);
  EXPECT_LT(largest_force(0.4 * effective) / expected, 0.85);
}

TEST(BondSlip, RefusesWhatHasNoSoftening) {
  EXPECT_THROW(bond(0.5 * kTau * kTau / kKs), Error);
  EXPECT_THROW(bond(-1.0), Error);
}

}  // namespace
}  // namespace quoin
