#pragma once

namespace quoin {

// Time since the start of the process, loading of libraries included, s. The first call starts the clock.
double process_seconds();

}  // namespace quoin
