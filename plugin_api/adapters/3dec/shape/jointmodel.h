// A 3DEC joint model as its SDK declares it (member names and arguments, public facts), declared anew: the members that
// a model implements or calls. Not binary compatible with 3DEC: build against the SDK for that.
#pragma once

#include <iostream>
#include <vector>

#include "state.h"

namespace jmodels {

class JointModel {
 public:
  virtual ~JointModel() = default;
  virtual String getName() const = 0;
  virtual String getPluginName() const { return getName(); }
  virtual String getFullName() const = 0;
  virtual UInt getMinorVersion() const { return 0; }
  virtual String getProperties() const = 0;           // names, separated by commas
  virtual String getStates() const = 0;               // names, separated by commas
  virtual Variant getProperty(UInt index) const = 0;  // the first has index 1
  virtual void setProperty(UInt, const Variant&, UInt = 0) { setValid(0); }
  virtual void save(std::ostream&) const {}
  virtual void restore(std::istream&, UInt) {}
  virtual JointModel* clone() const = 0;
  virtual Double getMaxNormalStiffness() const = 0;
  virtual Double getMaxShearStiffness() const = 0;
  virtual void copy(const JointModel* other) {
    valid_ = other->valid_;
    can_fail_ = other->can_fail_;
  }
  virtual void run(UByte dim, State* state) {
    if (!isValid(dim)) initialize(dim, state);
  }
  virtual void initialize(UByte dim, State*) { setValid(dim); }
  virtual Double getStressStrengthRatio(const State&) const { return 10.0; }
  virtual void scaleProperties(const Double&, const std::vector<UInt>&) {}
  virtual bool supportsStressStrengthRatio() const { return false; }
  virtual bool supportsPropertyScaling() const { return false; }
  virtual void destroy() { delete this; }
  virtual bool isSliding(const State&) { return false; }
  virtual bool isBonded(const State&) { return true; }

  enum EnergyKeys { kwEStrainShear = 1, kwEStrainCompression, kwEStrainTension, kwESlip };
  virtual String getEnergies() const {
    return L"energy-strain-shear,energy-strain-compression,energy-strain-tension,energy-slip";
  }
  virtual double getEnergy(UInt) const { return 0.0; }
  virtual bool getEnergyAccumulate(UInt) const { return false; }
  virtual void setEnergy(UInt, const double&) {}
  virtual void activateEnergy() {}
  virtual bool getEnergyActivated() const { return false; }

  bool isValid(UByte dim) const { return valid_ == dim; }
  void setValid(UByte dim) { valid_ = dim; }
  bool canFail() const { return can_fail_; }
  void setIfCanFail(bool can) { can_fail_ = can; }
  bool getPlugIn() const { return plugin_; }
  void setPlugIn(bool plugin) { plugin_ = plugin; }

 private:
  UByte valid_ = 0;
  bool can_fail_ = true;
  bool plugin_ = false;
};

}  // namespace jmodels
