// SPDX-License-Identifier: GPL-3.0-or-later
//
// EglContext: an OpenGL 4.5 core context without a display or a surface. Owned by one device and used on one
// thread at a time. It leaves the contexts of others alone: while a Current lives, this context is the
// thread's; afterwards the one before it is again.
#pragma once

#include <epoxy/egl.h>

#include <string>

namespace mote::render {

class EglContext {
  public:
    /// Prefers a hardware device (EGL_EXT_platform_device), then any device, then Mesa's surfaceless
    /// platform. Throws DeviceError if none offers OpenGL 4.5 core.
    EglContext();
    ~EglContext();
    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;

    /// Makes the context the calling thread's for its lifetime. Throws DeviceError.
    class Current {
      public:
        explicit Current(const EglContext& context);
        ~Current();
        Current(const Current&) = delete;
        Current& operator=(const Current&) = delete;

      private:
        EGLDisplay display_, ownDisplay_;
        EGLContext context_;
        EGLSurface draw_, read_;
    };

    /// GL_RENDERER.
    const std::string& renderer() const { return renderer_; }

  private:
    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
    std::string renderer_;
};

}  // namespace mote::render
