#include "analysis/modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <random>

#include "base/error.h"

namespace quoin {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using geometry::Vector;

constexpr double kTwoPi = 2.0 * std::numbers::pi;
// Largest numbers of unknowns for a full eigenvalue solution: for a few modes, and for a third of all modes.
constexpr Index kFew = 300, kFewForMany = 3000;
// Share of the largest eigenvalue below which an eigenvalue counts as 0.
constexpr double kZero = 1e-13;
// Shift over the largest ratio of stiffness to mass. It makes the matrix of free motion positive definite.
constexpr double kShift = 1e-10;

[[noreturn]] void refuse_unstable() {
  throw Error(Exit::numerical,
              "modes: the state is not stable: a motion of it grows by itself, and has no frequency; a run that is "
              "disturbed a little shows it");
}

struct Eigenpairs {
  VectorXd value;   // omega^2, 1/s2, ascending
  MatrixXd vector;  // in unknowns times the square root of mass, orthonormal
  double entries = 0.0;
};

// K scaled by the inverse roots of mass, lower triangle.
Eigen::SparseMatrix<double> scaled_stiffness(const Vibrating& v, const VectorXd& over_root) {
  Eigen::SparseMatrix<double> scaled = v.stiffness;
  for (Index column = 0; column < scaled.cols(); ++column) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(scaled, column); entry; ++entry)
      entry.valueRef() *= over_root(entry.row()) * over_root(column);
  }
  return scaled;
}

Eigenpairs all_of(const Eigen::SparseMatrix<double>& scaled, Index count) {
  const MatrixXd full = scaled;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(full);  // reads the lower triangle
  count = std::min(count, full.rows());
  return {eigen.eigenvalues().head(count), eigen.eigenvectors().leftCols(count)};
}

// Makes the columns of a block orthonormal, and orthogonal to `basis`; returns their coefficients. Two passes suffice.
MatrixXd orthonormalize(const Eigen::Ref<const MatrixXd>& basis, MatrixXd* block) {
  for (int pass = 0; pass < 2 && basis.cols() > 0; ++pass) {
    const MatrixXd inside = basis.transpose() * *block;
    block->noalias() -= basis * inside;
  }
  const Eigen::HouseholderQR<MatrixXd> qr(*block);
  const MatrixXd r = qr.matrixQR().topRows(block->cols()).triangularView<Eigen::Upper>();
  *block = qr.householderQ() * MatrixXd::Identity(block->rows(), block->cols());
  return r;
}

// Block Lanczos method with full orthogonalisation, on (K + shift)^-1. Blocks find equal frequencies, and read the
// factor once for all their columns.
Eigenpairs lowest_of(const Eigen::SparseMatrix<double>& scaled, const UnknownGroups& groups, double shift,
                     Index count) {
  constexpr Index kBlock = 6;  // the six rigid motions of one loose body
  // Walls take up to three vectors a mode.
  const Index most_blocks = std::max<Index>(60, 4 * count / kBlock);
  // Residual over the eigenvalue: the error of frequencies is its square.
  constexpr double kSettled = 1e-7;
  const Index n = scaled.rows();
  Eigen::SparseMatrix<double> shifted = scaled;
  for (Index i = 0; i < n; ++i) shifted.coeffRef(i, i) += shift;
  std::optional<SparseCholesky> factor;
  try {
    factor.emplace(shifted, groups);
  } catch (const Error& error) {
    if (error.exit_code == Exit::numerical) refuse_unstable();
    throw;
  }

  std::mt19937_64 random(1);  // fixed seed
  MatrixXd next(n, kBlock);
  for (Index c = 0; c < kBlock; ++c)
    for (Index i = 0; i < n; ++i) next(i, c) = static_cast<double>(random() >> 11) / 9007199254740992.0 - 0.5;
  MatrixXd basis(n, 0);
  orthonormalize(basis, &next);
  MatrixXd projected(0, 0);
  Index next_check = count + kBlock;
  for (Index k = 1; k <= most_blocks; ++k) {
    const Index before = basis.cols();
    basis.conservativeResize(Eigen::NoChange, before + kBlock);
    basis.rightCols(kBlock) = next;
    factor->solve(next);
    projected.conservativeResize(before + kBlock, before + kBlock);
    const MatrixXd column = basis.transpose() * next;
    projected.rightCols(kBlock) = column;
    projected.bottomRows(kBlock) = column.transpose();
    const MatrixXd rest = orthonormalize(basis, &next);
    if (projected.rows() < next_check) continue;
    next_check = projected.rows() + projected.rows() / 10;  // a check costs the cube of the rows
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(projected);
    bool settled = true;
    for (Index i = 0; settled && i < count; ++i) {
      const Index at = projected.rows() - 1 - i;
      const double residual = (rest * eigen.eigenvectors().col(at).tail(kBlock)).norm();
      settled = residual <= kSettled * eigen.eigenvalues()(at);
    }
    if (!settled) continue;
    Eigenpairs pairs{VectorXd(count), MatrixXd(n, count), factor->entries()};
    for (Index i = 0; i < count; ++i) {
      const Index at = projected.rows() - 1 - i;
      pairs.value(i) = 1.0 / eigen.eigenvalues()(at) - shift;
      pairs.vector.col(i).noalias() = basis * eigen.eigenvectors().col(at);
    }
    return pairs;
  }
  throw Error(Exit::numerical,
              fmt::format("modes: not settled after {} vectors; give fewer modes (--count)", most_blocks * kBlock));
}

