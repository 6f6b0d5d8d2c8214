// Stand-in for the SDK's declaration of a 3DEC joint model, from its public member names and arguments. It has the
// members that a model implements or calls. Not binary compatible with 3DEC: a plug-in is built against the SDK.
#pragma once

#include <iostream>
#include <vector>

#include "jmodelbase.h"

namespace jmodels {

struct State;  // a declaration only, as in the SDK: a model includes state.h itself

class JointModel {
 public:
  virtual ~JointModel() = default;
  virtual shape::Text getName() const = 0;
  virtual shape::Text getPluginName() const { return getName(); }
  virtual shape::Text getFullName() const = 0;
  virtual shape::Index getMinorVersion() const { return 0; }
  virtual shape::Text getProperties() const = 0;  // names, separated by commas; synonyms of one by spaces
  virtual shape::Text getStates() const = 0;      // names, separated by commas
  virtual shape::Value getProperty(shape::Index index) const = 0;  // the first has index 1
  virtual void setProperty(shape::Index, const shape::Value&, shape::Index = 0) { setValid(0); }
  virtual void save(std::ostream&) const {}
  virtual void restore(std::istream&, shape::Index) {}
  virtual JointModel* clone() const = 0;
  virtual double getMaxNormalStiffness() const = 0;
  virtual double getMaxShearStiffness() const = 0;
  virtual void copy(const JointModel* other) {
    valid_ = other->valid_;
    can_fail_ = other->can_fail_;
  }
  virtual void run(shape::Dimension dim, State* state) {
    if (!isValid(dim)) initialize(dim, state);
  }
  virtual void initialize(shape::Dimension dim, State*) { setValid(dim); }
  virtual void destroy() { delete this; }
  virtual bool isSliding(const State&) { return false; }
  virtual bool isBonded(const State&) { return true; }

  enum EnergyKeys { kwEStrainShear = 1, kwEStrainCompression, kwEStrainTension, kwESlip };
  virtual shape::Text getEnergies() const {
    const char* const names = "energy-strain-shear,energy-strain-compression,energy-strain-tension,energy-slip";
    return {names, names + std::char_traits<char>::length(names)};
  }
  virtual double getEnergy(shape::Index) const { return 0.0; }
  virtual bool getEnergyAccumulate(shape::Index) const { return false; }
  virtual void setEnergy(shape::Index, const double&) {}
  virtual void activateEnergy() {}
  virtual bool getEnergyActivated() const { return false; }

  bool isValid(shape::Dimension dim) const { return valid_ == dim; }
  void setValid(shape::Dimension dim) { valid_ = dim; }
  bool canFail() const { return can_fail_; }
  void setIfCanFail(bool can) { can_fail_ = can; }
  bool getPlugIn() const { return plugin_; }
  void setPlugIn(bool plugin) { plugin_ = plugin; }

 private:
  shape::Dimension valid_ = 0;
  bool can_fail_ = true;
  bool plugin_ = false;
};

}  // namespace jmodels
