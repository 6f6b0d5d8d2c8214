// Shapes, mass properties, validation, zoning and mesh files against closed forms.
#include "geometry/polyhedron.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <random>
#include <set>

#include "../scratch.h"
#include "base/error.h"
#include "geometry/drawn_shape.h"
#include "geometry/mesh_file.h"
#include "geometry/zoning.h"

namespace quoin::geometry {
namespace {

std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "not refused";
}

ConvexPolyhedron octahedron(double a) {
  return from_vertices({{a, 0, 0}, {-a, 0, 0}, {0, a, 0}, {0, -a, 0}, {0, 0, a}, {0, 0, -a}}, "octahedron");
}

ConvexPolyhedron prism(int sides, double radius, double height) {
  std::vector<Vector> p;
  for (int i = 0; i < sides; ++i) {
    const double a = 2 * std::numbers::pi * i / sides;
    for (double z : {0.0, height}) p.push_back({radius * std::cos(a), radius * std::sin(a), z});
  }
  return from_vertices(p, "prism");
}

// Both branches of rotation(), and angles near their limit: |half angle|^2 = 1e-4 separates the series from sine and
// cosine.
TEST(Vectors, RotationsAreThoseOfSineAndCosine) {
  for (const double angle : {1e-9, 1e-3, 0.0199, 0.0201, 0.5, 3.0}) {
    const Vector axis = normalized(Vector{1, -2, 0.5});
    const Quaternion q = rotation(angle * axis);
    EXPECT_NEAR(q.w, std::cos(angle / 2), 3e-16);
    EXPECT_NEAR(norm(q.v - std::sin(angle / 2) * axis), 0.0, 3e-16 * (1 + angle));
  }
}

// Also for a negative trace with each of the diagonal terms as the largest.
TEST(Vectors, QuaternionsAndMatricesAreTheSameRotation) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  int negative[3] = {};
  for (int i = 0; i < 200; ++i) {
    const Quaternion q = normalized(Quaternion{normal(random), {normal(random), normal(random), normal(random)}});
    const Matrix r = matrix(q), rr = transposed(r) * r;
    const Quaternion back = quaternion(r);
    const double sign = back.w * q.w + dot(back.v, q.v) > 0 ? 1.0 : -1.0;
    EXPECT_NEAR(sign * back.w, q.w, 1e-14);
    EXPECT_NEAR(norm(sign * back.v - q.v), 0.0, 1e-14);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(norm(rr.row[k] - Matrix{}.row[k]), 0.0, 1e-14);
      EXPECT_EQ(norm(r.column(k) - transposed(r).row[k]), 0.0);
      // r v = v + 2 w (q x v) + 2 q x (q x v)
      const Vector e = Matrix{}.row[k], c = cross(q.v, e);
      EXPECT_NEAR(norm(r.column(k) - (e + 2 * q.w * c + 2 * cross(q.v, c))), 0.0, 1e-14);
    }
    if (trace(r) < 0)
      for (int k = 0; k < 3; ++k) negative[k] += r.row[k][k] >= std::max({r.row[0].x, r.row[1].y, r.row[2].z});
  }
  for (const int count : negative) EXPECT_GT(count, 5);
}

TEST(Vectors, AnyNormalIsAUnitNormalFarFromCancellation) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    const Vector n = i < 3 ? Matrix{}.row[i] : normalized(Vector{normal(random), normal(random), normal(random)});
    EXPECT_NEAR(dot(any_normal(n), n), 0.0, 1e-15);
    EXPECT_NEAR(norm(any_normal(n)), 1.0, 1e-15);
  }
  // The first axis that is far enough from n, less its part along n.
  EXPECT_EQ(norm(any_normal({0, 0.6, 0.8}) - Vector{1, 0, 0}), 0.0);
  EXPECT_EQ(norm(any_normal({1, 0, 0}) - Vector{0, 1, 0}), 0.0);
  EXPECT_NEAR(norm(any_normal({0.8, 0.6, 0}) - Vector{0, 0, 1}), 0.0, 1e-16);
}

TEST(Vectors, EigenvectorsDiagonalise) {
  // The third has one off-diagonal term beside a zero on the diagonal: (1 +- sqrt 5)/2 and 0.
  std::vector<Matrix> cases{Matrix{{{2, -1, 0}, {-1, 2, -1}, {0, -1, 2}}}, Matrix::diagonal({3, -1, 2}),
                            Matrix{{{1, 1, 0}, {1, 0, 0}, {0, 0, 0}}},     Matrix{{{0, 0, 1}, {0, 0, 0}, {1, 0, 1}}},
                            Matrix{{{0, 0, 0}, {0, 1, 1}, {0, 1, 0}}},     Matrix{{{5, 2, 1}, {2, -7, 3}, {1, 3, 4}}}};
  for (const Matrix& m : cases) {
    const Eigen3 e = symmetric_eigen(m);
    EXPECT_LE(e.values.x, e.values.y);
    EXPECT_LE(e.values.y, e.values.z);
    EXPECT_NEAR(determinant(e.vectors), 1.0, 1e-14);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(norm(m * e.vectors.column(k) - e.values[k] * e.vectors.column(k)), 0.0, 1e-14);
  }
  EXPECT_NEAR(symmetric_eigen(cases[2]).values.z, (1 + std::sqrt(5.0)) / 2, 1e-14);
  EXPECT_NEAR(symmetric_eigen(cases[0]).values.x, 2 - std::sqrt(2.0), 1e-14);
}