void require(const ModesSettings& s) {
  if (s.count < 1) throw Error(Exit::bad_input, fmt::format("modes: {} modes; allowed: 1 or more", s.count));
  for (const double ratio : s.ratios) {
    if (!(ratio >= 0.0 && ratio < 1.0))
      throw Error(Exit::bad_input, fmt::format("modes: a damping ratio of {}; allowed: 0 to below 1", ratio));
  }
  for (const double f : s.at_frequencies) {
    if (!(f >= 0.0) || !std::isfinite(f))
      throw Error(Exit::bad_input, fmt::format("modes: damping at {} Hz; allowed: above 0", f));
  }
  if ((s.at_frequencies[0] == 0.0) != (s.at_frequencies[1] == 0.0))
    throw Error(Exit::bad_input,
                fmt::format("modes: damping at {} and {} Hz; allowed: above 0; leave both out for those "
                            "of the first and last mode",
                            s.at_frequencies[0], s.at_frequencies[1]));
}

// Blocks that move noticeably in the modes without stiffness.
std::vector<int> loose_blocks(const Vibrating& v, const MatrixXd& shapes) {
  constexpr double kTrace = 1e-6;  // share of the largest displacement, squared
  std::vector<double> motion(v.drawn.size(), 0.0);
  for (Index mode = 0; mode < shapes.cols(); ++mode) {
    for (Index i = 0; i < shapes.rows(); ++i)
      motion[static_cast<std::size_t>(v.unknown[static_cast<std::size_t>(i)].block)] +=
          v.mass[static_cast<std::size_t>(i)] * shapes(i, mode) * shapes(i, mode);
  }
  const double most = *std::max_element(motion.begin(), motion.end());
  std::vector<int> loose;
  for (std::size_t b = 0; b < motion.size(); ++b) {
    if (motion[b] > kTrace * most) loose.push_back(static_cast<int>(b));
  }
  return loose;
}

// Scales shapes to a largest displacement of 1, and computes participation factors and effective masses.
void finish(const Vibrating& v, Modes* modes) {
  for (std::size_t m = 0; m < modes->mode.size(); ++m) {
    auto column = modes->shape.col(static_cast<Index>(m));
    double largest = 0.0;
    for (std::size_t b = 0; b < v.drawn.size(); ++b) {
      for (const Vector& u : shape_of_block(v, *modes, static_cast<int>(b), static_cast<int>(m)))
        largest = std::max(largest, norm(u));
    }
    if (largest > 0.0) column /= largest;
    double generalized = 0.0;
    std::array<double, 3> excited{};
    for (Index i = 0; i < column.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      generalized += v.mass[k] * column(i) * column(i);
      for (int c = 0; c < 3; ++c)
        excited[static_cast<std::size_t>(c)] += v.mass[k] * column(i) * v.unknown[k].translation[c];
    }
    Mode& mode = modes->mode[m];
    if (v.symmetry_factor != 1.0) excited[2] = 0.0;  // the other half moves against it along z
    for (std::size_t c = 0; c < 3; ++c) {
      mode.participation[c] = excited[c] / generalized;
      mode.effective_mass[c] = v.symmetry_factor * excited[c] * excited[c] / generalized;
    }
  }
}

}  // namespace

