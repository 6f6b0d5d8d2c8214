#include "analysis/cone_limit.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <optional>

namespace quoin {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using geometry::Vector;

constexpr int kMostSteps = 100;
constexpr double kToBorder = 0.99;  // length of a step over the distance to the border of the cones
constexpr double kShort = 0.1;      // shorter steps are replaced by one to the centre of the cones
constexpr double kCentre = 0.9;     // share of the gap that such a step keeps
constexpr double kWanted = 5e-7;    // gap and residuals at which the iteration ends
constexpr double kGood = 1e-5;      // residuals that are accepted when steps make no progress
constexpr double kGoodGap = 1e-4;   // the same of the gap, which the result has
constexpr double kGoodNear = 1e-3;  // the same of both with given forces `near`: change of a settled multiplier
constexpr int kNoBetter = 10;       // steps without progress after which the best one counts
constexpr double kRegular = 1e-13;  // added to the diagonal, over its largest entry, for blocks without resistance
constexpr double kNear = 1e-6;      // weight of the distance to given forces, within what the gap leaves open
// The same where the multiplier is given. A force whose nearest value is its bound ends at the root of gap over weight
// from it.
constexpr double kNearest = 100.0;
constexpr double kGiven = 2e-5;       // width of the range of a given multiplier, over max(1, multiplier)
constexpr double kLeastBound = 1e-8;  // least z/s in the matrix, for forces without bounds; residuals have 0
constexpr double kInside = 1.0;       // distance of the start from the border of the cones

// Second-order cone s[0] >= |(s[1], s[2])|, with slack s and price z.
struct Cone {
  Vector3d s, z, lambda;
  Matrix3d w, w_inverse, square_inverse;  // Nesterov and Todd's scaling
  double eta = 1.0;                       // W = eta times a hyperbolic rotation,
  Eigen::Vector2d turn;                   // given by these components of its axis

