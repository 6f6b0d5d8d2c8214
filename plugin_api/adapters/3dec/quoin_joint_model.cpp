#include "3dec/quoin_joint_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "3dec/property_synonyms.h"
#include "shared/law_library.h"
#include "shared/point.h"

namespace quoin::threedec {

namespace {

// State bits: the first four as in 3DEC's models, for its commands and plots; those of the cap as in published models.
constexpr Index slip_now = 1, tension_now = 2, slip_past = 4, tension_past = 8, crush_now = 16, crush_past = 32;

Index state_bits(Index before, Index now) {
  constexpr Index all_now = slip_now | tension_now | crush_now;
  Index past = before & (slip_past | tension_past | crush_past);
  if ((before & slip_now) != 0) past |= slip_past;
  if ((before & tension_now) != 0) past |= tension_past;
  if ((before & crush_now) != 0) past |= crush_past;
  return past | (now & all_now);
}

constexpr std::uint64_t save_format = 0x6a6f696e74320000;  // changes whenever Memory changes

template <class T>
void write(std::ostream& stream, const T* data, std::size_t count) {
  stream.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(count * sizeof(T)));
}

template <class T>
void read(std::istream& stream, T* data, std::size_t count) {
  stream.read(reinterpret_cast<char*>(data), static_cast<std::streamsize>(count * sizeof(T)));
}

}  // namespace

ServedLaw::ServedLaw(const std::string& law_name)
    : name(law_name), law(adapters::law_by_name(law_name)), properties(adapters::scalar_properties(law)) {}

QuoinJointModel::QuoinJointModel(const ServedLaw& law)
    : served_(law),
      law_(law.law),
      values_(law.properties.size(), std::numeric_limits<double>::quiet_NaN()),
      states_(law.law.state_count) {}

Text QuoinJointModel::getName() const { return text(served_.name); }

Text QuoinJointModel::getFullName() const { return text(std::string(law_.name) + " (Quoin " + law_.version + ")"); }

Text QuoinJointModel::getProperties() const {
  std::string names;
  for (const quoin_property_info* info : served_.properties) {
    names += info->id;
    if (const std::string_view other = synonym(info->id); !other.empty()) names.append(" ").append(other);
    names += ",";
  }
  names += "initial_state";
  for (std::uint64_t k = 0; k < law_.state_count; ++k) names.append(",").append(law_.states[k]->id);
  return text(names);
}

// Returns the value, given or default. 3DEC saves it and sets it at a restore: a restored default is a given value.
Value QuoinJointModel::getProperty(Index index) const {
  const std::size_t i = index - 1, count = values_.size();  // index 0 becomes too large
  if (i < count) return adapters::value_in_force(served_.properties, values_, i);
  if (i == count) return static_cast<double>(initial_state_);
  return i < count + 1 + states_.size() ? states_[i - count - 1] : 0.0;
}

void QuoinJointModel::setProperty(Index index, const Value& value, Index restore_version) {
  JointModel::setProperty(index, value, restore_version);
  const std::size_t i = index - 1;
  if (i < values_.size()) {
    values_[i] = number(value);
    material_ = nullptr;
  } else if (i == values_.size()) {
    const double given = number(value);
    if (!(given >= 0.0 && given < static_cast<double>(law_.initial_state_count)))
      throw std::runtime_error("initial_state = " + std::to_string(given) + ": give an index from 0 to " +
                               std::to_string(law_.initial_state_count - 1));
    initial_state_ = static_cast<std::size_t>(given);
  } else if (restore_version == 0) {
    throw std::runtime_error("property " + std::to_string(index) +
                             " is a state of the law: it can be read, not set; choose the start by initial_state");
  }
}

void QuoinJointModel::save(std::ostream& stream) const {
  JointModel::save(stream);
  const std::uint64_t schema[] = {save_format, law_.state_schema};
  write(stream, schema, 2);
  write(stream, &memory_, 1);
  write(stream, states_.data(), states_.size());
}

void QuoinJointModel::restore(std::istream& stream, Index restore_version) {
  JointModel::restore(stream, restore_version);
  std::uint64_t schema[] = {0, 0};
  read(stream, schema, 2);
  if (schema[0] != save_format || schema[1] != law_.state_schema)
    throw std::runtime_error(std::string(law_.id) + " " + law_.version +
                             ": the save file was written with another version of the law, whose states differ, or of "
                             "this joint model");
  read(stream, &memory_, 1);
  read(stream, states_.data(), states_.size());
  if (!stream) throw std::runtime_error(std::string(law_.id) + ": the save file ends within a contact");
}

void QuoinJointModel::copy(const JointModel* other) {
  const auto* from = dynamic_cast<const QuoinJointModel*>(other);
  if (from == nullptr || &from->law_ != &law_)
    throw std::runtime_error(std::string(law_.id) + ": a contact of another joint model cannot be copied from");
  JointModel::copy(other);
  values_ = from->values_;
  initial_state_ = from->initial_state_;
  material_ = from->material_;
  memory_ = from->memory_;
  states_ = from->states_;
  energy_activated_ = from->energy_activated_;
}

