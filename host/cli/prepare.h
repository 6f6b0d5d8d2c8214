// Preparation of a scene, common to all commands with a scene.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace quoin {

struct SceneOptions {
  std::string scene;
  std::optional<std::string> text;  // text in place of the present contents of the file
  std::string text_sha256;          // hash of the scene's text at the start of a resumed run
  std::string law;                  // law in place of that of every joint family; empty: none
  std::vector<std::string> overrides;
  bool runs = false;       // whether the scene is run: limit analysis then finds the start of collapse stages
  bool force = false;      // whether models may exceed the memory of the machine
  int processes = 1;       // number of processes that compute the model together
  int processes_here = 1;  // number of these processes on this machine
};

// Calls read(). If it throws SceneFaults, its laws check the joints too, and all faults are thrown together.
Scene read_with_laws(const SceneOptions& options, const std::function<Scene()>& read);

// Reads the scene. Refuses a text other than the requested one, and a model that exceeds the machine's memory. Replaces
// its laws if requested; properties that the new law does not have are left out, with a message on stderr. Refuses
// properties that no law has or accepts, with place and suggestion. Throws all faults together.
Scene prepare_scene(const SceneOptions& options);
Scene prepare_scene(Scene read, const SceneOptions& options);  // prepares a scene that is already read

std::string end_of(const Stage& stage);  // "displacement 4 mm or 2 s"

}  // namespace quoin