// Points within an edge are not corners, for any order of the points.
TEST(Polyhedron, PointsOnEdgesAreNoCornersInAnyOrder) {
  const ConvexPolyhedron b = box({1, 2, 3}, {0.4, 0.175, 0.2});
  std::vector<Vector> p = b.vertices;
  for (const auto& f : b.faces)
    for (size_t i = 0; i < f.size(); ++i) p.push_back(0.5 * (b.vertices[f[i]] + b.vertices[f[(i + 1) % f.size()]]));
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::shuffle(p.begin(), p.end(), std::mt19937(seed));
    const ConvexPolyhedron s = from_vertices(p, "b");
    EXPECT_EQ(s.vertices.size(), 8u);
    EXPECT_EQ(s.edges.size(), 12u);
    for (const auto& f : s.faces) EXPECT_EQ(f.size(), 4u);
  }
}

TEST(Polyhedron, HullOfBoxHasSixQuadrilaterals) {
  std::vector<Vector> p = box({1, 2, 3}, {0.4, 0.175, 0.2}).vertices;
  p.push_back({1.2, 2.1, 3.1});  // inside
  p.push_back({1.2, 2.0, 3.1});  // on a face
  p.push_back({1.2, 2.0, 3.0});  // on an edge
  std::shuffle(p.begin(), p.end(), std::mt19937(7));
  const ConvexPolyhedron s = from_vertices(p, "b");
  EXPECT_EQ(s.vertices.size(), 8u);
  ASSERT_EQ(s.faces.size(), 6u);
  EXPECT_EQ(s.edges.size(), 12u);
  for (const auto& f : s.faces) EXPECT_EQ(f.size(), 4u);
}

TEST(Polyhedron, PrismsOfManySides) {
  for (int n : {3, 5, 8, 17, 40}) {
    const ConvexPolyhedron s = prism(n, 0.5, 2.0);
    EXPECT_EQ(s.faces.size(), size_t(n) + 2);
    const double base = 0.5 * n * 0.25 * std::sin(2 * std::numbers::pi / n);
    EXPECT_NEAR(mass_properties(s).volume, 2 * base, 1e-12);
    EXPECT_NEAR(norm(mass_properties(s).centroid - Vector{0, 0, 1}), 0.0, 1e-12);
  }
}

TEST(Polyhedron, MassPropertiesOfBoxAndOctahedron) {
  const auto m = mass_properties(box({-3, 1, 10}, {2, 3, 5}));
  EXPECT_NEAR(m.volume, 30.0, 1e-12);
  EXPECT_NEAR(norm(m.centroid - Vector{-2, 2.5, 12.5}), 0.0, 1e-13);
  EXPECT_NEAR(m.inertia.row[0].x, 30.0 * (9 + 25) / 12, 1e-10);
  EXPECT_NEAR(m.inertia.row[1].y, 30.0 * (4 + 25) / 12, 1e-10);
  EXPECT_NEAR(m.inertia.row[2].z, 30.0 * (4 + 9) / 12, 1e-10);
  EXPECT_NEAR(m.inertia.row[0].y, 0.0, 1e-10);
  const double a = 0.7, v = 4.0 / 3 * a * a * a;  // regular octahedron: I = m a^2 / 5
  const auto o = mass_properties(octahedron(a));
  EXPECT_NEAR(o.volume, v, 1e-14);
  EXPECT_NEAR(o.inertia.row[0].x, v * a * a / 5, 1e-14);
  EXPECT_NEAR(o.inertia.row[2].z, v * a * a / 5, 1e-14);
}

TEST(Polyhedron, RandomHullsAreConvexAndClosed) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 50; ++round) {
    std::vector<Vector> p;
    for (int i = 0; i < 30; ++i) p.push_back({normal(random), normal(random), normal(random)});
    const ConvexPolyhedron s = from_vertices(p, "random");
    EXPECT_EQ(s.vertices.size() + s.faces.size(), s.edges.size() + 2);
    Vector closed;
    for (size_t f = 0; f < s.faces.size(); ++f) {
      closed += face_area(s, int(f)) * s.normals[f];
      for (const Vector& q : p) EXPECT_LE(dot(q - s.vertices[s.faces[f][0]], s.normals[f]), 1e-5);
    }
    EXPECT_LT(norm(closed), 1e-12);
  }
}

