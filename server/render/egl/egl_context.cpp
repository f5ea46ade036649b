// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/egl_context.h"

#include <dlfcn.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "server/render/device.h"

namespace mote::render {
namespace {

bool offers(const char* extensions, std::string_view wanted) {
    std::string_view list = extensions == nullptr ? "" : extensions;
    while (!list.empty()) {
        const auto end = std::min(list.find(' '), list.size());
        if (list.substr(0, end) == wanted) return true;
        list.remove_prefix(std::min(end + 1, list.size()));
    }
    return false;
}

/// Displays to try, best first. They are the process's own and shared: never terminated by us, since others
/// in the process may use the same one.
std::vector<EGLDisplay> displays() {
    const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    std::vector<EGLDisplay> hardware;
    std::vector<EGLDisplay> software;
    if (offers(client, "EGL_EXT_platform_device") &&
        (offers(client, "EGL_EXT_device_enumeration") || offers(client, "EGL_EXT_device_base"))) {
        EGLDeviceEXT devices[32];
        EGLint count = 0;
        if (eglQueryDevicesEXT(32, devices, &count) != EGL_TRUE) count = 0;
        for (EGLint i = 0; i < count; ++i) {
            const char* extensions = eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS);
            auto& kind = offers(extensions, "EGL_MESA_device_software") ? software : hardware;
            kind.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
        }
    }
    hardware.insert(hardware.end(), software.begin(), software.end());
    if (offers(client, "EGL_MESA_platform_surfaceless")) {
        hardware.push_back(
            eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
    }
    return hardware;
}

EGLContext createContext(EGLDisplay display) {
    EGLint major = 0;
    EGLint minor = 0;
    if (display == EGL_NO_DISPLAY || eglInitialize(display, &major, &minor) != EGL_TRUE)
        return EGL_NO_CONTEXT;
    const char* extensions = eglQueryString(display, EGL_EXTENSIONS);
    if (!offers(extensions, "EGL_KHR_surfaceless_context")) return EGL_NO_CONTEXT;
    EGLConfig config = EGL_NO_CONFIG_KHR;
    if (!offers(extensions, "EGL_KHR_no_config_context")) {
        const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
        EGLint found = 0;
        if (eglChooseConfig(display, wanted, &config, 1, &found) != EGL_TRUE || found < 1)
            return EGL_NO_CONTEXT;
    }
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    return eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
}

bool isThere(const char* library) {
    return ::dlopen(library, RTLD_LAZY | RTLD_LOCAL) != nullptr;
}

/// Epoxy loads these when they are first called, and ends the process if they are not installed. They stay
/// loaded.
void requireLibraries() {
    if (!isThere("libEGL.so.1")) throw DeviceError("there is no libEGL.so.1 here");
    if (!isThere("libOpenGL.so.0") && !isThere("libGL.so.1")) {
        throw DeviceError("there is neither libOpenGL.so.0 nor libGL.so.1 here");
    }
}

}  // namespace

EglContext::EglContext() {
    requireLibraries();
    eglBindAPI(EGL_OPENGL_API);
    for (const EGLDisplay display : displays()) {
        context_ = createContext(display);
        if (context_ == EGL_NO_CONTEXT) continue;
        display_ = display;
        break;
    }
    if (context_ == EGL_NO_CONTEXT) {
        throw DeviceError("no EGL device or surfaceless platform here offers OpenGL 4.5 core");
    }
    const Current current(*this);
    const auto* name = glGetString(GL_RENDERER);
    renderer_ = name == nullptr ? "unknown" : reinterpret_cast<const char*>(name);
}

EglContext::~EglContext() {
    eglDestroyContext(display_, context_);
}

EglContext::Current::Current(const EglContext& context)
    : display_(eglGetCurrentDisplay()),
      ownDisplay_(context.display_),
      context_(eglGetCurrentContext()),
      draw_(eglGetCurrentSurface(EGL_DRAW)),
      read_(eglGetCurrentSurface(EGL_READ)) {
    eglBindAPI(EGL_OPENGL_API);
    if (eglMakeCurrent(context.display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context.context_) != EGL_TRUE) {
        throw DeviceError("the EGL context cannot be made current: it is in use on another thread, or lost");
    }
}

EglContext::Current::~Current() {
    if (context_ == EGL_NO_CONTEXT) {
        eglMakeCurrent(ownDisplay_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    } else {
        eglMakeCurrent(display_, draw_, read_, context_);
    }
}

}  // namespace mote::render