  void reset() {
    for (Matrix3d* m : {&w, &w_inverse, &square_inverse}) m->setIdentity();
    eta = 1.0, turn.setZero();
  }
  static double determinant(const Vector3d& v) { return (v[0] - v.tail<2>().norm()) * (v[0] + v.tail<2>().norm()); }
  static Vector3d product(const Vector3d& a, const Vector3d& b) {
    Vector3d c;
    c << a.dot(b), a[0] * b.tail<2>() + b[0] * a.tail<2>();
    return c;
  }
  Vector3d over_lambda(const Vector3d& d) const {
    Vector3d x;
    x[0] = (lambda[0] * d[0] - lambda.tail<2>().dot(d.tail<2>())) / determinant(lambda);
    x.tail<2>() = (d.tail<2>() - x[0] * lambda.tail<2>()) / lambda[0];
    return x;
  }
  bool scale() {
    const double of_s = determinant(s), of_z = determinant(z);
    if (!(of_s > 0.0) || !(of_z > 0.0)) return false;
    const Vector3d unit_s = s / std::sqrt(of_s);
    Vector3d unit_z = z / std::sqrt(of_z);
    const double gamma = std::sqrt(0.5 * (1.0 + unit_s.dot(unit_z)));
    unit_z.tail<2>() *= -1.0;
    const Vector3d v = (unit_s + unit_z) / (2.0 * gamma);
    eta = std::sqrt(std::sqrt(of_s / of_z));
    turn = v.tail<2>();
    Matrix3d root;
    root(0, 0) = v[0];
    root.block<1, 2>(0, 1) = turn.transpose(), root.block<2, 1>(1, 0) = turn;
    root.block<2, 2>(1, 1) = Eigen::Matrix2d::Identity() + turn * turn.transpose() / (1.0 + v[0]);
    w = eta * root;
    root.block<1, 2>(0, 1) *= -1.0, root.block<2, 1>(1, 0) *= -1.0;
    w_inverse = root / eta;
    Vector3d mirrored = v;
    mirrored.tail<2>() *= -1.0;
    const Eigen::DiagonalMatrix<double, 3> j(1.0, -1.0, -1.0);
    square_inverse = 2.0 * mirrored * mirrored.transpose();
    square_inverse -= Matrix3d(j);
    square_inverse /= eta * eta;
    lambda = w * z;
    return true;
  }
  // (G W^-2 G + D)^-1, G = diag(friction, -1, -1), D = diag(normal, shear, shear). In the axes of the turn q^2 - (2 v0
  // v1)^2 = 1. So no differences of large numbers occur, however close s and z are to the border.
  Matrix3d compliance(double friction, double normal, double shear) const {
    const double r = turn.norm(), q = 1.0 + 2.0 * r * r, coupled = 2.0 * std::sqrt(1.0 + r * r) * r;
    const double square = eta * eta, n = square * normal, p = square * shear, mu2 = friction * friction;
    const Eigen::Vector2d along = r > 0.0 ? Eigen::Vector2d(turn / r) : Eigen::Vector2d(1.0, 0.0);
    const Eigen::Vector2d across(-along[1], along[0]);
    const double over = square / (mu2 + n * q + p * (mu2 * q + n));
    Matrix3d m;
    m(0, 0) = over * (q + p);
    m.block<2, 1>(1, 0) = -over * friction * coupled * along;
    m.block<1, 2>(0, 1) = m.block<2, 1>(1, 0).transpose();
    m.block<2, 2>(1, 1) =
        over * (mu2 * q + n) * along * along.transpose() + square / (1.0 + p) * across * across.transpose();
    return m;
  }
  static double reach(const Vector3d& v, const Vector3d& d) {
    const double a = determinant(d), b = v[0] * d[0] - v.tail<2>().dot(d.tail<2>()), c = determinant(v);
    const double discriminant = b * b - a * c;
    if (discriminant < 0.0 || (a >= 0.0 && b >= 0.0)) return std::numeric_limits<double>::infinity();
    return c / (std::sqrt(discriminant) - b);
  }
};

// sign x[0] <= bound, with slack s and price z.
struct Bound {
  double sign = 1.0, bound = 0.0, s = 0.0, z = 0.0;
  double ds = 0.0, dz = 0.0, corrector = 0.0;
  double reach() const {
    const double of_s = ds < 0.0 ? -s / ds : std::numeric_limits<double>::infinity();
    return std::min(of_s, dz < 0.0 ? -z / dz : std::numeric_limits<double>::infinity());
  }
};

// A contact point with forces x along n, s, t, or a force of a member with one component.
struct Element {
  struct Side {
    int row;                         // first row of a block that is not fixed
    Eigen::Matrix<double, 6, 3> on;  // wrench on the block by unit forces
  };
  std::vector<Side> sides;  // by rows, ascending
  bool has_cone = false;    // whether it has a slack: strength - friction x[0] + live multiplier, x[1], x[2]
  double friction = 0.0, strength = 0.0, live = 0.0;
  Cone cone{};
  Vector3d cone_ds, cone_dz, corrector;
  std::vector<Bound> bounds;
  double pull = 0.0;  // stiffness that pulls the normal force to `towards`, and shear to 0
  double towards = 0.0;
  Vector3d x = Vector3d::Zero(), dx;

  double of_bounds = 0.0;  // stiffness of its bounds, z/s, and of the pull
  Matrix3d inverse;        // inverse of the Hessian H; 0 for components that the element does not have
  Vector3d to_multiplier;  // Hessian between x and the multiplier
  Vector3d rest, left;     // right side, and its residual

