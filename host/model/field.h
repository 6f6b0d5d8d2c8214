// Description of one array in the tables of fields (model/fields.h).
#pragma once

#include <cstddef>

#include "base/rank_rows.h"

namespace quoin {

// Kind of the items of an array.
enum class Owner { block, body, gridpoint, pair, contact_point, facet };
// Condition under which an array has its items; else it may be empty.
enum class When { always, with_stiffness_damping, with_maxwell, with_energies, after_checks, after_law_swaps };

struct Field {
  Owner owner;
  const char* name;
  When when = When::always;
  std::size_t hashed = 0;     // leading bytes of an item that belong to the hash of the state
  Part gathered = Part::all;  // first part with which ranks gather it in steps; nothing: steps do not change it
  bool known_to_all = false;  // whether every rank has all of it
  bool saved = true;

  // Copies of the field with one property changed.
  constexpr Field only(When holds) const {
    return change([&](Field& f) { f.when = holds; });
  }
  constexpr Field in_hash(std::size_t bytes) const {
    return change([&](Field& f) { f.hashed = bytes; });
  }
  constexpr Field in(Part part) const {
    return change([&](Field& f) { f.gathered = part; });
  }
  constexpr Field on_all_ranks() const {
    return change([&](Field& f) { f.known_to_all = true; });
  }
  constexpr Field not_saved() const {
    return change([&](Field& f) { f.saved = false; });
  }

 private:
  template <class Change>
  constexpr Field change(const Change& to) const {
    Field changed = *this;
    to(changed);
    return changed;
  }
};

}  // namespace quoin
