#include "mgis/property_sets.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace quoin::mgis {

namespace {

bool same_bytes(const std::vector<double>& a, const std::vector<double>& b) {
  return std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

}  // namespace

PropertySets& PropertySets::of_thread(const quoin_law& law) {
  thread_local std::vector<std::unique_ptr<PropertySets>> all;
  constinit thread_local static PropertySets* latest = nullptr;
  if (latest != nullptr && &latest->law_ == &law) return *latest;
  const auto known = std::ranges::find_if(all, [&](const auto& sets) { return &sets->law_ == &law; });
  latest = known != all.end() ? known->get() : all.emplace_back(std::make_unique<PropertySets>(law)).get();
  return *latest;
}

PropertySets::PropertySets(const quoin_law& law)
    : law_(law), infos_(adapters::scalar_properties(law)), own_(2 * infos_.size()), in_force_(infos_.size()) {
  columns_.reserve(infos_.size());
}

PointMaterial PropertySets::find(const double* values) {
  const std::string_view bytes(reinterpret_cast<const char*>(values), infos_.size() * sizeof(double));
  if (latest_ != nullptr && latest_->first == bytes) return {latest_->second, 0, nullptr};
  if (const auto known = materials_.find(bytes); known != materials_.end()) {
    latest_ = &*known;
  } else if (materials_.size() < kept || (law_.capabilities & QUOIN_CAN_PROPERTY_COLUMNS) == 0) {
    const adapters::Material& material = adapters::shared_material(law_, {values, infos_.size()});
    latest_ = &*materials_.emplace(bytes, &material).first;
  } else {
    return shared_with_columns(values);
  }
  return {latest_->second, 0, nullptr};
}

// Gives every per-point number a column. The material gives only the other properties; its own values of the numbers
// with columns have no effect.
PointMaterial PropertySets::shared_with_columns(const double* values) {
  columns_.clear();
  for (std::size_t i = 0; i < infos_.size(); ++i) {
    const quoin_property_info& info = *infos_[i];
    if ((info.flags & QUOIN_PROPERTY_REQUIRED) != 0 && std::isnan(values[i])) make(values);  // throws
    in_force_[i] = adapters::value_in_force(infos_, {values, infos_.size()}, i);
    const bool column = info.kind == QUOIN_PROPERTY_NUMBER && (info.flags & QUOIN_PROPERTY_PER_POINT) != 0 &&
                        std::isfinite(in_force_[i]);
    if (column) columns_.push_back({info.id, {&in_force_[i], 1}});
    own_[2 * i] = column ? 1.0 : 0.0;
    own_[2 * i + 1] = column ? 0.0 : values[i];
  }
  auto base = std::ranges::find_if(bases_, [&](const Base& known) { return same_bytes(known.own, own_); });
  if (base == bases_.end())
    base = bases_.insert(bases_.end(), {own_, &adapters::shared_material(law_, {values, infos_.size()})});
  return {base->material, columns_.size(), columns_.data()};
}

std::unique_ptr<adapters::Material> PropertySets::make(const double* values) const {
  return adapters::scalar_material(law_, {values, infos_.size()});
}

}  // namespace quoin::mgis
