#include "members/beam.h"

#include <algorithm>
#include <cmath>

namespace quoin::members {

using geometry::Matrix;

namespace {

// Rotation of a triad relative to a frame, as a vector; pieces are short enough for it to be small.
Vector rotation_in(const Matrix& frame, const Matrix& triad) {
  const Matrix m = transposed(frame) * triad;
  return 0.5 * Vector{m.row[2].y - m.row[1].z, m.row[0].z - m.row[2].x, m.row[1].x - m.row[0].y};
}

}  // namespace

Beam::Beam(std::string name, std::vector<Vector> points, const Vector& up, const Section& section)
    : name_(std::move(name)), section_(section), start_(std::move(points)) {
  const std::size_t n = start_.size();
  x_ = start_, v_.resize(n), frame_.resize(n), turn_.resize(n), spin_.resize(n), force_.resize(n), moment_.resize(n);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    Piece piece;
    piece.length = norm(start_[i + 1] - start_[i]);
    const Vector along = normalized(start_[i + 1] - start_[i]), side = normalized(cross(along, up));
    piece.frame = Matrix::columns(along, cross(side, along), side);
    pieces_.push_back(piece);
  }
}

double Beam::piece_at(int place) const {
  const auto k = static_cast<std::size_t>(place);
  return std::min(pieces_[k > 0 ? k - 1 : 0].length, pieces_[std::min(k, pieces_.size() - 1)].length);
}

double Beam::length() const {
  double sum = 0.0;
  for (const Piece& p : pieces_) sum += p.length;
  return sum;
}

// Points of one block at the ends of arms build a node in.
void Beam::find_clamps(const std::vector<Node>& nodes) {
  clamps_.clear();
  for (std::size_t place = 0; place < x_.size(); ++place) {
    Clamp clamp{place, {}, {}, {}};
    bool of_one = true;
    for (std::size_t i = 0; i < supports_.size(); ++i) {
      if (supports_[i].place != static_cast<int>(place) || norm(supports_[i].arm) == 0.0) continue;
      const auto block_of = [&](std::size_t s) { return nodes[static_cast<std::size_t>(supports_[s].node)].block; };
      of_one = of_one && (clamp.supports.empty() || block_of(i) == block_of(clamp.supports.front()));
      clamp.supports.push_back(i), clamp.off.push_back(supports_[i].arm);
    }
    if (!of_one || clamp.supports.empty()) continue;
    Vector mean;
    for (const Vector& arm : clamp.off) mean += (1.0 / static_cast<double>(clamp.off.size())) * arm;
    Matrix sum = Matrix::zero();
    for (Vector& off : clamp.off) {
      off -= mean;
      sum += dot(off, off) * Matrix{} - outer(off, off);
    }
    clamp.couples = inverse(sum);
    clamps_.push_back(std::move(clamp));
  }
}

// The rotation of the places of least squares: sum off x (R^T (x - mean) - off) = 0. It is conjugate to the couples.
void Beam::turn_frame(const Clamp& clamp, const std::vector<Node>& nodes) {
  const auto place_of = [&](std::size_t i) {
    return nodes[static_cast<std::size_t>(supports_[clamp.supports[i]].node)].x;
  };
  const std::size_t count = clamp.supports.size();
  Vector mean;
  for (std::size_t i = 0; i < count; ++i) mean += (1.0 / static_cast<double>(count)) * place_of(i);
  Matrix& turned = frame_[clamp.place];
  constexpr int kRounds = 2;  // Newton's method from the rotation of the last step
  for (int round = 0; round < kRounds; ++round) {
    Vector sum;
    for (std::size_t i = 0; i < count; ++i)
      sum += cross(clamp.off[i], transposed_times(turned, place_of(i) - mean) - clamp.off[i]);
    turned = turned * matrix(rotation(clamp.couples * sum));
  }
}

// Masses, and rotary inertia with which rotations vibrate no faster than displacements. It follows from row sums of
// magnitudes of the stiffness, which bound eigenvalues. Rotations are scaled by the length of a piece or by the arm of
// a support.
void Beam::find_inertia() {
  const std::size_t n = x_.size();
  std::vector<double> turning(n), arm(n);
  mass_.assign(n, 0.0), inertia_.assign(n, 0.0), row_.assign(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) arm[i] = piece_at(static_cast<int>(i));
  for (const Support& held : supports_) {
    double& longest = arm[static_cast<std::size_t>(held.place)];
    longest = std::max(longest, norm(held.arm));
  }
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const double l = pieces_[i].length, stiff = std::max(section_.bending[0], section_.bending[1]);
    for (const std::size_t k : {i, i + 1}) {
      const double other = std::min(arm[i], arm[i + 1]);
      mass_[k] += 0.5 * section_.mass * l, inertia_[k] += 0.5 * section_.polar * l;
      row_[k] += 2.0 * section_.axial / l + 24.0 * stiff / (l * l * l) + 12.0 * stiff / (l * l * other);
      turning[k] += 12.0 * stiff / (l * l * arm[k]) + 6.0 * stiff / (l * arm[k] * other) +
                    2.0 * section_.torsion / (l * arm[k] * other);
    }
  }
  for (const Clamp& clamp : clamps_) turning[clamp.place] *= 2.0;  // both rotations bend the pieces
  for (const Support& s : supports_) {
    const auto k = static_cast<std::size_t>(s.place);
    const double stiffness = 2.0 * std::max(s.law.normal, s.law.shear), lever = norm(s.arm) / arm[k];
    row_[k] += stiffness * (1.0 + lever), turning[k] += stiffness * lever * (1.0 + lever);
  }
  for (std::size_t k = 0; k < n; ++k) {
    const double share = turning[k] > 0.0 ? turning[k] / row_[k] : 1.0;  // a cable has no rotational stiffness
    inertia_[k] = std::max(inertia_[k], mass_[k] * arm[k] * arm[k] * share);
  }
}

