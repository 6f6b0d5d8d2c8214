#include "geometry/overlap.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace quoin::geometry {
namespace {

double cross2(const Point2& o, const Point2& a, const Point2& b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}
double distance2(const Point2& a, const Point2& b) { return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y); }
Point2 mix(const Point2& a, const Point2& b, double f) { return {a.x + f * (b.x - a.x), a.y + f * (b.y - a.y)}; }

void triangle_vertex_rule(const Point2& a, const Point2& b, const Point2& c, double tolerance,
                          std::vector<QuadraturePoint>& points, size_t first) {
  const double third = cross2(a, b, c) / 6;
  for (const Point2& p : {a, b, c}) add_merged(points, first, {p, third}, tolerance);
}

// To within rounding; by symmetry its corners have equal shares.
bool is_parallelogram(const Polygon& p) {
  constexpr double kRounding = 1e-12;  // of a diagonal
  if (p.size() != 4) return false;
  return distance2(mix(p[0], p[2], 0.5), mix(p[1], p[3], 0.5)) <= kRounding * kRounding * distance2(p[0], p[2]);
}

// Coordinates of Wachspress (1975) of a place inside a convex polygon: shares of its corners, >= 0, with 1 as their sum
// and the place as their mean. The share of a corner vanishes as the sides there come to lie on one line.
void corner_coordinates(const Polygon& p, const Point2& at, std::vector<double>& share) {
  const size_t n = p.size();
  share.resize(n);
  double sum = 0.0;
  for (size_t i = 0; i < n; ++i) {
    const Point2 &before = p[i > 0 ? i - 1 : n - 1], &after = p[i + 1 < n ? i + 1 : 0];
    share[i] = std::max(0.0, cross2(before, p[i], after)) / (cross2(at, before, p[i]) * cross2(at, p[i], after));
    sum += share[i];
  }
  for (double& of : share) of /= sum;
}

}  // namespace

double area(const Polygon& p) {
  double twice = 0.0;
  for (size_t i = 1; i + 1 < p.size(); ++i) twice += cross2(p[0], p[i], p[i + 1]);
  return 0.5 * twice;
}

Point2 centroid(const Polygon& p) {
  double twice = 0.0, x = 0.0, y = 0.0;
  for (size_t i = 1; i + 1 < p.size(); ++i) {
    const double w = cross2(p[0], p[i], p[i + 1]);
    twice += w;
    x += w * (p[0].x + p[i].x + p[i + 1].x);
    y += w * (p[0].y + p[i].y + p[i + 1].y);
  }
  return {x / (3 * twice), y / (3 * twice)};
}

void clip(const Polygon& subject, const Polygon& window, double tolerance, Polygon& result, Polygon& scratch) {
  result = subject;
  for (size_t k = 0; k < window.size() && !result.empty(); ++k) {
    const Point2 &a = window[k], &b = window[(k + 1) % window.size()];
    const double length = std::sqrt(distance2(a, b));
    scratch.clear();
    for (size_t i = 0; i < result.size(); ++i) {
      const Point2 &p = result[i], &q = result[(i + 1) % result.size()];
      // Distances within the tolerance count as 0, so that shared edges make no slivers.
      double dp = cross2(a, b, p) / length, dq = cross2(a, b, q) / length;
      if (std::abs(dp) <= tolerance) dp = 0;
      if (std::abs(dq) <= tolerance) dq = 0;
      if (dp >= 0) scratch.push_back(p);
      if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) scratch.push_back(mix(p, q, dp / (dp - dq)));
    }
    result.swap(scratch);
  }
  scratch.clear();
  for (const Point2& p : result) {
    if (scratch.empty() || distance2(scratch.back(), p) > tolerance * tolerance) scratch.push_back(p);
  }
  while (scratch.size() > 1 && distance2(scratch.back(), scratch.front()) <= tolerance * tolerance) scratch.pop_back();
  result.swap(scratch);
  if (result.size() < 3 || area(result) <= tolerance * std::sqrt(distance2(result[0], result[1]))) result.clear();
}

size_t add_merged(std::vector<QuadraturePoint>& points, size_t first, const QuadraturePoint& p, double tolerance) {
  for (size_t i = first; i < points.size(); ++i) {
    if (distance2(points[i].at, p.at) <= tolerance * tolerance) {
      points[i].area += p.area;
      return i;
    }
  }
  points.push_back(p);
  return points.size() - 1;
}

