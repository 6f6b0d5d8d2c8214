// quoin-check-law: checks a law against the contract of plugin_api/README.md.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <span>

#include "checks.h"

namespace {

using check::Report;

constexpr int kPassed = 0, kFailed = 1, kUsage = 2, kNotLoadable = 4;

const char* const kHelp =
    "quoin-check-law LIB [--law ID] [--property id=value]... [--law-seconds N] [--json]\n"
    "\n"
    "Checks every promise of the contact-law contract on a law, without the Quoin host. The contract is\n"
    "README.md of plugin_api, which quoin-dev installs in share/quoin.\n"
    "  LIB                  shared library with quoin_library_v1\n"
    "  --law ID             only this law of the library\n"
    "  --property id=value  property value: a number, a word, or a table x:y,x:y; the others take their default, or a\n"
    "                       usual value of their unit when they are required\n"
    "  --law-seconds N      whole seconds that a call of the law has before the check ends; 0: any time (default: 60)\n"
    "  --json               findings as JSON\n"
    "exit: 0 kept, 1 broken, 2 usage or a value that the law does not allow, 4 the library cannot be loaded\n";

struct Arguments {
  std::string path, only;
  check::Settings given;
  bool json = false;
};

// Returns the exit code of a call that ends here.
std::optional<int> parse(int argc, char** argv, Arguments* arguments) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const bool has_next = i + 1 < argc;
    if (argument == "--help" || argument == "-h") {
      std::fputs(kHelp, stdout);
      return kPassed;
    }
    if (argument == "--json") {
      arguments->json = true;
    } else if (argument == "--law-seconds" && has_next) {
      const std::string seconds = argv[++i];
      if (seconds.empty() || seconds.size() > 9 || seconds.find_first_not_of("0123456789") != std::string::npos) {
        std::fprintf(stderr, "--law-seconds %s: expected a whole number from 0 to 999999999\n", seconds.c_str());
        return kUsage;
      }
      check::law_seconds = static_cast<unsigned>(std::atoi(seconds.c_str()));
    } else if (argument == "--law" && has_next) {
      arguments->only = argv[++i];
    } else if (argument == "--property" && has_next) {
      const std::string setting = argv[++i];
      const size_t equals = setting.find('=');
      if (equals == std::string::npos || equals == 0) {
        std::fprintf(stderr, "--property %s: expected id=value\n", setting.c_str());
        return kUsage;
      }
      arguments->given[setting.substr(0, equals)] = setting.substr(equals + 1);
    } else if (arguments->path.empty() && !argument.empty() && argument[0] != '-') {
      arguments->path = argument;
    } else {
      std::fprintf(stderr, "%s: not understood\n\n%s", argument.c_str(), kHelp);
      return kUsage;
    }
  }
  if (!arguments->path.empty()) return std::nullopt;
  std::fputs(kHelp, stderr);
  return kUsage;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return out + "\"";
}

const char* state_of(const check::Outcome& outcome) {
  if (outcome.failures > 0) return "FAILED";
  return outcome.expectations > 0 ? "ok" : "skipped";
}

void print_text(const std::string& law, const check::Settings& settings, const Report& report) {
  std::printf("law %s\n", law.c_str());
  if (!settings.empty()) std::printf("  with");
  for (const auto& [id, value] : settings) std::printf(" %s=%s", id.c_str(), value.c_str());
  if (!settings.empty()) std::printf("\n");
  for (const check::Clause& clause : check::clauses()) {
    const auto found = report.outcomes().find(clause.id);
    if (found == report.outcomes().end()) continue;
    const check::Outcome& outcome = found->second;
    std::printf("  %-7s %-5s %s\n", state_of(outcome), clause.id, clause.text);
    for (const std::string& detail : outcome.details) std::printf("                - %s\n", detail.c_str());
    if (outcome.failures > static_cast<int>(outcome.details.size())) {
      std::printf("                - and %zu more\n", static_cast<size_t>(outcome.failures) - outcome.details.size());
    }
    if (outcome.expectations == 0) {
      for (const std::string& reason : outcome.skipped) std::printf("                - %s\n", reason.c_str());
    }
  }
  for (const std::string& note : report.notes()) std::printf("  note: %s\n", note.c_str());
}

