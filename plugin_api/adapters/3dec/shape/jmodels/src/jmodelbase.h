#pragma once

#include "interface/base/src/base.h"