// A prism of length 4 with a trapezoid of sides 3 and 1 and height 2: centroids of its faces in closed form.
TEST(Polyhedron, CentroidsOfFaces) {
  std::vector<Vector> corners;
  for (const double z : {0.0, 4.0})
    for (const Vector& p : {Vector{0, 0, z}, Vector{3, 0, z}, Vector{2, 2, z}, Vector{1, 2, z}}) corners.push_back(p);
  const ConvexPolyhedron prism = from_vertices(corners, "prism");
  int found = 0;
  for (size_t f = 0; f < prism.faces.size(); ++f) {
    const Vector& n = prism.normals[f];
    Vector expected = std::abs(n.z) > 0.5 ? Vector{1.5, 2.0 / 3.0 * (3 + 2 * 1) / (3 + 1), n.z > 0 ? 4.0 : 0.0}
                      : n.y < -0.5        ? Vector{1.5, 0, 2}
                      : n.y > 0.9         ? Vector{1.5, 2, 2}
                                          : Vector{n.x > 0 ? 2.5 : 0.5, 1, 2};
    EXPECT_LT(norm(face_centroid(prism, int(f)) - expected), 1e-12) << f;
    ++found;
  }
  EXPECT_EQ(found, 6);
}

TEST(Polyhedron, BadShapesAreRefusedWithNameAndPlace) {
  const ConvexPolyhedron b = box({0, 0, 0}, {1, 1, 1});
  EXPECT_NE(refusal([] {
              from_vertices({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, "k7");
            }).find("block k7: has 3 vertices"),
            std::string::npos);
  EXPECT_NE(refusal([] {
              from_vertices({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, "flat");
            }).find("one plane"),
            std::string::npos);
  EXPECT_NE(refusal([] {
              from_vertices({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, "line");
            }).find("one line"),
            std::string::npos);
  EXPECT_NE(refusal([] {
              from_vertices({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, std::nan("")}}, "n");
            }).find("vertex 3 is not a number"),
            std::string::npos);
  auto faces = b.faces;
  std::swap(faces[2][1], faces[2][3]);  // one face inverted
  EXPECT_NE(refusal([&] { from_faces(b.vertices, faces, "one"); }).find("inverted"), std::string::npos);
  faces = b.faces;
  for (auto& f : faces) std::reverse(f.begin(), f.end());
  EXPECT_NE(refusal([&] { from_faces(b.vertices, faces, "all"); }).find("block all: is inverted (volume -1 m3)"),
            std::string::npos);
  faces = b.faces;
  faces.pop_back();
  EXPECT_NE(refusal([&] { from_faces(b.vertices, faces, "open"); }).find("surface is open"), std::string::npos);
  auto vertices = b.vertices;
  vertices[7] = {1.2, 1.1, 1};  // warps two faces
  EXPECT_NE(refusal([&] { from_faces(vertices, b.faces, "warped"); }).find("not planar"), std::string::npos);
  // An L-shaped prism: closed and planar, but not convex.
  std::vector<Vector> l;
  for (double z : {0.0, 1.0}) {
    for (auto [x, y] : {std::pair{0., 0.}, {2., 0.}, {2., 1.}, {1., 1.}, {1., 2.}, {0., 2.}}) l.push_back({x, y, z});
  }
  std::vector<std::vector<int>> lf = {{5, 4, 3, 2, 1, 0}, {6, 7, 8, 9, 10, 11}};
  for (int i = 0; i < 6; ++i) lf.push_back({i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i});
  const std::string text = refusal([&] { from_faces(l, lf, "L"); });
  EXPECT_NE(text.find("block L: is not convex: vertex"), std::string::npos) << text;
}

// A box with a shallow valley in its top. Each far edge is outside of the other half of the top by about twice the
// valley's depth. Up to a millionth of the size this is rounding of files; above, the shape is not convex.
TEST(Polyhedron, ValleysDeeperThanRoundingAreNotConvex) {
  const auto with_valley = [](double front) {
    std::vector<Vector> vertices;
    for (const double y : {0.0, 1.0}) {
      for (auto [x, z] : {std::pair{0., 0.}, {1., 0.}, {1., 1.}, {0.5, 1 - front / 2}, {0., 1.}})
        vertices.push_back({x, y, z});
    }
    std::vector<std::vector<int>> faces = {{0, 1, 2, 3, 4}, {9, 8, 7, 6, 5}};
    for (int i = 0; i < 5; ++i) faces.push_back({(i + 1) % 5, i, 5 + i, 5 + (i + 1) % 5});
    return from_faces(vertices, faces, "valley");
  };
  EXPECT_NO_THROW(with_valley(1.8e-6));
  const std::string text = refusal([&] { with_valley(2.4e-6); });
  EXPECT_NE(text.find("block valley: is not convex: vertex"), std::string::npos) << text;
}

// A tetrahedron is refined along the shortest of its three inner diagonals, for any order of vertices. Quality: 12 (3
// V)^(2/3) over the sum of the squares of the edges, 1 for the regular one (Liu and Joe).
TEST(Zoning, QualityIsNoMatterOfTheOrderOfVertices) {
  std::vector<Vector> p{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0.5, 3}};
  std::vector<int> order{0, 1, 2, 3};
  double first = 0.0;
  do {
    std::vector<Vector> corners;
    for (const int i : order) corners.push_back(p[size_t(i)]);
    const Zoning z = make_zones(from_vertices(corners, "t"), 1.6, "t");
    if (first == 0.0) first = z.worst_quality;
    EXPECT_NEAR(z.worst_quality, first, 1e-12);
  } while (std::next_permutation(order.begin(), order.end()));
  // A cube in five: four corners of volume 1/6, with three edges of 1 and three of sqrt 2, and a regular one.
  const Zoning cube = make_zones(box({0, 0, 0}, {1, 1, 1}), 1.0, "c");
  ASSERT_EQ(cube.zones.size(), 5u);
  EXPECT_NEAR(cube.worst_quality, 12 * std::cbrt(9.0 / 36) / 9, 1e-12);
  EXPECT_NEAR(cube.longest_edge, std::sqrt(2.0), 1e-12);
}

TEST(Zoning, FillsTheVolumeAndCoversTheSurface) {
  const struct {
    ConvexPolyhedron shape;
    double edge, worst_allowed;
  } cases[] = {{box({0, 0, 0}, {0.4, 0.2, 0.1}), 0.1, 0.7},
               {octahedron(1.0), 0.4, 0.1},
               {prism(7, 0.5, 1.0), 0.25, 0.1},
               {from_vertices({{0, 0, 0}, {1, 0, 0}, {0.2, 0.9, 0.1}, {0.3, 0.2, 0.8}}, "tet"), 0.3, 0.2},
               // voussoir: brick topology, not a box
               {from_vertices({{0, 1, 0},
                               {0, 1.2, 0},
                               {0.5, 0.9, 0},
                               {0.6, 1.08, 0},
                               {0, 1, 1},
                               {0, 1.2, 1},
                               {0.5, 0.9, 1},
                               {0.6, 1.08, 1}},
                              "v"),
                0.2, 0.2}};
  for (const auto& c : cases) {
    const Zoning z = make_zones(c.shape, c.edge, "block");
    double volume = 0.0;
    for (const auto& t : z.zones) {
      const double v =
          dot(z.nodes[t[1]] - z.nodes[t[0]], cross(z.nodes[t[2]] - z.nodes[t[0]], z.nodes[t[3]] - z.nodes[t[0]])) / 6;
      EXPECT_GT(v, 0.0);
      volume += v;
    }
    EXPECT_NEAR(volume, mass_properties(c.shape).volume, 1e-9);
    std::vector<double> covered(c.shape.faces.size(), 0.0);
    for (const auto& t : z.surface) {
      const Vector m = cross(z.nodes[t.node[1]] - z.nodes[t.node[0]], z.nodes[t.node[2]] - z.nodes[t.node[0]]);
      EXPECT_GT(dot(m, c.shape.normals[t.face]), 0.0);
      covered[t.face] += norm(m) / 2;
    }
    for (size_t f = 0; f < covered.size(); ++f) EXPECT_NEAR(covered[f], face_area(c.shape, int(f)), 1e-9);
    EXPECT_LE(z.longest_edge, 2.0 * c.edge);
    EXPECT_GT(z.worst_quality, c.worst_allowed);
    for (size_t i = 0; i < c.shape.vertices.size(); ++i) EXPECT_EQ(norm(z.nodes[i] - c.shape.vertices[i]), 0.0);
  }
  EXPECT_NE(refusal([] { make_zones(box({0, 0, 0}, {1, 1, 1}), -1, "q"); }).find("block q"), std::string::npos);
  EXPECT_NE(refusal([] {
              make_zones(box({0, 0, 0}, {1, 1, 1}), 1e-4, "q");
            }).find("more than 1e+07"),
            std::string::npos);
}

// A stone cut by a plane near a corner has two short edges. Zones are refined by halving the long edges only, so the
// smallest height does not decrease. Halving all edges would halve it.
TEST(Zoning, FinerZonesAreNoFlatterThanShortEdgesMakeThem) {
  std::vector<Vector> stone;
  for (const Vector& p : prism(6, 0.1, 0.2).vertices) stone.push_back(p);
  stone[0] = stone[0] + 0.1 * (stone[1] - stone[0]);
  const ConvexPolyhedron shape = from_vertices(stone, "stone");
  const auto smallest = [&](double edge) {
    const Zoning z = make_zones(shape, edge, "stone");
    double height = 1e300;
    for (const auto& zone : z.zones) height = std::min(height, size_of_zone(z, zone).height);
    return std::pair(height, z.zones.size());
  };
  const auto [coarse, few] = smallest(1.0);
  const auto [fine, many] = smallest(0.1);
  EXPECT_GT(many, few);
  EXPECT_GT(fine, 0.75 * coarse);
}

// Neighbours with independent zoning have common gridpoints and triangles on the face between them. Here they are two
// halves of a prism, cut by an inclined plane.
TEST(Zoning, NeighboursShareTheTrianglesOfTheirFace) {
  std::vector<Vector> lower, upper;
  for (int k = 0; k < 7; ++k) {
    const double a = 2 * std::numbers::pi * k / 7, x = 0.3 * std::cos(a), z = 0.3 * std::sin(a), cut = 0.4 + 0.3 * x;
    lower.insert(lower.end(), {{x, 0, z}, {x, cut, z}});
    upper.insert(upper.end(), {{x, 1, z}, {x, cut, z}});
  }
  using Place = std::array<long, 3>;
  const auto triangles = [](const std::vector<Vector>& corners) {
    const Zoning z = make_zones(from_vertices(corners, "half"), 0.1, "half");
    std::set<std::set<Place>> found;
    for (const auto& t : z.surface) {
      std::set<Place> places;
      bool on_cut = true;
      for (int n : t.node) {
        const Vector& p = z.nodes[size_t(n)];
        on_cut &= std::abs(p.y - 0.4 - 0.3 * p.x) < 1e-9;
        places.insert({std::lround(p.x * 1e8), std::lround(p.y * 1e8), std::lround(p.z * 1e8)});
      }
      if (on_cut) found.insert(places);
    }
    return found;
  };
  const auto of_lower = triangles(lower);
  EXPECT_GT(of_lower.size(), 14u);
  EXPECT_EQ(of_lower, triangles(upper));
}

// Patch test: under a uniform stress an inner gridpoint is in equilibrium. A gridpoint of the surface has a third of
// the traction on each of its triangles, to rounding.
TEST(Zoning, UniformStressIsInBalance) {
  const Matrix stress{{{2.0, -0.3, 0.5}, {-0.3, 1.0, 0.7}, {0.5, 0.7, -1.5}}};
  for (const double edge : {0.5, 0.12, 0.05}) {
    const Zoning z = make_zones(from_vertices({{0, 0, 0},
                                               {0.3, 0, 0.02},
                                               {0.32, 0.02, 0.3},
                                               {0, 0.01, 0.25},
                                               {0.1, 0.3, 0.1},
                                               {0.25, 0.28, 0.2},
                                               {0.02, 0.2, 0.22}},
                                              "stone"),
                                edge, "stone");
    std::vector<Vector> force(z.nodes.size());
    for (const auto& t : z.zones) {
      for (int k = 0; k < 4; ++k) {  // V grad N is minus a third of the area of the side across
        const Vector &p = z.nodes[size_t(t[size_t(k)])], &a = z.nodes[size_t(t[size_t((k + 1) % 4)])],
                     &b = z.nodes[size_t(t[size_t((k + 2) % 4)])], &c = z.nodes[size_t(t[size_t((k + 3) % 4)])];
        Vector twice = cross(b - a, c - a);
        if (dot(twice, p - a) < 0) twice = -twice;
        force[size_t(t[size_t(k)])] += stress * (1.0 / 6 * twice);
      }
    }
    for (const auto& t : z.surface) {
      const Vector twice = cross(z.nodes[size_t(t.node[1])] - z.nodes[size_t(t.node[0])],
                                 z.nodes[size_t(t.node[2])] - z.nodes[size_t(t.node[0])]);
      for (const int n : t.node) force[size_t(n)] -= stress * (1.0 / 6 * twice);
    }
    for (const Vector& f : force) EXPECT_LT(norm(f), 1e-15);
  }
}

TEST(Zoning, TheSizeOfAZoneIsItsSmallest) {
  Zoning z;
  z.nodes = {{0, 0, 0}, {4, 0, 0}, {0, 3, 0}, {0, 0, 2}};
  const ZoneSize size = size_of_zone(z, {0, 1, 2, 3});
  // From the origin to the plane x/4 + y/3 + z/2 = 1.
  EXPECT_NEAR(size.height, 1 / std::sqrt(1 / 16.0 + 1 / 9.0 + 1 / 4.0), 1e-12);
  EXPECT_EQ(size.shortest_edge, 2.0);
}

TEST(MeshFile, OffObjAndStl) {
  const Scratch scratch;
  const ConvexPolyhedron b = box({0, 0, 0}, {2, 1, 1});
  {
    std::ofstream off(scratch.path("b.off"));
    off << "OFF\n# a box\n8 6 0\n";
    for (const Vector& p : b.vertices) off << p.x << ' ' << p.y << ' ' << p.z << '\n';
    for (const auto& f : b.faces) off << "4 " << f[0] << ' ' << f[1] << ' ' << f[2] << ' ' << f[3] << '\n';
    std::ofstream(scratch.path("b.obj")) << to_obj({{"first", b}, {"second", box({5, 0, 0}, {1, 1, 1})}});
    std::ofstream stl(scratch.path("b.stl"));
    stl << "solid brick\n";
    std::string binary(84, ' ');
    uint32_t count = 0;
    for (const auto& f : b.faces) {
      for (int i = 1; i < 3; ++i) {
        stl << "facet normal 0 0 0\nouter loop\n";
        float record[12] = {};
        int k = 3;
        for (int c : {f[0], f[i], f[i + 1]}) {
          const Vector& p = b.vertices[c];
          stl << "vertex " << p.x << ' ' << p.y << ' ' << p.z << '\n';
          for (int a = 0; a < 3; ++a) record[k++] = float(p[a]);
        }
        stl << "endloop\nendfacet\n";
        binary.append(reinterpret_cast<const char*>(record), 48).append(2, '\0');
        ++count;
      }
    }
    stl << "endsolid brick\n";
    std::memcpy(binary.data() + 80, &count, 4);
    scratch.file("binary.stl", binary);
  }
  for (const char* file : {"b.off", "b.obj", "b.stl", "binary.stl"}) {
    const auto shapes = read_mesh_file(scratch.path(file), 0.001);
    ASSERT_FALSE(shapes.empty()) << file;
    EXPECT_EQ(shapes[0].shape.faces.size(), 6u) << file;
    EXPECT_NEAR(mass_properties(shapes[0].shape).volume, 2e-9, 1e-18) << file;
  }
  EXPECT_EQ(read_mesh_file(scratch.path("b.obj")).size(), 2u);
  EXPECT_EQ(read_mesh_file(scratch.path("b.obj"))[1].name, "second");
  scratch.file("bad.off", "OFF\n4 4 0\n0 0 0\n1 0 x\n");
  EXPECT_NE(refusal([&] { read_mesh_file(scratch.path("bad.off")); }).find("bad.off:4: 'x' is not a number"),
            std::string::npos);
  EXPECT_NE(refusal([&] { read_mesh_file(scratch.path("none.ply")); }).find("unknown kind of mesh file"),
            std::string::npos);
}

// Points within faces and edges, as on the surface of a mesh, are not corners, for any order.
TEST(Polyhedron, PointsOnItsFacesAreNoCorners) {
  std::mt19937 random(5);
  const Matrix turned = matrix(rotation({0.3, -0.7, 0.4}));
  for (int n = 2; n <= 12; n += 5) {
    std::vector<Vector> points;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        for (int k = 0; k <= n; ++k) {
          if (i % n == 0 || j % n == 0 || k % n == 0)
            points.push_back(turned * Vector{double(i) / n, 0.5 * j / n, 2.0 * k / n});
        }
      }
    }
    for (int order = 0; order < 5; ++order) {
      std::shuffle(points.begin(), points.end(), random);
      const ConvexPolyhedron box = from_vertices(points, "grid");
      EXPECT_EQ(box.vertices.size(), 8u) << n;
      EXPECT_EQ(box.edges.size(), 12u) << n;
      EXPECT_NEAR(mass_properties(box).volume, 1.0, 1e-12);
    }
  }
}

