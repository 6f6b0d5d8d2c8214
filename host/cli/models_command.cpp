#include "cli/models_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cmath>

#include "base/error.h"
#include "law/law_library.h"

namespace quoin {

namespace {

std::string text(const char* s) { return law_text(s); }

std::string bounds(const quoin_property_info& p) {
  if (p.kind == QUOIN_PROPERTY_CHOICE) {
    std::vector<std::string> words(p.choices, p.choices + p.choice_count);
    return fmt::format("{}", fmt::join(words, " | "));
  }
  if (p.kind == QUOIN_PROPERTY_TABLE) return "pairs x, y";
  const bool lower = std::isfinite(p.lower), upper = std::isfinite(p.upper);
  if (!lower && !upper) return "any";
  return fmt::format("{}{}, {}{}", (p.flags & QUOIN_PROPERTY_LOWER_OPEN) != 0 || !lower ? "(" : "[",
                     lower ? fmt::format("{:g}", p.lower) : "-inf", upper ? fmt::format("{:g}", p.upper) : "inf",
                     (p.flags & QUOIN_PROPERTY_UPPER_OPEN) != 0 || !upper ? ")" : "]");
}

std::string default_of(const quoin_property_info& p) {
  if ((p.flags & QUOIN_PROPERTY_REQUIRED) != 0) return "required";
  if (p.default_from) return fmt::format("= {}", p.default_from);
  if (p.kind != QUOIN_PROPERTY_NUMBER) return text(p.default_text);
  return fmt::format("{:g}", p.default_value);
}

void print_law(const Law& law) {
  const quoin_law& l = *law.law;
  fmt::print("{} {}: {}\n  {}\n", l.id, text(l.version), text(l.name), text(l.description));
  if (l.citation && *l.citation) fmt::print("  reference: {}\n", l.citation);
  fmt::print("  library: {}\n\nproperties\n", law.library->path());
  size_t id = 2, symbol = 6, unit = 4, value = 7, allowed = 7;
  for (uint64_t i = 0; i < l.property_count; ++i) {
    const quoin_property_info& p = *l.properties[i];
    id = std::max(id, text(p.id).size());
    symbol = std::max(symbol, text(p.symbol).size());
    unit = std::max(unit, text(p.unit).size());
    value = std::max(value, default_of(p).size());
    allowed = std::max(allowed, bounds(p).size());
  }
  auto row = [&](const std::string& a, const std::string& b, const std::string& c, const std::string& d,
                 const std::string& e, const std::string& f) {
    fmt::print("  {:<{}}  {:<{}}  {:<{}}  {:<{}}  {:<{}}  {}\n", a, id, b, symbol, c, unit, d, value, e, allowed, f);
  };
  row("id", "symbol", "unit", "default", "allowed", "");
  for (uint64_t i = 0; i < l.property_count; ++i) {
    const quoin_property_info& p = *l.properties[i];
    row(text(p.id), text(p.symbol), text(p.unit), default_of(p), bounds(p), text(p.description));
  }

  fmt::print("\nstates of a contact point\n");
  for (uint64_t i = 0; i < l.state_count; ++i) {
    const quoin_state_info& s = *l.states[i];
    fmt::print("  {:<{}}  {:<{}}  {}{}{}\n", text(s.id), id, text(s.unit), unit, text(s.description),
               s.role == QUOIN_ROLE_DIAGNOSTIC ? " (diagnostic)" : "",
               (s.flags & QUOIN_STATE_MONOTONIC) != 0 ? " (never decreases)" : "");
  }
  if (l.state_count == 0) fmt::print("  none\n");
  std::vector<std::string> initial(l.initial_states, l.initial_states + l.initial_state_count);
  fmt::print("\ninitial states: {}\n", fmt::join(initial, ", "));
  std::vector<std::string> can;
  for (const auto& [bit, name] : {std::pair{QUOIN_CAN_ENERGY, "energies"},
                                  {QUOIN_CAN_TANGENT, "tangent"},
                                  {QUOIN_CAN_PROPERTY_COLUMNS, "properties by point"},
                                  {QUOIN_CAN_FLAGS, "flags"},
                                  {QUOIN_CAN_MIGRATE, "taking over from another law"},
                                  {QUOIN_CAN_DAMAGE, "damage by mode"}}) {
    if ((l.capabilities & bit) != 0) can.push_back(name);
  }
  fmt::print("capabilities: {}\n", can.empty() ? "none" : fmt::format("{}", fmt::join(can, ", ")));
}

// Line of a law in the list. A broken library must not hide the others.
std::string line_of(const std::string& id) {
  try {
    const Law law = Law::find(id);
    return fmt::format("{:<8} {}", text(law.law->version), text(law.law->name));
  } catch (const Error& error) {
    return fmt::format("cannot be used: {}", error.what());
  }
}

void models(const std::string& name) {
  if (!name.empty()) {
    const Law law = Law::find(name);
    if (name.find('/') == std::string::npos) return print_law(law);
    for (uint64_t i = 0; i < law.library->info().law_count; ++i) {
      if (i > 0) fmt::print("\n");
      print_law({law.library, law.library->info().laws[i]});
    }
    return;
  }
  for (const std::string& id : installed_laws()) fmt::print("{:<18} {}\n", id, line_of(id));
}

}  // namespace

void add_models_command(CLI::App& app, int&) {
  CLI::App* command = app.add_subcommand("models", "List contact laws, or the properties and states of one");
  auto name = std::make_shared<std::string>();
  command->add_option("law", *name, "A law by name, or the path of a library (default: list all)")
      ->type_name("NAME_OR_PATH");
  command->footer(
      "Examples:\n"
      "  quoin models\n"
      "  quoin models fracture_energy\n"
      "  quoin models ./my_law.so\n"
      "Laws are searched in $QUOIN_LAW_PATH, in laws/ beside the program and in ../lib/quoin/laws.\n"
      "They run from a copy in memory; for debuggers and profilers, set QUOIN_LAW_IN_PLACE.");
  command->callback([name] { models(*name); });
}

}  // namespace quoin
