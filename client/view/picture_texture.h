// SPDX-License-Identifier: GPL-3.0-or-later
//
// PictureTexture: the frame that is shown, as an OpenGL texture. Owned by the viewer; main thread, its
// context current.
#pragma once

#include <cstdint>
#include <span>

namespace mote::client {

class PictureTexture {
  public:
    PictureTexture();
    ~PictureTexture();
    PictureTexture(const PictureTexture&) = delete;
    PictureTexture& operator=(const PictureTexture&) = delete;

    /// RGBA, 8 bits, sRGB-encoded, row 0 on top; `pixels` holds 4 * width * height bytes.
    void upload(std::span<const std::uint8_t> pixels, std::uint32_t width, std::uint32_t height);
    /// What Dear ImGui calls it.
    void* handle() const;
    bool empty() const { return width_ == 0; }

  private:
    unsigned texture_ = 0;
    std::uint32_t width_ = 0, height_ = 0;
};

}  // namespace mote::client
