// Instruction sets with fused multiply-add are bitwise identical. Others agree to 1e-12 times the amplification near
// snap-back. Batch size, partition, stride and aliasing change no bit.
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <set>

#include "hwy/highway.h"
#include "hwy/targets.h"
#include "population.h"

namespace {

using quoin::api::Material;
using quoin::test::Batch;
using quoin::test::laws;
using quoin::test::load_law;
using quoin::test::make_material;
using quoin::test::make_some_extreme;
using quoin::test::materials;
using quoin::test::randomise;
using quoin::test::Values;

// Limits the instruction set; a material has the kernels of the best set that is enabled at its creation.
struct OnTarget {
  explicit OnTarget(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  ~OnTarget() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

// Returns true if the law accepts these values, with this value of the property.
bool accepted(const quoin_law& law, Values values, const std::string& property, double value) {
  std::erase_if(values.numbers, [&](const auto& number) { return number.first == property; });
  values.numbers.emplace_back(property, value);
  try {
    make_material(law, values);
    return true;
  } catch (const quoin::api::Error&) {
    return false;
  }
}

// Computes 60 steps of every material with both sets and returns the largest difference of tractions over their scale.
double difference(const char* id, std::int64_t one, std::int64_t other, bool extreme, bool& same_bits) {
  const quoin_law& law = load_law(id);
  double worst = 0.0;
  same_bits = true;
  for (const Values& values : materials(id)) {
    std::vector<Material> pair;
    for (const std::int64_t target : {one, other}) {
      const OnTarget on(target);
      pair.push_back(make_material(law, values));
    }
    std::mt19937_64 random(7);
    Batch a(law, 61);
    for (int step = 0; step < 60; ++step) {
      randomise(a, random);
      if (extreme) make_some_extreme(a, random);
      Batch b = a;  // both from the same old state: the comparison is of one step, not of a diverging path
      a.evaluate(pair[0]);
      b.evaluate(pair[1]);
      for (std::size_t k = 0; k < a.out.size(); ++k) {
        same_bits = same_bits && std::memcmp(a.out[k].data(), b.out[k].data(), a.count * sizeof(double)) == 0;
      }
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t i = 0; i < a.count; ++i) {
          // 5 MPa: fc, the largest strength; Table 1 stays below an amplification of 1/(1 - |S'|/ks) = 1.03
          worst = std::max(worst, std::abs(a.out[k][i] - b.out[k][i]) / 5e6);
        }
      }
      EXPECT_EQ(a.flags, b.flags);
      a.advance();
    }
  }
  return worst;
}

TEST(InstructionSets, AgreeToRoundingWithoutFusedMultiplyAdd) {
  for (const char* id : {"fracture_energy", "cyclic_joint"}) {
    bool same_bits = false;
    const double worst = difference(id, HWY_SSE4, hwy::SupportedTargets() & (HWY_AVX3 | HWY_AVX2), false, same_bits);
    EXPECT_LT(worst, 1e-12) << id;
    RecordProperty("largest_difference", std::to_string(worst));
  }
}

TEST(InstructionSets, AgreeBitForBitWithFusedMultiplyAdd) {
  if ((hwy::SupportedTargets() & HWY_AVX3) == 0 || (hwy::SupportedTargets() & HWY_AVX2) == 0) {
    GTEST_SKIP() << "this machine has not both AVX2 and AVX-512";
  }
  for (const char* id : {"fracture_energy", "cyclic_joint"}) {
    bool same_bits = false;
    EXPECT_EQ(difference(id, HWY_AVX2, HWY_AVX3, true, same_bits), 0.0) << id;
    EXPECT_TRUE(same_bits) << id;
  }
}

TEST(Batches, PartitionAndRequestedOutputsChangeNoBit) {
  const quoin_law& law = load_law("fracture_energy");
  for (const Values& values : materials("fracture_energy")) {
    const Material material = make_material(law, values);
    std::mt19937_64 random(11);
    Batch whole(law, 203);
    // Closure and uplift of another material, which act also if this material has no crushing and dilation.
    for (std::size_t i = 0; i < whole.count; ++i) {
      whole.in[8][i] = 2e-6 * static_cast<double>(i % 3);
      whole.in[9][i] = 1e-6 * static_cast<double>(i % 2);
    }
    for (int step = 0; step < 20; ++step) {
      randomise(whole, random);
      make_some_extreme(whole, random);
      Batch parts = whole;
      whole.evaluate(material, true);
      std::vector<quoin_in> old_states;
      std::vector<quoin_out> new_states;
      // Sizes that hit whole vectors, tails and single points; tractions and states only.
      for (std::size_t first = 0, n = 1; first < parts.count; first += n, n = n % 37 + 5) {
        quoin_batch b = parts.view(first, std::min(n, parts.count - first), false, old_states, new_states);
        ASSERT_EQ(law.evaluate(material.handle(), &b), QUOIN_OK);
      }
      for (std::size_t k = 0; k < 3 + whole.states; ++k) {
        ASSERT_EQ(std::memcmp(whole.out[k].data(), parts.out[k].data(), whole.count * sizeof(double)), 0)
            << "column " << k;
      }
      whole.advance();
    }
  }
}

// Batches of one point have separate code, and so have vectors of elastic points.
TEST(Batches, PartsOfEverySizeGiveTheSameBitsOnEveryInstructionSet) {
  constexpr std::size_t kCount = 256;
  for (const char* id : laws) {
    const quoin_law& law = load_law(id);
    for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
      const OnTarget on(targets & -targets);
      for (const Values& values : materials(id)) {
        const Material material = make_material(law, values);
        std::mt19937_64 random(13);
        Batch whole(law, kCount);
        for (int step = 0; step < 8; ++step) {
          randomise(whole, random);
          make_some_extreme(whole, random);
          Batch parts = whole;
          const quoin_batch expected = whole.evaluate(material, true);
          for (const std::size_t size : {1, 2, 3, 8, 256}) {
            for (const bool extras : {false, true}) {
              for (auto& column : parts.out) column.assign(kCount, -7.0);
              std::uint64_t failed = 0, yielding = 0;
              for (std::size_t first = 0; first < kCount; first += size) {
                std::vector<quoin_in> old_states;
                std::vector<quoin_out> new_states;
                const std::size_t n = std::min(size, kCount - first);
                quoin_batch b = parts.view(first, n, extras, old_states, new_states);
                ASSERT_EQ(law.evaluate(material.handle(), &b), QUOIN_OK);
                failed += b.failed_count;
                yielding |= b.any_yielding;
              }
              ASSERT_EQ(failed, expected.failed_count);
              ASSERT_EQ(yielding, expected.any_yielding);
              const std::size_t wanted = extras ? whole.out.size() : 3 + whole.states;
              for (std::size_t k = 0; k < wanted; ++k) {
                ASSERT_EQ(std::memcmp(whole.out[k].data(), parts.out[k].data(), kCount * sizeof(double)), 0)
                    << id << ", " << hwy::TargetName(targets & -targets) << ", parts of " << size << ", column " << k;
              }
              if (extras) {
                ASSERT_EQ(parts.flags, whole.flags);
                ASSERT_EQ(parts.status, whole.status);
              }
            }
          }
          whole.advance();
        }
      }
    }
  }
}