Rayleigh rayleigh(const std::array<double, 2>& frequencies, const std::array<double, 2>& ratios) {
  Rayleigh r{0.0, 0.0, frequencies, ratios};
  const double low = kTwoPi * frequencies[0], high = kTwoPi * frequencies[1];
  if (!(low > 0.0 && high > 0.0)) return r;
  if (std::abs(high - low) <= 1e-9 * low) {  // one frequency: each term gives half of its damping
    if (ratios[0] != ratios[1])
      throw Error(Exit::bad_input, fmt::format("modes: damping ratios of {:g} and {:g}, both at {:.4g} Hz; give one "
                                               "ratio twice, or two frequencies",
                                               ratios[0], ratios[1], frequencies[0]));
    r.mass_damping = ratios[0] * low, r.stiffness_damping = ratios[0] / low;
    return r;
  }
  const double over = 2.0 / (high * high - low * low);
  r.mass_damping = over * low * high * (ratios[0] * high - ratios[1] * low);
  r.stiffness_damping = over * (ratios[1] * high - ratios[0] * low);
  // Ratios of the two terms are proportional to 1/f and to f, so their sum cannot change faster.
  if (r.mass_damping < 0.0 || r.stiffness_damping < 0.0) {
    const double apart = std::max(frequencies[0], frequencies[1]) / std::min(frequencies[0], frequencies[1]);
    throw Error(
        Exit::bad_input,
        fmt::format("modes: damping ratios of {:g} at {:.4g} Hz and {:g} at {:.4g} Hz need alpha = {:.4g} 1/s "
                    "and beta = {:.4g} s, of which none may be negative: the ratios may differ by a factor of "
                    "{:.4g} at most, as the frequencies do",
                    ratios[0], frequencies[0], ratios[1], frequencies[1], r.mass_damping, r.stiffness_damping, apart));
  }
  return r;
}

std::vector<Vector> shape_of_block(const Vibrating& v, const Modes& modes, int block, int mode) {
  // Unknowns of a block are consecutive.
  const auto [first, end] = std::equal_range(v.unknown.begin(), v.unknown.end(), Unknown{block},
                                             [](const Unknown& a, const Unknown& b) { return a.block < b.block; });
  const std::vector<Vector>& points = v.drawn[static_cast<std::size_t>(block)].point;
  std::vector<Vector> shape(points.size());
  for (auto u = first; u != end; ++u) {
    const double amplitude = modes.shape(static_cast<Index>(u - v.unknown.begin()), mode);
    if (u->gridpoint >= 0) {
      shape[static_cast<std::size_t>(u->gridpoint)] += amplitude * u->translation;
      continue;
    }
    for (std::size_t p = 0; p < points.size(); ++p) shape[p] += amplitude * u->at(points[p]);
  }
  return shape;
}

std::vector<std::vector<std::vector<std::array<double, 3>>>> shapes_of(const Vibrating& v, const Modes& modes) {
  std::vector<std::vector<std::vector<std::array<double, 3>>>> shapes(modes.mode.size());
  for (std::size_t m = 0; m < shapes.size(); ++m) {
    for (std::size_t b = 0; b < v.drawn.size(); ++b) {
      auto& rows = shapes[m].emplace_back();
      for (const Vector& u : shape_of_block(v, modes, static_cast<int>(b), static_cast<int>(m)))
        rows.push_back(array(u));
    }
  }
  return shapes;
}