double Beam::own_eigenvalue(double mass_scaling) const {
  Beam other = *this;
  other.find_inertia();
  double largest = 0.0;
  for (std::size_t k = 0; k < other.row_.size(); ++k)
    largest = std::max(largest, other.row_[k] / (mass_scaling * other.mass_[k]));
  return largest;
}

// Moments at both ends from their rotations relative to the chord; hinges rotate until no moment is above yield.
void Beam::bend(Piece& piece, int plane, const std::array<double, 2>& rotation) {
  const auto p = static_cast<std::size_t>(plane);
  const double l = piece.length, ei = section_.bending[p];
  if (ei == 0.0) return;
  const double phi = std::isfinite(section_.shear_area[p]) ? 12.0 * ei / (section_.shear_area[p] * l * l) : 0.0;
  const double same = ei / l * (4.0 + phi) / (1.0 + phi), other = ei / l * (2.0 - phi) / (1.0 + phi);
  double &first = piece.hinge[p][0], &second = piece.hinge[p][1];
  const auto moments = [&] {
    const double a = rotation[0] - first, b = rotation[1] - second;
    return std::array{same * a + other * b, other * a + same * b};
  };
  const double most = section_.yield_moment[p];
  std::array<double, 2> m = moments();
  const std::array<double, 2> before = piece.hinge[p];
  // The ends yield in turn. Since the stiffness is positive, the iteration ends.
  for (int round = 0; round < 50 && (std::abs(m[0]) > most || std::abs(m[1]) > most); ++round) {
    const int end = std::abs(m[0]) >= std::abs(m[1]) ? 0 : 1;
    piece.hinge[p][static_cast<std::size_t>(end)] +=
        (m[static_cast<std::size_t>(end)] - std::copysign(most, m[static_cast<std::size_t>(end)])) / same;
    m = moments();
  }
  piece.moment[p] = m;
  for (std::size_t end = 0; end < 2; ++end) {
    dissipated_ += m[end] * (piece.hinge[p][end] - before[end]);
    stored_ += 0.5 * m[end] * (rotation[end] - piece.hinge[p][end]);
  }
}

void Beam::pull_piece(std::size_t i) {
  Piece& piece = pieces_[i];
  const Vector span = x_[i + 1] - x_[i];
  const double now = norm(span), k = section_.axial / piece.length;
  const double trial = k * (now - piece.length - piece.plastic);
  const bool slack = trial < 0.0 && !section_.compression;
  const double beyond = slack ? 0.0 : std::max(std::abs(trial) - section_.yield_force, 0.0);
  piece.plastic += std::copysign(beyond / k, trial);
  dissipated_ += section_.yield_force < 1e300 ? section_.yield_force * beyond / k : 0.0;
  piece.force = slack ? 0.0 : trial - std::copysign(beyond, trial);
  stored_ += 0.5 * piece.force * piece.force / k;
  const Vector along = span / now, pulling = piece.force * along;
  force_[i] += pulling, force_[i + 1] -= pulling;
  if (section_.bending[0] == 0.0 && section_.bending[1] == 0.0 && section_.torsion == 0.0) return;
  const Matrix first = frame_[i] * turn_[i] * piece.frame, second = frame_[i + 1] * turn_[i + 1] * piece.frame;
  const Vector side = normalized(cross(along, first.column(1) + second.column(1)));
  const Matrix frame = Matrix::columns(along, cross(side, along), side);
  const Vector a = rotation_in(frame, first), b = rotation_in(frame, second);
  largest_turn_ = std::max({largest_turn_, norm(a), norm(b)});
  piece.torque = section_.torsion / piece.length * (b.x - a.x);
  stored_ += 0.5 * piece.torque * (b.x - a.x);
  bend(piece, 0, {a.z, b.z});
  bend(piece, 1, {a.y, b.y});
  // Forces on the piece at its nodes.
  const Vector on_first = frame * Vector{-piece.torque, piece.moment[1][0], piece.moment[0][0]};
  const Vector on_second = frame * Vector{piece.torque, piece.moment[1][1], piece.moment[0][1]};
  const Vector shear = cross(along, on_first + on_second) / now;
  moment_[i] -= on_first, moment_[i + 1] -= on_second;
  force_[i] += shear, force_[i + 1] -= shear;
}