void vertex_rule(const Polygon& p, std::vector<QuadraturePoint>& points) {
  const size_t n = p.size(), first = points.size();
  if (n == 3 || is_parallelogram(p)) {
    const double share = area(p) / double(n);
    for (const Point2& c : p) points.push_back({c, share});
    return;
  }
  for (const Point2& c : p) points.push_back({c, 0.0});
  const Point2 g = centroid(p);
  std::vector<double> share;
  for (size_t i = 0; i < n; ++i) {  // a fan about the centroid, three points a triangle: exact for linear functions
    const Point2 *a = &g, *b = &p[i], *c = &p[i + 1 < n ? i + 1 : 0];
    const double third = cross2(*a, *b, *c) / 6;
    for (int k = 0; k < 3; ++k) {
      corner_coordinates(p, mix(mix(*b, *c, 0.5), *a, 2.0 / 3.0), share);
      for (size_t j = 0; j < n; ++j) points[first + j].area += third * share[j];
      std::swap(a, b), std::swap(b, c);
    }
  }
  const auto of_polygon = points.begin() + std::ptrdiff_t(first);
  points.erase(std::remove_if(of_polygon, points.end(), [](const QuadraturePoint& q) { return q.area <= 0.0; }),
               points.end());
}

void cubic_rule(const Polygon& p, std::vector<QuadraturePoint>& points) {
  const size_t n = p.size(), first = points.size();
  const Point2 g = centroid(p);
  const double tolerance = 1e-9 * std::sqrt(area(p));
  for (size_t i = 0; i < n; ++i) {
    const Point2 &a = p[i], &b = p[(i + 1) % n];
    const double s = 0.5 * cross2(g, a, b);
    for (const Point2& c : {g, a, b}) add_merged(points, first, {c, s / 20}, tolerance);
    for (const Point2& c : {mix(g, a, 0.5), mix(a, b, 0.5), mix(b, g, 0.5)})
      add_merged(points, first, {c, s * 2 / 15}, tolerance);
    points.push_back({{(g.x + a.x + b.x) / 3, (g.y + a.y + b.y) / 3}, s * 9 / 20});
  }
}

void grid_rule(const Polygon& p, double spacing, std::vector<QuadraturePoint>& points) {
  const size_t n = p.size(), first = points.size();
  auto divisions = [&](double length2) {
    constexpr double most = 100;  // points are merged pair by pair, which is slow for more
    const double count = std::max(1.0, std::ceil(std::sqrt(length2) / spacing - 1e-6));
    if (count > most) {
      throw Error(Exit::bad_input,
                  fmt::format("contact.point_spacing = {} m cuts a joint of {:.3g} m into {:.3g} parts; "
                              "allowed: {} parts at most",
                              spacing, std::sqrt(length2), count, most));
    }
    return int(count);
  };
  const double tolerance = 1e-7 * std::sqrt(area(p));
  if (n == 4) {
    const int nu = divisions(std::max(distance2(p[0], p[1]), distance2(p[3], p[2])));
    const int nv = divisions(std::max(distance2(p[1], p[2]), distance2(p[0], p[3])));
    auto at = [&](int i, int j) {
      return mix(mix(p[0], p[1], double(i) / nu), mix(p[3], p[2], double(i) / nu), double(j) / nv);
    };
    std::vector<QuadraturePoint> cell;
    for (int j = 0; j < nv; ++j) {
      for (int i = 0; i < nu; ++i) {
        cell.clear();
        vertex_rule({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}, cell);
        for (const QuadraturePoint& q : cell) add_merged(points, first, q, tolerance);
      }
    }
    return;
  }
  const Point2 g = centroid(p);
  double longest = 0.0;
  for (size_t i = 0; i < n; ++i) longest = std::max({longest, distance2(p[i], p[(i + 1) % n]), distance2(g, p[i])});
  const int m = divisions(longest);
  if (m == 1) {
    vertex_rule(p, points);
    return;
  }
  for (size_t t = 0; t < n; ++t) {
    const Point2 &a = p[t], &b = p[(t + 1) % n];
    auto at = [&](int i, int j) {  // i towards a, j towards b
      return Point2{g.x + (i * (a.x - g.x) + j * (b.x - g.x)) / m, g.y + (i * (a.y - g.y) + j * (b.y - g.y)) / m};
    };
    for (int i = 0; i < m; ++i) {
      for (int j = 0; i + j < m; ++j) {
        triangle_vertex_rule(at(i, j), at(i + 1, j), at(i, j + 1), tolerance, points, first);
        if (i + j + 1 < m) triangle_vertex_rule(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), tolerance, points, first);
      }
    }
  }
}

}  // namespace quoin::geometry
