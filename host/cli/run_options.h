// Options of a run on the command line.
#pragma once

#include <string>

#include "cli/prepare.h"
#include "law/law_calls.h"

namespace quoin {

struct RunOptions {
  SceneOptions scene;
  std::string out;
  std::string resume;  // folder of the run to be continued; empty: a new one
  std::string again;   // folder of the run to be repeated; empty: none
  double checkpoint_every = 60.0;
  int threads = 0;
  bool report = false, svg = false, histories = false, compressed = false;
  bool isolate_law = false;
  double law_seconds = kLawSeconds;  // time limit of one batch, s; 0: none
  int serve = -1;                    // port of the page of the running simulation; 0: any, < 0: no page
};

}  // namespace quoin
