// What every command that takes a scene does first.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace quoin {

struct SceneOptions {
  std::string scene;
  std::optional<std::string> text;  // in place of what that file holds now
  std::string text_sha256;          // hash of the scene that a resumed run began with
  std::string law;                  // replaces the law of every joint family; empty: as in the scene
  std::vector<std::string> overrides;
  bool runs = false;       // the scene is run: where collapse stages start is found by limit analysis
  bool force = false;      // models that seem too large for the machine, too
  int processes = 1;       // that compute the model together
  int processes_here = 1;  // number of these processes on this machine
};

// What read() returns. Where it throws SceneFaults, its laws are asked about the joints, and all faults are thrown as
// one.
Scene read_with_laws(const SceneOptions& options, const std::function<Scene()>& read);

// Reads the scene. Refuses another text than was requested, and one that the memory of the machine cannot hold.
// Replaces its laws when asked to; properties that the new law does not have are left out, with a word on stderr.
// Refuses properties that no law has or takes, each with its place and a suggestion. All faults are thrown as one.
Scene prepare_scene(const SceneOptions& options);
Scene prepare_scene(Scene read, const SceneOptions& options);  // the same, of a scene that has been read

std::string end_of(const Stage& stage);  // "displacement 4 mm or 2 s"

}  // namespace quoin
