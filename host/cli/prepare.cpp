#include "cli/prepare.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "analysis/collapse_start.h"
#include "base/error.h"
#include "base/input_file.h"
#include "base/sha256.h"
#include "files/memory.h"
#include "files/notice.h"
#include "law/law_library.h"
#include "law/property_text.h"
#include "model/motion.h"
#include "scene/read_scene.h"
#include "scene/rest_scene.h"
#include "scene/size.h"
#include "scene/unused_settings.h"
#include "step/law_swap.h"

namespace quoin {

namespace {

void replace_law(JointFamily& family, const std::string& name, const Law& law) {
  family.law = name;
  std::vector<std::string> left_out;
  std::erase_if(family.properties, [&](const PropertySetting& p) {
    if (find_property(*law.law, p.id)) return false;
    left_out.push_back(p.id);
    return true;
  });
  std::erase_if(family.correlation, [&](const PropertyCorrelation& c) {
    return !find_property(*law.law, c.first) || !find_property(*law.law, c.second);
  });
  if (!left_out.empty())
    notice(fmt::format("quoin: joints.{}: law {} has no {}: left out", family.name, law.law->id,
                       fmt::join(left_out, ", ")));
  const char* const* states = law.law->initial_states;
  const char* const* end = states + law.law->initial_state_count;
  if (states != end && std::none_of(states, end, [&](const char* s) { return family.initial_state == s; })) {
    notice(fmt::format("quoin: joints.{}: law {} has no initial state '{}': '{}' is used", family.name, law.law->id,
                       family.initial_state, *states));
    family.initial_state = *states;
  }
}

bool is_along_x(const Scene& scene) {
  if (scene.building) return false;
  if (scene.blocks && !scene.blocks->arches.empty()) return false;
  return !scene.blocks || std::all_of(scene.blocks->walls.begin(), scene.blocks->walls.end(),
                                      [](const DryWallSpec& w) { return w.direction == 0.0; });
}

// Fault of a random property, whose values per point the law must accept.
std::string fault_of_scatter(const Scene& scene, const JointFamily& family, const Law& law) {
  for (const PropertySetting& p : family.properties) {
    if (!p.scatter) continue;
    const quoin_property_info* info = find_property(*law.law, p.id);
    if (info && !(info->flags & QUOIN_PROPERTY_PER_POINT))
      return fmt::format("{}: a distribution, but law {} does not take this property point by point; give one value",
                         p.source.text, law.law->id);
    if (p.scatter->correlation_length > 0.0 && !is_along_x(scene))
      return fmt::format(
          "{}.correlation_length = {:g}: only of walls along x, where a course is one line; allowed here: 0",
          p.source.text, p.scatter->correlation_length);
  }
  for (const Stage& stage : scene.stages) {
    if (!stage.law_swaps.contains(family.name)) continue;
    if (std::string fault = fault_of_law_swap(family, stage); !fault.empty()) return fault;
  }
  return "";
}

std::string value_text(const PropertySetting& p) {
  return p.numbers.empty() ? p.text : fmt::format("{}", fmt::join(p.numbers, ", "));
}

// Refuses a scene that is too large, before the model is made.
void refuse_what_does_not_fit(const Scene& scene, const SceneOptions& options) {
  // Largest number of an index; bytes from which the user gets a message first.
  constexpr double kMost = 2e9, kLarge = 1e8;
  const SceneSize size = size_of(scene);
  const std::string words = fmt::format("{}: about {:.3g} blocks, {:.3g} zones and {:.3g} contact points", scene.file,
                                        size.blocks, size.zones, size.points);
  if (std::max(size.zones, size.points) > kMost)
    throw Error(Exit::bad_input,
                fmt::format("{}: of each, {:g} at most can be numbered; make the scene smaller", words, kMost));
  const int here = options.processes_here;
  const char* const each = size.bytes_shared > 0.0 ? "a part on each" : "all of them on each";
  if (!options.force)
    require_memory(here * (kProgramBytes + size.bytes_of_rank(options.processes)),
                   options.processes > 1 ? fmt::format("{}, {} of {} ranks here,", words, each, here) : words,
                   "make the scene smaller, or try all the same with --force");
  if (size.bytes > kLarge)
    notice(fmt::format("{}, about {:.2g} GB; to make them takes a while", words, size.bytes / 1e9));
}

// Fault of stiffnesses that are typing errors, or of a law. Time steps follow from stiffnesses. 0 is allowed: a joint
// without friction has no shear.
std::string fault_of_stiffness(const JointFamily& family, const Material& material) {
  constexpr double kMost = 1e20;  // Pa/m; steel of 2 nm
  const quoin_stiffness_bounds& bounds = material.stiffness_bounds();
  const auto allowed = [](double bound) { return bound >= 0.0 && bound <= kMost; };  // not NaN
  if (allowed(bounds.normal) && allowed(bounds.shear)) return "";
  return fmt::format(
      "{}: law {} is up to {:g} and {:g} Pa/m stiff (across and along the joint) with these properties; allowed: 0 to "
      "{:g} Pa/m, as time steps follow from it; {}",
      family.source.text, material.api().id, bounds.normal, bounds.shear, kMost,
      std::max(bounds.normal, bounds.shear) > kMost ? "lower the stiffness" : "correct the law's stiffness_bounds");
}

// Faults that laws report, one a line. If there are any, the exit code is that of a faulty scene.
class LawFaults {
 public:
  void add(const std::string& fault, Exit code = Exit::bad_input) {
    if (fault.empty()) return;
    if (std::find(faults_.begin(), faults_.end(), fault) == faults_.end()) faults_.push_back(fault);
    if (code == Exit::bad_input || exit_code_ == Exit::done) exit_code_ = code;
  }
  void throw_any() const {
    if (!faults_.empty()) throw Error(exit_code_, fmt::format("{}", fmt::join(faults_, "\n")));
  }

