// What a solver that promises a residual, or a tolerance, did not keep of it.
#pragma once

#include "host/stop.hpp"
#include "include/lockstep/verdict.hpp"
#include "kernels/types.h"
