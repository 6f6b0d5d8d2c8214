// Models: scenes as for `quoin check`. If a scene is small its model is built, makes some steps, and uses no more
// memory than estimated.
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>

#include "cli/prepare.h"
#include "judge.h"
#include "scene/read_scene.h"
#include "scene/size.h"
#include "step/simulation.h"

namespace {

constexpr double kSmall = 2e6;            // bytes
constexpr double kLarge = 1e8;            // bytes: models from this size on cause a notice, which is not needed here
constexpr double kOfAProgram = 32 << 20;  // bytes: stacks of threads, laws, free memory of malloc

// Peak memory of the process since construction, bytes.
class Peak {
 public:
  Peak() : before_(now()) {
    const int file = open("/proc/self/clear_refs", O_WRONLY | O_CLOEXEC);
    known_ = file >= 0 && write(file, "5", 1) == 1;
    if (file >= 0) close(file);
  }
  double grown() const { return known_ ? now() - before_ : 0.0; }

 private:
  static double now() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return 1024.0 * static_cast<double>(usage.ru_maxrss);
  }
  double before_;
  bool known_ = false;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quoin;
  judge({Exit::bad_input, Exit::law_refused, Exit::numerical}, [&] {
    Scene scene = read_scene_text({reinterpret_cast<const char*>(data), size}, "scene.toml");
    const double bytes = size_of(scene).bytes;
    if (bytes > kLarge && bytes < 1e12) return;
    scene = prepare_scene(std::move(scene), {});
    if (bytes > kSmall) return;
    const Peak peak;
    Simulation simulation(std::move(scene), 1);
    simulation.advance(2);
#ifndef QUOIN_SANITIZED
    if (peak.grown() > 2.0 * bytes + kOfAProgram) {
      std::fprintf(stderr, "%g bytes were estimated, %g were taken\n", bytes, peak.grown());
      std::abort();
    }
#endif
  });
  return 0;
}