std::string list_of(const std::vector<std::string>& texts) {
  std::string out;
  for (const std::string& text : texts) out += (out.empty() ? "" : ", ") + quoted(text);
  return "[" + out + "]";
}

std::string json_of(const std::string& law, const check::Settings& settings, const Report& report) {
  std::string out = "    {\"law\": " + quoted(law) + ", \"passed\": " + (report.passed() ? "true" : "false") +
                    ",\n     \"properties\": {";
  const char* separator = "";
  for (const auto& [id, value] : settings) {
    out += separator + quoted(id) + ": " + quoted(value);
    separator = ", ";
  }
  out += "},\n     \"clauses\": [";
  separator = "\n";
  for (const check::Clause& clause : check::clauses()) {
    const auto found = report.outcomes().find(clause.id);
    if (found == report.outcomes().end()) continue;
    out += std::string(separator) + "      {\"id\": \"" + clause.id + "\", \"status\": \"" + state_of(found->second) +
           "\", \"promise\": " + quoted(clause.text) + ", \"details\": " + list_of(found->second.details) + "}";
    separator = ",\n";
  }
  return out + "],\n     \"notes\": " + list_of(report.notes()) + "}";
}

// Bounds that are not ordered are the law's fault (C3.3), not the user's.
bool has_ordered_bounds(const quoin_property_info& number) { return number.lower <= number.upper; }

// Returns what a law allows for a property; empty: anything.
std::string allowed(const quoin_property_info& property) {
  if (property.kind == QUOIN_PROPERTY_NUMBER) {
    if (!has_ordered_bounds(property)) return "a number";
    const bool lower_open = (property.flags & QUOIN_PROPERTY_LOWER_OPEN) || std::isinf(property.lower);
    const bool upper_open = (property.flags & QUOIN_PROPERTY_UPPER_OPEN) || std::isinf(property.upper);
    return std::string("a number in ") + (lower_open ? "(" : "[") + check::shortest(property.lower) + ", " +
           check::shortest(property.upper) + (upper_open ? ") " : "] ") + property.unit;
  }
  std::string words;
  if (property.kind == QUOIN_PROPERTY_CHOICE && property.choices != nullptr) {
    for (const char* choice : std::span(property.choices, property.choice_count)) {
      if (choice != nullptr) words += (words.empty() ? "" : ", ") + std::string(choice);
    }
  }
  return words.empty() ? "" : "one of " + words;
}

bool is_allowed(const quoin_property_info& property, const std::string& value) {
  if (property.kind == QUOIN_PROPERTY_CHOICE) {
    return std::ranges::any_of(std::span(property.choices, property.choice_count),
                               [&](const char* choice) { return choice != nullptr && value == choice; });
  }
  if (property.kind != QUOIN_PROPERTY_NUMBER) return true;
  char* end = nullptr;
  const double number = std::strtod(value.c_str(), &end);
  return !value.empty() && *end == '\0' && (!has_ordered_bounds(property) || check::inside(property, number));
}

// Returns the faults of given properties that are the user's, not the law's, a line each.
std::string faults_of(const quoin_law& law, const check::Settings& given) {
  if (!check::metadata_is_usable(law)) return "";
  std::string faults;
  for (const auto& [id, value] : given) {
    const quoin_property_info* info = check::find_property(law, id);
    if (info == nullptr) {
      faults += "--property " + id + ": law " + law.id + " has no such property; quoin models lists them\n";
    } else if (const std::string range = allowed(*info); !range.empty() && !is_allowed(*info, value)) {
      faults += "--property " + id + "=" + value + ": law " + law.id + " allows " + range +
                "; give one, or leave the property out\n";
    }
  }
  return faults;
}

