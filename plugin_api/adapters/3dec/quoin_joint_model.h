// Any Quoin law as a 3DEC joint model: one object a contact point, which holds the law's state.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "jointmodel.h"
#include "quoin/quoin.h"
#include "shared/material.h"

namespace quoin::threedec {

class QuoinJointModel final : public jmodels::JointModel {
 public:
  // The law by name, see shared/law_library.h. Throws std::runtime_error.
  explicit QuoinJointModel(const std::string& law);

  String getName() const override;
  String getFullName() const override;
  UInt getMinorVersion() const override { return 1; }
  // The law's numbers and choices (by index) in its order, defaults included; initial_state (by index); the states, to
  // be read only.
  String getProperties() const override;
  String getStates() const override { return L"slip-n,tension-n,slip-p,tension-p,crush-p"; }
  Variant getProperty(UInt index) const override;
  void setProperty(UInt index, const Variant& value, UInt restore_version = 0) override;
  void save(std::ostream& stream) const override;
  void restore(std::istream& stream, UInt restore_version) override;
  jmodels::JointModel* clone() const override { return new QuoinJointModel(law_->id); }
  Double getMaxNormalStiffness() const override;
  Double getMaxShearStiffness() const override;
  void copy(const jmodels::JointModel* other) override;
  void run(UByte dim, jmodels::State* state) override;
  void initialize(UByte dim, jmodels::State* state) override;
  bool isSliding(const jmodels::State& state) override;
  bool isBonded(const jmodels::State& state) override;

  String getEnergies() const override;
  double getEnergy(UInt key) const override;
  bool getEnergyAccumulate(UInt key) const override;
  void setEnergy(UInt key, const double& value) override;
  void activateEnergy() override { energy_activated_ = true; }
  bool getEnergyActivated() const override { return energy_activated_; }

 private:
  enum Energy { strain_shear, strain_compression, strain_tension, slip, fracture_tension, fracture_shear, crushing };
  static constexpr std::size_t energy_count = 7;

  // What a contact point remembers between steps; forces and state bits are 3DEC's.
  struct Memory {
    bool started = false;
    std::uint32_t flags = 0;
    double jump = 0.0;  // d_n, m
    std::array<double, energy_count> energies{};
  };

  const adapters::Material& material() const;
  double value_in_force(std::size_t property) const;
  void start(const jmodels::State& state);
  void book_energies(double area, const double* traction, double stored, const double* dissipated);

  const quoin_law* law_;
  std::vector<const quoin_property_info*> infos_;
  std::vector<double> values_;  // NaN: the law's default
  std::size_t initial_state_ = 0;
  const adapters::Material* material_ = nullptr;  // null: a property has changed since
  Memory memory_;
  std::vector<double> states_;
  bool energy_activated_ = false;
};

}  // namespace quoin::threedec