// One point of an array of structures: in place, without diagnostics, with strides that have no meaning.
TEST(Batches, OnePointInPlaceWithoutDiagnostics) {
  for (const char* id : laws) {
    const quoin_law& law = load_law(id);
    for (const Values& values : materials(id)) {
      const Material material = make_material(law, values);
      std::mt19937_64 random(17);
      Batch apart(law, 60);
      for (int step = 0; step < 20; ++step) {
        randomise(apart, random);
        Batch in_place = apart;
        apart.evaluate(material, false);
        for (std::size_t i = 0; i < apart.count; ++i) {
          std::vector<quoin_in> old_states;
          std::vector<quoin_out> new_states;
          quoin_batch b = in_place.view(i, 1, false, old_states, new_states);
          for (std::size_t k = 0; k < 3; ++k) b.traction_new[k] = {in_place.in[3 + k].data() + i, 0};
          for (std::size_t k = 0; k < in_place.states; ++k) {
            new_states[k] = {in_place.in[6 + k].data() + i, 0};
            if (law.states[k]->role != QUOIN_ROLE_DIAGNOSTIC) continue;
            old_states[k] = {nullptr, 0};
            new_states[k] = {nullptr, 0};
          }
          ASSERT_EQ(law.evaluate(material.handle(), &b), QUOIN_OK);
        }
        for (std::size_t k = 0; k < 3 + apart.states; ++k) {
          if (k >= 3 && law.states[k - 3]->role == QUOIN_ROLE_DIAGNOSTIC) continue;
          ASSERT_EQ(apart.out[k], in_place.in[3 + k]) << id << ", column " << k;
        }
        apart.advance();
      }
    }
  }
}