// A cube without a corner, of sizes down to five times the tolerance: V = 1 - e^3/6.
TEST(Polyhedron, SmallFacesAreFaces) {
  for (const double e : {0.3, 1e-2, 1e-3, 1e-4, 1e-5, 5e-6}) {
    std::vector<Vector> points;
    for (int i = 1; i < 8; ++i) points.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2)});
    points.insert(points.end(), {{e, 0, 0}, {0, e, 0}, {0, 0, e}});
    const ConvexPolyhedron cut = from_vertices(points, "cut");
    EXPECT_EQ(cut.vertices.size(), 10u) << e;
    EXPECT_EQ(cut.faces.size(), 7u) << e;
    EXPECT_NEAR(mass_properties(cut).volume, 1.0 - e * e * e / 6, 1e-12) << e;
  }
}

// A zoning by make_zones, with gridpoints in another order, is accepted unchanged.
TEST(Tetrahedra, MadeElsewhereAreTheZonesOfTheBodyThatTheyFill) {
  const Zoning ours = make_zones(prism(5, 0.3, 1.0), 0.2, "prism");
  const auto count = int(ours.nodes.size());
  std::vector<Vector> points(ours.nodes.rbegin(), ours.nodes.rend());
  std::vector<std::array<int, 4>> tetrahedra = ours.zones;
  for (auto& t : tetrahedra) {
    for (int& n : t) n = count - 1 - n;
  }
  const ZonedShape made = from_tetrahedra(points, tetrahedra, "prism");
  EXPECT_EQ(made.shape.vertices.size(), 10u);
  EXPECT_EQ(made.shape.faces.size(), 7u);
  EXPECT_EQ(made.zoning.nodes.size(), ours.nodes.size());
  EXPECT_EQ(made.zoning.zones.size(), ours.zones.size());
  EXPECT_EQ(made.zoning.surface.size(), ours.surface.size());
  EXPECT_DOUBLE_EQ(made.zoning.worst_quality, ours.worst_quality);
  for (size_t i = 0; i < 10; ++i) EXPECT_EQ(norm(made.zoning.nodes[i] - made.shape.vertices[i]), 0.0);
  for (size_t z = 0; z < tetrahedra.size(); ++z) {
    for (size_t k = 0; k < 4; ++k)
      EXPECT_EQ(norm(made.zoning.nodes[size_t(made.zoning.zones[z][k])] - points[size_t(tetrahedra[z][k])]), 0.0);
  }
  for (const auto& t : made.zoning.surface) {  // each is on its face, counter-clockwise from outside
    const Vector &a = made.zoning.nodes[size_t(t.node[0])], &b = made.zoning.nodes[size_t(t.node[1])],
                 &c = made.zoning.nodes[size_t(t.node[2])];
    EXPECT_GT(dot(cross(b - a, c - a), made.shape.normals[size_t(t.face)]), 0.0);
  }
}

