// A law and its materials in C++20, over the C ABI of quoin/quoin.h: one header, nothing to link, no dependency.
//
//   void* file = dlopen("laws/fracture_energy.so", RTLD_NOW | RTLD_LOCAL);  // or LoadLibrary, or a law linked in
//   const auto entry = reinterpret_cast<quoin_library_function>(dlsym(file, QUOIN_LIBRARY_SYMBOL));
//   const quoin_law& law = *quoin::api::library(entry, "my program", "1.0").laws[0];
//   const quoin::api::Material mortar(law, {{"normal_stiffness", {82e9}}, {"shear_stiffness", {36e9}}});
//   quoin_batch batch = ...;  // columns of the program's own memory: quoin/batch.h
//   mortar.evaluate(batch);
//
// Units: SI, degrees where a property's unit says so; tension and opening positive (quoin/metadata.h).
// Ownership: a Material owns its quoin_material. The program owns the law and its library, which must outlive the
// Material. A Material keeps no pointer to the values that it is made from.
// Threads: a Material is immutable; any number of threads may evaluate at the same time, in batches that share no
// outputs.
// Errors: quoin::api::Error with the law and the reason.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "quoin/quoin.h"

namespace quoin::api {

class Error : public std::runtime_error {
 public:
  Error(quoin_status status_, const std::string& what, std::string words_ = {})
      : std::runtime_error(what), status(status_), words(std::move(words_)) {}
  quoin_status status;
  std::string words;  // message of the law: every fault, one a line
};

// Returns the whole text that call(quoin_text*) writes. If the first buffer is too short, calls it a second time with a
// longer one, up to a megabyte. If that fails too, because the law sets wrong lengths, returns the buffer as it is.
template <class Call>
std::string text_of(const Call& call) {
  constexpr std::uint64_t longest = 1 << 20;
  std::string buffer(4096, '\0');
  for (bool again = true;; again = false) {
    quoin_text text{sizeof text, buffer.data(), buffer.size(), 0};
    call(&text);
    if (text.length < buffer.size()) {
      buffer.resize(static_cast<std::size_t>(text.length));
      return buffer;
    }
    if (!again || text.length >= longest) {
      buffer.resize(std::min(buffer.find('\0'), buffer.size()));
      return buffer;
    }
    buffer.assign(static_cast<std::size_t>(text.length) + 1, '\0');
  }
}

// Returns the library that entry, the address of QUOIN_LIBRARY_SYMBOL, gives; it has one law or more. Throws
// Error(QUOIN_ERROR_VERSION): entry is null, the library refuses this program, its ABI has another major version, or it
// has no law.
inline const quoin_library& library(quoin_library_function entry, const char* program, const char* version) {
  if (entry == nullptr)
    throw Error(QUOIN_ERROR_VERSION, "exports no " QUOIN_LIBRARY_SYMBOL ": not a library of contact laws");
  const quoin_host_info host{sizeof host, QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR, program, version};
  const quoin_library* found = nullptr;
  const std::string words = text_of([&](quoin_text* text) { found = entry(&host, text); });
  if (found == nullptr) throw Error(QUOIN_ERROR_VERSION, "refuses " + std::string(program) + ": " + words, words);
  // Only the size and the version may be read before the version has been checked.
  constexpr std::size_t head = offsetof(quoin_library, abi_minor) + sizeof found->abi_minor;
  if (found->struct_size < head || found->abi_major != QUOIN_ABI_MAJOR || found->struct_size < sizeof *found)
    throw Error(QUOIN_ERROR_VERSION, "speaks another version of the ABI than " + std::to_string(QUOIN_ABI_MAJOR) +
                                         ".x; build the law against this program's headers");
  if (found->law_count == 0) throw Error(QUOIN_ERROR_VERSION, "holds no law");
  return *found;
}

// One property value: a number {x}, a table of pairs {x0, f0, x1, f1, ...}, or a choice, with text and no numbers.
struct Value {
  std::string id;
  std::vector<double> numbers;
  std::string text = {};
};

class Material {
 public:
  // Properties that are not given have the law's default. Throws Error with the law's message if the law refuses the
  // values (QUOIN_ERROR_PROPERTY) or fails otherwise.
  Material(const quoin_law& law, const std::vector<Value>& values) : law_(&law), handle_(nullptr, Destroy{&law}) {
    std::vector<quoin_property_value> raw;
    std::vector<const quoin_property_value*> pointers;
    raw.reserve(values.size());
    for (const Value& value : values) {
      const bool numeric = !value.numbers.empty();
      raw.push_back({sizeof(quoin_property_value), value.id.c_str(), value.numbers.size(),
                     numeric ? value.numbers.data() : nullptr, numeric ? nullptr : value.text.c_str()});
      pointers.push_back(&raw.back());
    }
    quoin_status status = QUOIN_OK;
    warnings_ = text_of([&](quoin_text* text) {
      quoin_material* made = nullptr;
      status = law.create_material(&law, pointers.size(), pointers.data(), &made, text);
      handle_.reset(made);
    });
    if (status != QUOIN_OK || handle_ == nullptr)
      throw Error(status, std::string(law.id) + ": " + (warnings_.empty() ? "refused without a reason" : warnings_),
                  warnings_);
    expect(law.stiffness_bounds(handle(), &stiffness_), "gives no stiffness bounds");
  }

  const quoin_law& law() const { return *law_; }
  const quoin_material* handle() const { return handle_.get(); }
  const std::string& warnings() const { return warnings_; }  // the law's warnings, one a line; empty: none
  // Upper bounds of the stiffness over all states of the material, Pa/m: quoin/law.h.
  const quoin_stiffness_bounds& stiffness() const { return stiffness_; }

  // Returns the value of a number property, given or default. Throws Error for an unknown property.
  double number(const std::string& property) const {
    double value = 0.0;
    expect(law_->material_number(handle(), property.c_str(), &value), "has no number property " + property);
    return value;
  }
  // Returns the law().state_count values of an initial state. Throws Error for an unknown id.
  std::vector<double> initial_state(const std::string& id) const {
    std::vector<double> values(law_->state_count);
    std::string known;
    for (std::uint64_t i = 0; i < law_->initial_state_count; ++i)
      known.append(i > 0 ? ", " : "").append(law_->initial_states[i]);
    expect(law_->initial_state(handle(), id.c_str(), values.data()), "no initial state " + id + "; it has " + known);
    return values;
  }
  // Evaluates the batch. Throws Error, with nothing written, if the batch breaks the contract or requests an output
  // that the law does not offer. Points that fail do not throw: see failed_count, worst_status and status of the batch.
  void evaluate(quoin_batch& batch) const {
    const quoin_status status = law_->evaluate(handle(), &batch);
    if (status != QUOIN_OK) expect(status, "refuses the batch with status " + std::to_string(status));
  }

 private:
  struct Destroy {
    const quoin_law* law;
    void operator()(quoin_material* material) const { law->destroy_material(material); }
  };
  void expect(quoin_status status, const std::string& otherwise) const {
    if (status != QUOIN_OK) throw Error(status, std::string(law_->id) + ": " + otherwise);
  }

  const quoin_law* law_;
  std::unique_ptr<quoin_material, Destroy> handle_;
  std::string warnings_;
  quoin_stiffness_bounds stiffness_{sizeof(quoin_stiffness_bounds), 0.0, 0.0};
};

}  // namespace quoin::api