 private:
  std::vector<std::string> faults_;
  Exit exit_code_ = Exit::done;
};

// Whether the law has all property keys of the family.
bool check_names(const Scene& scene, const JointFamily& family, const Law& law, LawFaults& faults) {
  std::vector<std::string> ids;
  for (uint64_t i = 0; i < law.law->property_count; ++i) ids.push_back(law.law->properties[i]->id);
  std::vector<std::string> states(law.law->initial_states, law.law->initial_states + law.law->initial_state_count);
  bool known = true;
  const auto add = [&](const std::string& fault) {
    faults.add(fault);
    known = known && fault.empty();
  };
  if (std::find(states.begin(), states.end(), family.initial_state) == states.end())
    add(fmt::format("{} = '{}': law {} has no such initial state{}; it has: {}", family.initial_state_source.text,
                    family.initial_state, law.law->id, did_you_mean(family.initial_state, states),
                    fmt::join(states, ", ")));
  std::vector<std::string> keys = ids;
  keys.insert(keys.end(), {"law", "initial_state", "missing_mortar", "correlation"});
  add(fault_of_scatter(scene, family, law));
  for (const PropertySetting& p : family.properties) {
    if (std::find(ids.begin(), ids.end(), p.id) != ids.end()) continue;
    add(fmt::format("{} = {}: unknown key{}; law {} has: {}", p.source.text, value_text(p), did_you_mean(p.id, keys),
                    law.law->id, fmt::join(ids, ", ")));
  }
  return known;
}

// Checks the laws of all joints, those of later stages too, before hours of computation.
LawFaults faults_of_laws(Scene& scene, const SceneOptions& options) {
  LawFaults faults;
  for (auto& [name, family] : scene.joints) {
    try {
      const Law law = Law::find(options.law.empty() ? family.law : options.law);
      if (!options.law.empty()) replace_law(family, options.law, law);
      const bool valued = std::ranges::none_of(
          family.properties, [](const PropertySetting& p) { return p.numbers.empty() && p.text.empty(); });
      if (check_names(scene, family, law, faults) && valued)
        faults.add(fault_of_stiffness(family, Material(law, family.properties)));
    } catch (const Error& error) {
      const bool located = !options.law.empty() || std::string_view(error.what()).find(scene.file) == 0;
      faults.add(located ? error.what() : fmt::format("{}: {}", family.source.text, error.what()), error.exit_code);
    }
  }
  for (const Stage& stage : scene.stages) {
    for (const auto& [family, law] : stage.law_swaps) {
      try {
        const JointFamily& joints = scene.joints.at(family);
        faults.add(fault_of_stiffness(joints, *successor(joints, law)));
      } catch (const Error& error) {
        faults.add(fmt::format("{}: stage '{}': {}", stage.source.text, stage.name, error.what()), error.exit_code);
      }
    }
  }
  return faults;
}

}  // namespace

Scene read_with_laws(const SceneOptions& options, const std::function<Scene()>& read) {
  try {
    return read();
  } catch (const SceneFaults& error) {
    LawFaults faults;
    faults.add(error.what());
    Scene scene = *error.scene;
    scene.stages.clear();  // names of joints in stages are part of the faults
    try {
      faults_of_laws(scene, options).throw_any();
    } catch (const Error& of_laws) {
      faults.add(of_laws.what(), of_laws.exit_code);
    }
    faults.throw_any();
    throw;
  }
}

Scene prepare_scene(const SceneOptions& options) {
  const std::string text = options.text ? *options.text : read_input_file(options.scene);
  if (!options.text_sha256.empty() && sha256_of(text) != options.text_sha256)
    throw Error(
        Exit::bad_input,
        fmt::format("{}: is of another scene than the run was begun with: sha256 {:.12}, then {:.12}; bring the "
                    "text of then back, or start the run anew without --resume",
                    options.scene, sha256_of(text), options.text_sha256));
  std::vector<std::string> keys = options.overrides;
  std::erase_if(keys, [](const std::string& set) { return set.starts_with(kRestAsked); });
  return prepare_scene(read_with_laws(options, [&] { return read_scene_text(text, options.scene, keys); }), options);
}

Scene prepare_scene(Scene scene, const SceneOptions& options) {
  refuse_what_does_not_fit(scene, options);
  faults_of_laws(scene, options).throw_any();
  for (const std::string& text : unused_settings(scene)) notice(fmt::format("{}: {}", scene.file, text));
  if (const auto stage = rest_asked(options.overrides)) {
    // In the kernels of the whole scene, which can begin from this state.
    const bool is_general = scene.blocks && choose_motion(scene).shapes;
    scene = at_rest(std::move(scene), *stage);
    if (is_general) scene.solver.kernels = Kernels::general;
  }
  if (options.runs) find_collapse_starts(&scene);
  return scene;
}

std::string end_of(const Stage& stage) {
  std::string end;
  const auto add = [&](const std::string& text) { end += (end.empty() ? "" : " or ") + text; };
  if (stage.equilibrium_ratio)
    add(fmt::format("largest unbalanced force <= {:g} of the mean contact force", *stage.equilibrium_ratio));
  if (stage.displacement) add(fmt::format("displacement {:g} mm", *stage.displacement * 1e3));
  if (stage.cycles)
    add(fmt::format("{} are done, {:g} s", text_of(*stage.cycles), *stage.duration));
  else if (stage.duration)
    add(fmt::format("{:g} s", *stage.duration));
  if (stage.cycles && stage.cycles->stop_at_force_loss)
    add(fmt::format("a half cycle reaches less than {:g} of the largest force before",
                    *stage.cycles->stop_at_force_loss));
  if (stage.collapse)
    add(fmt::format("some block has moved by {:g} mm, multiplier at most {}", stage.collapse->displacement * 1e3,
                    stage.collapse->limit ? fmt::format("{:g}", *stage.collapse->limit)
                                          : "1.2 times the associated one of limit analysis"));
  return end;
}

}  // namespace quoin
