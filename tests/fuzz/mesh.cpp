// Mesh files of each kind; what is read is a block: closed, with a volume.
#include <cmath>
#include <cstdlib>

#include "base/error.h"
#include "geometry/mesh_file.h"
#include "input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quoin;
  for (const char* ending : {".off", ".obj", ".stl"}) {
    try {
      for (const geometry::NamedShape& shape : geometry::read_mesh_file(file_of(data, size, ending))) {
        if (!(mass_properties(shape.shape).volume > 0.0)) std::abort();
      }
    } catch (const Error& error) {
      if (error.exit_code != Exit::bad_input || *error.what() == '\0') std::abort();
    }
  }
  return 0;
}
