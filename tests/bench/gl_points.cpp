// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/gl_points.h"

#include <epoxy/gl.h>

#include <chrono>
#include <glm/gtc/type_ptr.hpp>
#include <stdexcept>

namespace mote::bench {
namespace {

// GL objects are left to their context, which goes with the object that owns it.
GLuint stage(GLenum kind, const char* source) {
    const GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    GLint ok = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok != GL_TRUE) throw std::runtime_error("a shader of the GL_POINTS measurement does not compile");
    return shader;
}

GLuint pointProgram() {
    const GLuint program = glCreateProgram();
    glAttachShader(program, stage(GL_VERTEX_SHADER, R"(#version 450 core
        layout(location = 0) in vec3 place;
        layout(location = 0) uniform mat4 toClip;
        void main() { gl_Position = toClip * vec4(place, 1.0); })"));
    glAttachShader(program, stage(GL_FRAGMENT_SHADER, R"(#version 450 core
        layout(location = 0) out vec4 color;
        void main() { color = vec4(0.5, 0.35, 0.15, 0.5); })"));
    glLinkProgram(program);
    return program;
}

void makeFrameBuffer(std::uint32_t width, std::uint32_t height, GLenum format) {
    GLuint texture = 0;
    GLuint frame = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, format, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
    glCreateFramebuffers(1, &frame);
    glNamedFramebufferTexture(frame, GL_COLOR_ATTACHMENT0, texture, 0);
    if (glCheckNamedFramebufferStatus(frame, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        throw std::runtime_error("the frame buffer of the GL_POINTS measurement is not complete");
    }
    glBindFramebuffer(GL_FRAMEBUFFER, frame);
    glViewport(0, 0, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
}

void makeVertices(const std::vector<glm::vec3>& points) {
    GLuint vertices = 0;
    GLuint array = 0;
    glCreateBuffers(1, &vertices);
    glNamedBufferStorage(vertices, static_cast<GLsizeiptr>(points.size() * sizeof(glm::vec3)), points.data(),
                         0);
    glCreateVertexArrays(1, &array);
    glVertexArrayVertexBuffer(array, 0, vertices, 0, sizeof(glm::vec3));
    glVertexArrayAttribFormat(array, 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(array, 0, 0);
    glEnableVertexArrayAttrib(array, 0);
    glBindVertexArray(array);
}

}  // namespace

GlPoints::GlPoints(std::uint32_t width, std::uint32_t height, const std::vector<glm::vec3>& points, bool over)
    : width_(width), height_(height), count_(points.size()), over_(over) {
    const render::EglContext::Current current(context_);
    makeFrameBuffer(width, height, over ? GL_RGBA8 : GL_RGBA16F);
    makeVertices(points);
    program_ = pointProgram();
    glEnable(GL_BLEND);
    over ? glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA) : glBlendFunc(GL_ONE, GL_ONE);
}

double GlPoints::draw(const glm::mat4& toClip) {
    const render::EglContext::Current current(context_);
    glFinish();
    const auto start = std::chrono::steady_clock::now();
    glClear(GL_COLOR_BUFFER_BIT);
    glUseProgram(program_);
    glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(toClip));
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(count_));
    glFinish();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::uint64_t GlPoints::pixelsTouched() {
    const render::EglContext::Current current(context_);
    std::vector<float> pixels(std::size_t{width_} * height_ * 4);
    glReadPixels(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_), GL_RGBA, GL_FLOAT,
                 pixels.data());
    std::uint64_t touched = 0;
    for (std::size_t i = 0; i < pixels.size(); i += 4) touched += pixels[i] > 0.0F;
    return touched;
}

}  // namespace mote::bench
