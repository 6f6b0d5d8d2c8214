#include "members/strip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace quoin::members {

namespace {

// Inertia of nodes over the least stable one; the mass of a strip is far below either.
constexpr double kInertia = 2.0;
// Local damping (eq. 1) of nodes against their motion relative to the face, which prevents ringing. Against their
// motion in space it would brake moving faces.
constexpr double kDamping = 0.8;

}  // namespace

Strip::Strip(std::string name, std::vector<Place> places, const Fibres& fibres, std::shared_ptr<const Material> bond,
             const std::string& initial_state)
    : name_(std::move(name)), places_(std::move(places)), fibres_(fibres), bond_(std::move(bond)) {
  const std::size_t n = places_.size();
  for (const Place& p : places_) x_.push_back(p.at);
  face_ = x_;
  for (std::size_t i = 0; i + 1 < n; ++i) length_.push_back(norm(x_[i + 1] - x_[i]));
  v_.resize(n), mass_.resize(n), force_.resize(length_.size()), broken_.resize(length_.size()), flags_.resize(n);
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

double Strip::bond_stiffness(std::size_t place) const {
  const quoin_stiffness_bounds& bounds = bond_->stiffness_bounds();
  return places_[place].area * std::max(bounds.normal, bounds.shear);
}

// Masses from sums of magnitudes in the rows of the stiffness, which bound its eigenvalues.
void Strip::find_masses(double dt) {
  if (dt <= mass_step_) return;
  mass_step_ = dt;
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    double row = 2.0 * bond_stiffness(i);
    if (i > 0) row += 2.0 * fibres_.stiffness / length_[i - 1];
    if (i < length_.size()) row += 2.0 * fibres_.stiffness / length_[i];
    mass_[i] = kInertia * row * dt * dt / 4.0;
  }
}

void Strip::find_jumps(const std::vector<Node>& nodes) {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place& p = places_[i];
    const Node& node = nodes[static_cast<std::size_t>(p.node)];
    const Vector apart = transposed_times(node.turn, x_[i] - node.x);
    const double along = dot(apart, p.along), across = dot(apart, cross(p.normal, p.along));
    slip_[0][i] = along - jump_[1][i], slip_[1][i] = across - jump_[2][i];
    jump_[0][i] = dot(apart, p.normal), jump_[1][i] = along, jump_[2][i] = across;
  }
}

void Strip::ask_law() {
  const quoin_status status = bond_->evaluate(&batch_);
  if (status != QUOIN_OK || batch_.failed_count > 0)
    throw Error(Exit::numerical,
                fmt::format("strip '{}': its bond law '{}' failed at {} of {} nodes (status {}); a smaller "
                            "solver.time_step_fraction or a larger spacing may help",
                            name_, bond_->api().id, batch_.failed_count, places_.size(), static_cast<int>(status)));
}

void Strip::pull_bars(std::vector<Vector>& force) {
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
}

void Strip::advance(const std::vector<Vector>& force, const std::vector<Node>& nodes, double dt) {
  for (std::size_t i = 0; i < x_.size(); ++i) {
    Vector& v = v_[i];
    const Vector before = v, now = nodes[static_cast<std::size_t>(places_[i].node)].x;
    const Vector on_face = v - (1.0 / dt) * (now - face_[i]);
    face_[i] = now;
    for (int c = 0; c < 3; ++c) {
      const double braking = on_face[c] == 0.0 ? 0.0 : std::copysign(kDamping * std::abs(force[i][c]), on_face[c]);
      v[c] += dt / mass_[i] * (force[i][c] - braking);
      dissipated_ += braking * 0.5 * (before[c] + v[c]) * dt;
    }
    const Vector middle = 0.5 * (before + v);
    stored_ += 0.5 * mass_[i] * dot(middle, middle);
    x_[i] += dt * v;
  }
}

void Strip::pull(std::vector<Node>& nodes, double dt) {
  find_masses(dt);
  find_jumps(nodes);
  ask_law();
  stored_ = 0.0;
  std::vector<Vector> force(places_.size());
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place& p = places_[i];
    Node& node = nodes[static_cast<std::size_t>(p.node)];
    const Vector traction =
        traction_[0][i] * p.normal + traction_[1][i] * p.along + traction_[2][i] * cross(p.normal, p.along);
    const Vector on_block = p.area * (node.turn * traction);
    node.force += on_block, force[i] -= on_block;
    stored_ += p.area * energy_[0][i];
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) dissipated_ += p.area * energy_[1 + k][i];
  }
  pull_bars(force);
  advance(force, nodes, dt);
}

double Strip::largest_force() const { return force_.empty() ? 0.0 : *std::max_element(force_.begin(), force_.end()); }

double Strip::debonded_length() const {
  double length = 0.0;
  for (std::size_t i = 0; i < flags_.size(); ++i) {
    const double piece = 0.5 * ((i > 0 ? length_[i - 1] : 0.0) + (i < length_.size() ? length_[i] : 0.0));
    if (flags_[i] & QUOIN_FLAG_SHEAR_COMPLETE) length += piece;
  }
  return length;
}

double Strip::added_mass() const {
  double sum = 0.0;
  for (const double m : mass_) sum += m;
  return sum;
}

}  // namespace quoin::members
