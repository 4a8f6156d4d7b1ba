// How a run came out: the library's Verdict.
#pragma once

#include "host/unsolved.hpp"
#include "include/lockstep/verdict.hpp"