  Vector3d slope(const Vector3d& v, double multiplier) const {  // G x
    return {friction * v[0] - live * multiplier, -v[1], -v[2]};
  }
  Vector3d back(const Vector3d& z) const { return {friction * z[0], -z[1], -z[2]}; }  // its transpose
};

class ConeProgramme {
 public:
  // weight: of the distance to given forces. least: bound of the multiplier.
  ConeProgramme(const LimitProblem& problem, const LimitSettings& settings, double weight,
                double least = -std::numeric_limits<double>::infinity())
      : problem_(problem), settings_(settings), units_(units_of(problem)) {
    const std::vector<double>& near = settings.near;
    number_blocks();
    for (const LimitPoint& p : problem.points) add_point(p);
    const double pull = weight / static_cast<double>(near.size());
    for (std::size_t i = 0; i < near.size(); ++i) elements_[i].pull = pull, elements_[i].towards = -near[i] / force_;
    for (const LimitForce& force : problem.forces) {
      add_force(force);
      if (near.empty() || !force.start) continue;
      elements_.back().pull = pull, elements_.back().towards = *force.start / force_;
    }
    if (std::isfinite(settings.most)) multiplier_bounds_.push_back({1.0, settings.most / units_.multiplier});
    if (std::isfinite(least)) multiplier_bounds_.push_back({-1.0, -least / units_.multiplier});
    pattern();
  }

  LimitResult solve() {
    LimitResult result;
    if (elements_.empty() || !begin()) return result;
    for (int step = 0, best = 0; step < kMostSteps; ++step) {
      residuals();
      if (keep_best()) best = step;
      settings_.report(fmt::format("step {}, gap {:.1e}", step + 1, error_));
      if (settings_.is_late()) {
        result.status = LimitStatus::late;  // unless the best step so far will do
        break;
      }
      if (error_ < kWanted || (is_good() && step > best + kNoBetter) || !advance()) break;
    }
    if (!is_good()) return result;
    restore_best();
    fill(result);
    return result;
  }

 private:
  bool is_near() const { return !elements_.empty() && elements_.front().pull > 0.0; }
  bool is_good() const {
    return best_error_ < (is_near() ? kGoodNear : kGoodGap) && best_residual_ < (is_near() ? kGoodNear : kGood);
  }

  void number_blocks() {
    for (const LimitBlock& b : problem_.blocks) {
      rows_.push_back(b.fixed ? -1 : rows_count_);
      if (!b.fixed) rows_count_ += 6;
    }
    live_ = VectorXd::Zero(rows_count_), dead_ = VectorXd::Zero(rows_count_), y_ = VectorXd::Zero(rows_count_);
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      if (rows_[k] < 0) continue;
      const LimitBlock& b = problem_.blocks[k];
      for (int c = 0; c < 3; ++c) {
        live_[rows_[k] + c] = units_.multiplier * b.live.force[c] / force_;
        live_[rows_[k] + 3 + c] = units_.multiplier * b.live.moment[c] / (force_ * length_);
        dead_[rows_[k] + c] = b.dead.force[c] / force_, dead_[rows_[k] + 3 + c] = b.dead.moment[c] / (force_ * length_);
      }
    }
  }

  // Component c of an element acts on a block by a force f at a position, and by a moment.
  void act_on(int block, const Vector& position, const Vector& f, const Vector& turn, int c, Element& e) const {
    const int row = rows_[static_cast<std::size_t>(block)];
    if (row < 0) return;
    const auto after =
        std::find_if(e.sides.begin(), e.sides.end(), [&](const Element::Side& s) { return s.row >= row; });
    const auto side = after != e.sides.end() && after->row == row
                          ? after
                          : e.sides.insert(after, {row, Eigen::Matrix<double, 6, 3>::Zero()});
    const Vector moment = turn + cross(position - problem_.blocks[static_cast<std::size_t>(block)].centre, f);
    for (int k = 0; k < 3; ++k) side->on(k, c) += f[k], side->on(3 + k, c) += moment[k] / length_;
  }

  void add_point(const LimitPoint& p) {
    Element e;
    e.sides.reserve(2);
    for (int c = 0; c < 3; ++c) {
      const Vector& axis = c == 0 ? p.n : c == 1 ? p.s : p.t;
      act_on(p.a, p.position, axis, {}, c, e), act_on(p.b, p.position, -axis, {}, c, e);
    }
    e.friction = p.friction, e.strength = p.cohesion / force_, e.live = units_.multiplier * p.live_cohesion / force_;
    e.has_cone = e.friction > 0.0 || e.strength > 0.0 || e.live != 0.0;
    // Whether the apex of the cone bounds the tensile force.
    const bool tip = e.friction > 0.0 && e.live == 0.0 && p.tension >= p.cohesion / p.friction;
    if (!tip) e.bounds.push_back({1.0, p.tension / force_});
    if (std::isfinite(p.crushing)) e.bounds.push_back({-1.0, p.crushing / force_});
    elements_.push_back(e);
  }

