// What bad input is refused with.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "host/error.hpp"

namespace lockstep {

/// The one line that a call is refused with as bad input; "accepted" where it is not.
inline std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    const std::string line = error.what();
    EXPECT_EQ(error.failure(), Failure::input) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    return line;
  }
  return "accepted";
}

}  // namespace lockstep