// C6.11 applies also to batches of one point.
TEST(Batches, OnePointWithoutARequiredColumnIsRefused) {
  for (const char* id : laws) {
    const quoin_law& law = load_law(id);
    const Material material = make_material(law, materials(id)[0]);
    Batch points(law, 1);
    std::vector<quoin_in> old_states;
    std::vector<quoin_out> new_states;
    const auto expect_refused = [&](const std::string& what, const std::function<void(quoin_batch&)>& spoil) {
      quoin_batch b = points.view(0, 1, false, old_states, new_states);
      for (auto& column : points.out) column.assign(1, -7.0);
      spoil(b);
      EXPECT_EQ(law.evaluate(material.handle(), &b), QUOIN_ERROR_ARGUMENT) << id << ", " << what;
      for (const auto& column : points.out) EXPECT_EQ(column[0], -7.0) << id << ", " << what;
    };
    expect_refused("normal_jump", [](quoin_batch& b) { b.normal_jump.data = nullptr; });
    for (int k = 0; k < 2; ++k) {
      expect_refused("slip_increment", [k](quoin_batch& b) { b.slip_increment[k].data = nullptr; });
    }
    for (int k = 0; k < 3; ++k) {
      expect_refused("traction_old", [k](quoin_batch& b) { b.traction_old[k].data = nullptr; });
      expect_refused("traction_new", [k](quoin_batch& b) { b.traction_new[k].data = nullptr; });
    }
    const double kn = 1e10;
    const quoin_property_column twice[2] = {{"normal_stiffness", {&kn, 0}}, {"normal_stiffness", {&kn, 0}}};
    expect_refused("property column given twice", [&](quoin_batch& b) {
      b.property_column_count = 2;
      b.property_columns = twice;
    });
    for (std::size_t k = 0; k < points.states; ++k) {
      if (law.states[k]->role == QUOIN_ROLE_DIAGNOSTIC) continue;
      expect_refused("state_old", [&](quoin_batch&) { old_states[k].data = nullptr; });
      expect_refused("state_new", [&](quoin_batch&) { new_states[k].data = nullptr; });
    }
  }
}

// Two points of another law at rest, with one state, and what a migration of them writes.
struct AtRest {
  explicit AtRest(const quoin_law& law) : states(law.state_count, {-7.0, -7.0}) {
    for (auto& state : states) columns.push_back({state.data(), 1});
    m.struct_size = sizeof m;
    m.count = 2;
    m.from_law = "another_law";
    m.from_schema = m.from_state_count = 1;
    m.from_state_ids = &old_id;
    m.from_states = &old_state;
    m.normal_jump = {zeros, 1};
    for (quoin_in& column : m.traction) column = {zeros, 1};
    m.normal_shift = {shift, 1};
    m.state_new = columns.data();
    m.energy_jump = {jump, 1};
    m.status = {status, 1};
  }
  AtRest(const AtRest&) = delete;
  const double zeros[2] = {0.0, 0.0};
  double shift[2] = {-7.0, -7.0}, jump[2] = {-7.0, -7.0};
  std::uint32_t status[2] = {7, 7};
  std::vector<std::array<double, 2>> states;
  std::vector<quoin_out> columns;
  const char* old_id = "of_another_law";
  quoin_in old_state{zeros, 1};
  quoin_migration m{};
};

