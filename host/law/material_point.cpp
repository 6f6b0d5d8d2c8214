#include "law/material_point.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"

namespace quoin {

namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
// Tolerance of normal stress control, as a fraction of the stress. It also ends when d_n cannot be any finer.
constexpr double kStressTolerance = 1e-10;
constexpr int kMostHalvings = 10;  // of an increment under a given stress

}  // namespace

MaterialPoint::MaterialPoint(std::shared_ptr<const Material> material, const std::string& initial_state)
    : material_(std::move(material)) {
  const quoin_law& law = material_->api();
  energies_ = (law.capabilities & QUOIN_CAN_ENERGY) != 0;
  tangents_ = (law.capabilities & QUOIN_CAN_TANGENT) != 0;
  flags_known_ = (law.capabilities & QUOIN_CAN_FLAGS) != 0;
  now_.state = material_->initial_state(initial_state.empty() ? law.initial_states[0] : initial_state);
  if (!energies_) {
    now_.energy_stored = kNotANumber;
    now_.dissipated.fill(kNotANumber);
    now_.dissipated_now.fill(kNotANumber);
  }
  state_new_.resize(now_.state.size());
}

void MaterialPoint::evaluate(double dn, double ds_step, double dt_step, double* tangent) {
  const uint64_t count = now_.state.size();
  quoin_in state_old[64];
  quoin_out state_new[64];
  if (count > 64)
    throw Error(Exit::numerical, fmt::format("law '{}' has {} states; at most 64", material_->api().id, count));
  for (uint64_t i = 0; i < count; ++i) {
    state_old[i] = {&now_.state[i], 1};
    state_new[i] = {&state_new_[i], 1};
  }
  const double sliding[2] = {ds_step, dt_step};
  quoin_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.normal_jump = {&dn, 1};
  for (int i = 0; i < 2; ++i) batch.slip_increment[i] = {&sliding[i], 1};
  for (int i = 0; i < 3; ++i) batch.traction_old[i] = {&now_.traction[i], 1};
  for (int i = 0; i < 3; ++i) batch.traction_new[i] = {&traction_new_[i], 1};
  batch.state_old = state_old;
  batch.state_new = state_new;
  if (energies_) {
    batch.energy_stored = {&energy_[0], 1};
    for (int i = 0; i < 4; ++i) batch.dissipated[i] = {&energy_[i + 1], 1};
  }
  if (tangent != nullptr) {
    for (int i = 0; i < 9; ++i) batch.tangent[i] = {&tangent[i], 1};
  }
  if (flags_known_) batch.flags = {&flags_, 1};
  batch.status = {&status_, 1};
  const quoin_status status = material_->evaluate(&batch);
  if (status != QUOIN_OK) {
    material_->require_no_fault(Exit::numerical);
    throw Error(Exit::numerical, fmt::format("law '{}': evaluate returned status {}", material_->api().id, status));
  }
  if (status_ == QUOIN_POINT_FAILED) {
    throw Error(Exit::numerical, fmt::format("law '{}' failed at d_n = {}, sliding by {}, {} m", material_->api().id,
                                             dn, ds_step, dt_step));
  }
}

const PointResult& MaterialPoint::accept(double dn, double ds, double dt) {
  const std::array<double, 3> jump{dn, ds, dt};
  for (int i = 0; i < 3; ++i) now_.work += 0.5 * (now_.traction[i] + traction_new_[i]) * (jump[i] - now_.jump[i]);
  now_.jump = jump;
  now_.traction = traction_new_;
  std::swap(now_.state, state_new_);
  now_.flags = flags_;
  now_.status = status_;
  if (energies_) {
    now_.energy_stored = energy_[0];
    for (int i = 0; i < 4; ++i) {
      now_.dissipated_now[i] = energy_[i + 1];
      now_.dissipated[i] += energy_[i + 1];
    }
  }
  return now_;
}

const PointResult& MaterialPoint::move_to(double dn, double ds, double dt) {
  evaluate(dn, ds - now_.jump[1], dt - now_.jump[2], nullptr);
  return accept(dn, ds, dt);
}

const PointResult& MaterialPoint::move_by(double dn, double ds_step, double dt_step) {
  evaluate(dn, ds_step, dt_step, nullptr);
  return accept(dn, now_.jump[1] + ds_step, now_.jump[2] + dt_step);
}

std::array<double, 2> MaterialPoint::trial(double dn, double ds_step, double dt_step) {
  double tangent[9];
  evaluate(dn, ds_step, dt_step, tangents_ ? tangent : nullptr);
  return {traction_new_[0], tangents_ ? tangent[0] : kNotANumber};
}

