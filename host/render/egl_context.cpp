#include "host/render/egl_context.hpp"

#include <dlfcn.h>

#include <cstdlib>
#include <string_view>
#include <vector>

#include "host/error.hpp"

namespace lockstep {

namespace {

[[noreturn]] void no_egl(const std::string& why) {
  throw Error(Failure::device, "render",
              why +
                  "; pictures need EGL with OpenGL ES 3.0: install libegl1, libgles2 and libegl-mesa0, or the EGL of "
                  "the GPU's driver");
}

void* open_egl() {
  void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* why = dlerror();
    no_egl(why != nullptr ? why : "libEGL.so.1 cannot be loaded");
  }
  return library;
}

bool lists(const char* extensions, std::string_view name) {
  if (extensions == nullptr) return false;
  const std::string padded = " " + std::string(extensions) + " ";
  return padded.find(" " + std::string(name) + " ") != std::string::npos;
}

}  // namespace

struct EglContext::Egl {
  explicit Egl(void* library)
      : get_proc_address(reinterpret_cast<decltype(get_proc_address)>(dlsym(library, "eglGetProcAddress"))) {
    if (get_proc_address == nullptr) no_egl("libEGL.so.1 lacks eglGetProcAddress");
    load(library, "eglQueryString", query_string);
    load(library, "eglGetDisplay", get_display);
    load(library, "eglInitialize", initialize);
    load(library, "eglTerminate", terminate);
    load(library, "eglBindAPI", bind_api);
    load(library, "eglChooseConfig", choose_config);
    load(library, "eglCreateContext", create_context);
    load(library, "eglCreatePbufferSurface", create_pbuffer_surface);
    load(library, "eglMakeCurrent", make_current);
    find("eglGetPlatformDisplayEXT", get_platform_display);
    find("eglQueryDevicesEXT", query_devices);
    find("eglQueryDeviceStringEXT", query_device_string);
  }

  template <class Function>
  void find(const char* name, Function& function) const {
    function = reinterpret_cast<Function>(get_proc_address(name));
  }
  template <class Function>
  void load(void* library, const char* name, Function& function) const {
    function = reinterpret_cast<Function>(dlsym(library, name));
    if (function == nullptr) no_egl(std::string("libEGL.so.1 lacks ") + name);
  }

  decltype(&::eglGetProcAddress) get_proc_address;
  decltype(&::eglQueryString) query_string = nullptr;
  decltype(&::eglGetDisplay) get_display = nullptr;
  decltype(&::eglInitialize) initialize = nullptr;
  decltype(&::eglTerminate) terminate = nullptr;
  decltype(&::eglBindAPI) bind_api = nullptr;
  decltype(&::eglChooseConfig) choose_config = nullptr;
  decltype(&::eglCreateContext) create_context = nullptr;
  decltype(&::eglCreatePbufferSurface) create_pbuffer_surface = nullptr;
  decltype(&::eglMakeCurrent) make_current = nullptr;
  // extensions: null where they are missing
  PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display = nullptr;
  PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;
  PFNEGLQUERYDEVICESTRINGEXTPROC query_device_string = nullptr;

  /// Displays in the order in which they are worth trying: GPUs, Mesa without a screen, processors that draw, what
  /// there is.
  std::vector<EGLDisplay> displays() const {
    std::vector<EGLDisplay> found, slow;
    const char* client = query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    const auto add = [](std::vector<EGLDisplay>& to, EGLDisplay display) {
      if (display != EGL_NO_DISPLAY) to.push_back(display);
    };
    if (get_platform_display != nullptr && query_devices != nullptr && query_device_string != nullptr &&
        lists(client, "EGL_EXT_platform_device")) {
      EGLDeviceEXT devices[16];
      EGLint count = 0;
      if (query_devices(16, devices, &count) != EGL_TRUE) count = 0;
      for (EGLint i = 0; i < count; ++i) {
        const bool software = lists(query_device_string(devices[i], EGL_EXTENSIONS), "EGL_MESA_device_software");
        add(software ? slow : found, get_platform_display(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
      }
    }
    if (get_platform_display != nullptr && lists(client, "EGL_MESA_platform_surfaceless"))
      add(found, get_platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
    found.insert(found.end(), slow.begin(), slow.end());
    add(found, get_display(EGL_DEFAULT_DISPLAY));
    return found;
  }
};

EglContext::EglContext() {
  // Mesa's EGL talks about drivers it has tried; what is wrong is said here, in one line
  setenv("EGL_LOG_LEVEL", "fatal", 0);
  egl_library_ = open_egl();
  gles_library_ = dlopen("libGLESv2.so.2", RTLD_NOW | RTLD_LOCAL);  // EGL 1.5 finds all functions without it
  const Egl egl(egl_library_);
  terminate_ = egl.terminate;
  make_current_ = egl.make_current;
  for (const EGLDisplay display : egl.displays()) {
    if (!open(egl, display)) continue;
    load_functions(egl);
    const auto text = [&](GLenum what) {
      const GLubyte* told = gl_.GetString(what);
      return std::string(told != nullptr ? reinterpret_cast<const char*>(told) : "unknown");
    };
    renderer_ = text(GL_RENDERER);
    version_ = text(GL_VERSION);
    return;
  }
  no_egl("no driver here offers it");
}

// False where this display cannot do it.
bool EglContext::open(const Egl& egl, EGLDisplay display) {
  EGLint major = 0, minor = 0;
  if (egl.initialize(display, &major, &minor) != EGL_TRUE) return false;
  const bool surfaceless = lists(egl.query_string(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context");
  const EGLint wanted[] = {EGL_SURFACE_TYPE, surfaceless ? 0 : EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT,
                           EGL_NONE};
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 0, EGL_NONE};
  const EGLint size[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint configs = 0;
  const bool ready = egl.bind_api(EGL_OPENGL_ES_API) == EGL_TRUE &&
                     egl.choose_config(display, wanted, &config, 1, &configs) == EGL_TRUE && configs > 0;
  if (ready) context_ = egl.create_context(display, config, EGL_NO_CONTEXT, version);
  if (context_ != EGL_NO_CONTEXT && !surfaceless) surface_ = egl.create_pbuffer_surface(display, config, size);
  if (context_ != EGL_NO_CONTEXT && egl.make_current(display, surface_, surface_, context_) == EGL_TRUE) {
    display_ = display;
    return true;
  }
  egl.terminate(display);
  context_ = EGL_NO_CONTEXT;
  surface_ = EGL_NO_SURFACE;
  return false;
}

void EglContext::load_functions(const Egl& egl) {
#define GL_FUNCTION(name)                                                                                   \
  egl.find("gl" #name, gl_.name);                                                                           \
  if (gl_.name == nullptr && gles_library_ != nullptr)                                                      \
    gl_.name = reinterpret_cast<decltype(gl_.name)>(dlsym(gles_library_, "gl" #name)); /* before EGL 1.5 */ \
  if (gl_.name == nullptr) no_egl("the driver lacks gl" #name);
#include "host/render/gl_functions.def"
#undef GL_FUNCTION
}

// The libraries stay loaded: drivers have threads of their own that outlive the display.
EglContext::~EglContext() {
  if (display_ == EGL_NO_DISPLAY) return;
  make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  terminate_(display_);
}

}  // namespace lockstep
