// Materials of the law for the property values of points. MGIS passes the values at every call, and they may differ
// from point to point.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "shared/material.h"

namespace quoin::mgis {

// A material with property columns for one point. Valid until the next find of the thread.
struct PointMaterial {
  const adapters::Material* material;
  std::uint64_t column_count;  // 0: the material has exactly the values
  const quoin_property_column* columns;
};

// Property sets of one thread. Each of the first `kept` sets has its own material, which is found by its values.
// Further sets share a material and have their values as property columns, so that memory is bounded for a field in
// which every point differs. By C6.9 of the contract both have the same results.
class PropertySets {
 public:
  static constexpr std::size_t kept = 1024;

  static PropertySets& of_thread(const quoin_law& law);
  explicit PropertySets(const quoin_law& law);  // for of_thread only
  // Returns the material of values, in the order of adapters::scalar_properties, NaN for the law's default. Throws
  // std::runtime_error as Material does. A refused value in a column does not throw: the point fails in evaluate.
  PointMaterial find(const double* values);
  // Returns a new material of these values. Throws std::runtime_error as Material does.
  std::unique_ptr<adapters::Material> make(const double* values) const;
  const quoin_law& law() const { return law_; }

 private:
  struct BytesHash {
    using is_transparent = void;
    std::size_t operator()(std::string_view bytes) const { return std::hash<std::string_view>{}(bytes); }
  };
  struct Base {
    std::vector<double> own;  // for each property a pair: 1 if it has a column, and its value without one
    const adapters::Material* material;
  };

  PointMaterial shared_with_columns(const double* values);

  const quoin_law& law_;
  std::vector<const quoin_property_info*> infos_;
  // Materials by the bytes of their values, since NaN is a valid value.
  std::unordered_map<std::string, const adapters::Material*, BytesHash, std::equal_to<>> materials_;
  const std::pair<const std::string, const adapters::Material*>* latest_ = nullptr;
  std::vector<Base> bases_;
  std::vector<double> own_, in_force_;
  std::vector<quoin_property_column> columns_;
};

}  // namespace quoin::mgis