// Returns the material of the properties set so far, or null if they make none. initialize and run throw the reason.
const adapters::Material* QuoinJointModel::known_material() const {
  if (material_ != nullptr) return material_;
  try {
    return &adapters::shared_material(law_, values_);
  } catch (const std::runtime_error&) {
    return nullptr;
  }
}

// Returns d sigma / d d_n at the current state, Pa/m.
double QuoinJointModel::normal_stiffness_now(const adapters::Material& material) const {
  const double bound = material.stiffness().normal;
  if (!memory_.started || (law_.capabilities & QUOIN_CAN_TANGENT) == 0) return bound;
  return std::clamp(standing(material, adapters::outputs::tangent).tangent[0], 0.0, bound);
}

// 3DEC calls this also before the first step and before all properties are set.
double QuoinJointModel::getMaxNormalStiffness() const {
  const adapters::Material* const material = known_material();
  if (material == nullptr) return 0.0;
  return version == 9 ? normal_stiffness_now(*material) : material->stiffness().normal;
}

double QuoinJointModel::getMaxShearStiffness() const {
  const adapters::Material* const material = known_material();
  return material != nullptr ? material->stiffness().shear : 0.0;
}

void QuoinJointModel::initialize(Dimension dim, jmodels::State* state) {
  JointModel::initialize(dim, state);
  if (material_ == nullptr) material_ = &adapters::shared_material(law_, values_);
}

// Sets the initial state. Normal force before the first step (gravity, in-situ stress) counts as elastic and gives d_n.
void QuoinJointModel::start(const jmodels::State& state) {
  states_ = material_->initial_state(law_.initial_states[initial_state_]);
  memory_.jump = -state.normal_force_ / state.area_ / material_->elastic().normal;
  memory_.started = true;
}

// Evaluates a step to memory_.jump with slip `sliding`, from memory_.traction and states_. Writes new states to `to`.
void QuoinJointModel::evaluate(adapters::PointBatch& point, const adapters::Material& material,
                               const std::array<double, 2>& sliding, double* to) const {
  point.normal_jump = memory_.jump;
  for (std::size_t k = 0; k < 2; ++k) point.slip[k] = sliding[k];
  for (std::size_t k = 0; k < 3; ++k) point.traction[k] = memory_.traction[k];
  point.states(states_.data(), to);
  if (point.evaluate(material) == QUOIN_POINT_FAILED)
    throw std::runtime_error(std::string(law_.id) + ": opening " + std::to_string(memory_.jump) +
                             " m or the force before the step is not finite; the time step may be unstable");
}

// Evaluates a step without motion for the outputs `asked`, at the current state.
const adapters::PointBatch& QuoinJointModel::standing(const adapters::Material& material, unsigned asked) const {
  adapters::PointBatch& point = adapters::PointBatch::of_thread(law_, asked);
  std::array<double, adapters::max_states> unused;
  evaluate(point, material, {0.0, 0.0}, unused.data());
  return point;
}

// Updates memory_ and states_ to the end of the step and returns the bits of this step. The bits are computed from the
// forces, as in 3DEC's models: the law's flags would multiply the cost of the step.
Index QuoinJointModel::step(const std::array<double, 2>& sliding, const jmodels::State& state) {
  using namespace adapters;
  const bool energies = (energy_activated_ || state.trackEnergy()) && (law_.capabilities & QUOIN_CAN_ENERGY) != 0;
  PointBatch& point = PointBatch::of_thread(law_, energies ? outputs::energies : outputs::nothing);
  evaluate(point, *material_, sliding, states_.data());
  const double before[2] = {memory_.traction[1], memory_.traction[2]};
  for (std::size_t k = 0; k < 3; ++k) memory_.traction[k] = point.traction[k];
  if (energies) book_energies(state.area_, point.energy_stored, point.dissipated);

  constexpr double rounding = 4.0 * std::numeric_limits<double>::epsilon();
  const double kn = material_->elastic().normal, ks = material_->elastic().shear;
  memory_.reach = std::max(memory_.reach, std::abs(memory_.jump));
  const double short_length = 4.0 * rounding * memory_.reach;
  Index now = 0;
  if (const double opening = memory_.jump + memory_.closure; opening > 0.0) {
    if (kn * opening - memory_.traction[0] > kn * short_length) now |= tension_now;
  } else if (point.any_yielding()) {
    const double closure = memory_.traction[0] / kn - memory_.jump;
    if (closure - memory_.closure > short_length) now |= crush_now;
    if (std::abs(closure - memory_.closure) > short_length) memory_.closure = closure;
  }
  if (point.any_yielding()) {
    const auto length = [](double a, double b) { return std::sqrt(a * a + b * b); };
    const double elastic = length(before[0] + ks * sliding[0], before[1] + ks * sliding[1]);
    const double held = length(memory_.traction[1], memory_.traction[2]);
    if (elastic - held > rounding * elastic) now |= slip_now;
  }
  return now;
}

