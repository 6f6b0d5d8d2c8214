// A material from the plain numbers and words that foreign programs hand over.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "quoin.hpp"

namespace quoin::adapters {

using PropertyValue = api::Value;
using Material = api::Material;

// The properties that one number can give, in the law's order: numbers, and choices by their index. Tables are left
// out: a law takes its default for them.
std::vector<const quoin_property_info*> scalar_properties(const quoin_law& law);

// The value that holds for property i of scalar_properties, given all of their values, NaN for the law's default. It is
// 0 for one that is required and not given.
double value_in_force(std::span<const quoin_property_info* const> properties, std::span<const double> values,
                      std::size_t i);

// A value of scalar_properties. Throws std::runtime_error for the index of a choice that there is not.
PropertyValue scalar_value(const quoin_property_info& property, double number);

// The material of these values of scalar_properties, NaN for the law's default. Throws as Material does.
std::unique_ptr<Material> scalar_material(const quoin_law& law, std::span<const double> scalars);

// The same: one a process for equal values, shared by all points, and kept to the end. Throws as Material does. Any
// thread.
const Material& shared_material(const quoin_law& law, std::span<const double> scalars);

}  // namespace quoin::adapters
