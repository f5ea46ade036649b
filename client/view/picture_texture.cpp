// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/picture_texture.h"

#include <epoxy/gl.h>

#include "protocol/scene/mote_check.h"

namespace mote::client {

PictureTexture::PictureTexture() {
    glGenTextures(1, &texture_);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

PictureTexture::~PictureTexture() {
    glDeleteTextures(1, &texture_);
}

void PictureTexture::upload(std::span<const std::uint8_t> pixels, std::uint32_t width, std::uint32_t height) {
    MOTE_CHECK(pixels.size() == 4ULL * width * height);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    const auto w = static_cast<GLsizei>(width), h = static_cast<GLsizei>(height);
    if (width != width_ || height != height_) {
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, w, h, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
        width_ = width;
        height_ = height;
    } else {
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, w, h, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    }
}

void* PictureTexture::handle() const {
    return reinterpret_cast<void*>(static_cast<std::uintptr_t>(texture_));
}

}  // namespace mote::client