  void add_force(const LimitForce& force) {
    Element e;
    for (const LimitForce::Place& place : force.places) act_on(place.block, place.at, place.way, place.turn, 0, e);
    if (std::isfinite(force.high)) e.bounds.push_back({1.0, force.high / force_});
    if (std::isfinite(force.low)) e.bounds.push_back({-1.0, -force.low / force_});
    elements_.push_back(e);
  }

  // Visits pairs of sides, a side with itself included: visit(lower, upper), in the order of rows.
  template <class Visit>
  static void each_pair(const Element& e, const Visit& visit) {
    for (std::size_t i = 0; i < e.sides.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j) visit(e.sides[i], e.sides[j]);
  }

  // Pattern of the matrix, the same in all steps: the lower triangle, block by block.
  void pattern() {
    std::vector<Eigen::Triplet<double>> entries;
    for (int r = 0; r < rows_count_; ++r) entries.emplace_back(r, r, 1.0);
    for (const Element& e : elements_) {
      each_pair(e, [&](const Element::Side& lower, const Element::Side& upper) {
        for (int i = 0; i < 6; ++i)
          for (int j = 0; j < 6; ++j)
            if (lower.row + i >= upper.row + j) entries.emplace_back(lower.row + i, upper.row + j, 0.0);
      });
    }
    matrix_.resize(rows_count_, rows_count_);
    matrix_.setFromTriplets(entries.begin(), entries.end());
    factor_.analyzePattern(matrix_);
  }

  void add_block(int row, int col, const Eigen::Matrix<double, 6, 6>& k) {
    for (int j = 0; j < 6; ++j) {
      const int first = row == col ? j : 0;
      // Rows of a block are consecutive in a column.
      const auto begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[col + j],
                 end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[col + j + 1];
      double* value = matrix_.valuePtr() + (std::lower_bound(begin, end, row + first) - matrix_.innerIndexPtr());
      for (int i = first; i < 6; ++i) *value++ += k(i, j);
    }
  }

  // Assembles and factorises the matrix. identity: without scaling, for the start.
  bool assemble(bool identity) {
    std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
    pull_ = live_, own_ = whole_own_ = 0.0;
    for (Element& e : elements_) {
      if (e.has_cone && !identity && !e.cone.scale()) return false;
      scale(e, identity);
      eliminate(e);
    }
    for (const Bound& b : multiplier_bounds_)
      own_ += identity ? 1.0 : b.z / b.s, whole_own_ += identity ? 1.0 : b.z / b.s;
    double largest = 0.0;
    for (int r = 0; r < rows_count_; ++r) largest = std::max(largest, matrix_.coeff(r, r));
    for (int r = 0; r < rows_count_; ++r) matrix_.coeffRef(r, r) += kRegular * largest;
    factor_.factorize(matrix_);
    if (factor_.info() != Eigen::Success) return false;
    answer_to_pull_ = factor_.solve(pull_);
    return true;
  }

  void scale(Element& e, bool identity) {
    e.inverse.setZero(), e.to_multiplier.setZero();
    double of_bounds = e.pull;
    for (const Bound& b : e.bounds) of_bounds += identity ? 1.0 : b.z / b.s;
    e.of_bounds = of_bounds;
    if (!e.has_cone) {
      e.inverse(0, 0) = 1.0 / std::max(of_bounds, identity ? 1.0 : kLeastBound);
      return;
    }
    if (identity) e.cone.reset();
    const Eigen::DiagonalMatrix<double, 3> g(e.friction, -1.0, -1.0);
    e.to_multiplier = -e.live * (g * e.cone.square_inverse.col(0));
    own_ += e.live * e.live * e.cone.square_inverse(0, 0);
    whole_own_ += e.live * e.live * e.cone.square_inverse(0, 0);
    e.inverse = e.cone.compliance(e.friction, of_bounds, e.pull);
  }