// Sets memory_ from 3DEC's forces. Its shear force is that of the last step, unless the contact has rotated or its area
// has changed.
void QuoinJointModel::take_forces(const jmodels::State& s) {
  memory_.traction[0] = -s.normal_force_ / s.area_;
  if (same(s.shear_force_, memory_.shear_force()) && s.area_ == memory_.area) return;
  memory_.axes.follow(memory_.shear_force(), s.shear_force_);
  const std::array<double, 2> force = memory_.axes.components(s.shear_force_, s.shear_force_);
  for (std::size_t k = 0; k < 2; ++k) memory_.traction[1 + k] = -force[k] / s.area_;
  memory_.area = s.area_;
}

// Writes the forces of the step, their increments and dnop_ to s.
void QuoinJointModel::give_forces(double normal_force, const DVect3& shear_force, jmodels::State& s) {
  s.normal_force_inc_ = normal_force - s.normal_force_;
  s.shear_force_inc_ = shear_force - s.shear_force_;
  s.dnop_ = s.normal_disp_inc_;
  if (s.normal_force_ > 0.0 && normal_force <= 0.0 && s.normal_force_inc_ < 0.0)
    s.dnop_ = -s.normal_disp_inc_ * s.normal_force_ / s.normal_force_inc_;
  s.normal_force_ = normal_force;
  s.shear_force_ = shear_force;
  memory_.keep_shear_force(shear_force);
}

void QuoinJointModel::run(Dimension dim, jmodels::State* state) {
  JointModel::run(dim, state);
  jmodels::State& s = *state;
  if (s.area_ <= 0.0) {  // no forces; opening and states are kept for a later step with an area
    if (memory_.started) memory_.jump += s.normal_disp_inc_;
    memory_.area = 0.0;
    give_forces(0.0, DVect3(0.0), s);
    s.state_ = state_bits(s.state_, 0);
    return;
  }
  if (!memory_.started) start(s);
  memory_.jump += s.normal_disp_inc_;

  take_forces(s);
  const std::array<double, 2> sliding = memory_.axes.components(s.shear_disp_inc_, s.shear_force_);
  std::array<double, 3>& traction = memory_.traction;
  Index now = 0;
  if (canFail()) {
    now = step(sliding, s);
  } else {  // 3DEC's elastic phases
    traction[0] += material_->elastic().normal * s.normal_disp_inc_;
    for (std::size_t k = 0; k < 2; ++k) traction[1 + k] += material_->elastic().shear * sliding[k];
  }
  give_forces(-traction[0] * s.area_, memory_.axes.vector(traction[1], traction[2]) * -s.area_, s);
  s.state_ = state_bits(s.state_, now);
}

bool QuoinJointModel::isSliding(const jmodels::State& state) { return (state.state_ & slip_now) != 0; }

// True unless the law's flags report complete tension or shear softening.
bool QuoinJointModel::isBonded(const jmodels::State&) {
  const adapters::Material* const material = known_material();
  if (!memory_.started || material == nullptr) return true;
  const std::uint32_t flags = standing(*material, adapters::outputs::flags).flags;
  return (flags & (QUOIN_FLAG_TENSION_COMPLETE | QUOIN_FLAG_SHEAR_COMPLETE)) == 0;
}

Text QuoinJointModel::getEnergies() const {
  const Text base = JointModel::getEnergies();
  return text(std::string(base.begin(), base.end()) + ",energy-fracture-tension,energy-fracture-shear,energy-crushing");
}

double QuoinJointModel::getEnergy(Index key) const {
  return key >= 1 && key <= energy_count ? memory_.energies[key - 1] : 0.0;
}

bool QuoinJointModel::getEnergyAccumulate(Index key) const { return key > strain_tension + 1; }

void QuoinJointModel::setEnergy(Index key, const double& value) {
  if (key >= 1 && key <= energy_count) memory_.energies[key - 1] = value;
}

// A law gives the stored energy as one number: its shear part is the elastic one, the rest is the normal part.
void QuoinJointModel::book_energies(double area, double stored, const double* dissipated) {
  const std::array<double, 3>& traction = memory_.traction;
  std::array<double, energy_count>& e = memory_.energies;
  const double shear = std::hypot(traction[1], traction[2]);
  e[strain_shear] = area * shear * shear / (2.0 * material_->elastic().shear);
  const double normal = area * stored - e[strain_shear];
  e[strain_compression] = traction[0] <= 0.0 ? normal : 0.0;
  e[strain_tension] = traction[0] > 0.0 ? normal : 0.0;
  e[slip] += area * dissipated[QUOIN_DISSIPATED_FRICTION];
  e[fracture_tension] += area * dissipated[QUOIN_DISSIPATED_TENSION];
  e[fracture_shear] += area * dissipated[QUOIN_DISSIPATED_COHESION];
  e[crushing] += area * dissipated[QUOIN_DISSIPATED_CRUSHING];
}

}  // namespace quoin::threedec
