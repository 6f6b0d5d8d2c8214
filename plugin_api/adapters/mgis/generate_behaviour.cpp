// Prints the source of a behaviour library, whose symbols describe a law to an MGIS-based host.
// usage: quoin-generate-behaviour LAW_FILE > source.cpp
#include <cmath>
#include <exception>
#include <iostream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "mgis/behaviour_data.h"
#include "shared/law_library.h"
#include "shared/material.h"

namespace {

using Names = std::vector<std::string>;

class Writer {
 public:
  explicit Writer(std::string behaviour) : behaviour_(std::move(behaviour)) {}

  void flag(const std::string& symbol, unsigned value) const {
    std::cout << "QUOIN_EXPORT unsigned short " << behaviour_ << "_" << symbol << " = " << value << ";\n";
  }
  void text(const std::string& symbol, const std::string& value) const {
    std::cout << "QUOIN_EXPORT const char* " << behaviour_ << "_" << symbol << " = \"" << value << "\";\n";
  }
  // Prints the pair of symbols from which hosts read a list: its length n<symbol> and its names <symbol>.
  void list(const std::string& symbol, const Names& names) const {
    flag("n" + symbol, static_cast<unsigned>(names.size()));
    std::cout << "QUOIN_EXPORT const char* " << behaviour_ << "_" << symbol << "[] = {";
    for (const std::string& name : names) std::cout << "\"" << name << "\", ";
    std::cout << "nullptr};\n";
  }
  void types(const std::string& symbol, std::size_t count, int type) const {
    std::cout << "QUOIN_EXPORT int " << behaviour_ << "_" << symbol << "Types[] = {";
    for (std::size_t i = 0; i < count; ++i) std::cout << type << ", ";
    std::cout << "-1};\n";
  }
  void bound(const std::string& variable, const char* side, double value) const {
    if (!std::isfinite(value)) return;
    std::cout << "QUOIN_EXPORT long double " << behaviour_ << "_" << variable << "_" << side
              << "PhysicalBound = " << std::scientific << value << "L;\n";
  }

 private:
  std::string behaviour_;
};

// Prints one behaviour. energies: true if it computes energies, which multiply the cost of a step. MGIS provides memory
// for them to every behaviour that declares them, also where the host does not use them, so there is one without.
void print_behaviour(const quoin_law& law, const std::string& name, bool energies) {
  constexpr int scalar = 0, vector = 2;
  const Writer write(name);
  Names properties, states, initial_states;
  for (const quoin_property_info* property : quoin::adapters::scalar_properties(law))
    properties.push_back(property->id);
  for (std::uint64_t i = 0; i < law.state_count; ++i) states.push_back(law.states[i]->id);
  for (std::uint64_t i = 0; i < law.initial_state_count; ++i) initial_states.push_back(law.initial_states[i]);

  write.text("mfront_ept", name);
  write.text("mfront_interface", "Generic");
  write.text("src", std::string("quoin law ") + law.id + " " + law.version);
  write.text("unit_system", "SI");
  write.flag("api_version", quoin::mgis::api_version);
  write.flag("mfront_mkt", 1);          // a behaviour
  write.flag("BehaviourType", 3);       // cohesive zone model
  write.flag("BehaviourKinematic", 2);  // opening displacement, cohesive force
  write.flag("SymmetryType", 0);        // isotropic
  write.flag("ElasticSymmetryType", 0);
  write.flag("UsableInPurelyImplicitResolution", 1);
  write.flag("requiresStiffnessTensor", 0);
  write.flag("requiresThermalExpansionCoefficientTensor", 0);
  write.flag("TemperatureRemovedFromExternalStateVariables", 0);  // no temperature
  write.flag("ComputesInternalEnergy", energies);
  write.flag("ComputesDissipatedEnergy", energies);
  write.list("ModellingHypotheses", {"PlaneStrain", "Tridimensional"});
  write.flag("nMainVariables", 1);
  write.list("Gradients", {"OpeningDisplacement"});
  write.types("Gradients", 1, vector);
  write.list("ThermodynamicForces", {"CohesiveForce"});
  write.types("ThermodynamicForces", 1, vector);
  write.list("TangentOperatorBlocks", {"CohesiveForce", "OpeningDisplacement"});
  write.list("MaterialProperties", properties);
  write.list("InternalStateVariables", states);
  write.types("InternalStateVariables", states.size(), scalar);
  write.list("ExternalStateVariables", {});
  write.types("ExternalStateVariables", 0, scalar);
  write.list("Parameters", {});
  write.types("Parameters", 0, scalar);
  write.list("PostProcessings", {});
  write.list("InitializeFunctions", initial_states);
  for (const std::string& state : initial_states) {
    write.list("InitializeFunction_" + state + "_Inputs", {});
    write.types("InitializeFunction_" + state + "_Inputs", 0, scalar);
  }
  for (std::uint64_t i = 0; i < law.property_count; ++i) {
    const quoin_property_info& property = *law.properties[i];
    if (property.kind != QUOIN_PROPERTY_NUMBER) continue;
    write.bound(property.id, "Lower", property.lower);
    write.bound(property.id, "Upper", property.upper);
  }
  std::cout << "\nstatic constinit quoin::mgis::Behaviour behaviour_" << name << "(\"" << law.id << "\", "
            << law.state_schema << "u, " << name << "_MaterialProperties, " << properties.size() << ", "
            << (energies ? "true" : "false") << ");\n";
  for (const auto& [hypothesis, constant] :
       {std::pair{"PlaneStrain", "plane_strain"}, std::pair{"Tridimensional", "tridimensional"}}) {
    const std::string prefix = name + "_" + hypothesis;
    for (const std::string& state : initial_states)
      std::cout << "QUOIN_EXPORT int " << prefix << "_InitializeFunction_" << state
                << "(quoin::mgis::BehaviourData* data, const double*) {\n  return behaviour_" << name
                << ".initialize(*data, \"" << state << "\");\n}\n";
    std::cout << "QUOIN_EXPORT int " << prefix << "(quoin::mgis::BehaviourData* data) {\n"
              << "  return behaviour_" << name << ".integrate(*data, quoin::mgis::Hypothesis::" << constant
              << ");\n}\n";
  }
}

void print_source(const quoin_law& law) {
  std::cout.precision(std::numeric_limits<double>::max_digits10);
  std::cout << "// Generated by quoin-generate-behaviour from the metadata of " << law.id << " " << law.version << ".\n"
            << "#include \"mgis/behaviour.h\"\n\n"
            << "extern \"C\" {\n\n";
  print_behaviour(law, law.id, false);
  if ((law.capabilities & QUOIN_CAN_ENERGY) != 0) print_behaviour(law, std::string(law.id) + "_with_energies", true);
  std::cout << "\n}  // extern \"C\"\n";
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: quoin-generate-behaviour LAW_FILE > source.cpp\n";
    return 2;
  }
  try {
    print_source(quoin::adapters::law_in_file(argv[1]));
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
  return 0;
}