// Returns the report of one law, which includes the findings about its library.
Report check_law(const Report& library_report, const quoin_law& law, const check::Settings& given,
                 check::Settings* used) {
  Report report = library_report;
  report.section("metadata", [&](Report& r) { check::check_metadata(r, law); });
  if (!check::metadata_is_usable(law)) return report;
  check::Subject subject = {law, check::base_settings(law, given), {}};
  *used = subject.base;
  report.section("first material", [&](Report& r) {
    r.clause("C4.1");
    const check::Material material(law, subject.base);
    if (material.handle == nullptr) r.note("give values that the law accepts with --property id=value");
    r.expect(material.handle != nullptr, "refused: %s", material.message.c_str());
  });
  const auto found = report.outcomes().find("C4.1");
  if (found == report.outcomes().end() || found->second.failures > 0) return report;

  const struct {
    const char* name;
    void (*run)(Report&, const check::Subject&);
  } sections[] = {
      {"materials", check::check_materials},
      {"zero strengths", check::check_zero_strengths},
      {"states", check::check_states},
      {"purity", check::check_purity},
      {"memory", check::check_memory},
      {"threads", check::check_threads},
      {"optional outputs", check::check_optional},
      {"refusals", check::check_refusals},
      {"property columns", check::check_property_columns},
      {"failed points", check::check_failed_points},
      {"paths", check::check_paths},
      {"energy", check::check_energy},
      {"damage", check::check_damage},
      {"stiffness", check::check_stiffness},
      {"migration", check::check_migration},
  };
  for (const auto& section : sections) {
    if (report.hangs()) break;
    report.section(section.name, [&](Report& r) {
      r.clause("C4.1");
      subject.varied = check::varied_settings(law, subject.base);
      section.run(r, subject);
    });
  }
  return report;
}

// Checks the laws of a library and prints what was found. Returns the exit code.
int check_laws(const Arguments& arguments, const quoin_library& info, const Report& library_report) {
  std::vector<const quoin_law*> laws;
  std::string faults;
  for (const quoin_law* law : std::span(info.laws, info.law_count)) {
    if (!arguments.only.empty() && (law->id == nullptr || law->id != arguments.only)) continue;
    laws.push_back(law);
    faults += faults_of(*law, arguments.given);
  }
  if (laws.empty()) faults = arguments.path + ": no law " + arguments.only + "\n";
  if (!faults.empty()) {
    std::fputs(faults.c_str(), stderr);
    return kUsage;
  }
  bool passed = true;
  std::string entries;
  if (!arguments.json) std::printf("%s: %s %s\n", arguments.path.c_str(), info.name, info.version);
  for (const quoin_law* law : laws) {
    const std::string id = law->id != nullptr ? law->id : "(null)";
    check::Settings used;
    const Report report = check_law(library_report, *law, arguments.given, &used);
    passed = passed && report.passed();
    if (arguments.json) {
      entries += (entries.empty() ? "" : ",\n") + json_of(id, used, report);
    } else {
      print_text(id, used, report);
    }
  }
  if (arguments.json) {
    std::printf("{\"library\": %s, \"passed\": %s, \"laws\": [\n%s\n]}\n", quoted(arguments.path).c_str(),
                passed ? "true" : "false", entries.c_str());
  } else {
    std::printf("%s: %s\n", arguments.path.c_str(), passed ? "the contract is kept" : "the contract is BROKEN");
  }
  return passed ? kPassed : kFailed;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  if (const std::optional<int> code = parse(argc, argv, &arguments)) return *code;
  const check::Library library = check::open_library(arguments.path);
  if (library.entry == nullptr) {
    std::fprintf(stderr, "%s: cannot be loaded: %s\n", arguments.path.c_str(), library.error.c_str());
    return kNotLoadable;
  }
  Report library_report;
  library_report.section("library", [&](Report& r) { check::check_library(r, library); });
  const quoin_host_info host = check::host_info();
  check::Text text;
  const quoin_library* info = library_report.hangs() ? nullptr : library.entry(&host, &text.text);
  if (info == nullptr || info->laws == nullptr) {
    print_text("-", {}, library_report);
    std::printf("%s: BROKEN\n", arguments.path.c_str());
    return kFailed;
  }
  return check_laws(arguments, *info, library_report);
}
