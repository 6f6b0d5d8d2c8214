// Order of convergence on mixed cyclic paths, and the reason why some points do not converge at first:
// contact_models/cyclic_joint/LAW.md, "Convergence". Joints have the starting values of that page.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "joints.h"
#include "tests/mixed_paths.h"

namespace {

using namespace quoin::cyclic;
using namespace quoin::test::mixed;
using Path = Jump (*)(std::size_t point, double x);

constexpr int kChecks = 64;  // number of positions along each path at which errors are computed

// Returns Table 1 of the paper with the starting values of the law's page, as in
// benchmarks/laws/law_error_against_cost.cpp.
Joint joint() {
  Joint j = mortar();
  j.fcr = 0;
  return j;
}

struct Traction {
  double n, s, t;
};
struct Course {
  std::vector<Traction> tractions;  // kPoints tractions for each check
  std::vector<double> needs;        // for each point: number of increments needed to keep the contact that this run has
};

// Computes all points along their paths. While the faces slide up their seat and the joint opens, the closure of the
// contact has a minimum. An increment that opens by more than this minimum loses contact at the old uplift.
Course drive(const quoin_law& law, Path path, int increments) {
  LawPoints points(law, joint(), kPoints, false);
  auto& b = points.batch;
  Course course{{}, std::vector<double>(kPoints, 0.0)};
  struct Before {
    Jump jump;
    double closure, closure_before, uplift;
  };
  std::vector<Before> before(kPoints);
  for (std::size_t i = 0; i < kPoints; ++i) before[i] = {path(i, 0.0), 0.0, 0.0, 0.0};
  for (int step = 1; step <= increments; ++step) {
    std::vector<Jump> to(kPoints);
    for (std::size_t i = 0; i < kPoints; ++i) {
      to[i] = path(i, static_cast<double>(step) / increments);
      b.in[0][i] = to[i].n, b.in[1][i] = to[i].s - before[i].jump.s, b.in[2][i] = to[i].t - before[i].jump.t;
    }
    b.evaluate(points.material, false);
    b.advance();
    for (std::size_t i = 0; i < kPoints; ++i) {
      const History s = points.history(i);
      const double v = static_cast<double>(uplift(s)), opens = to[i].n - before[i].jump.n;
      const double closure = static_cast<double>(s.q - s.w) + v - to[i].n;
      Before& was = before[i];
      const bool least = was.closure > 0.0 && was.closure <= was.closure_before && was.closure < closure;
      if (least && opens > 0.0 && v > was.uplift) {
        course.needs[i] = std::max(course.needs[i], opens * increments / was.closure);
      }
      was = {to[i], closure, was.closure, v};
      if (static_cast<long>(step) * kChecks % increments == 0) {
        course.tractions.push_back({b.in[3][i], b.in[4][i], b.in[5][i]});
      }
    }
  }
  return course;
}

// Returns the largest error along the path of every point, relative to normal and shear strength.
std::vector<double> errors(const Course& course, const Course& exact, double normal, double shear) {
  std::vector<double> largest(kPoints, 0.0);
  for (std::size_t k = 0; k < exact.tractions.size(); ++k) {
    const Traction &a = course.tractions[k], &b = exact.tractions[k];
    const double error = std::max(std::abs(a.n - b.n) / normal, std::hypot(a.s - b.s, a.t - b.t) / shear);
    largest[k % kPoints] = std::max(largest[k % kPoints], error);
  }
  return largest;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// With eight times the increments the error of a point of first order falls by eight. Only points that nearly lose
// contact may not converge. Their number decreases with the increment, and so does the mean error of all points.
void converges(Path path, double normal, double shear, double small) {
  const quoin_law& law = quoin::test::load_law("cyclic_joint");
  constexpr int kFew = 256, kMany = 8 * kFew, kFinest = 8 * kMany;
  const Course exact = drive(law, path, kFinest);
  const std::vector<double> few = errors(drive(law, path, kFew), exact, normal, shear);
  const std::vector<double> many = errors(drive(law, path, kMany), exact, normal, shear);
  std::vector<double> orders, contact_kept;
  int graze_few = 0, graze_many = 0, stand = 0;
  for (std::size_t i = 0; i < kPoints; ++i) {
    orders.push_back(std::log(few[i] / many[i]) / std::log(8.0));
    graze_few += exact.needs[i] > kFew;
    const bool grazes = exact.needs[i] > kMany, stands = many[i] > std::max(few[i] / 3.0, small);
    graze_many += grazes, stand += stands;
    if (!grazes) contact_kept.push_back(many[i]);
    EXPECT_TRUE(grazes || !stands) << "point " << i << ": " << few[i] << " in " << kFew << ", " << many[i] << " in "
                                   << kMany << " increments; enough for its contact: " << exact.needs[i];
  }
  std::sort(orders.begin(), orders.end());
  std::printf(
      "order, median %.2f, 0.5 or more in %.1f %% of points; mean error %.4f in %d, %.4f in %d increments; %d and %d "
      "points graze, %d stand still; largest error %.2f, of the others %.3f\n",
      orders[kPoints / 2],
      100.0 * static_cast<double>(orders.end() - std::lower_bound(orders.begin(), orders.end(), 0.5)) / kPoints,
      mean(few), kFew, mean(many), kMany, graze_few, graze_many, stand, *std::max_element(many.begin(), many.end()),
      *std::max_element(contact_kept.begin(), contact_kept.end()));
  EXPECT_GT(orders[kPoints / 2], 0.9);
  EXPECT_GT(orders[kPoints / 20], 0.3);
  EXPECT_GT(std::log(mean(few) / mean(many)) / std::log(8.0), 0.8);
  EXPECT_LE(graze_many, graze_few / 3);
}

TEST(Convergence, OfAllPointsButThoseThatGraze) {
  converges([](std::size_t i, double x) { return path(i, x); }, 0.2e6, 0.3e6, 0.15);
}
TEST(Convergence, OfAllPointsButThoseThatGrazeCrushingAsWell) { converges(crushing_path, 5e6, 5e6 / 3.0, 0.02); }

// ---- Reason: the law is discontinuous where contact is just lost or kept --------------------------------------------

// One of the 256 points, which does not converge up to 2048 increments; it loses or keeps contact at x = 0.14.
constexpr std::size_t kGrazing = 228;
constexpr double kAfter = 0.16;

// Returns sigma after the near loss of contact, with openings larger by the share `wider`.
double by_the_page(double wider, int increments) {
  const Joint j = joint();
  History s = initial(j, false);
  Jump from = path(kGrazing, 0.0, wider);
  Real sigma = 0;
  for (int step = 1; step <= static_cast<int>(kAfter * increments); ++step) {
    const Jump to = path(kGrazing, static_cast<double>(step) / increments, wider);
    sigma = update(j, s, to.n, to.s - from.s, to.t - from.t).sigma;
    from = to;
  }
  return static_cast<double>(sigma);
}
double by_the_rates(double wider, int pieces) {
  quoin::cyclic_rates::Point point(rates_of(joint()), false);
  Jump from = path(kGrazing, 0.0, wider);
  for (int piece = 1; piece <= static_cast<int>(kAfter * pieces); ++piece) {
    const Jump to = path(kGrazing, static_cast<double>(piece) / pieces, wider);
    point.go(to.n, to.s - from.s, to.t - from.t, 1);
    from = to;
  }
  return static_cast<double>(point.sigma());
}

// Returns the share above which larger openings lose contact, to 1e-8; with smaller ones contact is kept.
double threshold(double (*sigma)(double, int), int increments) {
  double kept = -0.03, lost = 0.03;
  while (lost - kept > 1e-8) {
    const double middle = (kept + lost) / 2.0;
    (sigma(middle, increments) > 0.05e6 ? lost : kept) = middle;
  }
  return lost;
}

TEST(Convergence, TheRatesThemselvesLoseContactOrKeepIt) {
  constexpr int kMany = 2048;
  double at[3];
  for (int k = 0; k < 3; ++k) at[k] = threshold(by_the_page, kMany << k);
  // The position of the discontinuity converges at first order, to 0.9 % of the amplitude, close to this path.
  EXPECT_NEAR((at[1] - at[0]) / (at[2] - at[1]), 2.0, 0.1);
  const double limit = 2.0 * at[2] - at[1];
  const double coarse = threshold(by_the_rates, 4 * kMany), fine = threshold(by_the_rates, 16 * kMany);
  EXPECT_NEAR((4.0 * fine - coarse) / 3.0, limit, 2e-5);  // the remaining error of second order is 6e-6
  // There a change of two millionths of the amplitude changes sigma by 0.9 of the tensile strength, in update and
  // rates.
  const auto jump = [](double (*sigma)(double, int), double where, int increments) {
    return sigma(where + 1e-6, increments) - sigma(where - 1e-6, increments);
  };
  EXPECT_GT(jump(by_the_page, at[2], 4 * kMany), 0.17e6);
  EXPECT_GT(jump(by_the_rates, fine, 16 * kMany), 0.17e6);
  std::printf("contact is lost at openings larger by %.5f, %.5f, %.5f, and so on to %.5f; the rates: %.5f, %.5f\n",
              at[0], at[1], at[2], limit, coarse, fine);
}

}  // namespace
