// C1 to C3: symbols, negotiation, text, metadata.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include "checks.h"

namespace check {
namespace {

constexpr char kGuard = 0x5a;

// Calls with null, empty and short text buffers. Returns the text that a large buffer received.
template <class Call>
std::string check_text(Report& report, const char* what, const Call& call) {
  Text whole;
  report.clause("C2.1");
  call(&whole.text);
  const std::string message = whole.str();
  report.expect(call(nullptr), "%s: another result with null text", what);
  quoin_text nowhere = {sizeof nowhere, nullptr, 0, 12345};
  report.expect(call(&nowhere), "%s: another result with null data", what);
  report.clause("C2.3");
  report.expect(whole.text.length == message.size(), "%s: length %llu for a message of %zu bytes", what,
                static_cast<unsigned long long>(whole.text.length), message.size());
  report.expect(nowhere.length == message.size(), "%s: length %llu with null data for a message of %zu bytes", what,
                static_cast<unsigned long long>(nowhere.length), message.size());
  for (const size_t capacity : {0u, 1u, 2u, 3u, 8u, 31u, 64u, 200u}) {
    std::vector<char> bytes(capacity + 1024, kGuard);
    quoin_text text = {sizeof text, bytes.data() + 512, capacity, 12345};
    call(&text);
    report.clause("C2.2");
    const auto guarded = [](char c) { return c == kGuard; };
    report.expect(std::all_of(bytes.begin(), bytes.begin() + 512, guarded) &&
                      std::all_of(bytes.begin() + 512 + static_cast<long>(capacity), bytes.end(), guarded),
                  "%s: bytes outside a buffer of %zu were written", what, capacity);
    if (capacity > 0) {
      const char* end = static_cast<const char*>(std::memchr(text.data, 0, capacity));
      if (report.expect(end != nullptr, "%s: no final zero in a buffer of %zu", what, capacity)) {
        report.expect(message.compare(0, static_cast<size_t>(end - text.data), text.data) == 0,
                      "%s: a cut message is not the beginning of the whole one", what);
      }
    }
    report.clause("C2.3");
    report.expect(text.length == message.size(), "%s: length %llu with capacity %zu for a message of %zu bytes", what,
                  static_cast<unsigned long long>(text.length), capacity, message.size());
  }
  report.clause("C2.4");
  char small[64];
  std::memset(small, kGuard, sizeof small);
  quoin_text cut = {24, small, sizeof small, 12345};
  call(&cut);
  report.expect(cut.length == 12345 && small[0] == kGuard, "%s: a quoin_text of 24 bytes was written to", what);
  return message;
}

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

}  // namespace

void check_library(Report& report, const Library& library) {
  report.clause("C1.1");
  report.expect(library.exported.size() == 1, "%zu symbols are exported", library.exported.size());
  for (const std::string& name : library.exported) {
    report.expect(name == QUOIN_LIBRARY_SYMBOL, "exported: %s", name.c_str());
  }

  report.clause("C1.5");
  const quoin_host_info ours = host_info();
  Text text;
  const quoin_library* info = library.entry(&ours, &text.text);
  if (!report.expect(info != nullptr, "refuses a host of its own version: %s", text.str().c_str())) return;
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

  for (const uint32_t major : {QUOIN_ABI_MAJOR + 1, 0u, 4000000000u}) {
    const quoin_host_info other = host_info(major);
    report.clause("C1.2");
    Text reason;
    report.expect(library.entry(&other, &reason.text) == nullptr, "major version %u is accepted", major);
    report.expect(!reason.str().empty(), "major version %u is refused without a reason", major);
  }
  const quoin_host_info next = host_info(QUOIN_ABI_MAJOR + 1);
  check_text(report, "quoin_library_v1", [&](quoin_text* t) { return library.entry(&next, t) == nullptr; });

  report.clause("C1.3");
  report.expect(library.entry(nullptr, &text.text) == nullptr, "a null host is accepted");
  quoin_host_info cut = host_info();
  cut.struct_size = 8;
  report.expect(library.entry(&cut, &text.text) == nullptr, "a host description of 8 bytes is accepted");

  report.clause("C1.4");
  struct {
    quoin_host_info host;
    uint64_t later[4];
  } longer = {host_info(QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR + 7), {~0ull, ~0ull, ~0ull, ~0ull}};
  longer.host.struct_size = sizeof longer;
  report.expect(library.entry(&longer.host, &text.text) == info, "a host of a newer minor version is not served alike");

  if (info->extension != nullptr) {
    report.clause("C1.5");
    report.expect(info->extension("quoin.draft.no_such_extension/1") == nullptr, "an unknown extension is not null");
  }
}

bool metadata_is_usable(const quoin_law& law) {
  if (law.struct_size < sizeof law || law.id == nullptr || law.create_material == nullptr ||
      law.destroy_material == nullptr || law.material_number == nullptr || law.initial_state == nullptr ||
      law.stiffness_bounds == nullptr || law.evaluate == nullptr || law.initial_state_count == 0 ||
      law.initial_states == nullptr || law.initial_states[0] == nullptr ||
      (law.property_count > 0 && law.properties == nullptr) || (law.state_count > 0 && law.states == nullptr)) {
    return false;
  }
  for (uint64_t p = 0; p < law.property_count; ++p) {
    if (law.properties[p] == nullptr || law.properties[p]->id == nullptr || law.properties[p]->unit == nullptr) {
      return false;
    }
  }
  for (uint64_t s = 0; s < law.state_count; ++s) {
    if (law.states[s] == nullptr || law.states[s]->id == nullptr || law.states[s]->unit == nullptr) return false;
  }
  return true;
}

void check_metadata(Report& report, const quoin_law& law) {
  report.clause("C3.1");
  report.expect(good_id(law.id), "law id %s", shown(law.id));
  report.expect(law.name != nullptr && law.version != nullptr && law.citation != nullptr && law.description != nullptr,
                "name, version, citation or description is null");
  report.expect(law.create_material != nullptr && law.destroy_material != nullptr && law.material_number != nullptr &&
                    law.initial_state != nullptr && law.stiffness_bounds != nullptr && law.evaluate != nullptr,
                "a function is null");
  report.expect(metadata_is_usable(law), "an id, unit or list is null: most of the law cannot be checked");
  if (!metadata_is_usable(law)) return;
  std::set<std::string> ids;
  for (uint64_t p = 0; p < law.property_count; ++p) {
    const quoin_property_info& property = *law.properties[p];
    report.expect(good_id(property.id), "property id %s", property.id);
    report.expect(ids.insert(property.id).second, "property %s is there twice", property.id);
    report.expect(property.symbol != nullptr && property.description != nullptr, "%s: symbol or description is null",
                  property.id);
    report.expect(property.struct_size >= sizeof property, "%s: short quoin_property_info", property.id);
  }
  ids.clear();
  for (uint64_t s = 0; s < law.state_count; ++s) {
    const quoin_state_info& state = *law.states[s];
    report.expect(good_id(state.id), "state id %s", state.id);
    report.expect(ids.insert(state.id).second, "state %s is there twice", state.id);
    report.expect(state.description != nullptr, "%s: description is null", state.id);
    report.expect(state.struct_size >= sizeof state, "%s: short quoin_state_info", state.id);
  }

  report.clause("C3.2");
  const quoin_convention* c = law.convention;
  report.expect(c != nullptr && c->struct_size >= sizeof *c && c->tension_sign == 1 && c->opening_sign == 1 &&
                    c->force_on_a_sign == 1 && c->normal_is_total == 1 && c->sliding_is_increment == 1 &&
                    c->traction_is_stress == 1,
                "not +1 +1 +1 total increment stress");

  for (uint64_t p = 0; p < law.property_count; ++p) {
    const quoin_property_info& property = *law.properties[p];
    report.clause("C3.4");
    report.expect(known_unit(property.unit), "property %s: unit \"%s\"", property.id, property.unit);
    report.clause("C3.3");
    const bool number = property.kind == QUOIN_PROPERTY_NUMBER;
    report.expect(number || property.kind == QUOIN_PROPERTY_CHOICE || property.kind == QUOIN_PROPERTY_TABLE,
                  "%s: kind %u", property.id, property.kind);
    report.expect((property.flags & ~15u) == 0, "%s: unknown flags %u", property.id, property.flags);
    if (number) {
      report.expect(property.lower <= property.upper, "%s: bounds %g to %g", property.id, property.lower,
                    property.upper);
      const bool has_default = !(property.flags & QUOIN_PROPERTY_REQUIRED) && property.default_from == nullptr;
      if (has_default) {
        const double value = property.default_value;
        const bool above =
            property.flags & QUOIN_PROPERTY_LOWER_OPEN ? value > property.lower : value >= property.lower;
        // An infinite default switches a mode off. The interval then includes the infinite bound.
        const bool below = (property.flags & QUOIN_PROPERTY_UPPER_OPEN) && !std::isinf(value) ? value < property.upper
                                                                                              : value <= property.upper;
        report.expect(above && below, "%s: default %g outside %g to %g", property.id, value, property.lower,
                      property.upper);
      }
      if (property.default_from != nullptr) {
        const quoin_property_info* from = find_property(law, property.default_from);
        report.expect(!(property.flags & QUOIN_PROPERTY_REQUIRED), "%s: required and with a default", property.id);
        report.expect(
            from != nullptr && from->kind == QUOIN_PROPERTY_NUMBER && std::strcmp(from->unit, property.unit) == 0,
            "%s: default_from %s is not a number of this law in the same unit", property.id, property.default_from);
        for (uint64_t steps = 0; from != nullptr && from->default_from != nullptr; ++steps) {
          if (!report.expect(steps <= law.property_count, "%s: default_from runs in a circle", property.id)) break;
          from = find_property(law, from->default_from);
        }
      }
    } else if (property.kind == QUOIN_PROPERTY_CHOICE) {
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
  }

  for (uint64_t s = 0; s < law.state_count; ++s) {
    const quoin_state_info& state = *law.states[s];
    report.clause("C3.4");
    report.expect(known_unit(state.unit), "state %s: unit \"%s\"", state.id, state.unit);
    report.clause("C3.5");
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

  report.clause("C3.6");
  ids.clear();
  for (uint64_t i = 0; i < law.initial_state_count; ++i) {
    report.expect(good_id(law.initial_states[i]) && ids.insert(law.initial_states[i]).second, "initial state %s",
                  shown(law.initial_states[i]));
  }
  report.expect((law.capabilities & ~UINT64_C(63)) == 0, "unknown capability bits");
  report.expect(((law.capabilities & QUOIN_CAN_MIGRATE) != 0) == (law.migrate_state != nullptr),
                "QUOIN_CAN_MIGRATE and migrate_state disagree");
}

}  // namespace check