const PointResult& MaterialPoint::press_to(double sigma, double ds, double dt) {
  if (press_in_parts(sigma, ds, dt, kMostHalvings)) return now_;
  throw Error(
      Exit::numerical,
      fmt::format(
          "no normal jump near d_n = {:.9g} m gives sigma = {:.9g} Pa (from {:.9g} Pa, tau = {:.9g}, {:.9g} Pa): "
          "the joint cannot carry it (softened or crushed); prescribe dn there",
          now_.jump[0], sigma, now_.traction[0], now_.traction[1], now_.traction[2]));
}

// A joint dilates in a step only if it is closed before its slip, d_n <= v: then -sigma >= kn tan(psi) slip. So a step
// that slips further than -sigma/(kn tan(psi)) finds no d_n, and the increment is halved.
bool MaterialPoint::press_in_parts(double sigma, double ds, double dt, int halvings) {
  if (press_at_once(sigma, ds, dt)) return true;
  if (halvings == 0) return false;
  const PointResult before = now_;
  if (press_in_parts(0.5 * (before.traction[0] + sigma), 0.5 * (before.jump[1] + ds), 0.5 * (before.jump[2] + dt),
                     halvings - 1)) {
    const PointResult middle = now_;
    if (press_in_parts(sigma, ds, dt, halvings - 1)) {
      for (int i = 0; i < 4; ++i) now_.dissipated_now[i] += middle.dissipated_now[i];
      now_.status = std::max(now_.status, middle.status);
      return true;
    }
  }
  now_ = before;
  return false;
}

bool MaterialPoint::press_at_once(double sigma, double ds, double dt) {
  const double ds_step = ds - now_.jump[1];
  const double dt_step = dt - now_.jump[2];
  const double stiffness = material_->stiffness_bounds().normal;
  double scale = std::max(std::abs(sigma), std::abs(now_.traction[0]));
  if (scale == 0.0) scale = 1.0;  // Pa: from zero to zero
  const double tolerance = kStressTolerance * (sigma != 0.0 ? std::abs(sigma) : scale);

  double dn = now_.jump[0];
  auto [stress, slope] = trial(dn, ds_step, dt_step);
  double low = dn, high = dn, low_stress = stress, high_stress = stress;  // sigma(low) <= target <= sigma(high)

  // Newton's method first: it converges in a step or two where the law is piecewise smooth, on the branch of the old
  // point.
  for (int i = 0; i < 20; ++i) {
    if (std::abs(stress - sigma) <= tolerance) return accept(dn, ds, dt), true;
    if (!(std::abs(slope) > 1e-12 * stiffness)) slope = stiffness;
    const double next = dn + (sigma - stress) / slope;
    if (next == dn || !std::isfinite(next)) break;
    dn = next;
    const std::array<double, 2> answer = trial(dn, ds_step, dt_step);
    stress = answer[0];
    slope = answer[1];
  }
  if (std::abs(stress - sigma) <= tolerance) return accept(dn, ds, dt), true;

  // Bracket from the old point outwards along the rising branch, then bisection with secants.
  dn = low;
  double reach = std::max(std::abs(sigma - low_stress) / stiffness, 1e-9 * scale / stiffness);
  const bool up = low_stress < sigma;
  bool found = false;
  for (int i = 0; i < 80 && !found; ++i, reach *= 1.6) {
    dn += up ? reach : -reach;
    stress = trial(dn, ds_step, dt_step)[0];
    (up ? high : low) = dn;
    (up ? high_stress : low_stress) = stress;
    found = up ? stress >= sigma : stress <= sigma;
    if (!found) {
      (up ? low : high) = dn;
      (up ? low_stress : high_stress) = stress;
    }
  }
  for (int i = 0; found && i < 200; ++i) {
    double middle = low + (sigma - low_stress) * (high - low) / (high_stress - low_stress);
    if (i % 2 == 1 || !(middle > low && middle < high)) middle = 0.5 * (low + high);
    stress = trial(middle, ds_step, dt_step)[0];
    if (std::abs(stress - sigma) <= tolerance || middle == low || middle == high) {
      // d_n cannot be finer: the stress is then within kn times one unit in the last place of d_n.
      if (std::abs(stress - sigma) > tolerance + 4.0 * stiffness * std::abs(middle) * 2.3e-16) break;
      return accept(middle, ds, dt), true;
    }
    (stress < sigma ? low : high) = middle;
    (stress < sigma ? low_stress : high_stress) = stress;
  }
  return false;
}

}  // namespace quoin
