#include "shim/properties.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

namespace quoin::shim {

std::string Report::join(const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) all += (all.empty() ? "" : "\n") + line;
  return all;
}

std::string to_text(double value) {
  char digits[40];
  const auto result = std::to_chars(digits, digits + sizeof digits, value);
  return std::string(digits, result.ptr);
}

namespace {

std::string allowed_range(const quoin_property_info& info) {
  const bool lower_open = (info.flags & QUOIN_PROPERTY_LOWER_OPEN) != 0 || std::isinf(info.lower);
  const bool upper_open = (info.flags & QUOIN_PROPERTY_UPPER_OPEN) != 0 || std::isinf(info.upper);
  return std::string(lower_open ? "(" : "[") + to_text(info.lower) + ", " + to_text(info.upper) +
         (upper_open ? ")" : "]") + " " + info.unit;
}

bool inside(const quoin_property_info& info, double value) {
  if (std::isnan(value)) return false;
  const bool above = (info.flags & QUOIN_PROPERTY_LOWER_OPEN) != 0 ? value > info.lower : value >= info.lower;
  const bool below = (info.flags & QUOIN_PROPERTY_UPPER_OPEN) != 0 ? value < info.upper : value <= info.upper;
  return above && below;
}

}  // namespace

PropertyValues::PropertyValues(std::span<const quoin_property_info* const> metadata,
                               std::span<const quoin_property_value* const> values, Report& report) {
  for (const quoin_property_value* value : values) {
    if (value == nullptr || value->id == nullptr || value->struct_size < sizeof(quoin_property_value)) {
      report.faults.push_back("a property value without id, or with a struct_size that is too small");
      continue;
    }
    const std::string id = value->id;
    const auto known =
        std::find_if(metadata.begin(), metadata.end(), [&](const quoin_property_info* info) { return id == info->id; });
    if (known == metadata.end()) {
      std::string ids;
      for (const quoin_property_info* info : metadata) ids += (ids.empty() ? "" : ", ") + std::string(info->id);
      report.faults.push_back(id + ": unknown property; this law has: " + ids);
      continue;
    }
    if (!given_.insert(id).second) {
      report.faults.push_back(id + ": given twice; give it once");
      continue;
    }
    const quoin_property_info& info = **known;
    if (info.kind == QUOIN_PROPERTY_CHOICE) {
      const std::string word = value->text == nullptr ? "" : value->text;
      std::string choices;
      bool found = false;
      for (std::uint64_t k = 0; k < info.choice_count; ++k) {
        choices += (k == 0 ? "" : ", ") + std::string(info.choices[k]);
        found = found || word == info.choices[k];
      }
      if (!found) report.faults.push_back(id + " = '" + word + "': not one of " + choices);
      texts_[id] = word;
    } else if (info.kind == QUOIN_PROPERTY_TABLE) {
      if (value->number_count == 0 || value->numbers == nullptr) {
        report.faults.push_back(id + ": needs pairs of numbers x0, y0, x1, y1, ...");
      } else {
        tables_[id].assign(value->numbers, value->numbers + value->number_count);
      }
    } else if (value->number_count != 1 || value->numbers == nullptr) {
      const bool is_text = value->number_count == 0 && value->text != nullptr && *value->text != '\0';
      report.faults.push_back(
          id + ": needs one number, got " +
          (is_text ? std::string("the text '") + value->text + "'" : std::to_string(value->number_count)));
    } else {
      const double number = value->numbers[0];
      if (!inside(info, number)) {
        report.faults.push_back(id + " = " + to_text(number) + ": outside the allowed range " + allowed_range(info));
      }
      numbers_[id] = number;
    }
  }
  for (const quoin_property_info* info : metadata) {
    if (info->kind == QUOIN_PROPERTY_CHOICE) {
      texts_.try_emplace(info->id, info->default_text);
    } else if (info->kind == QUOIN_PROPERTY_TABLE) {
      tables_.try_emplace(info->id);
    } else if (!numbers_.contains(info->id)) {
      if ((info->flags & QUOIN_PROPERTY_REQUIRED) != 0 && !given_.contains(info->id)) {
        report.lacks_value = true;
        report.faults.push_back(std::string(info->id) + ": required and not given; allowed range " +
                                allowed_range(*info));
      }
      numbers_[info->id] = info->default_value;
    }
  }
  for (const quoin_property_info* info : metadata) {
    if (info->default_from != nullptr && !given_.contains(info->id)) numbers_[info->id] = numbers_[info->default_from];
  }
}

void write_text(quoin_text* buffer, const std::string& text) {
  if (buffer == nullptr || buffer->struct_size < sizeof(quoin_text)) return;
  buffer->length = text.size();
  if (buffer->data == nullptr || buffer->capacity == 0) return;
  const std::size_t n = std::min<std::size_t>(text.size(), buffer->capacity - 1);
  std::memcpy(buffer->data, text.data(), n);
  buffer->data[n] = '\0';
}

}  // namespace quoin::shim