// Of a migration only energies and status may be null (law.h). No output of several points has stride 0, and 0 points
// need no data (batch.h). States of another schema are refused (C5.4).
TEST(Migrations, OfAnIncompleteRequestAreRefused) {
  for (const char* id : laws) {
    const quoin_law& law = load_law(id);
    const Material material = make_material(law, materials(id)[0]);
    const auto expect = [&](quoin_status status, const std::string& what, const std::function<void(AtRest&)>& spoil) {
      AtRest points(law);
      spoil(points);
      EXPECT_EQ(law.migrate_state(material.handle(), &points.m, nullptr), status) << id << ", " << what;
      const double written = status == QUOIN_OK && points.m.count > 0 ? 0.0 : -7.0;
      for (const double shift : points.shift) EXPECT_EQ(shift, written) << id << ", " << what;
    };
    expect(QUOIN_OK, "whole", [](AtRest&) {});
    const auto expect_refused = [&](const std::string& what, const std::function<void(AtRest&)>& spoil) {
      expect(QUOIN_ERROR_ARGUMENT, what, spoil);
    };
    expect_refused("normal_jump", [](AtRest& p) { p.m.normal_jump.data = nullptr; });
    expect_refused("normal_shift", [](AtRest& p) { p.m.normal_shift.data = nullptr; });
    expect_refused("from_law", [](AtRest& p) { p.m.from_law = nullptr; });
    expect_refused("from_states", [](AtRest& p) { p.m.from_states = nullptr; });
    expect_refused("from_state_ids", [](AtRest& p) { p.m.from_state_ids = nullptr; });
    expect_refused("from_state_ids[0]", [](AtRest& p) { p.old_id = nullptr; });
    for (int k = 0; k < 3; ++k) expect_refused("traction", [k](AtRest& p) { p.m.traction[k].data = nullptr; });
    expect_refused("struct_size", [](AtRest& p) { p.m.struct_size = sizeof p.m - 1; });
    expect_refused("stride of normal_shift", [](AtRest& p) { p.m.normal_shift.stride = 0; });
    expect_refused("stride of energy_jump", [](AtRest& p) { p.m.energy_jump.stride = 0; });
    expect_refused("stride of status", [](AtRest& p) { p.m.status.stride = 0; });
    if (law.state_count > 0) {
      expect_refused("state_new", [](AtRest& p) { p.m.state_new = nullptr; });
      expect_refused("state_new[0]", [](AtRest& p) { p.columns[0].data = nullptr; });
      expect_refused("stride of state_new[0]", [](AtRest& p) { p.columns[0].stride = 0; });
    }
    expect(QUOIN_ERROR_VERSION, "own law, another schema", [&](AtRest& p) { p.m.from_law = id; });
    expect(QUOIN_OK, "own law, own schema", [&](AtRest& p) { p.m.from_law = id, p.m.from_schema = law.state_schema; });
    expect(QUOIN_OK, "no points", [](AtRest& p) {
      p.m.count = 0;
      p.m.normal_jump = p.m.traction[0] = {};
      p.m.normal_shift = {};
      p.m.state_new = nullptr;
    });
  }
}

