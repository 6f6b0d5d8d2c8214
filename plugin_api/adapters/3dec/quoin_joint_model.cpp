#include "3dec/quoin_joint_model.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "3dec/shear_axes.h"
#include "shared/law_library.h"
#include "shared/point.h"

namespace quoin::threedec {

namespace {

// The first four bits as in 3DEC's own models, which its commands and plots know.
constexpr UInt slip_now = 1, tension_now = 2, slip_past = 4, tension_past = 8, crush_past = 16;

UInt state_bits(UInt before, std::uint32_t flags) {
  UInt bits = before & (slip_past | tension_past);
  if ((before & slip_now) != 0) bits |= slip_past;
  if ((before & tension_now) != 0) bits |= tension_past;
  if ((flags & QUOIN_FLAG_SLIPPING) != 0) bits |= slip_now;
  if ((flags & QUOIN_FLAG_OPEN) != 0 && (flags & QUOIN_FLAG_TENSION_DAMAGED) != 0) bits |= tension_now;
  if ((flags & QUOIN_FLAG_CRUSHED) != 0) bits |= crush_past;
  return bits;
}

String wide(const std::string& text) { return {text.begin(), text.end()}; }

template <class T>
void write(std::ostream& stream, const T* data, std::size_t count) {
  stream.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(count * sizeof(T)));
}

template <class T>
void read(std::istream& stream, T* data, std::size_t count) {
  stream.read(reinterpret_cast<char*>(data), static_cast<std::streamsize>(count * sizeof(T)));
}

}  // namespace

QuoinJointModel::QuoinJointModel(const std::string& law)
    : law_(&adapters::law_by_name(law)),
      infos_(adapters::scalar_properties(*law_)),
      values_(infos_.size(), std::numeric_limits<double>::quiet_NaN()),
      states_(law_->state_count) {
  for (std::uint64_t k = 0; k < law_->state_count; ++k)
    if (law_->states[k]->kind != QUOIN_STATE_SCALAR)
      throw std::runtime_error(std::string(law_->id) + ": state " + law_->states[k]->id +
                               " is a vector of the contact plane, whose axes 3DEC does not tell; give it as scalars");
}

String QuoinJointModel::getName() const { return wide(law_->id); }

String QuoinJointModel::getFullName() const { return wide(std::string(law_->name) + " (Quoin " + law_->version + ")"); }

String QuoinJointModel::getProperties() const {
  std::string names;
  for (const quoin_property_info* info : infos_) names += std::string(info->id) + ",";
  names += "initial_state";
  for (std::uint64_t k = 0; k < law_->state_count; ++k) names += std::string(",") + law_->states[k]->id;
  return wide(names);
}

// 3DEC saves what it reads here and sets it again when it restores: the default that is in force, not that it is one.
double QuoinJointModel::value_in_force(std::size_t property) const {
  if (!std::isnan(values_[property])) return values_[property];
  const quoin_property_info& info = *infos_[property];
  if (info.default_from != nullptr)
    for (std::size_t i = 0; i < infos_.size(); ++i)
      if (std::strcmp(infos_[i]->id, info.default_from) == 0) return value_in_force(i);
  for (std::uint64_t c = 0; c < info.choice_count; ++c)
    if (std::strcmp(info.choices[c], info.default_text) == 0) return static_cast<double>(c);
  return (info.flags & QUOIN_PROPERTY_REQUIRED) != 0 ? 0.0 : info.default_value;
}

Variant QuoinJointModel::getProperty(UInt index) const {
  const std::size_t i = index - 1;  // 0 becomes too large
  if (i < infos_.size()) return value_in_force(i);
  if (i == infos_.size()) return static_cast<double>(initial_state_);
  return i < infos_.size() + 1 + states_.size() ? states_[i - infos_.size() - 1] : 0.0;
}

void QuoinJointModel::setProperty(UInt index, const Variant& value, UInt restore_version) {
  JointModel::setProperty(index, value, restore_version);
  const std::size_t i = index - 1;
  if (i < infos_.size()) {
    values_[i] = value.toDouble();
    material_ = nullptr;
  } else if (i == infos_.size()) {
    const double number = value.toDouble();
    if (!(number >= 0.0 && number < static_cast<double>(law_->initial_state_count)))
      throw std::runtime_error("initial_state = " + std::to_string(number) + ": give an index from 0 to " +
                               std::to_string(law_->initial_state_count - 1));
    initial_state_ = static_cast<std::size_t>(number);
  } else if (restore_version == 0) {
    throw std::runtime_error("property " + std::to_string(index) +
                             " is a state of the law: it can be read, not set; choose the start by initial_state");
  }
}

void QuoinJointModel::save(std::ostream& stream) const {
  JointModel::save(stream);
  const std::uint64_t schema = law_->state_schema;
  write(stream, &schema, 1);
  write(stream, &memory_, 1);
  write(stream, states_.data(), states_.size());
}

void QuoinJointModel::restore(std::istream& stream, UInt restore_version) {
  JointModel::restore(stream, restore_version);
  std::uint64_t schema = 0;
  read(stream, &schema, 1);
  if (schema != law_->state_schema)
    throw std::runtime_error(std::string(law_->id) + " " + law_->version +
                             ": the save file was written with another version of the law, whose states differ");
  read(stream, &memory_, 1);
  read(stream, states_.data(), states_.size());
  if (!stream) throw std::runtime_error(std::string(law_->id) + ": the save file ends within a contact");
}

