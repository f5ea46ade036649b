// SPDX-License-Identifier: GPL-3.0-or-later
//
// GL objects as move-only values. Made, used and destroyed while their context is current.
#pragma once

#include <epoxy/gl.h>

#include <cstddef>
#include <span>
#include <stop_token>
#include <utility>

namespace mote::render {

/// A name that GL gave out, deleted with its owner.
template <void (*destroy)(GLuint)>
class GlName {
  public:
    GlName() = default;
    explicit GlName(GLuint name) : name_(name) {}
    GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    GlName& operator=(GlName&& other) noexcept {
        std::swap(name_, other.name_);
        return *this;
    }
    ~GlName() {
        if (name_ != 0) destroy(name_);
    }
    GLuint get() const { return name_; }
    explicit operator bool() const { return name_ != 0; }

  private:
    GLuint name_ = 0;
};

namespace detail {
inline void deleteBuffer(GLuint name) {
    glDeleteBuffers(1, &name);
}
inline void deleteTexture(GLuint name) {
    glDeleteTextures(1, &name);
}
inline void deleteProgram(GLuint name) {
    glDeleteProgram(name);
}
inline void deleteShader(GLuint name) {
    glDeleteShader(name);
}
}  // namespace detail

using GlTexture = GlName<detail::deleteTexture>;
using GlProgram = GlName<detail::deleteProgram>;
using GlShader = GlName<detail::deleteShader>;

/// Bytes in the device's memory.
class GlBuffer {
  public:
    GlBuffer() = default;
    /// Filled from `data` if it is not null. Throws DeviceError if memory runs out.
    explicit GlBuffer(std::size_t bytes, const void* data = nullptr);
    template <class T>
    static GlBuffer of(std::span<const T> values) {
        return GlBuffer(values.size_bytes(), values.data());
    }

    GLuint get() const { return name_.get(); }
    /// What it takes, at least what was asked for.
    std::size_t bytes() const { return bytes_; }
    /// Makes it at least as large; what it held is lost if it grows.
    void grow(std::size_t bytes);
    void write(std::size_t offset, std::size_t bytes, const void* data);
    void read(std::size_t offset, std::size_t bytes, void* data) const;
    /// The first of another buffer.
    void copy(std::size_t offset, const GlBuffer& from, std::size_t bytes);
    /// Zeros the first `bytes`, a multiple of 4.
    void zero(std::size_t bytes);
    /// Repeats one or two words through the first `bytes`, a multiple of their size.
    void fill(std::size_t bytes, const GLuint* words, int wordCount);
    void bindStorage(GLuint binding) const { glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, get()); }

  private:
    GlName<detail::deleteBuffer> name_;
    std::size_t bytes_ = 0;
};

/// A view of a buffer as a one-dimensional array of texels.
GlTexture bufferTexture(const GlBuffer& buffer, GLenum format);

/// Throws DeviceError that names `what` if GL has an error pending.
void checkGl(const char* what);

/// Pacer: lets the device work a little ahead of the host and no more, so that a stop request is answered
/// within two pieces of work. A value of one frame.
class Pacer {
  public:
    explicit Pacer(std::stop_token stop) : stop_(std::move(stop)) {}
    ~Pacer() { glDeleteSync(before_); }
    Pacer(const Pacer&) = delete;
    Pacer& operator=(const Pacer&) = delete;

    /// Called after each piece of work, a few milliseconds long: false if the frame is to be given up.
    bool next() {
        if (stop_.stop_requested()) return false;
        const GLsync now = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
        if (before_ != nullptr) glClientWaitSync(before_, GL_SYNC_FLUSH_COMMANDS_BIT, 10'000'000'000);
        glDeleteSync(before_);
        before_ = now;
        return !stop_.stop_requested();
    }
    bool stopped() const { return stop_.stop_requested(); }
    /// Whose requests are heeded from now on.
    void heed(std::stop_token stop) { stop_ = std::move(stop); }

  private:
    std::stop_token stop_;
    GLsync before_ = nullptr;
};

}  // namespace mote::render
