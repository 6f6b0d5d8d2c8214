// Damage by mode (ABI 1.1), the lost share of the strength, against closed forms of the three shapes and against the
// remaining strength of the points.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "law_case.h"

namespace quoin::test {
namespace {

// One step from the bonded state to each of the given jumps, with the outputs that the test sets in the batch.
class Step {
 public:
  Step(const Case& c, const std::vector<double>& opening, const std::vector<double>& sliding)
      : material_(c.material()), opening_(opening), sliding_(sliding) {
    const quoin_law& law = material_->api();
    const std::size_t n = opening.size();
    initial_.resize(law.state_count), scratch_.resize((law.state_count + 3) * n), zero_.resize(n);
    EXPECT_EQ(law.initial_state(material_->handle(), "bonded", initial_.data()), QUOIN_OK);
    for (std::size_t k = 0; k < law.state_count; ++k) {
      old_.push_back({&initial_[k], 0});
      fresh_.push_back({scratch_.data() + k * n, 1});
    }
    batch.struct_size = sizeof batch;
    batch.count = n;
    batch.normal_jump = {opening_.data(), 1};
    batch.slip_increment[0] = {sliding_.data(), 1};
    batch.slip_increment[1] = {zero_.data(), 1};
    batch.state_old = old_.data();
    batch.state_new = fresh_.data();
    for (std::size_t k = 0; k < 3; ++k) {
      batch.traction_old[k] = {zero_.data(), 1};
      batch.traction_new[k] = {scratch_.data() + (law.state_count + k) * n, 1};
    }
  }
  Step(const Step&) = delete;
  Step& operator=(const Step&) = delete;
  // Sets an output of the batch to a column.
  void ask(quoin_out* view, std::vector<double>* column) const {
    column->assign(opening_.size(), NAN);
    *view = {column->data(), 1};
  }
  void evaluate(quoin_batch* asked) const {
    EXPECT_EQ(material_->api().evaluate(material_->handle(), asked), QUOIN_OK);
  }
  quoin_batch batch{};

