// Vectors, matrices and rotations in three dimensions, in plain doubles.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace quoin::geometry {

struct Vector {
  double x = 0.0, y = 0.0, z = 0.0;

  double operator[](int i) const { return i == 0 ? x : (i == 1 ? y : z); }
  double& operator[](int i) { return i == 0 ? x : (i == 1 ? y : z); }
  Vector& operator+=(const Vector& b) { return x += b.x, y += b.y, z += b.z, *this; }
  Vector& operator-=(const Vector& b) { return x -= b.x, y -= b.y, z -= b.z, *this; }
  Vector& operator*=(double f) { return x *= f, y *= f, z *= f, *this; }
};

inline Vector operator+(Vector a, const Vector& b) { return a += b; }
inline Vector operator-(Vector a, const Vector& b) { return a -= b; }
inline Vector operator-(const Vector& a) { return {-a.x, -a.y, -a.z}; }
inline Vector operator*(double f, Vector a) { return a *= f; }
inline Vector operator*(Vector a, double f) { return a *= f; }
inline Vector operator/(const Vector& a, double f) { return {a.x / f, a.y / f, a.z / f}; }
inline double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(const Vector& a) { return std::sqrt(dot(a, a)); }
inline Vector normalized(const Vector& a) { return a / norm(a); }
inline Vector vector(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }
inline std::array<double, 3> array(const Vector& a) { return {a.x, a.y, a.z}; }
inline Vector min(const Vector& a, const Vector& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
inline Vector max(const Vector& a, const Vector& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

// A unit vector normal to the unit vector n; it depends on n alone, bit for bit.
inline Vector any_normal(const Vector& n) {
  const Vector axis = std::abs(n.x) < 0.6 ? Vector{1, 0, 0} : (std::abs(n.y) < 0.6 ? Vector{0, 1, 0} : Vector{0, 0, 1});
  return normalized(axis - dot(axis, n) * n);
}

// Row by row.
struct Matrix {
  Vector row[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

  static Matrix zero() { return {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}}; }
  static Matrix diagonal(const Vector& d) { return {{{d.x, 0, 0}, {0, d.y, 0}, {0, 0, d.z}}}; }
  static Matrix columns(const Vector& a, const Vector& b, const Vector& c) {
    return {{{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}}};
  }
  Vector column(int j) const { return {row[0][j], row[1][j], row[2][j]}; }
  Matrix& operator+=(const Matrix& b) { return row[0] += b.row[0], row[1] += b.row[1], row[2] += b.row[2], *this; }
};

inline Vector operator*(const Matrix& m, const Vector& v) {
  return {dot(m.row[0], v), dot(m.row[1], v), dot(m.row[2], v)};
}
inline Matrix operator*(double f, const Matrix& m) { return {{f * m.row[0], f * m.row[1], f * m.row[2]}}; }
inline Matrix operator+(Matrix a, const Matrix& b) { return a += b; }
inline Matrix operator-(const Matrix& a, const Matrix& b) {
  return {{a.row[0] - b.row[0], a.row[1] - b.row[1], a.row[2] - b.row[2]}};
}
inline Matrix transposed(const Matrix& m) { return {{m.column(0), m.column(1), m.column(2)}}; }
// transposed(m) * v without the transpose.
inline Vector transposed_times(const Matrix& m, const Vector& v) {
  return v.x * m.row[0] + v.y * m.row[1] + v.z * m.row[2];
}
inline Matrix operator*(const Matrix& a, const Matrix& b) {
  return {{transposed_times(b, a.row[0]), transposed_times(b, a.row[1]), transposed_times(b, a.row[2])}};
}
inline Matrix outer(const Vector& a, const Vector& b) { return {{a.x * b, a.y * b, a.z * b}}; }
inline double determinant(const Matrix& m) { return dot(m.row[0], cross(m.row[1], m.row[2])); }
inline double trace(const Matrix& m) { return m.row[0].x + m.row[1].y + m.row[2].z; }
// Angle of the rotation from r0 to r, rad; small angles: the Frobenius norm of r - r0 is sqrt(2) times it.
inline double angle_between(const Matrix& r, const Matrix& r0) {
  const Matrix d = r - r0;
  return std::sqrt(0.5 * (dot(d.row[0], d.row[0]) + dot(d.row[1], d.row[1]) + dot(d.row[2], d.row[2])));
}
inline Matrix inverse(const Matrix& m) {
  const Vector a = cross(m.row[1], m.row[2]), b = cross(m.row[2], m.row[0]), c = cross(m.row[0], m.row[1]);
  return 1.0 / dot(m.row[0], a) * Matrix::columns(a, b, c);
}

// Unit quaternion (w, v): rotation from a block's own frame to space.
struct Quaternion {
  double w = 1.0;
  Vector v;
};

inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - dot(a.v, b.v), a.w * b.v + b.w * a.v + cross(a.v, b.v)};
}
inline Quaternion normalized(const Quaternion& q) {
  const double f = 1.0 / std::sqrt(q.w * q.w + dot(q.v, q.v));
  return {f * q.w, f * q.v};
}
// Rotation by |angle| radians about angle's direction.
inline Quaternion rotation(const Vector& angle) {
  const double half2 = 0.25 * dot(angle, angle);
  // sin(h)/h and cos(h) by series for small angles: exact to rounding there, and far cheaper in the step
  if (half2 < 1e-4) {
    const double sinc = 1.0 - half2 / 6.0 * (1.0 - half2 / 20.0 * (1.0 - half2 / 42.0));
    return {1.0 - half2 / 2.0 * (1.0 - half2 / 12.0 * (1.0 - half2 / 30.0)), (0.5 * sinc) * angle};
  }
  const double half = std::sqrt(half2);
  return {std::cos(half), (0.5 * std::sin(half) / half) * angle};
}
inline Matrix matrix(const Quaternion& q) {
  const double x = q.v.x, y = q.v.y, z = q.v.z, w = q.w;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}
