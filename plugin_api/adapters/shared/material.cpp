#include "shared/material.h"

#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <stdexcept>

#include "shared/point.h"

namespace quoin::adapters {

std::vector<const quoin_property_info*> scalar_properties(const quoin_law& law) {
  std::vector<const quoin_property_info*> found;
  for (std::uint64_t i = 0; i < law.property_count; ++i)
    if (law.properties[i]->kind != QUOIN_PROPERTY_TABLE) found.push_back(law.properties[i]);
  return found;
}

double value_in_force(std::span<const quoin_property_info* const> properties, std::span<const double> values,
                      std::size_t i) {
  if (!std::isnan(values[i])) return values[i];
  const quoin_property_info& info = *properties[i];
  if (info.default_from != nullptr)
    for (std::size_t k = 0; k < properties.size(); ++k)
      if (std::strcmp(properties[k]->id, info.default_from) == 0) return value_in_force(properties, values, k);
  for (std::uint64_t c = 0; c < info.choice_count; ++c)
    if (std::strcmp(info.choices[c], info.default_text) == 0) return static_cast<double>(c);
  return (info.flags & QUOIN_PROPERTY_REQUIRED) != 0 ? 0.0 : info.default_value;
}

PropertyValue scalar_value(const quoin_property_info& property, double number) {
  if (property.kind == QUOIN_PROPERTY_NUMBER) return {property.id, {number}, {}};
  for (std::uint64_t i = 0; i < property.choice_count; ++i)
    if (number == static_cast<double>(i)) return {property.id, {}, property.choices[i]};
  std::string allowed;
  for (std::uint64_t i = 0; i < property.choice_count; ++i)
    allowed += (i > 0 ? ", " : "") + std::to_string(i) + " " + property.choices[i];
  throw std::runtime_error(std::string(property.id) + " = " + std::to_string(number) + ": give one of " + allowed);
}

Material::Material(const quoin_law& law, const std::vector<PropertyValue>& values)
    : api::Material(law, values), elastic_(stiffness()) {
  constexpr double closing = 1e-12;  // m, more than rounding of 0, less than any strength
  if ((law.capabilities & QUOIN_CAN_TANGENT) == 0) return;
  PointBatch& point = PointBatch::of_thread(law, outputs::tangent);
  std::vector<double> states = initial_state(law.initial_states[0]);
  point.states(states.data(), states.data());
  point.normal_jump = -closing;
  for (double& slip : point.slip) slip = 0.0;
  for (double& traction : point.traction) traction = 0.0;
  if (point.evaluate(*this) == QUOIN_POINT_FAILED) return;
  elastic_.normal = point.tangent[0], elastic_.shear = point.tangent[4];
}

std::unique_ptr<Material> scalar_material(const quoin_law& law, std::span<const double> scalars) {
  const std::vector<const quoin_property_info*> infos = scalar_properties(law);
  std::vector<PropertyValue> values;
  for (std::size_t i = 0; i < infos.size(); ++i)
    if (!std::isnan(scalars[i])) values.push_back(scalar_value(*infos[i], scalars[i]));
  return std::make_unique<Material>(law, values);
}

const Material& shared_material(const quoin_law& law, std::span<const double> scalars) {
  static std::mutex mutex;
  static std::map<std::pair<const quoin_law*, std::string>, std::unique_ptr<Material>> materials;
  // Materials by the bytes of their values, since NaN is a valid value.
  std::string bytes(reinterpret_cast<const char*>(scalars.data()), scalars.size_bytes());
  const std::lock_guard lock(mutex);
  std::unique_ptr<Material>& entry = materials[{&law, std::move(bytes)}];
  if (entry == nullptr) entry = scalar_material(law, scalars);
  return *entry;
}

}  // namespace quoin::adapters
