// The request of a run on the command line.
#pragma once

#include <string>

#include "cli/prepare.h"
#include "law/law_calls.h"

namespace quoin {

struct RunOptions {
  SceneOptions scene;
  std::string out;
  std::string resume;  // folder of the run that goes on; empty: a new one
  std::string again;   // folder of the run that is repeated; empty: none
  double checkpoint_every = 60.0;
  int threads = 0;
  bool report = false, svg = false, histories = false, compressed = false;
  bool isolate_law = false;
  double law_seconds = kLawSeconds;  // for one batch; 0: any time
  int serve = -1;                    // port of a page of the run while it goes on; 0: any, < 0: none
};

}  // namespace quoin