  void eliminate(const Element& e) {
    each_pair(e, [&](const Element::Side& lower, const Element::Side& upper) {
      add_block(lower.row, upper.row, lower.on * e.inverse * upper.on.transpose());
    });
    for (const Element::Side& side : e.sides) pull_.segment<6>(side.row) -= side.on * e.inverse * e.to_multiplier;
    own_ -= e.to_multiplier.dot(e.inverse * e.to_multiplier);
  }

  Vector3d forces_from(const Element& e, const VectorXd& y) const {  // A^T y
    Vector3d v = Vector3d::Zero();
    for (const Element::Side& side : e.sides) v += side.on.transpose() * y.segment<6>(side.row);
    return v;
  }
  void act(const Element& e, const Vector3d& f, VectorXd& on) const {  // A f
    for (const Element::Side& side : e.sides) on.segment<6>(side.row) += side.on * f;
  }

  // Solves H dx + A^T dy + to_multiplier dm = rest, A dx + live dm = of_rows, and the row of the multiplier, with
  // iterative refinement. Elements with cones get no refinement. H dx loses more digits than the inverse does, and
  // their prices follow from velocities.
  void solve_for(const VectorXd& of_rows, double of_multiplier) {
    for (Element& e : elements_) e.dx.setZero(), e.left = e.rest;
    dy_ = VectorXd::Zero(rows_count_), dm_ = 0.0;
    VectorXd rows = of_rows;
    double multiplier = of_multiplier;
    for (int again = 0; again < 3; ++again) {
      add_solution(rows, multiplier);
      rows = of_rows - dm_ * live_;
      multiplier = of_multiplier - live_.dot(dy_) - whole_own_ * dm_;
      for (Element& e : elements_) {
        e.left.setZero();
        if (!e.has_cone) e.left[0] = e.rest[0] - e.of_bounds * e.dx[0] - forces_from(e, dy_)[0];
        multiplier -= e.to_multiplier.dot(e.dx);
        act(e, -e.dx, rows);
      }
    }
  }
  void add_solution(const VectorXd& of_rows, double of_multiplier) {
    VectorXd right = -of_rows;
    double pulled = of_multiplier;
    for (const Element& e : elements_) {
      const Vector3d x = e.inverse * e.left;
      act(e, x, right);
      pulled -= e.to_multiplier.dot(x);
    }
    const VectorXd first = factor_.solve(right);
    const double m = (pulled - pull_.dot(first)) / (own_ + pull_.dot(answer_to_pull_));
    const VectorXd y = first + m * answer_to_pull_;
    dm_ += m, dy_ += y;
    for (Element& e : elements_) e.dx += e.inverse * (e.left - forces_from(e, y) - m * e.to_multiplier);
  }

  // Start: forces nearest to the centre of the cones, and prices nearest to 0, both moved inside.
  bool begin() {
    if (!assemble(true)) return false;
    double of_multiplier = 0.0;
    for (Element& e : elements_) {
      e.rest = e.has_cone ? e.back({e.strength, 0.0, 0.0}) : Vector3d::Zero();
      if (e.has_cone) of_multiplier -= e.live * e.strength;
      for (const Bound& b : e.bounds) e.rest[0] += b.sign * b.bound;
    }
    for (const Bound& b : multiplier_bounds_) of_multiplier += b.sign * b.bound;
    solve_for(-dead_, of_multiplier);
    m_ = dm_;
    double outside = -std::numeric_limits<double>::infinity();
    for (Element& e : elements_) {
      e.x = e.dx;
      if (e.has_cone)
        e.cone.s = Vector3d(e.strength, 0.0, 0.0) - e.slope(e.x, m_),
        outside = std::max(outside, e.cone.s.tail<2>().norm() - e.cone.s[0]);
      for (Bound& b : e.bounds) b.s = b.bound - b.sign * e.x[0], outside = std::max(outside, -b.s);
    }
    for (Bound& b : multiplier_bounds_) b.s = b.bound - b.sign * m_, outside = std::max(outside, -b.s);
    move_inside(outside, true);

    for (Element& e : elements_) e.rest.setZero();
    solve_for(VectorXd::Zero(rows_count_), 1.0);
    y_ = dy_;
    outside = -std::numeric_limits<double>::infinity();
    for (Element& e : elements_) {
      if (e.has_cone)
        e.cone.z = e.slope(e.dx, dm_), outside = std::max(outside, e.cone.z.tail<2>().norm() - e.cone.z[0]);
      for (Bound& b : e.bounds) b.z = b.sign * e.dx[0], outside = std::max(outside, -b.z);
    }
    for (Bound& b : multiplier_bounds_) b.z = b.sign * dm_, outside = std::max(outside, -b.z);
    move_inside(outside, false);
    degree_ = static_cast<double>(multiplier_bounds_.size());
    for (const Element& e : elements_) degree_ += (e.has_cone ? 1.0 : 0.0) + static_cast<double>(e.bounds.size());
    return true;
  }

