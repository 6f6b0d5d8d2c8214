// Scenes: read, sized, and made where they are small.
#include <cstdlib>

#include "base/error.h"
#include "input.h"
#include "scene/generate.h"
#include "scene/read_scene.h"
#include "scene/size.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quoin;
  try {
    const Scene scene = read_scene(file_of(data, size, ".toml"), {});
    const SceneSize large = size_of(scene);
    if (!(large.blocks >= 0.0 && large.bytes >= 0.0)) std::abort();  // not a number
    if (large.blocks < 1e3 && (scene.wall || scene.building)) assemble(scene);
  } catch (const Error& error) {
    if (error.exit_code != Exit::bad_input || *error.what() == '\0') std::abort();
  }
  return 0;
}
