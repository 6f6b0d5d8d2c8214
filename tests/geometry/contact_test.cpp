// Separation, overlap, quadrature and broad phase against closed forms and brute force.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "geometry/broad_phase.h"
#include "geometry/overlap.h"
#include "geometry/separation.h"

namespace quoin::geometry {
namespace {

ConvexPolyhedron moved(ConvexPolyhedron s, const Quaternion& q, const Vector& by) {
  for (Vector& p : s.vertices) p = matrix(q) * p + by;
  update_normals(s);
  return s;
}
ConvexPolyhedron cube(double a) { return box({-a / 2, -a / 2, -a / 2}, {a, a, a}); }

TEST(Separation, FaceFace) {
  const auto a = cube(1), b = moved(cube(1), {}, {0.3, 1.02, 0.1});
  const auto s = separate(placed(a, {}), placed(b, {0.3, 1.02, 0.1}), 1e9, 1e-6);
  EXPECT_NE(s.feature, Separation::edges);
  EXPECT_NEAR(s.distance, 0.02, 1e-14);
  EXPECT_NEAR(s.normal.y, 1.0, 1e-15);
}

TEST(Separation, VertexOverFace) {
  // A cube on its corner: the body diagonal is vertical.
  const Vector diagonal = normalized(Vector{1, 1, 1}), up{0, 1, 0};
  const Vector axis = cross(diagonal, up);
  const Quaternion q = rotation(std::asin(norm(axis)) * normalized(axis));
  const double half = std::sqrt(3.0) / 2;
  const auto floor = box({-5, -1, -5}, {10, 1, 10}), b = moved(cube(1), q, {0.2, half - 0.01, 0.4});
  const auto s = separate(placed(floor, {0, -0.5, 0}), placed(b, {0.2, half - 0.01, 0.4}), 1e9, 1e-6);
  EXPECT_EQ(s.feature, Separation::face_of_a);
  EXPECT_NEAR(s.distance, -0.01, 1e-12);
  EXPECT_NEAR(s.normal.y, 1.0, 1e-15);
}

TEST(Separation, CrossingEdges) {
  // Two cubes, each with an edge towards the other; the edges are perpendicular.
  const double h = std::sqrt(2.0) / 2, gap = 0.03;
  const auto a = moved(cube(1), rotation({0, 0, std::numbers::pi / 4}), {0, -h, 0});  // ridge along z at the origin
  const auto b = moved(cube(1), rotation({std::numbers::pi / 4, 0, 0}), {0, h + gap, 0});  // ridge along x
  const auto s = separate(placed(a, {0, -h, 0}), placed(b, {0, h + gap, 0}), 1e9, 1e-6);
  EXPECT_EQ(s.feature, Separation::edges);
  EXPECT_NEAR(s.distance, gap, 1e-12);
  EXPECT_NEAR(s.normal.y, 1.0, 1e-12);
  const auto& ea = a.edges[s.index_a];
  const auto& eb = b.edges[s.index_b];
  const auto points = crossing_points(a.vertices[ea.tail], a.vertices[ea.head] - a.vertices[ea.tail],
                                      b.vertices[eb.tail], b.vertices[eb.head] - b.vertices[eb.tail]);
  ASSERT_TRUE(points);
  const auto& [p, q] = *points;
  EXPECT_NEAR(norm(p), 0.0, 1e-12);
  EXPECT_NEAR(norm(q - Vector{0, gap, 0}), 0.0, 1e-12);
}

// Units on each other, rotated by some thousandths, with faces out of plane by some hundredths of a millimetre. The
// distance is not more than that of their corners along the axis, also with edges that are almost parallel.
TEST(Separation, BentUnitsAreNoFurtherApartThanTheirCorners) {
  std::mt19937 random(7);
  constexpr double bent = 2e-5;  // m, deviation of a face from its plane
  std::uniform_real_distribution<double> any(-1, 1);
  const auto vector = [&](double size) { return size * Vector{any(random), any(random), any(random)}; };
  const auto unit = [&](const Vector& centre) {
    auto shape = moved(box({-0.055, -0.03125, -0.05}, {0.11, 0.0625, 0.1}),
                       rotation(Vector{3e-4 * any(random), 3e-3 * any(random), 3e-4 * any(random)}), centre);
    for (Vector& corner : shape.vertices) corner += vector(bent);
    update_normals(shape);
    return shape;
  };
  int edges = 0;
  for (int round = 0; round < 2000; ++round) {
    const Vector above{2.5e-3 * any(random), 0.0625 + 1e-4 * any(random), 1e-3 * any(random)};
    const auto a = unit({}), b = unit(above);
    for (const bool upwards : {true, false}) {
      const auto &from = upwards ? a : b, &to = upwards ? b : a;
      const auto s =
          separate(placed(from, upwards ? Vector{} : above), placed(to, upwards ? above : Vector{}), 1e9, 1e-6);
      double low = 1e9, high = -1e9;
      for (const Vector& p : to.vertices) low = std::min(low, dot(s.normal, p));
      for (const Vector& p : from.vertices) high = std::max(high, dot(s.normal, p));
      EXPECT_LE(s.distance, low - high + (s.feature == Separation::edges ? 1e-12 : 2 * bent)) << s.feature;
      edges += s.feature == Separation::edges;
    }
  }
  EXPECT_GT(edges, 0);
}

TEST(Separation, EdgesThatPassBesideEachOtherDoNotCross) {
  const Vector u{0, 0, 0.1};
  const auto beside = [&](const Vector& q, const Vector& v) { return crossing_points({0, 0, 0}, u, q, v); };
  EXPECT_TRUE(beside({-0.1, 0.01, 0.03}, {0.2, 0, 0}));
  EXPECT_FALSE(beside({0.01, 0.01, 0.03}, {0.2, 0, 0})) << "the second ends beside the first";
  EXPECT_FALSE(beside({-0.1, 0.01, 0.11}, {0.2, 0, 0})) << "the first ends before the second";
  EXPECT_FALSE(beside({-0.1, 0.01, 0.0}, {3e-4, 0, 0.1})) << "almost parallel: the lines cross 33 m away";
  EXPECT_FALSE(beside({-0.1, 0.01, 0.0}, u));
}

// The separating-axis distance of random cubes against a brute-force scan of directions, and symmetry of both bodies.
TEST(Separation, RandomPairsAgreeWithScanOfDirections) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 40; ++round) {
    auto any = [&] { return Vector{normal(random), normal(random), normal(random)}; };
    const Vector at = 1.1 * normalized(any());
    const auto a = moved(cube(1), rotation(any()), {}),
               b = moved(box({-0.4, -0.3, -0.6}, {0.8, 0.6, 1.2}), rotation(any()), at);
    const auto s = separate(placed(a, {}), placed(b, at), 1e9, 1e-9);
    const auto r = separate(placed(b, at), placed(a, {}), 1e9, 1e-9);
    EXPECT_NEAR(s.distance, r.distance, 1e-12);
    EXPECT_NEAR(norm(s.normal + r.normal), 0.0, 1e-9);
    auto along = [&](const Vector& n) {
      double low = 1e9, high = -1e9;
      for (const Vector& p : b.vertices) low = std::min(low, dot(n, p));
      for (const Vector& p : a.vertices) high = std::max(high, dot(n, p));
      return low - high;
    };
    EXPECT_NEAR(along(s.normal), s.distance, 1e-12);
    if (s.distance > 0)
      continue;  // for separate cubes a vertex pair may be the closest: the value is then a lower bound
    for (int k = 0; k < 4000; ++k) EXPECT_LE(along(normalized(any())), s.distance + 1e-12);
  }
}