void Beam::pull_support(Support& s, std::vector<Node>& nodes, double dt) {
  const auto k = static_cast<std::size_t>(s.place);
  Node& node = nodes[static_cast<std::size_t>(s.node)];
  const Vector arm = frame_[k] * turn_[k] * s.arm;
  const Vector moved = (node.x - node.start) - (x_[k] + arm - start_[k] - s.arm);
  const double dissipated = s.state.dissipated;
  s.state.follow(s.law, s.out, moved, dt);
  dissipated_ += s.state.dissipated - dissipated, stored_ += s.state.stored;
  node.force += s.state.force;
  force_[k] -= s.state.force, moment_[k] -= cross(arm, s.state.force);
}

const Beam::Support* Beam::slid_off() const {
  for (const Seat& seat : seats_) {
    const Support& support = supports_[seat.support];
    if (norm(support.state.force) == 0.0) continue;
    // The node stands for half a piece to each side on which there is one.
    const auto k = static_cast<std::size_t>(support.place);
    const auto goes_on = [&](const Vector& way) {
      return (k > 0 && dot(start_[k - 1] - start_[k], way) > 0.0) ||
             (k + 1 < start_.size() && dot(start_[k + 1] - start_[k], way) > 0.0);
    };
    for (const ToEdge& edge : seat.edges) {
      const double still_there = goes_on(-edge.out) ? 0.5 * piece_at(support.place) : 0.0;
      if (-dot(support.state.moved, edge.out) > edge.distance + still_there) return &support;
    }
  }
  return nullptr;
}

void Beam::advance(const Surroundings& step) {
  unbalanced_ = 0.0;
  for (std::size_t k = 0; k < x_.size(); ++k) {
    const double mass = step.mass_scaling * mass_[k];
    const Vector weight = mass_[k] * step.gravity, force = force_[k] + weight, before = v_[k];
    unbalanced_ = std::max(unbalanced_, norm(force));
    const Vector moment = transposed_times(frame_[k], moment_[k]);
    Vector turned;
    for (int c = 0; c < 3; ++c) {
      dissipated_ += brake(step, mass, force[c], step.ground_velocity[c], v_[k][c]);
      const double spin = spin_[k][c];
      dissipated_ += brake(step, step.mass_scaling * inertia_[k], moment[c], 0.0, spin_[k][c]);
      const double middle = 0.5 * (spin + spin_[k][c]);
      stored_ += 0.5 * step.mass_scaling * inertia_[k] * middle * middle;
      turned[c] = step.dt * spin_[k][c];
    }
    const Vector middle = 0.5 * (before + v_[k]);
    stored_ += 0.5 * mass * dot(middle, middle);
    outside_ += step.dt * dot(weight, middle);
    x_[k] += step.dt * v_[k];
    turn_[k] = matrix(rotation(turned)) * turn_[k];
  }
}

void Beam::pull(std::vector<Node>& nodes, const Surroundings& step) {
  if (mass_.empty()) find_clamps(nodes), find_inertia();
  const auto node_of = [&](std::size_t support) -> Node& {
    return nodes[static_cast<std::size_t>(supports_[support].node)];
  };
  for (const Clamp& clamp : clamps_) turn_frame(clamp, nodes);
  stored_ = 0.0;
  std::fill(force_.begin(), force_.end(), Vector{});
  std::fill(moment_.begin(), moment_.end(), Vector{});
  for (std::size_t i = 0; i < pieces_.size(); ++i) pull_piece(i);
  for (Support& s : supports_) pull_support(s, nodes, step.dt);
  for (const Clamp& clamp : clamps_) {  // inertia against the block acts on it: a couple of its supports
    const Matrix& turned = frame_[clamp.place];
    const Vector couple = clamp.couples * transposed_times(turned, moment_[clamp.place]);
    for (std::size_t i = 0; i < clamp.supports.size(); ++i)
      node_of(clamp.supports[i]).force += turned * cross(couple, clamp.off[i]);
  }
  advance(step);
}

double Beam::largest_force() const {
  double largest = 0.0;
  for (const Piece& p : pieces_) largest = std::max(largest, std::abs(p.force));
  return largest;
}

double Beam::largest_moment() const {
  double largest = 0.0;
  for (const Piece& p : pieces_) {
    for (const auto& ends : p.moment) largest = std::max({largest, std::abs(ends[0]), std::abs(ends[1])});
  }
  return largest;
}

double Beam::largest_hinge() const {
  double largest = 0.0;
  for (const Piece& p : pieces_) {
    for (const auto& ends : p.hinge) largest = std::max({largest, std::abs(ends[0]), std::abs(ends[1])});
  }
  return largest;
}

std::vector<Line> Beam::lines(const std::vector<Node>& /*nodes*/) const {
  std::vector<Line> lines;
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const Piece& p = pieces_[k];
    const double largest = std::max(
        {std::abs(p.moment[0][0]), std::abs(p.moment[0][1]), std::abs(p.moment[1][0]), std::abs(p.moment[1][1])});
    lines.push_back({kBeam, 0, x_[k], x_[k + 1], p.force, p.plastic, largest, false});
  }
  return lines;
}

}  // namespace quoin::members
