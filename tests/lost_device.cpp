// An OpenCL whose device is lost, to be loaded before the real one (LD_PRELOAD): from call LOCKSTEP_LOST_AT of the
// function LOCKSTEP_LOST_IN on, every call that needs the device fails.
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>

#include <atomic>
#include <cstdlib>
#include <string_view>

namespace {

bool is_lost(std::string_view function) {
  static const char *const in = std::getenv("LOCKSTEP_LOST_IN"), *const at = std::getenv("LOCKSTEP_LOST_AT");
  static std::atomic<long> calls{0};
  static std::atomic<bool> lost{false};
  if (in && at && function == in && ++calls >= std::atol(at)) lost = true;
  return lost;
}

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

#define CALL_UNLESS_LOST(name, lost_status, ...)        \
  if (is_lost(#name)) return lost_status;               \
  static const auto call = real<decltype(name)>(#name); \
  return call(__VA_ARGS__)

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t* offset,
                              const size_t* size, const size_t* group, cl_uint waits, const cl_event* wait,
                              cl_event* event) {
  CALL_UNLESS_LOST(clEnqueueNDRangeKernel, CL_OUT_OF_RESOURCES, queue, kernel, dimensions, offset, size, group, waits,
                   wait, event);
}

cl_int clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t size,
                           void* to, cl_uint waits, const cl_event* wait, cl_event* event) {
  CALL_UNLESS_LOST(clEnqueueReadBuffer, CL_OUT_OF_RESOURCES, queue, buffer, blocking, offset, size, to, waits, wait,
                   event);
}

cl_int clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t size,
                            const void* from, cl_uint waits, const cl_event* wait, cl_event* event) {
  CALL_UNLESS_LOST(clEnqueueWriteBuffer, CL_OUT_OF_RESOURCES, queue, buffer, blocking, offset, size, from, waits, wait,
                   event);
}

// Nothing of a lost device goes on.
cl_int clFinish(cl_command_queue queue) {
  static const auto call = real<decltype(clFinish)>("clFinish");
  const cl_int status = call(queue);
  return is_lost("clFinish") ? CL_INVALID_COMMAND_QUEUE : status;
}

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void* host, cl_int* status) {
  if (is_lost("clCreateBuffer")) {
    if (status) *status = CL_MEM_OBJECT_ALLOCATION_FAILURE;
    return nullptr;
  }
  static const auto call = real<decltype(clCreateBuffer)>("clCreateBuffer");
  return call(context, flags, size, host, status);
}

}  // extern "C"