// Largest separation of two bodies over the normals of their faces, and over all axes across two edges. Along such an
// axis both edges are the farthest of their bodies.
double largest_over_all_axes(const ConvexPolyhedron& a, const ConvexPolyhedron& b) {
  constexpr double kTie = 1e-10;  // m, of corners that are equally far along an axis
  const auto along = [](const ConvexPolyhedron& p, const Vector& n) {
    std::pair<double, double> range{1e9, -1e9};
    for (const Vector& x : p.vertices) range = {std::min(range.first, dot(n, x)), std::max(range.second, dot(n, x))};
    return range;
  };
  double largest = -1e9;
  for (const Vector& n : a.normals) largest = std::max(largest, along(b, n).first - along(a, n).second);
  for (const Vector& n : b.normals) largest = std::max(largest, -along(b, n).second + along(a, n).first);
  for (const auto& ea : a.edges) {
    for (const auto& eb : b.edges) {
      const Vector u = a.vertices[ea.head] - a.vertices[ea.tail], v = b.vertices[eb.head] - b.vertices[eb.tail];
      const Vector m = cross(u, v);
      if (norm(m) < 1e-3 * norm(u) * norm(v)) continue;  // parallel: an axis is that of a face
      for (const double sign : {1.0, -1.0}) {
        const Vector n = (sign / norm(m)) * m;
        const double high = along(a, n).second, low = along(b, n).first;
        if (dot(n, a.vertices[ea.tail]) > high - kTie && dot(n, b.vertices[eb.tail]) < low + kTie)
          largest = std::max(largest, low - high);
      }
    }
  }
  return largest;
}

