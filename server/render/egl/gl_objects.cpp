// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/gl_objects.h"

#include <algorithm>
#include <string>

#include "server/render/device.h"

namespace mote::render {
namespace {

GLuint newBuffer() {
    GLuint name = 0;
    glCreateBuffers(1, &name);
    return name;
}

/// At least as many bytes. Mesa's software rasteriser compiles a program anew if a buffer that it reads as
/// texels becomes or ceases to be a power of two, or a multiple of 2^16: none of ours ever is.
std::size_t allocated(std::size_t bytes) {
    constexpr std::size_t unit = 1U << 16, beyond = 1U << 8;
    return (std::max(bytes, beyond + 1) - beyond + unit - 1) / unit * unit + beyond;
}

}  // namespace

GlBuffer::GlBuffer(std::size_t bytes, const void* data) : name_(newBuffer()), bytes_(allocated(bytes)) {
    glNamedBufferStorage(get(), static_cast<GLsizeiptr>(bytes_), nullptr, GL_DYNAMIC_STORAGE_BIT);
    checkGl("a buffer");
    if (data != nullptr) write(0, bytes, data);
}

void GlBuffer::grow(std::size_t bytes) {
    if (bytes <= bytes_) return;
    *this = GlBuffer();  // first give back, then take
    *this = GlBuffer(bytes);
}

void GlBuffer::write(std::size_t offset, std::size_t bytes, const void* data) {
    if (bytes == 0) return;
    glNamedBufferSubData(get(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
}

void GlBuffer::read(std::size_t offset, std::size_t bytes, void* data) const {
    if (bytes == 0) return;
    glGetNamedBufferSubData(get(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
}

void GlBuffer::copy(std::size_t offset, const GlBuffer& from, std::size_t bytes) {
    glCopyNamedBufferSubData(from.get(), get(), 0, static_cast<GLintptr>(offset),
                             static_cast<GLsizeiptr>(bytes));
}

void GlBuffer::zero(std::size_t bytes) {
    const GLuint nothing = 0;
    fill(bytes, &nothing, 1);
}

void GlBuffer::fill(std::size_t bytes, const GLuint* words, int wordCount) {
    if (bytes == 0) return;
    const GLenum internal = wordCount == 1 ? GL_R32UI : GL_RG32UI;
    const GLenum format = wordCount == 1 ? GL_RED_INTEGER : GL_RG_INTEGER;
    glClearNamedBufferSubData(get(), internal, 0, static_cast<GLsizeiptr>(bytes), format, GL_UNSIGNED_INT,
                              words);
}

GlTexture bufferTexture(const GlBuffer& buffer, GLenum format) {
    GLuint name = 0;
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &name);
    GlTexture texture(name);
    glTextureBuffer(texture.get(), format, buffer.get());
    checkGl("a buffer texture");
    return texture;
}

void checkGl(const char* what) {
    const GLenum error = glGetError();
    if (error == GL_NO_ERROR) return;
    while (glGetError() != GL_NO_ERROR) {
    }
    if (error == GL_OUT_OF_MEMORY)
        throw DeviceError(std::string("the device has no memory left for ") + what);
    throw DeviceError(std::string("OpenGL error ") + std::to_string(error) + " while making or drawing " +
                      what);
}

}  // namespace mote::render
