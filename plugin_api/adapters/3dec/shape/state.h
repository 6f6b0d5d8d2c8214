// What 3DEC passes to a joint model for one contact point and step. Compression is positive, forces are forces;
// displacements open positive, and shear vectors lie in the contact plane.
#pragma once

#include "jmodelbase.h"

namespace jmodels {

struct State {
  static const UInt max_working_ = 10;
  static const UInt max_iworking_ = 2;

  virtual ~State() = default;
  virtual Double getTimeStep() const = 0;
  virtual bool isThermal() const = 0;
  virtual bool isCreep() const = 0;
  virtual bool isFluid() const = 0;
  virtual bool trackEnergy() const = 0;
  virtual void* getTableIndexFromID(const String& id) const = 0;
  virtual Double getYFromX(void* table, const Double& x) const = 0;
  virtual Double getSlopeFromX(void* table, const Double& x) const = 0;

  UInt state_ = 0;  // bits in the order of JointModel::getStates
  Double area_ = 0.0;
  Double normal_force_ = 0.0;
  DVect3 shear_force_;
  Double normal_disp_ = 0.0;
  DVect3 shear_disp_;
  Double normal_disp_inc_ = 0.0;
  DVect3 shear_disp_inc_;
  Double normal_force_inc_ = 0.0;  // out
  DVect3 shear_force_inc_;         // out
  Double dnop_ = 0.0;              // out: the part of normal_disp_inc_ after which the contact is in tension
  Double working_[max_working_] = {};
  Int iworking_[max_iworking_] = {};
};

}  // namespace jmodels