 private:
  std::shared_ptr<const Material> material_;
  std::vector<double> opening_, sliding_, initial_, scratch_, zero_;
  std::vector<quoin_in> old_;
  std::vector<quoin_out> fresh_;
};

struct Outcome {
  std::array<std::vector<double>, 3> traction, damage;
};

// Returns the result of one step; with one mode only it does not depend on the path.
Outcome reach(const Case& c, const std::vector<double>& opening, const std::vector<double>& sliding) {
  Step step(c, opening, sliding);
  Outcome outcome;
  for (std::size_t k = 0; k < 3; ++k) {
    step.ask(&step.batch.traction_new[k], &outcome.traction[k]);
    step.ask(&step.batch.damage[k], &outcome.damage[k]);
  }
  step.evaluate(&step.batch);
  return outcome;
}

Case shaped(reference::Shape shape) {
  Case c = mortar();
  c.p.shape = shape;
  if (shape == reference::Shape::table) c.p.table = {{0.0L, 1.0L}, {0.3L, 0.5L}, {1.0L, 0.0L}};
  return c;
}

// Returns 1 - f(xi), from the formulas of the softening functions.
double lost(reference::Shape shape, double xi) {
  if (shape == reference::Shape::linear) return std::min(1.0, xi);
  if (shape == reference::Shape::exponential) return -std::expm1(-xi);
  return xi < 0.3 ? xi / 0.6 : std::min(1.0, 0.5 + (xi - 0.3) / 1.4);
}

std::vector<double> points(double from, double to) {
  std::vector<double> values;
  for (int i = 0; i < 53; ++i)
    values.push_back(from + (to - from) * i / 52);  // 53 points: no multiple of a vector length
  return values;
}

// Tolerance for rounding of values of order 1, of the difference e - u0 and of the softening length.
constexpr double kRounding = 1e-10;

class Damage : public ::testing::TestWithParam<reference::Shape> {};

TEST_P(Damage, InTensionIsThatOfTheClosedForm) {
  for (const bool shared : {true, false}) {
    Case c = shaped(GetParam());
    c.p.shared = shared;
    const std::vector<double> opening = points(0.0, c.u0() + 1.5 * c.lt());
    const Outcome o = reach(c, opening, std::vector<double>(opening.size(), 0.0));
    for (std::size_t i = 0; i < opening.size(); ++i) {
      const double expected = lost(GetParam(), std::max(0.0, (opening[i] - c.u0()) / c.lt()));
      EXPECT_NEAR(o.damage[QUOIN_DAMAGE_TENSION][i], expected, kRounding) << opening[i];
      EXPECT_NEAR(o.damage[QUOIN_DAMAGE_COHESION][i], shared ? expected : 0.0, kRounding) << opening[i];
      EXPECT_EQ(o.damage[QUOIN_DAMAGE_CRUSHING][i], 0.0);
    }
  }
}

TEST_P(Damage, InShearIsTheCohesionThatIsNotCarried) {
  for (const double cr : {0.0, 0.05e6}) {
    Case c = shaped(GetParam());
    c.p.cr = cr;
    const double c0 = static_cast<double>(c.p.c0);
    // Every point slides: |tau| = c at zero pressure.
    const std::vector<double> sliding = points(1.001 * c0 / static_cast<double>(c.p.ks), 1.5 * c.su());
    const Outcome o = reach(c, std::vector<double>(sliding.size(), 0.0), sliding);
    for (std::size_t i = 0; i < sliding.size(); ++i) {
      EXPECT_NEAR(o.damage[QUOIN_DAMAGE_COHESION][i], (c0 - o.traction[1][i]) / (c0 - cr), kRounding) << sliding[i];
      const double slip = sliding[i] - o.traction[1][i] / static_cast<double>(c.p.ks);
      EXPECT_NEAR(o.damage[QUOIN_DAMAGE_COHESION][i], lost(GetParam(), slip / c.su()), kRounding) << sliding[i];
    }
    EXPECT_LT(o.damage[QUOIN_DAMAGE_COHESION].front(), 0.1);
    EXPECT_GT(o.damage[QUOIN_DAMAGE_COHESION].back(), 0.7);
  }
}

TEST_P(Damage, InCompressionIsTheStrengthThatIsNotCarried) {
  for (const double share : {0.0, 0.3}) {
    Case c = shaped(GetParam());
    c.p.fcr = share * c.p.fc;
    const double fc = static_cast<double>(c.p.fc), fcr = static_cast<double>(c.p.fcr);
    const std::vector<double> closing = points(-1.001 * fc / static_cast<double>(c.p.kn), -1.5 * c.wu());
    const Outcome o = reach(c, closing, std::vector<double>(closing.size(), 0.0));
    for (std::size_t i = 0; i < closing.size(); ++i) {
      EXPECT_NEAR(o.damage[QUOIN_DAMAGE_CRUSHING][i], (fc + o.traction[0][i]) / (fc - fcr), kRounding) << closing[i];
      EXPECT_EQ(o.damage[QUOIN_DAMAGE_TENSION][i], 0.0);
    }
    EXPECT_GT(o.damage[QUOIN_DAMAGE_CRUSHING].back(), 0.7);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Damage,
                         ::testing::Values(reference::Shape::linear, reference::Shape::exponential,
                                           reference::Shape::table));

// Outputs that are requested alone are bitwise identical to those that are requested together.
TEST(Outputs, AskedForAloneAreThoseAskedForTogether) {
  const Step step(mortar(), points(-2e-6, 60e-6), points(0.0, 200e-6));
  constexpr std::size_t kStored = 1, kDissipated = 4, kTangent = 9, kAll = kStored + kDissipated + kTangent;
  using Columns = std::array<std::vector<double>, kAll>;
  const auto ask = [&](std::size_t first, std::size_t count) {
    Columns columns;
    quoin_batch batch = step.batch;
    for (std::size_t k = first; k < first + count; ++k) {
      step.ask(k < kStored                 ? &batch.energy_stored
               : k < kStored + kDissipated ? &batch.dissipated[k - kStored]
                                           : &batch.tangent[k - kStored - kDissipated],
               &columns[k]);
    }
    step.evaluate(&batch);
    return columns;
  };
  const Columns all = ask(0, kAll);
  double lost = 0.0;
  for (const double energy : all[kStored + QUOIN_DISSIPATED_COHESION]) lost += energy;
  EXPECT_GT(lost, 0.0);
  std::vector<std::pair<std::size_t, std::size_t>> some{{kStored, kDissipated}, {kStored + kDissipated, kTangent}};
  for (std::size_t k = 0; k < kAll; ++k) some.emplace_back(k, 1);
  for (const auto& [first, count] : some) {
    const Columns alone = ask(first, count);
    for (std::size_t k = first; k < first + count; ++k) EXPECT_EQ(alone[k], all[k]) << k << " of " << count;
  }
}

}  // namespace
}  // namespace quoin::test
