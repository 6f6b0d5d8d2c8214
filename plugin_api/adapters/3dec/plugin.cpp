// The four functions that 3DEC looks up in a plug-in. One build serves every law: the file's own name says which,
// jmodelNAME001.dll for the law NAME, as 3DEC's naming of plug-ins has it.
#include <cctype>
#include <string>

#include "3dec/quoin_joint_model.h"
#include "shared/law_library.h"

namespace {

const std::string& law_name() {
  static const std::string name = [] {
    std::string stem = quoin::adapters::own_file().stem().string();
    while (!stem.empty() && std::isdigit(static_cast<unsigned char>(stem.back()))) stem.pop_back();
    return stem.starts_with("jmodel") ? stem.substr(6) : stem;
  }();
  return name;
}

}  // namespace

extern "C" {

QUOIN_EXPORT const char* getName() {
  static const std::string name = "jmodel" + law_name();
  return name.c_str();
}
QUOIN_EXPORT unsigned getMajorVersion() { return 1; }
QUOIN_EXPORT unsigned getMinorVersion() { return 1; }
QUOIN_EXPORT void* createInstance() {
  return static_cast<jmodels::JointModel*>(new quoin::threedec::QuoinJointModel(law_name()));
}

}  // extern "C"
