#include "members/strip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/local_damping.h"

namespace quoin::members {

namespace {

// Inertia of nodes over the least stable one; the mass of a strip is far below either.
constexpr double kInertia = 2.0;
// Local damping (eq. 1) of nodes, which prevents ringing.
constexpr double kDamping = 0.8;

}  // namespace

Strip::Strip(std::string name, std::vector<Place> places, const Fibres& fibres, std::shared_ptr<const Material> bond,
             const std::string& initial_state)
    : name_(std::move(name)), places_(std::move(places)), fibres_(fibres), bond_(std::move(bond)) {
  const std::size_t n = places_.size();
  for (const Place& p : places_) x_.push_back(p.at);
  off_.resize(n), speed_.resize(n);
  for (std::size_t i = 0; i + 1 < n; ++i) length_.push_back(norm(x_[i + 1] - x_[i]));
  mass_.resize(n), force_.resize(length_.size()), broken_.resize(length_.size()), flags_.resize(n);
  for (auto& column : jump_) column.resize(n);
  for (auto& column : slip_) column.resize(n);
  for (auto& column : traction_) column.resize(n);
  for (auto& column : energy_) column.resize(n);
  for (const double value : bond_->initial_state(initial_state)) state_.emplace_back(n, value);
  bind();
}

void Strip::bind() {
  batch_ = {};
  batch_.struct_size = sizeof batch_;
  batch_.count = places_.size();
  batch_.normal_jump = {jump_[0].data(), 1};
  for (int k = 0; k < 2; ++k) batch_.slip_increment[k] = {slip_[k].data(), 1};
  for (int k = 0; k < 3; ++k) {
    batch_.traction_old[k] = {traction_[k].data(), 1};
    batch_.traction_new[k] = {traction_[k].data(), 1};
  }
  state_old_.clear(), state_new_.clear();
  for (auto& column : state_) state_old_.push_back({column.data(), 1}), state_new_.push_back({column.data(), 1});
  batch_.state_old = state_old_.data(), batch_.state_new = state_new_.data();
  if (bond_->api().capabilities & QUOIN_CAN_FLAGS) batch_.flags = {flags_.data(), 1};
  if (!(bond_->api().capabilities & QUOIN_CAN_ENERGY)) return;
  batch_.energy_stored = {energy_[0].data(), 1};
  for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) batch_.dissipated[k] = {energy_[1 + k].data(), 1};
}

// Masses from sums of magnitudes in the rows of the stiffness, which bound its eigenvalues. Motion of a face and of its
// nodes share the bars: (a + b)^2 <= 2 a^2 + 2 b^2.
void Strip::find_masses(double dt) {
  if (dt <= mass_step_) return;
  mass_step_ = dt;
  const quoin_stiffness_bounds& bounds = bond_->stiffness_bounds();
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    double row = places_[i].area * std::max(bounds.normal, bounds.shear);
    if (i > 0) row += 4.0 * bar_stiffness(i - 1);
    if (i < length_.size()) row += 4.0 * bar_stiffness(i);
    mass_[i] = kInertia * row * dt * dt / 4.0;
  }
}

void Strip::find_jumps() {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place& p = places_[i];
    const double along = dot(off_[i], p.along), across = dot(off_[i], cross(p.normal, p.along));
    slip_[0][i] = along - jump_[1][i], slip_[1][i] = across - jump_[2][i];
    jump_[0][i] = dot(off_[i], p.normal), jump_[1][i] = along, jump_[2][i] = across;
  }
}

void Strip::ask_law() {
  const quoin_status status = bond_->evaluate(&batch_);
  if (status == QUOIN_OK && batch_.failed_count == 0) return;
  bond_->require_no_fault(Exit::numerical);
  throw Error(Exit::numerical,
              fmt::format("strip '{}': its bond law '{}' failed at {} of {} nodes (status {}); a smaller "
                          "solver.time_step_fraction or a larger spacing may help",
                          name_, bond_->api().id, batch_.failed_count, places_.size(), static_cast<int>(status)));
}

