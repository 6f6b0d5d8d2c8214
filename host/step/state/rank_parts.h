// Which part of the model this rank holds, and how much of the last step it has from the others. Written when work is
// divided, in each step, and by what is gathered.
#pragma once

#include "model/halo.h"

namespace quoin {

struct RankParts {
  bool divided = false;                            // each rank holds a part of the model
  bool holds_all = true;                           // this one all of it
  bool gathered = true, gathered_by_first = true;  // all of it, since the last step: by everybody, by rank 0
  bool has_row = false;  // whether numbers of a row of the last step are gathered; large motion in parts
  Halo halo;
};

}  // namespace quoin