TEST(Tetrahedra, WhatIsNoBodyIsToldWithItsPlace) {
  const Zoning cube = make_zones(box({0, 0, 0}, {1, 1, 1}), 0.5, "cube");
  const auto without = [&](const auto& change) {
    std::vector<Vector> points = cube.nodes;
    std::vector<std::array<int, 4>> tetrahedra = cube.zones;
    change(points, tetrahedra);
    return refusal([&] { from_tetrahedra(points, tetrahedra, "cube"); });
  };
  using Points = std::vector<Vector>;
  using Fours = std::vector<std::array<int, 4>>;
  EXPECT_EQ(without([](Points&, Fours&) {}), "not refused");
  EXPECT_THAT(without([](Points&, Fours& t) { t[3][2] = 99; }),
              testing::HasSubstr("tetrahedron 3 names vertex 99; there are vertices 0 to 26"));
  EXPECT_THAT(without([](Points&, Fours& t) { std::swap(t[3][2], t[3][1]); }),
              testing::HasSubstr("tetrahedron 3 near (0, 0.5, 0.5) m is inverted (-0.0208 m3): swap"))
      << "a corner of a cube of 0.5 m: 0.5^3 / 6";
  EXPECT_THAT(without([](Points&, Fours& t) { t[3][2] = t[3][1]; }),
              testing::HasSubstr("tetrahedron 3 near (0, 0.5, 0.5) m is flat: 0 m3 with an edge of 0.707 m; mesh"));
  EXPECT_THAT(without([](Points& p, Fours&) {
                p.push_back({0.5, 0.1, 0.1});
              }),
              testing::HasSubstr("vertex 27 at (0.5, 0.1, 0.1) m belongs to no tetrahedron"));
  EXPECT_THAT(without([](Points&, Fours& t) { t.push_back(t[0]); }),
              testing::HasSubstr("tetrahedra 0 and 40 overlap: both lie on the same side of the triangle near (0"));
  EXPECT_THAT(without([](Points&, Fours& t) { t.erase(t.begin() + 4); }),
              testing::HasSubstr("alone lies inside the hull"));
  // Two separate cubes, and one with a duplicate gridpoint.
  EXPECT_THAT(without([](Points& p, Fours& t) {
                const auto n = int(p.size());
                const Fours all = t;
                for (int i = 0; i < n; ++i) p.push_back(p[size_t(i)] + Vector{3, 0, 0});
                for (auto z : all) t.push_back({z[0] + n, z[1] + n, z[2] + n, z[3] + n});
              }),
              testing::HasSubstr("not convex"));
  EXPECT_THAT(without([](Points& p, Fours& t) {
                p.push_back(p[size_t(t[4][0])]);
                t[4][0] = int(p.size()) - 1;
              }),
              testing::HasSubstr("alone lies inside the hull"));
  EXPECT_THAT(without([](Points& p, Fours&) { p[4].y = std::nan(""); }),
              testing::HasSubstr("vertex 4 is not a number"));
}