// A value that is not finite fails its point alone, as in a batch (C7.1, C7.2).
TEST(Migrations, OfAValueThatIsNotFiniteFailItsPoint) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const char* id : laws) {
    const quoin_law& law = load_law(id);
    const Material material = make_material(law, materials(id)[0]);
    for (const double wrong : {nan, inf, -inf}) {
      const double column[2] = {wrong, 0.0};
      std::vector<std::pair<std::string, std::function<void(AtRest&)>>> spoils = {
          {"normal_jump", [&](AtRest& p) { p.m.normal_jump.data = column; }}, {"energy_stored", [&](AtRest& p) {
                                                                                 p.m.energy_stored = {column, 1};
                                                                               }}};
      for (int k = 0; k < 3; ++k) spoils.emplace_back("traction", [&, k](AtRest& p) { p.m.traction[k].data = column; });
      for (const char* state : {"w", "v", "xi", "xi_t", "failed", "lambda", "slip"})
        spoils.emplace_back(state, [&, state](AtRest& p) { p.old_id = state, p.old_state.data = column; });
      for (const auto& [what, spoil] : spoils) {
        AtRest points(law);
        spoil(points);
        EXPECT_EQ(law.migrate_state(material.handle(), &points.m, nullptr), QUOIN_ERROR_UNSUPPORTED) << id << what;
        EXPECT_EQ(points.m.failed_count, 1u) << id << ", " << what;
        EXPECT_EQ(points.status[0], QUOIN_POINT_FAILED) << id << ", " << what << " = " << wrong;
        EXPECT_EQ(points.status[1], QUOIN_POINT_OK) << id << ", " << what;
        EXPECT_EQ(points.jump[0], 0.0) << id << ", " << what;
        EXPECT_TRUE(std::isfinite(points.shift[0])) << id << ", " << what;
      }
    }
  }
}

// CLAMPED says that damage is lost (law.h), whether or not the traction is that of an undamaged joint. A closed point
// at rest, one state of damage: kept by the laws that have it, or that of the same mode.
TEST(Migrations, ThatLoseDamageSaySo) {
  const std::map<std::string, std::set<std::string>> kept_by = {
      {"failed", {"coulomb_slip", "fracture_energy", "cyclic_joint"}},
      {"xi", {"fracture_energy", "cyclic_joint"}},
      {"xi_t", {"fracture_energy", "cyclic_joint"}},
      {"xi_s", {"fracture_energy", "cyclic_joint"}},
      {"w", {"fracture_energy", "cyclic_joint"}},
      {"lambda", {"bond_slip"}}};
  const double half[2] = {0.5, 0.0};
  for (const char* id : laws) {
    const quoin_law& law = load_law(id);
    const Material material = make_material(law, materials(id)[0]);
    for (const auto& [state, keepers] : kept_by) {
      AtRest points(law);
      points.old_id = state.c_str(), points.old_state.data = half;
      EXPECT_EQ(law.migrate_state(material.handle(), &points.m, nullptr), QUOIN_OK) << id << ", " << state;
      EXPECT_EQ(points.status[0], keepers.contains(id) ? QUOIN_POINT_OK : QUOIN_POINT_CLAMPED) << id << ", " << state;
      EXPECT_EQ(points.status[1], QUOIN_POINT_OK) << id << ", " << state;
    }
  }
}

// contact_models/bond_slip/LAW.md, statement 5: sigma <= f_p on any path, with slip or without. Tension of an elastic
// joint just inside and outside of it; 1e-6 is far beyond the rounding that the law allows, 1e-9.
TEST(Migrations, ToABondBeyondItsPeelStrengthAreRefused) {
  const quoin_law& law = load_law("bond_slip");
  const Material material = make_material(law, materials("bond_slip")[2]);
  const double kn = material.number("normal_stiffness"), peel = material.number("peel_strength");
  for (const double tau : {0.0, 1.0}) {
    const double sigma[2] = {peel * (1.0 + 1e-6), peel * (1.0 - 1e-6)}, taus[2] = {tau, tau};
    const double opening[2] = {sigma[0] / kn, sigma[1] / kn};
    AtRest points(law);
    points.m.normal_jump.data = opening, points.m.traction[0].data = sigma, points.m.traction[1].data = taus;
    EXPECT_EQ(law.migrate_state(material.handle(), &points.m, nullptr), QUOIN_ERROR_UNSUPPORTED) << tau;
    EXPECT_EQ(points.status[0], QUOIN_POINT_FAILED) << tau;
    EXPECT_EQ(points.status[1], QUOIN_POINT_OK) << tau;
  }
}

