// Scenes: they are read, their size is estimated, and small ones are built.
#include <cstdlib>

#include "judge.h"
#include "scene/generate.h"
#include "scene/read_scene.h"
#include "scene/size.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quoin;
  judge({Exit::bad_input}, [&] {
    const Scene scene = read_scene_text({reinterpret_cast<const char*>(data), size}, "scene.toml");
    const SceneSize large = size_of(scene);
    if (!(large.blocks >= 0.0 && large.bytes >= 0.0)) std::abort();  // not a number
    if (large.blocks < 100 && (scene.wall || scene.building)) assemble(scene);
  });
  return 0;
}
