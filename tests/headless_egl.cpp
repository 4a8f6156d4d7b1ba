// An EGL as a GPU's driver has it where there is no screen, to be found before the real one (LD_LIBRARY_PATH): it has
// no display but those of devices, and lacks the extensions that LOCKSTEP_EGL_LACKS names. LOCKSTEP_EGL is the path of
// the real one.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <cstdlib>
#include <map>
#include <sstream>
#include <string>

namespace {

template <class Function>
Function* real(const char* name) {
  static void* const library = dlopen(std::getenv("LOCKSTEP_EGL"), RTLD_NOW | RTLD_LOCAL);
  return library == nullptr ? nullptr : reinterpret_cast<Function*>(dlsym(library, name));
}

bool is_lacking(const std::string& extension) {
  const char* lacks = std::getenv("LOCKSTEP_EGL_LACKS");
  return (" " + std::string(lacks != nullptr ? lacks : "") + " ").find(" " + extension + " ") != std::string::npos;
}

}  // namespace

extern "C" {

EGLDisplay eglGetDisplay(EGLNativeDisplayType) { return EGL_NO_DISPLAY; }

const char* eglQueryString(EGLDisplay display, EGLint name) {
  const char* all = real<decltype(eglQueryString)>("eglQueryString")(display, name);
  if (all == nullptr || name != EGL_EXTENSIONS) return all;
  static std::map<EGLDisplay, std::string> kept;
  std::string& left = kept[display];
  left.clear();
  std::istringstream words(all);
  for (std::string word; words >> word;) {
    if (!is_lacking(word)) left += word + " ";
  }
  return left.c_str();
}

#define PASSED_ON(result, name, parameters, ...) \
  result name parameters { return real<decltype(name)>(#name)(__VA_ARGS__); }

PASSED_ON(__eglMustCastToProperFunctionPointerType, eglGetProcAddress, (const char* name), name)
PASSED_ON(EGLBoolean, eglInitialize, (EGLDisplay display, EGLint* major, EGLint* minor), display, major, minor)
PASSED_ON(EGLBoolean, eglTerminate, (EGLDisplay display), display)
PASSED_ON(EGLBoolean, eglBindAPI, (EGLenum api), api)
PASSED_ON(EGLBoolean, eglChooseConfig,
          (EGLDisplay display, const EGLint* wanted, EGLConfig* configs, EGLint size, EGLint* count), display, wanted,
          configs, size, count)
PASSED_ON(EGLContext, eglCreateContext,
          (EGLDisplay display, EGLConfig config, EGLContext shared, const EGLint* attributes), display, config, shared,
          attributes)
PASSED_ON(EGLSurface, eglCreatePbufferSurface, (EGLDisplay display, EGLConfig config, const EGLint* attributes),
          display, config, attributes)
PASSED_ON(EGLBoolean, eglMakeCurrent, (EGLDisplay display, EGLSurface draw, EGLSurface read, EGLContext context),
          display, draw, read, context)

}  // extern "C"