// Bricks turned at random, with corners rounded to `step` as text files have them.
TEST(UnitedFaces, RoundedBricksHaveSixPlanarFaces) {
  constexpr double kStep = 1e-5;
  const Vector size{0.22, 0.0625, 0.11};
  const double volume = size.x * size.y * size.z, area = 2 * (size.x * size.y + size.y * size.z + size.z * size.x);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-3.0, 3.0);
  int divided = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Matrix turn = matrix(rotation({any(random), any(random), any(random)}));
    const Vector origin{any(random), any(random), any(random)};
    std::vector<Vector> corners;
    for (int i = 0; i < 8; ++i) {
      const Vector p = origin + turn * Vector{i & 1 ? size.x : 0.0, i & 2 ? size.y : 0.0, i & 4 ? size.z : 0.0};
      corners.push_back(
          {kStep * std::round(p.x / kStep), kStep * std::round(p.y / kStep), kStep * std::round(p.z / kStep)});
    }
    ConvexPolyhedron brick = from_vertices(corners, "brick");
    divided += brick.faces.size() > 6;
    const double moved = unite_faces(brick, 2 * kStep);
    ASSERT_GE(moved, 0.0);
    ASSERT_EQ(brick.faces.size(), 6u);
    EXPECT_TRUE(fault_of_faces(brick.vertices, brick.faces).empty());
    // Corners are off by half a step along each axis, faces by no more; they move by as much again.
    EXPECT_LT(moved, std::sqrt(3.0) * kStep);
    EXPECT_NEAR(mass_properties(brick).volume, volume, area * std::sqrt(3.0) / 2 * kStep);
  }
  EXPECT_GT(divided, 100) << "without the rule triangles are left";
}