Vector mean_of(const ConvexPolyhedron& p) {
  Vector sum;
  for (const Vector& x : p.vertices) sum += x;
  return sum / double(p.vertices.size());
}

// Most edges are skipped, as no axis across them can win. Bodies: units that rock on each other by up to a tenth of a
// radian, some with a rim in common. Hulls of random points, from deep overlap to apart. Tolerance: rounding.
TEST(Separation, SkippedEdgesAreThoseThatCannotWin) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int edges = 0, apart = 0;
  for (int round = 0; round < 3000; ++round) {
    const auto any = [&] { return Vector{unit(random), unit(random), unit(random)}; };
    const bool units = round % 2 == 0;
    std::vector<Vector> cloud_a, cloud_b;
    for (int k = 0; k < 12; ++k) cloud_a.push_back(any()), cloud_b.push_back(any());
    const Vector size{0.2, 0.1, 0.1};
    const double beside = round % 4 == 0 ? 0.0 : 0.05 * unit(random);
    const Vector at = units ? Vector{0.1 * unit(random), 0.1 + 2e-3 * unit(random), beside} : 1.2 * any();
    const ConvexPolyhedron a = units ? moved(box(-0.5 * size, size), rotation(0.03 * any()), {})
                                     : from_vertices(cloud_a, "a"),
                           b = units ? moved(box(-0.5 * size, size), rotation(0.1 * any()), at)
                                     : moved(from_vertices(cloud_b, "b"), {}, at);
    const auto s = separate(placed(a, mean_of(a)), placed(b, mean_of(b)), 1e9, 0.0);
    EXPECT_NEAR(s.distance, largest_over_all_axes(a, b), 1e-12) << round;
    edges += s.feature == Separation::edges, apart += s.distance > 0.0;
  }
  EXPECT_GT(edges, 300);
  EXPECT_GT(apart, 300);
}

TEST(Separation, KeepsTheReferenceBetweenEqualAxes) {
  const auto a = cube(1), b = moved(cube(1), {}, {0, 0.9999, 0});
  const auto first = separate(placed(a, {}), placed(b, {0, 0.9999, 0}), 1e9, 1e-3);
  const auto tilted = moved(cube(1), rotation({0, 0, 1e-4}), {0, 0.99995, 0});
  const auto second = separate(placed(a, {}), placed(tilted, {0, 0.99995, 0}), 1e9, 1e-3, &first);
  EXPECT_EQ(first.feature, second.feature);
  EXPECT_EQ(first.index_a, second.index_a);
}