// Elastic points, which a whole vector computes by the short path: this path, too, must detect an invalid value.
TEST(Batches, AnOldValueThatIsNotFiniteFailsItsPointAmongElasticOnes) {
  const quoin_law& law = load_law("fracture_energy");
  for (const Values& values : materials("fracture_energy")) {
    const Material material = make_material(law, values);
    const bool shared = values.words[1].second == "shared";
    for (const std::size_t column : {4, 5, 6, 7, 8, 9}) {  // tau_s, tau_t, xi_t, xi_s, w, v
      if (shared && column == 7) continue;                 // only xi_t is read
      for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
        Batch b(law, 32);
        b.in[0].assign(b.count, -1e-6);
        b.in[1].assign(b.count, 1e-8);
        b.in[column][5] = bad;
        EXPECT_EQ(b.evaluate(material, false).failed_count, 1u) << "column " << column << " = " << bad;
        for (std::size_t i = 0; i < b.count; ++i) {
          EXPECT_EQ(b.out[0][i], i == 5 ? 0.0 : 82e9 * -1e-6);
          EXPECT_EQ(std::memcmp(&b.out[column - 3][5], &bad, sizeof bad), 0);
        }
      }
    }
  }
}

// The law reads tau, xi, q, l, w and v_m of an elastic joint; without uplift it does not read the seat.
TEST(Batches, AnOldValueOfCyclicJointThatIsNotFiniteFailsItsPointAmongElasticOnes) {
  const quoin_law& law = load_law("cyclic_joint");
  for (const Values& values : materials("cyclic_joint")) {
    const Material material = make_material(law, values);
    std::vector<double> bonded(law.state_count);
    law.initial_state(material.handle(), "bonded", bonded.data());
    for (const std::size_t column : {4, 5, 6, 8, 9, 10, 14}) {
      for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
        Batch b(law, 32);
        for (std::size_t k = 0; k < bonded.size(); ++k) b.in[6 + k].assign(b.count, bonded[k]);
        b.in[0].assign(b.count, -1e-6);
        b.in[1].assign(b.count, 1e-8);
        b.in[column][5] = bad;
        EXPECT_EQ(b.evaluate(material, false).failed_count, 1u) << "column " << column << " = " << bad;
        for (std::size_t i = 0; i < b.count; ++i) EXPECT_EQ(b.out[0][i], i == 5 ? 0.0 : 82e9 * -1e-6);
        EXPECT_EQ(std::memcmp(&b.out[column - 3][5], &bad, sizeof bad), 0);
      }
    }
  }
}

// A joint that is crushed out has traction +0 at e = 0, also with a neighbour that slips.
TEST(Batches, SignOfZeroDoesNotDependOnNeighbours) {
  const quoin_law& law = load_law("fracture_energy");
  const Material material = make_material(law, materials("fracture_energy")[1]);
  for (const double slip_of_neighbour : {0.0, 1e-4}) {
    Batch b(law, 16);
    b.in[8].assign(b.count, 0.25);   // w, far beyond wu
    b.in[0].assign(b.count, -0.25);  // e = 0
    b.in[1][3] = slip_of_neighbour;
    b.evaluate(material, false);
    for (const double sigma : b.out[0]) EXPECT_TRUE(sigma == 0.0 && !std::signbit(sigma));
  }
}

