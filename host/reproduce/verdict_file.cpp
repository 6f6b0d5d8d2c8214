#include "reproduce/verdict_file.h"

#include <fmt/format.h>

#include <fstream>

#include "results/json_file.h"

namespace quoin::reproduce {

std::filesystem::path verdict_file(const std::filesystem::path& root, const Study& study) {
  return root / (study.beyond ? "beyond.json" : "verdict.json");
}

void write_verdicts(const std::filesystem::path& file, const std::string& study, const StudyReport& report) {
  using Json = nlohmann::ordered_json;
  std::ifstream stream(file);
  Json before = Json::parse(stream, nullptr, false);
  // In the order of the studies, not of their runs.
  std::map<std::string, std::vector<Json>> by_study;
  if (before.is_array()) {
    for (const Json& entry : before) by_study[entry.value("study", "")].push_back(entry);
  }
  by_study[study].clear();
  for (const Verdict& v : report.verdicts) {
    Json entry;
    entry["study"] = study;
    entry["claim"] = v.claim;
    entry["number"] = v.number;
    entry["reference"] = v.reference ? Json(*v.reference) : Json(nullptr);
    entry["unit"] = v.unit;
    entry["kind"] = kind_word(v.kind);
    entry["reproduced"] = v.reproduced;
    entry["text"] = v.text;
    by_study[study].push_back(entry);
  }
  Json all = Json::array();
  for (const Study& s : studies()) {
    for (const Json& entry : by_study[s.id]) all.push_back(entry);
  }
  write_json(file, all);
}

std::string verdict_line(const std::string& study, const Verdict& v) {
  return fmt::format("{:<14} {:<15} {}: {}", v.reproduced ? "reproduced" : "NOT reproduced", study, v.claim, v.text);
}

}  // namespace quoin::reproduce