  void move_inside(double outside, bool slacks) {
    if (outside < -1e-8) return;
    const double by = kInside + outside;
    for (Element& e : elements_) {
      if (e.has_cone) (slacks ? e.cone.s : e.cone.z)[0] += by;
      for (Bound& b : e.bounds) (slacks ? b.s : b.z) += by;
    }
    for (Bound& b : multiplier_bounds_) (slacks ? b.s : b.z) += by;
  }

  // Computes residuals of equilibrium, prices and slacks, and the gap.
  void residuals() {
    of_rows_ = dead_ + m_ * live_;
    of_multiplier_ = -1.0 + live_.dot(y_);
    double of_forces = 0.0, of_slacks = 0.0;
    gap_ = 0.0;
    double dual = dead_.dot(y_);  // dual of the minimum of -multiplier
    for (Element& e : elements_) {
      act(e, e.x, of_rows_);
      e.rest = forces_from(e, y_) + pulled(e);
      if (e.has_cone) {
        e.rest += e.back(e.cone.z);
        of_multiplier_ -= e.live * e.cone.z[0];
        of_slacks = std::max(of_slacks, slack_error(e).lpNorm<Eigen::Infinity>());
        gap_ += e.cone.s.dot(e.cone.z), dual -= e.strength * e.cone.z[0];
      }
      for (const Bound& b : e.bounds) {
        e.rest[0] += b.sign * b.z;
        of_slacks = std::max(of_slacks, std::abs(b.sign * e.x[0] + b.s - b.bound));
        gap_ += b.s * b.z, dual -= b.bound * b.z;
      }
      if (!e.has_cone) e.rest[1] = e.rest[2] = 0.0;
      of_forces = std::max(of_forces, e.rest.lpNorm<Eigen::Infinity>());
    }
    for (const Bound& b : multiplier_bounds_) {
      of_multiplier_ += b.sign * b.z;
      of_slacks = std::max(of_slacks, std::abs(b.sign * m_ + b.s - b.bound));
      gap_ += b.s * b.z, dual -= b.bound * b.z;
    }
    upper_ = -dual;
    const double scale = std::max(1.0, std::abs(m_));
    residual_ = std::max({of_rows_.lpNorm<Eigen::Infinity>(), of_forces, std::abs(of_multiplier_), of_slacks});
    error_ = std::max({gap_ / scale, is_near() ? 0.0 : std::abs(upper_ - m_) / scale, residual_});
  }

  Vector3d slack_error(const Element& e) const { return e.slope(e.x, m_) + e.cone.s - Vector3d(e.strength, 0.0, 0.0); }

