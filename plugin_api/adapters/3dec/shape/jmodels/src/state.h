// What 3DEC passes to a joint model for one contact point and step. Forces are in N, not per area, and positive in
// compression. Displacements open positive, and shear vectors lie in the contact plane.
#pragma once

#include "jmodelbase.h"

namespace jmodels {

struct State {
  static const shape::Index max_working_ = 10;
  static const shape::Index max_iworking_ = 2;

  virtual double getTimeStep() const = 0;
  virtual bool isThermal() const = 0;
  virtual bool isCreep() const = 0;
  virtual bool isFluid() const = 0;
  virtual bool trackEnergy() const = 0;
  virtual void* getTableIndexFromID(const shape::Text& id) const = 0;
  virtual double getYFromX(void* table, const double& x) const = 0;
  virtual double getSlopeFromX(void* table, const double& x) const = 0;

  // The values that the SDK's constructor writes are not public; a model cannot use them, so they are NaN here.
  State() {
    for (double& number : working_) number = not_a_number;
  }

  shape::Index state_ = ~shape::Index{0};  // bits in the order of JointModel::getStates
  double area_ = not_a_number;
  double normal_force_ = not_a_number;
  DVect3 shear_force_;
  double normal_disp_ = not_a_number;
  DVect3 shear_disp_;
  double normal_disp_inc_ = not_a_number;
  DVect3 shear_disp_inc_;
  double normal_force_inc_ = not_a_number;  // out
  DVect3 shear_force_inc_;                  // out
  double dnop_ = not_a_number;              // out: part of normal_disp_inc_ after which the contact is in tension
  double working_[max_working_];
  std::int32_t iworking_[max_iworking_] = {-1, -1};

 protected:
  ~State() = default;  // 3DEC never deletes through it: not virtual

 private:
  static constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace jmodels