// Of faces that are equally close to a direction, to rounding, facing returns the first one. Tested at each of the 8
// corners and 12 edges of a cube.
TEST(Separation, FacingIsTheFirstOfFacesAlikeWhateverTheirRounding) {
  const auto cube_at_rest = cube(1);
  const Placed p = placed(cube_at_rest, {});
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const Vector towards{double(x), double(y), double(z)};
        if (norm(towards) == 0) continue;
        const auto ahead = [&](const Vector& normal) { return dot(normal, towards) > 0.5; };
        const int first = int(std::find_if(p.normals, p.normals + 6, ahead) - p.normals);
        for (const Vector& rounding : {Vector{}, Vector{1e-12, 0, 0}, Vector{0, 1e-12, 0}, Vector{0, 0, 1e-12}}) {
          EXPECT_EQ(facing(p, normalized(towards + rounding)), first) << x << y << z;
          EXPECT_EQ(facing(p, normalized(towards - rounding)), first) << x << y << z;
        }
      }
    }
  }
  EXPECT_NEAR(p.normals[size_t(facing(p, {0.3, -1.0, 0.2}))].y, -1.0, 1e-15);
}

double integral(const std::vector<QuadraturePoint>& points, int i, int j) {
  double sum = 0;
  for (const auto& q : points) sum += q.area * std::pow(q.at.x, i) * std::pow(q.at.y, j);
  return sum;
}
// Returns the exact integral of x^i y^j, i + j <= 3, over a polygon, by Gauss points of degree 5 on its triangles.
double exact(const Polygon& p, int i, int j) {
  const double a = 0.797426985353087, b = 0.101286507323456, c = 0.059715871789770, d = 0.470142064105115;
  double sum = 0;
  for (size_t k = 1; k + 1 < p.size(); ++k) {
    const Point2 u = p[0], v = p[k], w = p[k + 1];
    const double s = 0.5 * ((v.x - u.x) * (w.y - u.y) - (v.y - u.y) * (w.x - u.x));
    auto add = [&](double l, double m, double n, double weight) {
      sum += s * weight * std::pow(l * u.x + m * v.x + n * w.x, i) * std::pow(l * u.y + m * v.y + n * w.y, j);
    };
    add(1. / 3, 1. / 3, 1. / 3, 0.225);
    for (auto [l, m, weight] : {std::tuple{a, b, 0.125939180544827}, {c, d, 0.132394152788506}}) {
      add(l, m, m, weight), add(m, l, m, weight), add(m, m, l, weight);
    }
  }
  return sum;
}

TEST(Overlap, ClosedForms) {
  const Polygon unit{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  Polygon result, scratch;
  clip(unit, {{0.25, -1}, {2, -1}, {2, 0.5}, {0.25, 0.5}}, 1e-9, result, scratch);
  EXPECT_NEAR(area(result), 0.375, 1e-15);
  EXPECT_NEAR(centroid(result).x, 0.625, 1e-15);
  const double r = std::sqrt(0.5);  // square rotated by 45 degrees about the same centre: regular octagon
  clip(unit, {{0.5 - r, 0.5}, {0.5, 0.5 - r}, {0.5 + r, 0.5}, {0.5, 0.5 + r}}, 1e-9, result, scratch);
  EXPECT_EQ(result.size(), 8u);
  EXPECT_NEAR(area(result), 2 * std::sqrt(2.0) - 2, 1e-14);
  clip(unit, {{1, 0}, {2, 0}, {2, 1}, {1, 1}}, 1e-9, result, scratch);
  EXPECT_TRUE(result.empty());
  clip(unit, unit, 1e-9, result, scratch);
  EXPECT_EQ(result.size(), 4u);
  EXPECT_NEAR(area(result), 1.0, 1e-15);
}

TEST(Overlap, RulesArePositiveAndExact) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi);
  for (int n = 3; n < 9; ++n) {
    std::vector<double> a;
    for (int i = 0; i < n; ++i) a.push_back(angle(random));
    std::sort(a.begin(), a.end());
    Polygon p;
    for (double t : a) p.push_back({0.3 + 0.5 * std::cos(t), -0.2 + 0.7 * std::sin(t)});
    if (area(p) < 0.05) continue;
    for (int rule = 0; rule < 4; ++rule) {
      std::vector<QuadraturePoint> points;
      if (rule == 0) vertex_rule(p, points);
      if (rule == 1) cubic_rule(p, points);
      if (rule == 2) grid_rule(p, 0.2, points);
      if (rule == 3) grid_rule(p, 10, points);
      for (const auto& q : points) EXPECT_GT(q.area, 0.0);
      for (int i = 0; i <= 3; ++i) {
        for (int j = 0; i + j <= (rule == 1 ? 3 : 1); ++j)
          EXPECT_NEAR(integral(points, i, j), exact(p, i, j), 1e-13) << n << rule;
      }
    }
  }
  std::vector<QuadraturePoint> points;
  vertex_rule({{0, 0}, {2, 0}, {2, 1}, {0, 1}}, points);
  for (const auto& q : points) EXPECT_NEAR(q.area, 0.5, 1e-15);
  points.clear();
  grid_rule({{0, 0}, {2, 0}, {2, 1}, {0, 1}}, 0.5, points);
  EXPECT_EQ(points.size(), 15u);
}