TEST(UnitedFaces, ExactShapesAreLeftAsTheyAre) {
  for (ConvexPolyhedron shape : {octahedron(1.0), prism(7, 0.3, 1.0), box({0, 0, 0}, {0.3, 0.1, 0.2})}) {
    const ConvexPolyhedron before = shape;
    EXPECT_EQ(unite_faces(shape, 1e-4 * least_extent(shape)), 0.0);
    EXPECT_EQ(shape.faces, before.faces);
    for (size_t i = 0; i < before.vertices.size(); ++i) EXPECT_EQ(norm(shape.vertices[i] - before.vertices[i]), 0.0);
  }
}

// A bevel of a prism stays where it is wider than the tolerance: the sagitta of two facets of 64 is r (1 - cos(2
// pi/64)).
TEST(UnitedFaces, FacetsOfARoundShapeStay) {
  ConvexPolyhedron drum = prism(64, 0.5, 0.5);
  const double sagitta = 0.5 * (1 - std::cos(2 * std::numbers::pi / 64));
  EXPECT_EQ(unite_faces(drum, 0.1 * sagitta), 0.0);
  EXPECT_EQ(drum.faces.size(), 66u);
}

// A bevel at 45 degrees is meant, though it is hardly wider than the tolerance. The side beside it was tilted.
TEST(UnitedFaces, ABevelStays) {
  constexpr double kBevel = 1.5e-4, kTop = 1.0 - kBevel;
  ConvexPolyhedron cube = from_vertices({{0, 0, 0},
                                         {1, 0, 0},
                                         {0, 0, 1},
                                         {1, 0, 1},
                                         {0, kTop, 0},
                                         {0, kTop, 1},
                                         {kBevel, 1, 0},
                                         {kBevel, 1, 1},
                                         {1, 1, 0},
                                         {1, 1, 1}},
                                        "cube");
  ASSERT_EQ(cube.faces.size(), 7u);
  EXPECT_EQ(unite_faces(cube, 1e-4), 0.0);
  EXPECT_EQ(cube.faces.size(), 7u);
}

// Prisms of many sides, turned at random, 5e5 m from the origin, where coordinates have 6e-11 m.
TEST(FromVertices, PrismsFarFromTheOriginClose) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-3.0, 3.0);
  for (int trial = 0; trial < 100; ++trial) {
    const Matrix turn = matrix(rotation({any(random), any(random), any(random)}));
    const int sides = 5 + trial % 20;
    std::vector<Vector> corners;
    for (const Vector& p : prism(sides, 0.5, 1.0).vertices) corners.push_back(Vector{4e5, -3e5, 2e5} + turn * p);
    const ConvexPolyhedron shape = from_vertices(corners, "prism");
    EXPECT_EQ(shape.faces.size(), size_t(sides + 2));
    // Rounding of coordinates over the surface of less than 10 m2.
    EXPECT_NEAR(mass_properties(shape).volume, 0.125 * sides * std::sin(2 * std::numbers::pi / sides), 1e-9);
  }
}

}  // namespace
}  // namespace quoin::geometry
