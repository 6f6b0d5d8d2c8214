// One contact point under any law, for `quoin path` and `quoin fit`.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "law/law_library.h"

namespace quoin {

// Output of the law for the point at the end of a step. Energies are not a number if the law computes none.
struct PointResult {
  std::array<double, 3> jump{};      // d_n, d_s, d_t, totals, m
  std::array<double, 3> traction{};  // sigma, tau_s, tau_t, Pa
  std::vector<double> state;         // order of the law's metadata
  uint32_t flags = 0;
  uint32_t status = QUOIN_POINT_OK;
  double energy_stored = 0.0;              // J/m2
  std::array<double, 4> dissipated{};      // by mode, since the start of the path, J/m2
  std::array<double, 4> dissipated_now{};  // by mode, during the last step
  double work = 0.0;                       // work of the traction since the start of the path, trapezoidal rule, J/m2
};

class MaterialPoint {
 public:
  // Throws Error(bad_input) for an initial state that the law does not have.
  MaterialPoint(std::shared_ptr<const Material> material, const std::string& initial_state);

  // Each returns the point at the end of one increment. Throws Error(numerical) when the law reports that the point
  // failed.
  const PointResult& move_to(double dn, double ds, double dt);            // totals
  const PointResult& move_by(double dn, double ds_step, double dt_step);  // total d_n, slip increments
  // Finds the d_n that gives this normal stress together with the slip increment, to 1e-10 of the stress. It applies
  // Newton's method with the law's tangent, inside a bracket. Where no d_n near the old one gives the stress, it halves
  // the increment, in 1024 parts at most. Throws Error(numerical) when that does not help, with the point as before.
  const PointResult& press_to(double sigma, double ds, double dt);

  const PointResult& now() const { return now_; }
  const Material& material() const { return *material_; }

 private:
  bool press_in_parts(double sigma, double ds, double dt, int halvings);
  bool press_at_once(double sigma, double ds, double dt);
  const PointResult& accept(double dn, double ds, double dt);
  // Returns sigma and d sigma / d d_n (or not a number) at the end of a trial increment that is not accepted.
  std::array<double, 2> trial(double dn, double ds_step, double dt_step);
  void evaluate(double dn, double ds_step, double dt_step, double* tangent);

  std::shared_ptr<const Material> material_;
  bool energies_, tangents_, flags_known_;
  PointResult now_;
  // Output of one evaluation and its columns, which point into buffers of this object.
  std::array<double, 3> traction_new_{};
  std::vector<double> state_new_;
  std::array<double, 5> energy_{};
  uint32_t flags_ = 0, status_ = 0;
};

}  // namespace quoin
