// JSON files of results.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "files/file.h"

namespace quoin {

inline nlohmann::ordered_json number_or_null(const std::optional<double>& x) {
  return x ? nlohmann::ordered_json(*x) : nlohmann::ordered_json(nullptr);
}
// JSON holds UTF-8 alone, while file names may hold any bytes: invalid ones become U+FFFD.
inline std::string json_text(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}
// Throws as write_file().
inline void write_json(const std::filesystem::path& path, const nlohmann::ordered_json& json) {
  write_file(path, json_text(json));
}

}  // namespace quoin