TEST(Batches, PropertyColumnsEqualMaterials) {
  const quoin_law& law = load_law("fracture_energy");
  const std::vector<Values> all = materials("fracture_energy");
  const Material uniform = make_material(law, all[1]);
  std::mt19937_64 random(3);
  Batch a(law, 40);
  std::vector<double> ft(40, 0.2e6), phi(40, 35.0), gc(40, 8000.0);
  const quoin_property_column columns[] = {{"tensile_strength", {ft.data(), 1}},
                                           {"friction_angle", {phi.data(), 1}},
                                           {"fracture_energy_compression", {gc.data(), 1}}};
  for (int step = 0; step < 20; ++step) {
    randomise(a, random);
    Batch b = a;
    a.evaluate(uniform);
    std::vector<quoin_in> old_states;
    std::vector<quoin_out> new_states;
    quoin_batch view = b.view(0, b.count, true, old_states, new_states);
    view.property_column_count = 3;
    view.property_columns = columns;
    ASSERT_EQ(law.evaluate(uniform.handle(), &view), QUOIN_OK);
    for (std::size_t k = 0; k < a.out.size(); ++k) ASSERT_EQ(a.out[k], b.out[k]) << "column " << k;
    a.advance();
  }
  // A point whose per-point properties would snap back fails; its neighbours do not.
  ft[3] = 5e6;
  std::vector<quoin_in> old_states;
  std::vector<quoin_out> new_states;
  quoin_batch view = a.view(0, a.count, true, old_states, new_states);
  view.property_column_count = 3;
  view.property_columns = columns;
  ASSERT_EQ(law.evaluate(uniform.handle(), &view), QUOIN_OK);
  EXPECT_EQ(view.failed_count, 1u);
  EXPECT_EQ(a.status[3], QUOIN_POINT_FAILED);
}

// Contract C4.5: null arguments are refused.
TEST(Batches, AMaterialOfNoLawIsRefused) {
  for (const char* name : {"elastic", "coulomb_slip", "fracture_energy", "cyclic_joint", "bond_slip"}) {
    const quoin_law& law = load_law(name);
    quoin_material* material = nullptr;
    EXPECT_EQ(law.create_material(nullptr, 0, nullptr, &material, nullptr), QUOIN_ERROR_ARGUMENT) << name;
    EXPECT_EQ(material, nullptr);
  }
}

// A residual friction that is given is not changed by a column: points whose friction is less are refused, as a
// material is. It was limited to the column, without a word. A residual by default is limited.
TEST(Batches, AGivenResidualFrictionIsNoLessBesideAColumn) {
  for (const char* name : {"fracture_energy", "cyclic_joint", "coulomb_slip"}) {
    const quoin_law& law = load_law(name);
    for (const bool given : {true, false}) {
      Values values{{{"normal_stiffness", 80e9}, {"shear_stiffness", 36e9}, {"friction_angle", 35.0}}, {}, {}};
      if (given) values.numbers.emplace_back("friction_angle_residual", 30.0);
      const Material material = make_material(law, values);
      std::vector<double> phi{40.0, 35.0, 30.0, 25.0};
      const quoin_property_column column{"friction_angle", {phi.data(), 1}};
      Batch b(law, phi.size());
      b.in[0].assign(b.count, -1e-5), b.in[1].assign(b.count, 1e-3);
      std::vector<quoin_in> old_states;
      std::vector<quoin_out> new_states;
      quoin_batch view = b.view(0, b.count, true, old_states, new_states);
      view.property_column_count = 1, view.property_columns = &column;
      ASSERT_EQ(law.evaluate(material.handle(), &view), QUOIN_OK);
      EXPECT_EQ(view.failed_count, given ? 1u : 0u) << name;
      EXPECT_EQ(b.status[3] == QUOIN_POINT_FAILED, given) << name;
    }
  }
}

