#include "law/property_text.h"

#include <fmt/format.h>

#include <string_view>

#include "base/error.h"
#include "base/text.h"
#include "law/law_library.h"

namespace quoin {

const quoin_property_info* find_property(const quoin_law& law, const std::string& id) {
  for (uint64_t i = 0; i < law.property_count; ++i) {
    if (id == law.properties[i]->id) return law.properties[i];
  }
  return nullptr;
}

PropertySetting parse_setting(const quoin_law& law, const std::string& assignment, const Source& source) {
  const auto equals = assignment.find('=');
  if (equals == std::string::npos || trimmed(std::string_view(assignment).substr(0, equals)).empty()) {
    throw Error(Exit::usage,
                fmt::format("{}: '{}': write id=value, for example cohesion=0.3e6", source.text, assignment));
  }
  PropertySetting setting;
  setting.id = trimmed(std::string_view(assignment).substr(0, equals));
  setting.source.text = fmt::format("{} {}", source.text, setting.id);
  const std::string value = trimmed(std::string_view(assignment).substr(equals + 1));
  const quoin_property_info* info = find_property(law, setting.id);

  if (info == nullptr) {
    double number = 0.0;
    if (parse_number(value, number)) {
      setting.numbers = {number};
    } else {
      setting.text = value;
    }
  } else if (info->kind == QUOIN_PROPERTY_CHOICE) {
    setting.text = value;
  } else if (info->kind == QUOIN_PROPERTY_NUMBER) {
    double number = 0.0;
    if (!parse_number(value, number)) {
      throw Error(Exit::bad_input,
                  fmt::format("{}: '{}' is no number [{}]", setting.source.text, value, law_text(info->unit)));
    }
    setting.numbers = {number};
  } else {
    for (std::size_t begin = 0; begin <= value.size();) {
      const std::size_t end = std::min(value.find(',', begin), value.size());
      const std::string pair = value.substr(begin, end - begin);
      const auto colon = pair.find(':');
      double x = 0.0;
      double y = 0.0;
      if (colon == std::string::npos || !parse_number(pair.substr(0, colon), x) ||
          !parse_number(pair.substr(colon + 1), y)) {
        throw Error(Exit::bad_input, fmt::format("{}: '{}' in '{}' is no pair; write a table as 0:1,0.3:0.5,1:0",
                                                 setting.source.text, pair, value));
      }
      setting.numbers.push_back(x);
      setting.numbers.push_back(y);
      begin = end + 1;
    }
  }
  return setting;
}

}  // namespace quoin
