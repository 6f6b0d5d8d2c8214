// Contact laws in the host: C++ ownership of the C interface in plugin_api.
#pragma once

#include <memory>
#include <new>
#include <string>
#include <vector>

#include "base/error.h"
#include "quoin.hpp"
#include "scene/scene.h"

namespace quoin {

class LawProcess;

// A loaded library; unloaded with its last owner. Laws and materials own their library.
class LawLibrary {
 public:
  // Loads a library. name_or_path: a path (contains '/') or the name of a law. NAME.so is searched in $QUOIN_LAW_PATH
  // (colon separated), laws/ beside the program, and ../lib*/quoin/laws. Throws Error(law_refused) with the paths tried
  // and the reason. Reasons are a missing or incomplete file, a file that is no shared library, no quoin_library_v1,
  // and another ABI version. The library runs from a copy in memory, which is made again if the file has changed since
  // the last load. Later changes of the file have no effect. With $QUOIN_LAW_IN_PLACE set it runs from its file, as
  // debuggers and profilers require.
  static std::shared_ptr<const LawLibrary> load(const std::string& name_or_path);
  ~LawLibrary();
  LawLibrary(const LawLibrary&) = delete;
  LawLibrary& operator=(const LawLibrary&) = delete;

  const quoin_library& info() const { return *library_; }
  const std::string& path() const { return path_; }

 private:
  LawLibrary() = default;
  void open(const std::string& bytes, const std::string& failed);
  void* handle_ = nullptr;
  const void* entry_ = nullptr;  // address in the library's code
  int copy_ = -1;                // descriptor of the copy; -1: none
  const quoin_library* library_ = nullptr;
  std::string path_;
};

// One law of a library.
struct Law {
  std::shared_ptr<const LawLibrary> library;
  const quoin_law* law = nullptr;

  // The law of a bare name; for a path, the only or first law of its library.
  static Law find(const std::string& name_or_path);
  int state_index(const std::string& id) const;  // -1: none

  // Calls a function of the law outside of steps. If it throws, which no law may, throws Error(law_refused).
  template <class Function>
  auto call(const Function& function) const {
    try {
      return function();
    } catch (const std::bad_alloc&) {  // memory may run out in our code too
      throw;
    } catch (...) {
      refuse_thrown();
    }
  }
  std::string thrown_text() const;  // for the exception that is being handled

 private:
  [[noreturn]] void refuse_thrown() const;
};

// An immutable, thread-safe material.
class Material {
 public:
  // Throws Error(law_refused) with the law's message (all its errors), preceded by the source of each wrong key if
  // known.
  Material(Law law, const std::vector<PropertySetting>& settings);
  const Law& law() const { return law_; }
  const quoin_law& api() const { return *law_.law; }
  const quoin_material* handle() const { return material_.handle(); }
  const std::string& warnings() const { return warnings_; }
  // Calls the law's function. The call is registered, so that a message can name a law that never returns
  // (law_calls.h). After isolate_laws() it runs in a separate process. Returns QUOIN_ERROR_INTERNAL once the law has
  // thrown, or its process has ended; fault() then has the reason. Thread-safe.
  quoin_status evaluate(quoin_batch* batch) const;
  std::string fault() const;                                    // empty: none
  void require_no_fault(Exit code) const;                       // throws Error with this code and the fault
  const LawProcess* process() const { return process_.get(); }  // null: none
  double number(const std::string& property_id) const;
  std::vector<double> initial_state(const std::string& id) const;  // throws Error(bad_input): unknown initial state
  const quoin_stiffness_bounds& stiffness_bounds() const { return material_.stiffness(); }

 private:
  Law law_;
  quoin::api::Material material_;
  std::string warnings_;
  std::shared_ptr<LawProcess> process_;
  struct Thrown;
  std::shared_ptr<Thrown> thrown_;
};

// Settings of laws in separate processes.
struct LawIsolation {
  int threads = 0;       // number of threads that evaluate at once; 0: laws are evaluated in this process
  double seconds = 0.0;  // time limit of a batch; 0: none
};
// Sets the isolation of materials that this thread makes from now on; returns the previous setting.
LawIsolation isolate_laws(const LawIsolation& wanted);

// Text of a law, which may be null.
inline const char* law_text(const char* text) { return text == nullptr ? "" : text; }

// Adds a folder in which laws are searched by name, before the folders beside the program. For other programs, such as
// tests.
void add_law_folder(const std::string& folder);

// Names of the laws in the search path, for `quoin models`.
std::vector<std::string> installed_laws();

}  // namespace quoin
