// Mesh files of one kind, QUOIN_FUZZ_ENDING. An accepted mesh is a block: closed, with a volume.
#include <cmath>
#include <cstdlib>

#include "geometry/mesh_file.h"
#include "input.h"
#include "judge.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quoin;
  judge({Exit::bad_input}, [&] {
    for (const geometry::NamedShape& shape : geometry::read_mesh_file(file_of(data, size, QUOIN_FUZZ_ENDING))) {
      if (!(mass_properties(shape.shape).volume > 0.0)) std::abort();
    }
  });
  return 0;
}