std::vector<Vector> Strip::pull_bars() {
  std::vector<Vector> force(places_.size());
  for (std::size_t i = 0; i < length_.size(); ++i) {
    if (broken_[i]) continue;
    const Vector span = x_[i + 1] - x_[i];
    const double now = norm(span);
    double tension = fibres_.stiffness * (now / length_[i] - 1.0);
    if (!fibres_.compression) tension = std::max(tension, 0.0);
    if (tension > fibres_.strength) {  // its stored energy is lost
      dissipated_ += 0.5 * force_[i] * force_[i] * length_[i] / fibres_.stiffness;
      broken_[i] = 1, force_[i] = 0.0;
      continue;
    }
    force_[i] = tension;
    stored_ += 0.5 * tension * tension * length_[i] / fibres_.stiffness;
    const Vector pulling = (tension / now) * span;
    force[i] += pulling, force[i + 1] -= pulling;
  }
  return force;
}

// force: of bars and bond, in the frame of the face.
void Strip::advance(const std::vector<Vector>& force, double dt) {
  dissipated_ += braked_later_, braked_later_ = 0.0;
  for (std::size_t i = 0; i < off_.size(); ++i) {
    Vector& w = speed_[i];
    const Vector before = w;
    for (int c = 0; c < 3; ++c) {
      const double braking = local_damping(kDamping, force[i][c], w[c]);
      w[c] += dt / mass_[i] * (force[i][c] - braking);
      dissipated_ += 0.5 * dt * braking * before[c], braked_later_ += 0.5 * dt * braking * w[c];
    }
    stored_ += 0.5 * mass_[i] * dot(before, w);  // with the product the balance closes at any step
    off_[i] += dt * w;
  }
}

void Strip::pull(std::vector<Node>& nodes, const Surroundings& step) {
  find_masses(step.dt);
  const auto node_at = [&](std::size_t i) -> Node& { return nodes[static_cast<std::size_t>(places_[i].node)]; };
  for (std::size_t i = 0; i < places_.size(); ++i) x_[i] = node_at(i).x + node_at(i).turn * off_[i];
  find_jumps();
  ask_law();
  stored_ = 0.0;
  std::vector<Vector> force = pull_bars();
  unbalanced_ = 0.0;
  Vector on_block;  // sum over the nodes of one block
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place& p = places_[i];
    node_at(i).force += force[i];
    const Vector traction =
        traction_[0][i] * p.normal + traction_[1][i] * p.along + traction_[2][i] * cross(p.normal, p.along);
    force[i] = transposed_times(node_at(i).turn, force[i]) - p.area * traction;
    on_block = i > 0 && node_at(i).block == node_at(i - 1).block ? on_block + force[i] : force[i];
    if (i + 1 == places_.size() || node_at(i).block != node_at(i + 1).block)
      unbalanced_ = std::max(unbalanced_, norm(on_block));
    stored_ += p.area * energy_[0][i];
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) dissipated_ += p.area * energy_[1 + k][i];
  }
  advance(force, step.dt);
}

double Strip::largest_force() const {
  const auto smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
  return force_.empty() ? 0.0 : *std::max_element(force_.begin(), force_.end(), smaller);
}

double Strip::debonded_length() const {
  double length = 0.0;
  for (std::size_t i = 0; i < flags_.size(); ++i) {
    const double piece = 0.5 * ((i > 0 ? length_[i - 1] : 0.0) + (i < length_.size() ? length_[i] : 0.0));
    if (flags_[i] & QUOIN_FLAG_SHEAR_COMPLETE) length += piece;
  }
  return length;
}

std::vector<Line> Strip::lines(const std::vector<Node>& /*nodes*/) const {
  std::vector<Line> lines;
  for (std::size_t k = 0; k < force_.size(); ++k)
    lines.push_back({kStrip, 0, x_[k], x_[k + 1], force_[k], 0.0, 0.0, broken_[k] != 0});
  return lines;
}

}  // namespace quoin::members