// The quaternion of a proper rotation matrix.
inline Quaternion quaternion(const Matrix& m) {
  const double t = trace(m);
  Quaternion q;
  if (t > 0) {
    q = {1 + t, {m.row[2].y - m.row[1].z, m.row[0].z - m.row[2].x, m.row[1].x - m.row[0].y}};
  } else {
    const int i = m.row[0].x > m.row[1].y ? (m.row[0].x > m.row[2].z ? 0 : 2) : (m.row[1].y > m.row[2].z ? 1 : 2);
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    q.w = m.row[k][j] - m.row[j][k];
    q.v[i] = 1 + m.row[i][i] - m.row[j][j] - m.row[k][k];
    q.v[j] = m.row[i][j] + m.row[j][i];
    q.v[k] = m.row[i][k] + m.row[k][i];
  }
  return normalized(q);
}

// Eigenvalues (ascending) and eigenvectors (columns of a proper rotation) of a symmetric matrix, by Jacobi rotations.
struct Eigen3 {
  Vector values;
  Matrix vectors;
};
inline Eigen3 symmetric_eigen(Matrix m) {
  Matrix v;
  for (int sweep = 0; sweep < 30; ++sweep) {
    const double off = std::abs(m.row[0].y) + std::abs(m.row[0].z) + std::abs(m.row[1].z);
    if (off <= 1e-17 * (std::abs(m.row[0].x) + std::abs(m.row[1].y) + std::abs(m.row[2].z))) break;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (m.row[p][q] == 0.0) continue;
        const double theta = (m.row[q][q] - m.row[p][p]) / (2 * m.row[p][q]);
        const double t = (theta >= 0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        Matrix r;
        r.row[p][p] = c, r.row[q][q] = c, r.row[p][q] = s, r.row[q][p] = -s;
        m = transposed(r) * m * r;
        v = v * r;
      }
    }
  }
  Eigen3 e{{m.row[0].x, m.row[1].y, m.row[2].z}, v};
  for (int pass = 0; pass < 2; ++pass) {
    for (int i = 0; i < 2; ++i) {
      if (e.values[i] <= e.values[i + 1]) continue;
      std::swap(e.values[i], e.values[i + 1]);
      for (int k = 0; k < 3; ++k) std::swap(e.vectors.row[k][i], e.vectors.row[k][i + 1]);
    }
  }
  if (determinant(e.vectors) < 0) {
    for (int k = 0; k < 3; ++k) e.vectors.row[k].x = -e.vectors.row[k].x;
  }
  return e;
}

struct Box {
  Vector lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};
  void include(const Vector& p) { lower = min(lower, p), upper = max(upper, p); }
};
inline bool overlap(const Box& a, const Box& b) {
  return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y && b.lower.y <= a.upper.y &&
         a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

}  // namespace quoin::geometry
