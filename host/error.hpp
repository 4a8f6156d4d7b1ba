// The one type of exception, which is the library's.
#pragma once

#include "include/lockstep/error.hpp"
