#include "law/metadata.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <set>

#include "base/printable.h"

namespace quoin {

namespace {

constexpr uint64_t kMost = 4096;         // laws, properties, states, choices; a larger count is an error
constexpr std::size_t kLongest = 65536;  // bytes of a text

// Whether a text ends, its bytes can be read, and it has no control characters.
bool is_text(const char* text) {
  for (std::size_t done = 0; done < kLongest;) {
    // Reads up to the end of a page at once, as the next page may not be mapped.
    const std::size_t page = 4096 - (reinterpret_cast<std::uintptr_t>(text + done) & 4095);
    if (!is_readable(text + done, page)) return false;
    // A terminal would execute control characters.
    if (std::memchr(text + done, 0, page) != nullptr) return is_printable(text);
    done += page;
  }
  return false;
}
bool is_text_or_null(const char* text) { return text == nullptr || is_text(text); }
bool is_id(const char* text) { return text != nullptr && is_text(text) && *text != '\0'; }

template <class Item>
bool is_list(const Item* list, uint64_t count) {
  return count == 0 || (list != nullptr && count <= kMost && is_readable(list, count * sizeof(Item)));
}

template <class Function>
bool is_function(Function* function) {
  Dl_info info;
  return dladdr(reinterpret_cast<const void*>(function), &info) != 0;
}

std::string fault_of_property(const quoin_property_info* p) {
  if (p == nullptr || !is_readable(p, sizeof *p) || p->struct_size < sizeof *p || !is_id(p->id))
    return "has no valid metadata";
  const std::string name = fmt::format("'{}' ", p->id);
  for (const char* text : {p->symbol, p->unit, p->description, p->default_from, p->default_text}) {
    if (!is_text_or_null(text)) return name + "has a text that is none, or not printable";
  }
  if (p->kind < QUOIN_PROPERTY_NUMBER || p->kind > QUOIN_PROPERTY_TABLE)
    return name + fmt::format("is of the unknown kind {}", p->kind);
  if (p->kind != QUOIN_PROPERTY_CHOICE) return {};
  if (p->choice_count == 0 || !is_list(p->choices, p->choice_count)) return name + "has no choices";
  for (uint64_t i = 0; i < p->choice_count; ++i) {
    if (!is_id(p->choices[i])) return name + "has a choice without a printable name";
  }
  return {};
}

std::string fault_of_state(const quoin_state_info* s) {
  if (s == nullptr || !is_readable(s, sizeof *s) || s->struct_size < sizeof *s || !is_id(s->id))
    return "has no valid metadata";
  const std::string name = fmt::format("'{}' ", s->id);
  if (!is_text_or_null(s->unit) || !is_text_or_null(s->description))
    return name + "has a text that is none, or not printable";
  if (!(s->lower <= s->upper)) return name + fmt::format("has the bounds [{:g}, {:g}]", s->lower, s->upper);
  return {};
}

std::string fault_of_law(const quoin_law* law) {
  if (law == nullptr || !is_readable(law, sizeof law->struct_size)) return "a null entry in its list of laws";
  if (law->struct_size < sizeof(quoin_law) || !is_readable(law, sizeof *law)) {
    return fmt::format("a quoin_law of {} bytes, but version {}.0 has {}", law->struct_size, QUOIN_ABI_MAJOR,
                       sizeof(quoin_law));
  }
  if (!is_id(law->id)) return "a law without a printable id";
  const std::string name = fmt::format("law '{}': ", law->id);
  for (const char* text : {law->name, law->version, law->citation, law->description}) {
    if (!is_text_or_null(text)) return name + "a text that is none, or not printable";
  }
  if (law->create_material == nullptr || law->destroy_material == nullptr || law->material_number == nullptr ||
      law->initial_state == nullptr || law->stiffness_bounds == nullptr || law->evaluate == nullptr) {
    return name + "a required function is null";
  }
  if (!is_function(law->create_material) || !is_function(law->destroy_material) || !is_function(law->material_number) ||
      !is_function(law->initial_state) || !is_function(law->stiffness_bounds) || !is_function(law->evaluate) ||
      (law->migrate_state != nullptr && !is_function(law->migrate_state))) {
    return name + "a function that is at no place of a library";
  }
  if ((law->capabilities & QUOIN_CAN_MIGRATE) != 0 && law->migrate_state == nullptr) {
    return name + "it says that it can migrate, but migrate_state is null";
  }
  const quoin_convention* c = law->convention;
  if (c == nullptr || !is_readable(c, sizeof *c) || c->struct_size < sizeof *c) return name + "no convention";
  if (c->tension_sign != 1 || c->opening_sign != 1 || c->force_on_a_sign != 1 || c->normal_is_total != 1 ||
      c->sliding_is_increment != 1 || c->traction_is_stress != 1) {
    return name + "a sign convention other than version 1's";
  }
  std::set<std::string> ids;
  if (!is_list(law->properties, law->property_count))
    return name + fmt::format("no list of {} properties", law->property_count);
  for (uint64_t i = 0; i < law->property_count; ++i) {
    const std::string fault = fault_of_property(law->properties[i]);
    if (!fault.empty()) return fmt::format("{}property {} {}", name, i, fault);
    if (!ids.insert(law->properties[i]->id).second)
      return fmt::format("{}property '{}' twice", name, law->properties[i]->id);
  }
  ids.clear();
  if (!is_list(law->states, law->state_count)) return name + fmt::format("no list of {} states", law->state_count);
  for (uint64_t i = 0; i < law->state_count; ++i) {
    const std::string fault = fault_of_state(law->states[i]);
    if (!fault.empty()) return fmt::format("{}state {} {}", name, i, fault);
    const quoin_state_info* s = law->states[i];
    if (!ids.insert(s->id).second) return fmt::format("{}state '{}' twice", name, s->id);
    const bool second = i > 0 && law->states[i - 1]->kind == QUOIN_STATE_PAIR_S;
    if (second != (s->kind == QUOIN_STATE_PAIR_T))
      return fmt::format("{}state '{}' breaks an (s, t) pair", name, s->id);
  }
  if (law->state_count > 0 && law->states[law->state_count - 1]->kind == QUOIN_STATE_PAIR_S) {
    return name + "an (s, t) pair of states has no t";
  }
  if (law->initial_state_count == 0 || !is_list(law->initial_states, law->initial_state_count))
    return name + "no initial state";
  for (uint64_t i = 0; i < law->initial_state_count; ++i) {
    if (!is_id(law->initial_states[i])) return fmt::format("{}initial state {} has no printable id", name, i);
  }
  return {};
}

}  // namespace

bool is_readable(const void* address, std::size_t bytes) {
  // The kernel copies the bytes, and returns an error where it cannot. One byte of each page suffices.
  constexpr std::size_t kPage = 4096;
  const auto begin = reinterpret_cast<std::uintptr_t>(address);
  if (bytes == 0) return true;
  if (address == nullptr || begin > UINTPTR_MAX - bytes) return false;
  for (std::uintptr_t at = begin; at < begin + bytes; at = (at / kPage + 1) * kPage) {
    char byte = 0;
    iovec here{&byte, 1}, there{reinterpret_cast<void*>(at), 1};
    if (process_vm_readv(getpid(), &here, 1, &there, 1, 0) < 0) return errno != EFAULT;
  }
  return true;
}

std::string fault_of_tables(const quoin_library& library) {
  if (!is_text_or_null(library.name) || !is_text_or_null(library.version))
    return "a text of the library that is none, or not printable";
  if (!is_list(library.laws, library.law_count)) return fmt::format("no list of {} laws", library.law_count);
  for (uint64_t i = 0; i < library.law_count; ++i) {
    const std::string fault = fault_of_law(library.laws[i]);
    if (!fault.empty()) return fault;
  }
  return {};
}

}  // namespace quoin
