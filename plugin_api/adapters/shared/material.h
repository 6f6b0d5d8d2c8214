// Materials from plain numbers, as other programs pass them.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "quoin.hpp"

namespace quoin::adapters {

using PropertyValue = api::Value;

class Material : public api::Material {
 public:
  // Throws as api::Material does.
  Material(const quoin_law& law, const std::vector<PropertyValue>& values);
  // Normal and shear stiffness of a closed joint that nothing has changed, Pa/m. They are the law's tangent there.
  // Without a tangent they are its stiffness bounds, which may be larger, as of a joint that dilates.
  const quoin_stiffness_bounds& elastic() const { return elastic_; }

 private:
  quoin_stiffness_bounds elastic_;
};

// Returns the properties that one number can give, in the law's order: numbers, and choices by their index. Tables are
// excluded: they have the law's default.
std::vector<const quoin_property_info*> scalar_properties(const quoin_law& law);

// Returns the value of property i, given or default. values: of all scalar_properties, NaN for the law's default. 0 for
// a required property that is not given.
double value_in_force(std::span<const quoin_property_info* const> properties, std::span<const double> values,
                      std::size_t i);

// Returns the property value for a number. Throws std::runtime_error for the index of a choice that does not exist.
PropertyValue scalar_value(const quoin_property_info& property, double number);

// Returns a new material of the values of scalar_properties, NaN for the law's default. Throws as Material does.
std::unique_ptr<Material> scalar_material(const quoin_law& law, std::span<const double> scalars);

// Returns the material of these values that all points of the process share; it is never freed. Throws as Material
// does. May be called from any thread.
const Material& shared_material(const quoin_law& law, std::span<const double> scalars);

}  // namespace quoin::adapters
