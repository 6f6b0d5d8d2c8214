// Joint model of a plug-in whose law is missing or refused.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "3dec/interface_types.h"

namespace quoin::threedec {

// Has no properties; `initialize` and `run` throw std::runtime_error with the reason.
class UnservedModel final : public jmodels::JointModel {
 public:
  UnservedModel(std::string law, std::string reason) : law_(std::move(law)), reason_(std::move(reason)) {}

  Text getName() const override { return text(law_); }
  Text getFullName() const override { return text(law_ + " (not available: " + reason_ + ")"); }
  Text getProperties() const override { return text(""); }
  Text getStates() const override { return text(""); }
  Value getProperty(Index) const override { return 0.0; }
  jmodels::JointModel* clone() const override { return new UnservedModel(law_, reason_); }
  double getMaxNormalStiffness() const override { return 0.0; }
  double getMaxShearStiffness() const override { return 0.0; }
  void initialize(Dimension, jmodels::State*) override { throw std::runtime_error(reason_); }
  void run(Dimension, jmodels::State*) override { throw std::runtime_error(reason_); }

 private:
  std::string law_, reason_;
};

}  // namespace quoin::threedec
