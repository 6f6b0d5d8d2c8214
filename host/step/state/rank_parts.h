// The part of the model that this rank holds, and what it has gathered of the others since the last step. Written when
// work is divided, in each step and by gather.
#pragma once

#include "model/halo.h"

namespace quoin {

struct RankParts {
  bool divided = false;                            // whether each rank holds a part of the model
  bool holds_all = true;                           // whether this rank holds all of the model
  bool gathered = true, gathered_by_first = true;  // all results of the last step: on all ranks, on rank 0
  bool has_row = false;                            // numbers of a row of the last step; large motion in parts
  Halo halo;
};

}  // namespace quoin
