// A material from the plain numbers and words that foreign programs hand over.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "quoin/quoin.h"

namespace quoin::adapters {

// Numbers have one number, tables pairs, choices a word.
struct PropertyValue {
  std::string id;
  std::vector<double> numbers;
  std::string text;
};

// The properties that one number can give, in the law's order: numbers, and choices by their index. Tables are left
// out: a law takes its default for them.
std::vector<const quoin_property_info*> scalar_properties(const quoin_law& law);

// The value that holds for property i of scalar_properties, given all of their values, NaN for the law's default. 0 for
// one that is required and not given.
double value_in_force(std::span<const quoin_property_info* const> properties, std::span<const double> values,
                      std::size_t i);

// A value of scalar_properties. Throws std::runtime_error for the index of a choice that there is not.
PropertyValue scalar_value(const quoin_property_info& property, double number);

class Material {
 public:
  // Properties that are not given take the law's default. Throws std::runtime_error with the law's own message: every
  // fault, one a line.
  Material(const quoin_law& law, const std::vector<PropertyValue>& values);
  ~Material();
  Material(const Material&) = delete;
  Material& operator=(const Material&) = delete;

  const quoin_law& law() const { return *law_; }
  const quoin_material* handle() const { return handle_; }
  const quoin_stiffness_bounds& stiffness() const { return stiffness_; }
  // Throws std::runtime_error: unknown initial state.
  void initial_state(const std::string& id, double* values) const;

 private:
  const quoin_law* law_;
  quoin_material* handle_ = nullptr;
  quoin_stiffness_bounds stiffness_{sizeof(quoin_stiffness_bounds), 0.0, 0.0};
};

// The material of these values of scalar_properties, NaN for the law's default. Throws as Material does.
std::unique_ptr<Material> scalar_material(const quoin_law& law, std::span<const double> scalars);

// The same: one a process for equal values, however
// many points ask, and kept to the end. Throws as Material does. Any thread.
const Material& shared_material(const quoin_law& law, std::span<const double> scalars);

}  // namespace quoin::adapters