void QuoinJointModel::copy(const JointModel* other) {
  const auto* from = dynamic_cast<const QuoinJointModel*>(other);
  if (from == nullptr || from->law_ != law_)
    throw std::runtime_error(std::string(law_->id) + ": a contact of another joint model cannot be copied from");
  JointModel::copy(other);
  values_ = from->values_;
  initial_state_ = from->initial_state_;
  material_ = from->material_;
  memory_ = from->memory_;
  states_ = from->states_;
  energy_activated_ = from->energy_activated_;
}

// 3DEC asks for stiffnesses before the first step, and again after properties have been set.
const adapters::Material& QuoinJointModel::material() const {
  return material_ != nullptr ? *material_ : adapters::shared_material(*law_, values_);
}

Double QuoinJointModel::getMaxNormalStiffness() const { return material().stiffness().normal; }
Double QuoinJointModel::getMaxShearStiffness() const { return material().stiffness().shear; }

void QuoinJointModel::initialize(UByte dim, jmodels::State* state) {
  JointModel::initialize(dim, state);
  material_ = &material();
}

// Forces that are there before the first step (gravity, in-situ stress) are taken as elastic: they fix d_n.
void QuoinJointModel::start(const jmodels::State& state) {
  material_->initial_state(law_->initial_states[initial_state_], states_.data());
  memory_.jump = -state.normal_force_ / state.area_ / material_->stiffness().normal;
  memory_.started = true;
}

void QuoinJointModel::run(UByte dim, jmodels::State* state) {
  JointModel::run(dim, state);
  jmodels::State& s = *state;
  if (s.area_ <= 0.0) return;
  if (!memory_.started) start(s);
  memory_.jump += s.normal_disp_inc_;

  const ShearAxes axes(s.shear_force_ / -s.area_, s.shear_disp_inc_);
  double traction[3] = {-s.normal_force_ / s.area_, axes.traction(), 0.0};
  double stored = 0.0, dissipated[QUOIN_DISSIPATED_COUNT] = {};
  std::uint32_t flags = 0;
  if (canFail()) {
    adapters::PointStep step;
    step.normal_jump = memory_.jump;
    step.slip[0] = axes.slip()[0];
    step.slip[1] = axes.slip()[1];
    step.traction_old = step.traction_new = traction;
    step.state_old = step.state_new = states_.data();
    const bool energies = (energy_activated_ || s.trackEnergy()) && (law_->capabilities & QUOIN_CAN_ENERGY) != 0;
    if (energies) step.energy_stored = &stored, step.dissipated = dissipated;
    if (adapters::evaluate(*material_, step) == QUOIN_POINT_FAILED)
      throw std::runtime_error(std::string(law_->id) + ": normal increment " + std::to_string(s.normal_disp_inc_) +
                               " m or the force before it is not finite; the time step may be unstable");
    if (energies) book_energies(s.area_, traction, stored, dissipated);
    flags = step.flags;
  } else {  // 3DEC's elastic phases
    const quoin_stiffness_bounds& stiffness = material_->stiffness();
    traction[0] += stiffness.normal * s.normal_disp_inc_;
    traction[1] += stiffness.shear * axes.slip()[0];
    traction[2] += stiffness.shear * axes.slip()[1];
  }

  const double normal_force = -traction[0] * s.area_;
  const DVect3 shear_force = axes.vector(traction[1], traction[2]) * -s.area_;
  s.normal_force_inc_ = normal_force - s.normal_force_;
  s.shear_force_inc_ = shear_force - s.shear_force_;
  s.dnop_ = s.normal_disp_inc_;
  if (s.normal_force_ > 0.0 && normal_force <= 0.0 && s.normal_force_inc_ < 0.0)
    s.dnop_ = -s.normal_disp_inc_ * s.normal_force_ / s.normal_force_inc_;
  s.normal_force_ = normal_force;
  s.shear_force_ = shear_force;
  s.state_ = state_bits(s.state_, flags);
  memory_.flags = flags;
}

bool QuoinJointModel::isSliding(const jmodels::State& state) { return (state.state_ & slip_now) != 0; }

bool QuoinJointModel::isBonded(const jmodels::State&) {
  return (memory_.flags & (QUOIN_FLAG_TENSION_COMPLETE | QUOIN_FLAG_SHEAR_COMPLETE)) == 0;
}

String QuoinJointModel::getEnergies() const {
  return JointModel::getEnergies() + L",energy-fracture-tension,energy-fracture-shear,energy-crushing";
}

double QuoinJointModel::getEnergy(UInt key) const {
  return key >= 1 && key <= energy_count ? memory_.energies[key - 1] : 0.0;
}

bool QuoinJointModel::getEnergyAccumulate(UInt key) const { return key > strain_tension + 1; }

void QuoinJointModel::setEnergy(UInt key, const double& value) {
  if (key >= 1 && key <= energy_count) memory_.energies[key - 1] = value;
}

// A law says what is stored as one number: the elastic shear part of it is known, the rest is normal.
void QuoinJointModel::book_energies(double area, const double* traction, double stored, const double* dissipated) {
  std::array<double, energy_count>& e = memory_.energies;
  const double shear = std::hypot(traction[1], traction[2]);
  e[strain_shear] = area * shear * shear / (2.0 * material_->stiffness().shear);
  const double normal = area * stored - e[strain_shear];
  e[strain_compression] = traction[0] <= 0.0 ? normal : 0.0;
  e[strain_tension] = traction[0] > 0.0 ? normal : 0.0;
  e[slip] += area * dissipated[QUOIN_DISSIPATED_FRICTION];
  e[fracture_tension] += area * dissipated[QUOIN_DISSIPATED_TENSION];
  e[fracture_shear] += area * dissipated[QUOIN_DISSIPATED_COHESION];
  e[crushing] += area * dissipated[QUOIN_DISSIPATED_CRUSHING];
}

}  // namespace quoin::threedec