// Without optional outputs tractions and states are computed by shorter code, also with property columns. They are
// bitwise identical, and the same points fail. There is separate code for columns of strengths and energies, of
// stiffnesses, and of angles. The energies of one point in eight are refused, since they would snap back. The first
// steps are so small that all other points are elastic.
TEST(Batches, PropertyColumnsGiveTheSameBitsWhateverIsAskedFor) {
  const quoin_law& law = load_law("fracture_energy");
  const char* const ids[] = {"tensile_strength",      "cohesion",         "fracture_energy_tension",
                             "fracture_energy_shear", "normal_stiffness", "friction_angle"};
  for (const Values& values : materials("fracture_energy")) {
    const Material material = make_material(law, values);
    for (std::uint64_t draw = 0; draw < 15; ++draw) {
      const std::size_t used = 4 + draw % 3;
      std::mt19937_64 random(5 + draw);
      std::uniform_real_distribution<double> factor(0.8, 1.25), order(-7.0, 2.0);
      Batch full(law, 40);
      std::vector<std::vector<double>> scattered;
      std::vector<quoin_property_column> columns;
      for (std::size_t c = 0; c < used; ++c) {
        double usual = 0.0;
        ASSERT_EQ(law.material_number(material.handle(), ids[c], &usual), QUOIN_OK);
        std::vector<double>& column = scattered.emplace_back(full.count, usual);
        const bool energy = c == 2 || c == 3;
        for (std::size_t i = 0; i < column.size(); ++i)
          column[i] *= energy && i % 8 == 5 ? std::exp(order(random)) : factor(random);
      }
      scattered[0][3] = 0.0, scattered[1][21] = 0.0;
      scattered[2][7] = -1.0;  // refused
      for (std::size_t c = 0; c < used; ++c) columns.push_back({ids[c], {scattered[c].data(), 1}});
      for (int step = 0; step < 20; ++step) {
        randomise(full, random);
        for (std::size_t k = 0; k < 3 && step < 10; ++k)
          for (double& jump : full.in[k]) jump *= 1e-3;
        Batch lean = full;
        std::uint64_t failed[2];
        for (const bool extras : {false, true}) {
          std::vector<quoin_in> old_states;
          std::vector<quoin_out> new_states;
          Batch& batch = extras ? full : lean;
          quoin_batch view = batch.view(0, batch.count, extras, old_states, new_states);
          view.property_column_count = columns.size();
          view.property_columns = columns.data();
          ASSERT_EQ(law.evaluate(material.handle(), &view), QUOIN_OK);
          failed[extras] = view.failed_count;
        }
        ASSERT_GE(failed[0], 1u);
        ASSERT_EQ(failed[0], failed[1]);
        for (std::size_t k = 0; k < 3 + full.states; ++k) ASSERT_EQ(lean.out[k], full.out[k]) << "column " << k;
        full.advance();
      }
    }
  }
}

// A value in a column that create_material refuses fails only its point, also if the property's mode is switched off:
// C6.9.
TEST(Batches, PropertyColumnsFailWhatMaterialsRefuse) {
  for (const char* id : laws) {
    const quoin_law& law = load_law(id);
    std::vector<Values> all = materials(id);
    all.push_back(materials("elastic")[0]);  // only stiffnesses: every other mode is switched off
    for (const Values& values : all) {
      for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
        const OnTarget on(targets & -targets);
        const Material material = make_material(law, values);
        for (std::uint64_t p = 0; p < law.property_count; ++p) {
          const quoin_property_info& property = *law.properties[p];
          if ((property.flags & QUOIN_PROPERTY_PER_POINT) == 0) continue;
          for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL, -1.0}) {
            if (accepted(law, values, property.id, bad)) continue;  // an infinite strength in compression
            double good = 0.0;
            ASSERT_EQ(law.material_number(material.handle(), property.id, &good), QUOIN_OK);
            Batch b(law, 24);
            std::vector<double> column(b.count, good);
            column[5] = bad;
            b.in[0].assign(b.count, -1e-7);
            b.in[3].assign(b.count, -123.0);
            std::vector<quoin_in> old_states;
            std::vector<quoin_out> new_states;
            quoin_batch view = b.view(0, b.count, true, old_states, new_states);
            const quoin_property_column columns[] = {{property.id, {column.data(), 1}}};
            view.property_columns = columns;
            view.property_column_count = 1;
            ASSERT_EQ(law.evaluate(material.handle(), &view), QUOIN_OK);
            const std::string what = std::string(id) + ", " + property.id + " = " + std::to_string(bad);
            EXPECT_EQ(view.failed_count, 1u) << what;
            EXPECT_EQ(b.status[5], QUOIN_POINT_FAILED) << what;
            EXPECT_EQ(b.out[0][5], -123.0) << what;
            EXPECT_EQ(b.status[4], QUOIN_POINT_OK) << what;
          }
        }
      }
    }
  }
}

}  // namespace