  // Direction of the predictor, towards the solution (centring 0), or of the corrector, towards the centre as well.
  void direction(double centring) {
    const double mu = gap_ / degree_, keep = 1.0 - centring;
    VectorXd rows = -keep * of_rows_;
    double multiplier = -keep * of_multiplier_;
    for (Element& e : elements_) {
      e.rest = -keep * price_error(e);
      if (e.has_cone) {
        Vector3d d = -Cone::product(e.cone.lambda, e.cone.lambda) - e.corrector;
        d[0] += centring * mu;
        e.cone_ds = e.cone.w * e.cone.over_lambda(d);  // part of the slack; the rest follows from prices
        const Vector3d right = e.cone.square_inverse * (keep * slack_error(e) + e.cone_ds);
        e.rest -= e.back(right);
        multiplier += e.live * right[0];
      }
      for (Bound& b : e.bounds) {
        b.ds = (centring * mu - b.s * b.z - b.corrector) / b.z;
        e.rest[0] -= b.sign * b.z / b.s * (keep * (b.sign * e.x[0] + b.s - b.bound) + b.ds);
      }
    }
    for (Bound& b : multiplier_bounds_) {
      b.ds = (centring * mu - b.s * b.z - b.corrector) / b.z;
      multiplier -= b.sign * b.z / b.s * (keep * (b.sign * m_ + b.s - b.bound) + b.ds);
    }
    solve_for(rows, multiplier);
    for (Element& e : elements_) {
      for (Bound& b : e.bounds) finish(b, b.sign * e.dx[0], keep * (b.sign * e.x[0] + b.s - b.bound));
      if (e.has_cone) finish(e, keep);
    }
    for (Bound& b : multiplier_bounds_) finish(b, b.sign * dm_, keep * (b.sign * m_ + b.s - b.bound));
  }
  static void finish(Bound& b, double moved, double error) {
    b.dz = b.z / b.s * (moved + error + b.ds);
    b.ds = -error - moved;
  }
  // Slacks and prices from forces and velocities, so that their relations hold to rounding.
  void finish(Element& e, double keep) const {
    const Vector3d moved = e.slope(e.dx, dm_) + keep * slack_error(e);
    Vector3d prices = keep * price_error(e) + forces_from(e, dy_) + e.pull * e.dx;
    for (const Bound& b : e.bounds) prices[0] += b.sign * b.dz;
    e.cone_dz[0] = e.friction != 0.0 ? -prices[0] / e.friction : (e.cone.square_inverse * (moved + e.cone_ds))[0];
    e.cone_dz.tail<2>() = prices.tail<2>();
    e.cone_ds = -moved;
  }

  static Vector3d pulled(const Element& e) { return e.pull * (e.x - Vector3d(e.towards, 0.0, 0.0)); }
  Vector3d price_error(const Element& e) const {
    Vector3d v = forces_from(e, y_) + pulled(e);
    if (e.has_cone) v += e.back(e.cone.z);
    for (const Bound& b : e.bounds) v[0] += b.sign * b.z;
    if (!e.has_cone) v[1] = v[2] = 0.0;
    return v;
  }

  double reach() const {
    double far = std::numeric_limits<double>::infinity();
    for (const Element& e : elements_) {
      if (e.has_cone) far = std::min({far, Cone::reach(e.cone.s, e.cone_ds), Cone::reach(e.cone.z, e.cone_dz)});
      for (const Bound& b : e.bounds) far = std::min(far, b.reach());
    }
    for (const Bound& b : multiplier_bounds_) far = std::min(far, b.reach());
    return far;
  }

  void clear_correctors() {
    for (Element& e : elements_) {
      e.corrector.setZero();
      for (Bound& b : e.bounds) b.corrector = 0.0;
    }
    for (Bound& b : multiplier_bounds_) b.corrector = 0.0;
  }

