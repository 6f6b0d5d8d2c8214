// From a point's property values to a material of the law. MGIS hands the values over again at every call, and a field
// of them may differ from point to point.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "shared/material.h"

namespace quoin::mgis {

// A material, and what of it holds for this point alone. Valid until the next find of the thread.
struct PointMaterial {
  const adapters::Material* material;
  std::uint64_t column_count;  // 0: the material is exactly that of the values
  const quoin_property_column* columns;
};

// Those of one thread. The first sets of values get a material each, which is found again by its values. Further ones
// share a material and give what they have of their own as property columns. So a field in which every point differs
// costs no memory. By C6.9 both give the same result.
class PropertySets {
 public:
  static constexpr std::size_t kept = 1024;

  static PropertySets& of_thread(const quoin_law& law);
  explicit PropertySets(const quoin_law& law);  // use of_thread
  // values: of adapters::scalar_properties, NaN for the law's default. Throws std::runtime_error as Material does;
  // values that a column carries, the law refuses at the point.
  PointMaterial find(const double* values);
  // A new material of exactly these values. Throws as find does.
  std::unique_ptr<adapters::Material> make(const double* values) const;
  const quoin_law& law() const { return law_; }

 private:
  struct BytesHash {
    using is_transparent = void;
    std::size_t operator()(std::string_view bytes) const { return std::hash<std::string_view>{}(bytes); }
  };
  struct Base {
    std::vector<double> own;  // what no column carries, in pairs: whether a column does, the value
    const adapters::Material* material;
  };

  PointMaterial shared_with_columns(const double* values);

  const quoin_law& law_;
  std::vector<const quoin_property_info*> infos_;
  // By the bytes of the values: NaN is a value here.
  std::unordered_map<std::string, const adapters::Material*, BytesHash, std::equal_to<>> materials_;
  const std::pair<const std::string, const adapters::Material*>* latest_ = nullptr;
  std::vector<Base> bases_;
  std::vector<double> own_, in_force_;
  std::vector<quoin_property_column> columns_;
};

}  // namespace quoin::mgis
