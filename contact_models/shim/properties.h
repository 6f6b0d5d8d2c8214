// Property values checked against a law's metadata. Not used during steps.
#pragma once

#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "quoin/quoin.h"

namespace quoin::shim {

// Faults and warnings of one set of properties, one line each: property, value, bound, remedy.
struct Report {
  std::vector<std::string> faults;
  std::vector<std::string> warnings;
  bool lacks_value = false;  // a required one, without which the conditions between values say nothing
  static std::string join(const std::vector<std::string>& lines);
};

// Returns the shortest text that converts back to the same number.
std::string to_text(double value);

class PropertyValues {
 public:
  // Fills in defaults. Adds to report a fault for each unknown id, wrong kind, number out of bounds and missing value.
  PropertyValues(std::span<const quoin_property_info* const> metadata,
                 std::span<const quoin_property_value* const> values, Report& report);

  double number(const std::string& id) const { return numbers_.at(id); }
  const std::string& text(const std::string& id) const { return texts_.at(id); }
  const std::vector<double>& table(const std::string& id) const { return tables_.at(id); }
  const std::map<std::string, double>& numbers() const { return numbers_; }
  bool is_given(const std::string& id) const { return given_.contains(id); }

 private:
  std::set<std::string> given_;  // ids that were given; others have their default
  std::map<std::string, double> numbers_;
  std::map<std::string, std::string> texts_;
  std::map<std::string, std::vector<double>> tables_;
};

// Writes text into a caller's buffer by the rules of quoin_text (quoin/base.h); null is allowed.
void write_text(quoin_text* buffer, const std::string& text);

}  // namespace quoin::shim
