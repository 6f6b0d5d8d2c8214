// C1 and C3: symbols, negotiation, metadata.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include "checks.h"

namespace check {
namespace {

bool good_id(const char* id) {
  if (id == nullptr || !(*id >= 'a' && *id <= 'z')) return false;
  for (const char* c = id; *c != 0; ++c) {
    if (!((*c >= 'a' && *c <= 'z') || (*c >= '0' && *c <= '9') || *c == '_')) return false;
  }
  return true;
}

bool known_unit(const char* unit) {
  static const std::set<std::string> units = {"-",    "m",     "s",   "Pa",  "Pa/m", "Pa s", "Pa s/m",
                                              "J/m2", "J/m3",  "N/m", "N",   "m/s",  "1/m",  "deg",
                                              "rad",  "kg/m3", "K",   "1/s", "1/Pa"};
  return unit != nullptr && units.count(unit) > 0;
}

const char* shown(const char* text) { return text != nullptr ? text : "(null)"; }

void check_symbols(Report& report, const Library& library) {
  report.clause("C1.1");
  report.expect(library.exported.size() == 1, "%zu symbols are exported", library.exported.size());
  for (const std::string& name : library.exported) {
    report.expect(name == QUOIN_LIBRARY_SYMBOL, "exported: %s", name.c_str());
  }
}

// Returns the description, null where the library refuses to give it.
const quoin_library* check_description(Report& report, const Library& library) {
  report.clause("C1.5");
  const quoin_host_info ours = host_info();
  Text text;
  const quoin_library* info = library.entry(&ours, &text.text);
  if (!report.expect(info != nullptr, "refuses a host of its own version: %s", text.str().c_str())) return nullptr;
  report.expect(info->struct_size >= sizeof(quoin_library), "quoin_library is %llu bytes, version 1.0 has %zu",
                static_cast<unsigned long long>(info->struct_size), sizeof(quoin_library));
  report.expect(info->abi_major == QUOIN_ABI_MAJOR, "built for major version %u", info->abi_major);
  report.expect(info->name != nullptr && info->version != nullptr, "name or version is null");
  report.expect(info->law_count > 0 && info->laws != nullptr, "the library holds no law");
  report.expect(library.entry(&ours, &text.text) == info, "a second call gives another description");
  for (uint64_t i = 0; i < info->law_count; ++i) {
    report.expect(info->laws[i] != nullptr && info->laws[i]->struct_size >= sizeof(quoin_law),
                  "law %llu is null or short", static_cast<unsigned long long>(i));
  }
  if (info->extension != nullptr) {
    report.expect(info->extension("quoin.draft.no_such_extension/1") == nullptr, "an unknown extension is not null");
  }
  return info;
}

void check_other_majors(Report& report, const Library& library) {
  report.clause("C1.2");
  for (const uint32_t major : {QUOIN_ABI_MAJOR + 1, 0u, 4000000000u}) {
    const quoin_host_info other = host_info(major);
    Text reason;
    report.expect(library.entry(&other, &reason.text) == nullptr, "major version %u is accepted", major);
    report.expect(!reason.str().empty(), "major version %u is refused without a reason", major);
  }
}

void check_ill_formed_hosts(Report& report, const Library& library) {
  report.clause("C1.3");
  Text text;
  report.expect(library.entry(nullptr, &text.text) == nullptr, "a null host is accepted");
  quoin_host_info cut = host_info();
  cut.struct_size = 8;
  report.expect(library.entry(&cut, &text.text) == nullptr, "a host description of 8 bytes is accepted");
}

void check_newer_host(Report& report, const Library& library, const quoin_library* info) {
  report.clause("C1.4");
  struct {
    quoin_host_info host;
    uint64_t later[4];
  } longer = {host_info(QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR + 7), {~0ull, ~0ull, ~0ull, ~0ull}};
  longer.host.struct_size = sizeof longer;
  Text text;
  report.expect(library.entry(&longer.host, &text.text) == info, "a host of a newer minor version is not served alike");
}

// Ids and structs of properties or states; has_texts: whether the other texts of one are there.
template <class Info, class HasTexts>
void check_items(Report& report, const char* what, const char* texts, std::span<const Info* const> items,
                 const HasTexts& has_texts) {
  std::set<std::string> ids;
  for (const Info* item : items) {
    report.expect(good_id(item->id), "%s id %s", what, item->id);
    report.expect(ids.insert(item->id).second, "%s %s is there twice", what, item->id);
    report.expect(has_texts(*item), "%s: %s is null", item->id, texts);
    report.expect(item->struct_size >= sizeof *item, "%s: short quoin_%s_info", item->id, what);
  }
}

// Returns whether the rest of the metadata can be read.
bool check_completeness(Report& report, const quoin_law& law) {
  report.clause("C3.1");
  report.expect(good_id(law.id), "law id %s", shown(law.id));
  report.expect(law.name != nullptr && law.version != nullptr && law.citation != nullptr && law.description != nullptr,
                "name, version, citation or description is null");
  report.expect(law.create_material != nullptr && law.destroy_material != nullptr && law.material_number != nullptr &&
                    law.initial_state != nullptr && law.stiffness_bounds != nullptr && law.evaluate != nullptr,
                "a function is null");
  if (!report.expect(metadata_is_usable(law), "an id, unit or list is null: most of the law cannot be checked"))
    return false;
  check_items(report, "property", "symbol or description", properties_of(law), [](const quoin_property_info& property) {
    return property.symbol != nullptr && property.description != nullptr;
  });
  check_items(report, "state", "description", states_of(law),
              [](const quoin_state_info& state) { return state.description != nullptr; });
  return true;
}

void check_convention(Report& report, const quoin_law& law) {
  report.clause("C3.2");
  const quoin_convention* c = law.convention;
  report.expect(c != nullptr && c->struct_size >= sizeof *c && c->tension_sign == 1 && c->opening_sign == 1 &&
                    c->force_on_a_sign == 1 && c->normal_is_total == 1 && c->sliding_is_increment == 1 &&
                    c->traction_is_stress == 1,
                "not +1 +1 +1 total increment stress");
}

// C3.3 of a number.
void check_number(Report& report, const quoin_law& law, const quoin_property_info& property) {
  const bool required = property.flags & QUOIN_PROPERTY_REQUIRED;
  report.expect(property.lower <= property.upper, "%s: bounds %g to %g", property.id, property.lower, property.upper);
  if (!required && property.default_from == nullptr) {
    const double value = property.default_value;
    // An infinite default switches a mode off. The interval then includes the infinite bound.
    report.expect(inside(property, value) || (std::isinf(value) && value == property.upper),
                  "%s: default %g outside %g to %g", property.id, value, property.lower, property.upper);
  }
  if (property.default_from == nullptr) return;
  const quoin_property_info* from = find_property(law, property.default_from);
  report.expect(!required, "%s: required and with a default", property.id);
  report.expect(from != nullptr && from->kind == QUOIN_PROPERTY_NUMBER && std::strcmp(from->unit, property.unit) == 0,
                "%s: default_from %s is not a number of this law in the same unit", property.id, property.default_from);
  for (uint64_t steps = 0; from != nullptr && from->default_from != nullptr; ++steps) {
    if (!report.expect(steps <= law.property_count, "%s: default_from runs in a circle", property.id)) break;
    from = find_property(law, from->default_from);
  }
}

// C3.3 of a choice.
void check_choice(Report& report, const quoin_property_info& property) {
  bool found = property.default_text == nullptr;
  report.expect(property.choice_count > 0 && property.choices != nullptr, "%s: no choices", property.id);
  for (uint64_t i = 0; i < property.choice_count && property.choices != nullptr; ++i) {
    if (!report.expect(property.choices[i] != nullptr, "%s: a choice is null", property.id)) continue;
    found = found || std::strcmp(property.default_text, property.choices[i]) == 0;
  }
  report.expect(found, "%s: default \"%s\" is not a choice", property.id, shown(property.default_text));
  report.expect((property.default_text != nullptr) != ((property.flags & QUOIN_PROPERTY_REQUIRED) != 0),
                "%s: a choice is either required or has a default", property.id);
}

void check_properties(Report& report, const quoin_law& law) {
  for (const quoin_property_info* property : properties_of(law)) {
    report.clause("C3.3");
    const bool number = property->kind == QUOIN_PROPERTY_NUMBER, choice = property->kind == QUOIN_PROPERTY_CHOICE;
    report.expect(number || choice || property->kind == QUOIN_PROPERTY_TABLE, "%s: kind %u", property->id,
                  property->kind);
    report.expect((property->flags & ~15u) == 0, "%s: unknown flags %u", property->id, property->flags);
    if (number) check_number(report, law, *property);
    if (choice) check_choice(report, *property);
  }
}

void check_units(Report& report, const quoin_law& law) {
  for (const quoin_property_info* property : properties_of(law)) {
    report.clause("C3.4");
    report.expect(known_unit(property->unit), "property %s: unit \"%s\"", property->id, property->unit);
  }
  for (const quoin_state_info* state : states_of(law)) {
    report.clause("C3.4");
    report.expect(known_unit(state->unit), "state %s: unit \"%s\"", state->id, state->unit);
  }
}

void check_state_infos(Report& report, const quoin_law& law) {
  for (uint64_t s = 0; s < law.state_count; ++s) {
    report.clause("C3.5");
    const quoin_state_info& state = *law.states[s];
    report.expect(state.role == QUOIN_ROLE_HISTORY || state.role == QUOIN_ROLE_DIAGNOSTIC, "%s: role %u", state.id,
                  state.role);
    report.expect(state.kind >= QUOIN_STATE_SCALAR && state.kind <= QUOIN_STATE_PAIR_T, "%s: kind %u", state.id,
                  state.kind);
    report.expect((state.flags & ~1u) == 0 && state.reserved == 0, "%s: unknown flags", state.id);
    report.expect(state.lower <= state.upper, "%s: bounds %g to %g", state.id, state.lower, state.upper);
    if (state.kind == QUOIN_STATE_PAIR_S) {
      report.expect(s + 1 < law.state_count && law.states[s + 1]->kind == QUOIN_STATE_PAIR_T &&
                        std::strcmp(state.unit, law.states[s + 1]->unit) == 0,
                    "%s: the next state is not its t component", state.id);
    }
    if (state.kind == QUOIN_STATE_PAIR_T) {
      report.expect(s > 0 && law.states[s - 1]->kind == QUOIN_STATE_PAIR_S, "%s: no s component before it", state.id);
    }
  }
}

void check_capabilities(Report& report, const quoin_law& law) {
  report.clause("C3.6");
  std::set<std::string> ids;
  for (uint64_t i = 0; i < law.initial_state_count; ++i) {
    report.expect(good_id(law.initial_states[i]) && ids.insert(law.initial_states[i]).second, "initial state %s",
                  shown(law.initial_states[i]));
  }
  report.expect((law.capabilities & ~UINT64_C(63)) == 0, "unknown capability bits");
  report.expect(((law.capabilities & QUOIN_CAN_MIGRATE) != 0) == (law.migrate_state != nullptr),
                "QUOIN_CAN_MIGRATE and migrate_state disagree");
}

}  // namespace

void check_library(Report& report, const Library& library) {
  check_symbols(report, library);
  const quoin_library* info = check_description(report, library);
  if (info == nullptr) return;
  check_other_majors(report, library);
  const quoin_host_info next = host_info(QUOIN_ABI_MAJOR + 1);
  check_text(report, "quoin_library_v1", [&](quoin_text* text) { return library.entry(&next, text) == nullptr; });
  check_ill_formed_hosts(report, library);
  check_newer_host(report, library, info);
}

bool metadata_is_usable(const quoin_law& law) {
  if (law.struct_size < sizeof law || law.id == nullptr || law.create_material == nullptr ||
      law.destroy_material == nullptr || law.material_number == nullptr || law.initial_state == nullptr ||
      law.stiffness_bounds == nullptr || law.evaluate == nullptr || law.initial_state_count == 0 ||
      law.initial_states == nullptr || law.initial_states[0] == nullptr ||
      (law.property_count > 0 && law.properties == nullptr) || (law.state_count > 0 && law.states == nullptr)) {
    return false;
  }
  const auto named = [](const auto* item) { return item != nullptr && item->id != nullptr && item->unit != nullptr; };
  return std::ranges::all_of(properties_of(law), named) && std::ranges::all_of(states_of(law), named);
}

void check_metadata(Report& report, const quoin_law& law) {
  if (!check_completeness(report, law)) return;
  check_convention(report, law);
  check_properties(report, law);
  check_units(report, law);
  check_state_infos(report, law);
  check_capabilities(report, law);
}

}  // namespace check
