// Valid tables of a law, with some words replaced.
#include <cstdlib>
#include <cstring>
#include <limits>

#include "judge.h"
#include "law/law_library.h"
#include "law/metadata.h"

namespace {

struct Tables {
  quoin_property_info property{};
  quoin_state_info state{};
  quoin_convention convention{sizeof(quoin_convention), 1, 1, 1, 1, 1, 1};
  const quoin_property_info* properties[1]{&property};
  const quoin_state_info* states[1]{&state};
  const char* initial_states[1]{"bonded"};
  quoin_law law{};
  const quoin_law* laws[1]{&law};
  quoin_library library{};
  Tables() {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    property.struct_size = sizeof property, property.id = "stiffness", property.symbol = "k", property.unit = "Pa/m";
    property.description = "a property", property.kind = QUOIN_PROPERTY_NUMBER, property.upper = kInfinite;
    state.struct_size = sizeof state, state.id = "damage", state.unit = "-", state.description = "a state";
    state.upper = 1.0;
    law.struct_size = sizeof law, law.id = "law", law.name = law.version = law.citation = law.description = "words";
    law.convention = &convention;
    law.property_count = law.state_count = law.initial_state_count = 1;
    law.properties = properties, law.states = states, law.initial_states = initial_states;
    // Valid function pointers, which are not called.
    const auto function = reinterpret_cast<void (*)()>(&std::abort);
    law.create_material = reinterpret_cast<decltype(law.create_material)>(function);
    law.destroy_material = reinterpret_cast<decltype(law.destroy_material)>(function);
    law.material_number = reinterpret_cast<decltype(law.material_number)>(function);
    law.initial_state = reinterpret_cast<decltype(law.initial_state)>(function);
    law.stiffness_bounds = reinterpret_cast<decltype(law.stiffness_bounds)>(function);
    law.evaluate = reinterpret_cast<decltype(law.evaluate)>(function);
    library.struct_size = sizeof library, library.abi_major = QUOIN_ABI_MAJOR, library.name = library.version = "words";
    library.law_count = 1, library.laws = laws;
  }
};

std::size_t length_of(const char* text) { return std::strlen(quoin::law_text(text)); }

}  // namespace

// Input: edits of ten bytes: table, word, new value.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kEdit = 10;
  Tables t;
  if (!quoin::fault_of_tables(t.library).empty()) std::abort();
  const auto edit = [&](void* table, std::size_t bytes, const std::uint8_t* with) {
    std::memcpy(static_cast<char*>(table) + with[1] % (bytes / 8) * 8, with + 2, 8);
  };
  for (std::size_t at = 0; at + kEdit <= size; at += kEdit) {
    switch (data[at] % 6) {
      case 0:
        edit(&t.library.name, sizeof t.library - offsetof(quoin_library, name), data + at);
        break;
      case 1:
        edit(&t.law, sizeof t.law, data + at);
        break;
      case 2:
        edit(&t.property, sizeof t.property, data + at);
        break;
      case 3:
        edit(&t.state, sizeof t.state, data + at);
        break;
      case 4:
        edit(&t.convention, sizeof t.convention, data + at);
        break;
      default:
        edit(t.initial_states, sizeof t.initial_states, data + at);
    }
  }
  const bool refused = !quoin::fault_of_tables(t.library).empty();
  ++ends()[refused ? quoin::Exit::law_refused : quoin::Exit::done];
  if (refused) return 0;
  // Tables that are accepted can be read completely.
  std::size_t all = length_of(t.library.name) + length_of(t.library.version);
  for (std::uint64_t l = 0; l < t.library.law_count; ++l) {
    const quoin_law& law = *t.library.laws[l];
    for (const char* text : {law.id, law.name, law.version, law.citation, law.description}) all += length_of(text);
    for (std::uint64_t i = 0; i < law.property_count; ++i) {
      const quoin_property_info& p = *law.properties[i];
      for (const char* text : {p.id, p.symbol, p.unit, p.description, p.default_from, p.default_text})
        all += length_of(text);
      for (std::uint64_t c = 0; p.kind == QUOIN_PROPERTY_CHOICE && c < p.choice_count; ++c)
        all += length_of(p.choices[c]);
    }
    for (std::uint64_t i = 0; i < law.state_count; ++i) all += length_of(law.states[i]->id);
    for (std::uint64_t i = 0; i < law.initial_state_count; ++i) all += length_of(law.initial_states[i]);
  }
  if (all > std::size_t{1} << 40) std::abort();  // law_text truncates every text
  return 0;
}