// A square and the same turned by a small angle overlap in an octagon. Four of its corners lie at mid-side, and their
// area vanishes with the angle. The others have nearly a quarter of the area each.
TEST(Overlap, AreaOfACornerVanishesAsItGoesFlat) {
  const Polygon unit = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  for (double angle : {1e-2, 1e-3, 1e-4}) {
    Polygon turned = unit, overlap, scratch;
    for (Point2& p : turned)
      p = {std::cos(angle) * p.x - std::sin(angle) * p.y, std::sin(angle) * p.x + std::cos(angle) * p.y};
    clip(turned, unit, 1e-9, overlap, scratch);
    ASSERT_EQ(overlap.size(), 8u);
    std::vector<QuadraturePoint> points;
    vertex_rule(overlap, points);
    double at_sides = 0.0;
    for (const QuadraturePoint& q : points) {
      const bool at_corner = std::min(std::abs(q.at.x), std::abs(q.at.y)) > 0.4;
      if (at_corner) {
        EXPECT_NEAR(q.area, 0.25, angle);
      }
      at_sides += at_corner ? 0.0 : q.area;
    }
    EXPECT_GT(at_sides, 0.0);
    EXPECT_LT(at_sides, 4.0 * angle);
  }
}

TEST(BroadPhase, AgreesWithBruteForce) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(0, 1);
  std::vector<Box> boxes;
  for (int i = 0; i < 2000; ++i) {
    const Vector p{10 * u(random), 4 * u(random), 2 * u(random)};
    const double size = i % 500 == 3 ? 9.0 : 0.1 + 0.3 * u(random);
    boxes.push_back({p, p + Vector{size, 0.5 * size, size * u(random)}});
  }
  std::vector<Pair> brute;
  for (int i = 0; i < 2000; ++i) {
    for (int j = i + 1; j < 2000; ++j) {
      if (overlap(boxes[i], boxes[j])) brute.push_back({i, j});
    }
  }
  const auto pairs = overlapping_pairs(boxes);
  EXPECT_GT(pairs.size(), 3000u);
  EXPECT_EQ(pairs, brute);
}

// The smallest cases, which test the ends of a list.
TEST(BroadPhase, TwoAndThreeBoxes) {
  const Box a{{0, 0, 0}, {1, 1, 1}}, b{{0.5, 0.5, 0.5}, {2, 2, 2}}, c{{1.5, 1.5, 1.5}, {3, 3, 3}};
  EXPECT_TRUE(overlapping_pairs({}).empty());
  EXPECT_TRUE(overlapping_pairs({a}).empty());
  EXPECT_EQ(overlapping_pairs({a, b}), (std::vector<Pair>{{0, 1}}));
  EXPECT_TRUE(overlapping_pairs({a, c}).empty());
  EXPECT_EQ(overlapping_pairs({a, c, b}), (std::vector<Pair>{{0, 2}, {1, 2}}));
}

}  // namespace
}  // namespace quoin::geometry