  bool advance() {
    if (!assemble(false)) return false;
    clear_correctors();
    direction(0.0);
    const double centring = std::pow(1.0 - std::min(1.0, reach()), 3);
    for (Element& e : elements_) {
      if (e.has_cone) e.corrector = Cone::product(e.cone.w_inverse * e.cone_ds, e.cone.w * e.cone_dz);
      for (Bound& b : e.bounds) b.corrector = b.ds * b.dz;
    }
    for (Bound& b : multiplier_bounds_) b.corrector = b.ds * b.dz;
    direction(centring);
    double by = std::min(1.0, kToBorder * reach());
    if (by < kShort) {
      clear_correctors();
      direction(kCentre);
      by = std::min(1.0, kToBorder * reach());
    }
    if (!std::isfinite(by) || !std::isfinite(dm_) || by < 1e-10) return false;
    for (Element& e : elements_) {
      e.x += by * e.dx;
      if (e.has_cone) e.cone.s += by * e.cone_ds, e.cone.z += by * e.cone_dz;
      for (Bound& b : e.bounds) b.s += by * b.ds, b.z += by * b.dz;
    }
    for (Bound& b : multiplier_bounds_) b.s += by * b.ds, b.z += by * b.dz;
    m_ += by * dm_, y_ += by * dy_;
    return true;
  }

  // Returns whether this step is the best one so far.
  bool keep_best() {
    if (!(error_ < best_error_)) return false;
    best_error_ = error_, best_residual_ = residual_, best_m_ = m_, best_upper_ = upper_, best_y_ = y_;
    best_x_.resize(elements_.size());
    for (std::size_t i = 0; i < elements_.size(); ++i) best_x_[i] = elements_[i].x;
    return true;
  }
  void restore_best() {
    m_ = best_m_, upper_ = best_upper_, y_ = best_y_;
    for (std::size_t i = 0; i < elements_.size(); ++i) elements_[i].x = best_x_[i];
  }

  void fill(LimitResult& r) const {
    r.status = LimitStatus::solved;
    r.multiplier = units_.multiplier * m_, r.gap = std::abs(upper_ - m_) / std::max(1.0, std::abs(m_));
    const std::size_t points = problem_.points.size();
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      const Vector3d f = force_ * elements_[i].x;
      if (i < points)
        r.force.push_back({f[0], f[1], f[2]});
      else
        r.member_force.push_back(f[0]);
    }
    r.velocity.resize(problem_.blocks.size());
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      for (int c = 0; rows_[k] >= 0 && c < 3; ++c) {
        r.velocity[k].force[c] = y_[rows_[k] + c];
        r.velocity[k].moment[c] = y_[rows_[k] + 3 + c] / length_;
      }
    }
  }

  const LimitProblem& problem_;
  const LimitSettings& settings_;
  LimitUnits units_;
  const double force_ = units_.force, length_ = units_.length;
  std::vector<int> rows_;  // first of each block; -1: fixed
  int rows_count_ = 0;
  std::vector<Element> elements_;  // points, then forces of members
  std::vector<Bound> multiplier_bounds_;
  VectorXd live_, dead_, y_, dy_;
  double m_ = 0.0, dm_ = 0.0;  // multiplier
  Eigen::SparseMatrix<double> matrix_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
  VectorXd pull_, answer_to_pull_;      // coefficients of the multiplier in rows of blocks, after elimination of forces
  double own_ = 0.0, whole_own_ = 0.0;  // diagonal entry of the multiplier, after elimination of forces and before
  VectorXd of_rows_;
  double of_multiplier_ = 0.0, gap_ = 0.0, upper_ = 0.0, degree_ = 0.0;
  double residual_ = 0.0, error_ = 0.0;  // largest residual; the larger of it and the gap
  double best_error_ = std::numeric_limits<double>::infinity(), best_residual_ = 0.0, best_m_ = 0.0, best_upper_ = 0.0;
  VectorXd best_y_;
  std::vector<Vector3d> best_x_;
};

}  // namespace

LimitResult limit_with_cones(const LimitProblem& problem, const LimitSettings& settings) {
  LimitResult found = ConeProgramme(problem, settings, kNear).solve();
  if (settings.near.empty() || !has_members(problem) || found.status != LimitStatus::solved) return found;
  // The forces of members have no unique value otherwise, and those near the middle of their bounds would be taken.
  const double unit = units_of(problem).multiplier;
  const double least = found.multiplier - kGiven * std::max(unit, std::abs(found.multiplier));
  LimitResult nearest = ConeProgramme(problem, settings, kNearest, least).solve();
  return nearest.status == LimitStatus::solved ? nearest : found;
}

}  // namespace quoin
