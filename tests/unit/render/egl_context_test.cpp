// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/egl_context.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <optional>
#include <thread>

namespace mote::render {
namespace {

TEST(EglContext, OffersOpenGl45) {
    const EglContext context;
    EXPECT_FALSE(context.renderer().empty());
    const EglContext::Current current(context);
    EXPECT_GE(epoxy_gl_version(), 45);
}

TEST(EglContext, LeavesTheThreadAsItWas) {
    EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
    const EglContext first;
    EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
    {
        const EglContext::Current current(first);
        const EGLContext before = eglGetCurrentContext();
        EXPECT_NE(before, EGL_NO_CONTEXT);
        std::optional<EglContext> second(std::in_place);
        EXPECT_EQ(eglGetCurrentContext(), before);
        {
            const EglContext::Current inner(*second);
            EXPECT_NE(eglGetCurrentContext(), before);
        }
        EXPECT_EQ(eglGetCurrentContext(), before);
        second.reset();
        EXPECT_EQ(eglGetCurrentContext(), before);
        EXPECT_NE(glGetString(GL_VERSION), nullptr);
    }
    EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
}

TEST(EglContext, OneAThreadAndNoneDisturbsAnother) {
    const EglContext here;
    const EglContext::Current current(here);
    int version = 0;
    std::thread([&version] {
        const EglContext there;
        const EglContext::Current own(there);
        version = epoxy_gl_version();
    }).join();
    EXPECT_GE(version, 45);
    // The display that they share is still there.
    EXPECT_NE(glGetString(GL_RENDERER), nullptr);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
}

}  // namespace
}  // namespace mote::render
