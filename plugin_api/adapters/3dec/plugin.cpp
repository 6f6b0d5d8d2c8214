// The four functions that 3DEC looks up in a plug-in. One build serves every law; the law is that of the file name. By
// 3DEC's naming of plug-ins, law NAME is jmodelNAME007.dll, with three digits for the version of the interface.
#include <algorithm>
#include <cctype>
#include <exception>
#include <string>

#include "3dec/quoin_joint_model.h"
#include "3dec/unserved_model.h"
#include "shared/law_library.h"

namespace {

const std::string& law_name() {
  static const std::string name = [] {
    std::string stem = quoin::adapters::own_file().stem().string();
    constexpr std::size_t digits = 3;  // exactly three, since the name of a law may end with a digit
    const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
    if (stem.size() > digits && std::all_of(stem.end() - digits, stem.end(), is_digit))
      stem.resize(stem.size() - digits);
    return stem.starts_with("jmodel") ? stem.substr(6) : stem;
  }();
  return name;
}

}  // namespace

// No exception crosses extern "C", since 3DEC may be built by another compiler. A law that is missing or refused
// becomes a joint model that throws the reason when it is used.
extern "C" {

QUOIN_EXPORT const char* getName() {
  try {
    static const std::string name = "jmodel" + law_name();
    return name.c_str();
  } catch (...) {  // no memory
    return "jmodel";
  }
}
QUOIN_EXPORT unsigned getMajorVersion() { return quoin::threedec::version; }
QUOIN_EXPORT unsigned getMinorVersion() { return 1; }
QUOIN_EXPORT void* createInstance() {
  using namespace quoin::threedec;
  try {
    try {
      static const ServedLaw law(law_name());
      return static_cast<jmodels::JointModel*>(new QuoinJointModel(law));
    } catch (const std::exception& error) {
      return static_cast<jmodels::JointModel*>(new UnservedModel(law_name(), error.what()));
    }
  } catch (...) {  // no memory
    return nullptr;
  }
}

}  // extern "C"