Modes find_modes(const Vibrating& v, const ModesSettings& settings) {
  require(settings);
  const auto n = static_cast<Index>(v.unknown.size());
  VectorXd over_root(n);
  for (Index i = 0; i < n; ++i) over_root(i) = 1.0 / std::sqrt(v.mass[static_cast<std::size_t>(i)]);
  const Eigen::SparseMatrix<double> scaled = scaled_stiffness(v, over_root);
  const double stiffest = scaled.diagonal().maxCoeff();
  if (!std::isfinite(stiffest)) throw Error(Exit::bad_input, "modes: a stiffness or mass is not a finite number");
  const double shift = stiffest > 0.0 ? kShift * stiffest : 1.0;
  const bool many = Index{3} * settings.count > n;
  if (many && n > kFewForMany)
    throw Error(Exit::bad_input, fmt::format("modes: {} modes of a model with {} unknowns; allowed: up to a third, {}",
                                             settings.count, n, n / 3));
  const bool in_full = n <= kFew || many;
  Eigenpairs pairs = in_full ? all_of(scaled, settings.count) : lowest_of(scaled, v.groups, shift, settings.count);
  if (pairs.value(0) < -shift) refuse_unstable();

  Modes modes;
  modes.factor_entries = pairs.entries;
  modes.shape = over_root.asDiagonal() * pairs.vector;
  for (Index i = 0; i < pairs.value.size(); ++i) {
    const bool is_zero = pairs.value(i) <= kZero * stiffest;
    modes.zero += is_zero ? 1 : 0;
    modes.mode.push_back({is_zero ? 0.0 : std::sqrt(pairs.value(i)) / kTwoPi});
  }
  if (modes.zero > 0) modes.loose = loose_blocks(v, modes.shape.leftCols(modes.zero));
  finish(v, &modes);
  for (int c = 0; c < 3; ++c) modes.free_mass[static_cast<std::size_t>(c)] = v.free_mass(c);
  std::array<double, 2> at = settings.at_frequencies;
  if (static_cast<std::size_t>(modes.zero) < modes.mode.size()) {
    if (at[0] == 0.0) at[0] = modes.mode[static_cast<std::size_t>(modes.zero)].frequency;
    if (at[1] == 0.0) at[1] = modes.mode.back().frequency;
  }
  modes.rayleigh = rayleigh(at, settings.ratios);
  return modes;
}

nlohmann::ordered_json json_of(const std::string& scene, const Vibrating& v, const Modes& modes) {
  nlohmann::ordered_json json;
  json["scene"] = scene;
  for (const char* key : {"frequencies_Hz", "periods_s", "participation", "effective_mass_kg", "effective_mass_ratio"})
    json[key] = nlohmann::ordered_json::array();
  std::array<double, 3> sum{};
  for (const Mode& mode : modes.mode) {
    json["frequencies_Hz"].push_back(mode.frequency);
    if (mode.frequency > 0.0)
      json["periods_s"].push_back(1.0 / mode.frequency);
    else
      json["periods_s"].push_back(nullptr);
    json["participation"].push_back(mode.participation);
    json["effective_mass_kg"].push_back(mode.effective_mass);
    std::array<double, 3> ratio{};
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c] += mode.effective_mass[c];
      ratio[c] = modes.free_mass[c] > 0.0 ? mode.effective_mass[c] / modes.free_mass[c] : 0.0;
    }
    json["effective_mass_ratio"].push_back(ratio);
  }
  json["effective_mass_sum_kg"] = sum, json["free_mass_kg"] = modes.free_mass;
  json["zero_modes"] = modes.zero;
  json["loose_blocks"] = nlohmann::ordered_json::array();
  for (const int b : modes.loose) json["loose_blocks"].push_back(v.label[static_cast<std::size_t>(b)]);
  const Rayleigh& r = modes.rayleigh;
  json["rayleigh"] = {{"ratios", r.ratios},
                      {"frequencies_Hz", r.frequencies},
                      {"alpha_per_s", r.mass_damping},
                      {"beta_s", r.stiffness_damping}};
  json["supports"] = v.held;
  json["state"] = v.state;
  if (v.state != "undamaged") json["open_points"] = v.open;
  json["symmetric_modes_only"] = v.symmetry_factor != 1.0;
  json["blocks"] = v.drawn.size() - v.members, json["zones"] = v.zones, json["contact_points"] = v.points;
  json["degrees_of_freedom"] = v.unknown.size();
  return json;
}

}  // namespace quoin
