// The one place that includes the OpenCL bindings: version 1.2, exceptions on, failures turned into Error.
#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_ENABLE_EXCEPTIONS
#include <CL/opencl.hpp>
#include <string>
#include <type_traits>
#include <utility>

#include "host/error.hpp"

namespace lockstep {

/// "CL_OUT_OF_RESOURCES (-5)".
std::string opencl_error_name(cl_int code);

/// Runs `call`; an OpenCL failure becomes an Error (device) that carries where: a string ("opening <device>"), or a
/// function that makes it, for calls that are made often.
template <class Where, class Call>
decltype(auto) opencl_guard(Where&& where, Call&& call) {
  try {
    return std::forward<Call>(call)();
  } catch (const cl::Error& error) {
    const std::string what = std::string(error.what()) + " failed: " + opencl_error_name(error.err());
    if constexpr (std::is_invocable_v<Where>)
      throw Error(Failure::device, where(), what);
    else
      throw Error(Failure::device, where, what);
  }
}

}  // namespace lockstep
