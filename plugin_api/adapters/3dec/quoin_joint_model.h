// A Quoin law as a 3DEC joint model: one object for each contact point, with the law's states.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "3dec/interface_types.h"
#include "3dec/shear_axes.h"
#include "quoin/quoin.h"
#include "shared/material.h"
#include "shared/point.h"

namespace quoin::threedec {

// The law that a plug-in serves, shared by all of its models.
struct ServedLaw {
  // Finds the law by name, see shared/law_library.h. Throws std::runtime_error if it is missing or not usable in 3DEC.
  explicit ServedLaw(const std::string& law_name);

  std::string name;
  const quoin_law& law;
  std::vector<const quoin_property_info*> properties;  // adapters::scalar_properties of the law
};

class QuoinJointModel final : public jmodels::JointModel {
 public:
  // The law must outlive the model.
  explicit QuoinJointModel(const ServedLaw& law);

  Text getName() const override;
  Text getFullName() const override;
  Index getMinorVersion() const override { return 1; }
  // Names of the law's numbers and choices (by index) in its order, then initial_state (by index), then the states,
  // which are read-only.
  Text getProperties() const override;
  Text getStates() const override { return text("slip-n,tension-n,slip-p,tension-p,cap-n,cap-p"); }
  Value getProperty(Index index) const override;
  void setProperty(Index index, const Value& value, Index restore_version = 0) override;
  void save(std::ostream& stream) const override;
  void restore(std::istream& stream, Index restore_version) override;
  jmodels::JointModel* clone() const override { return new QuoinJointModel(served_); }
  // Pa/m. 0 while the properties make no material. For 3DEC 9, whose Maxwell damping uses it, the current stiffness:
  // see README.
  double getMaxNormalStiffness() const override;
  double getMaxShearStiffness() const override;
  void copy(const jmodels::JointModel* other) override;
  void run(Dimension dim, jmodels::State* state) override;
  void initialize(Dimension dim, jmodels::State* state) override;
  bool isSliding(const jmodels::State& state) override;
  bool isBonded(const jmodels::State& state) override;

  Text getEnergies() const override;
  double getEnergy(Index key) const override;
  bool getEnergyAccumulate(Index key) const override;
  void setEnergy(Index key, const double& value) override;
  void activateEnergy() override { energy_activated_ = true; }
  bool getEnergyActivated() const override { return energy_activated_; }

 private:
  enum Energy { strain_shear, strain_compression, strain_tension, slip, fracture_tension, fracture_shear, crushing };
  static constexpr std::size_t energy_count = 7;

  // State of a contact point between steps; forces and state bits are 3DEC's.
  struct Memory {
    bool started = false;
    double jump = 0.0;                 // d_n, m
    double closure = 0.0;              // m, last closure at zero pressure: crushing less uplift
    double reach = 0.0;                // m, largest |d_n| so far, the scale of rounding of lengths
    std::array<double, 3> traction{};  // Pa, its shear along the axes, as the vector states
    std::array<double, energy_count> energies{};
    ShearAxes axes;
    double area = 0.0;                  // m2, area of the last step with an area
    double force[3] = {0.0, 0.0, 0.0};  // N, shear force of the last step
    DVect3 shear_force() const { return {force[0], force[1], force[2]}; }
    void keep_shear_force(const DVect3& f) { force[0] = f.x(), force[1] = f.y(), force[2] = f.z(); }
  };

  const adapters::Material* known_material() const;
  double normal_stiffness_now(const adapters::Material& material) const;
  void start(const jmodels::State& state);
  void evaluate(adapters::PointBatch& point, const adapters::Material& material, const std::array<double, 2>& sliding,
                double* to) const;
  const adapters::PointBatch& standing(const adapters::Material& material, unsigned asked) const;
  Index step(const std::array<double, 2>& sliding, const jmodels::State& state);
  void take_forces(const jmodels::State& s);
  void give_forces(double normal_force, const DVect3& shear_force, jmodels::State& s);
  void book_energies(double area, double stored, const double* dissipated);

  const ServedLaw& served_;
  const quoin_law& law_;
  std::vector<double> values_;  // NaN: the law's default
  std::size_t initial_state_ = 0;
  const adapters::Material* material_ = nullptr;  // null: to be made from values_, which have changed
  Memory memory_;
  std::vector<double> states_;
  bool energy_activated_ = false;
};

}  // namespace quoin::threedec
