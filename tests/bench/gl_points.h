// SPDX-License-Identifier: GPL-3.0-or-later
//
// GlPoints: the usual way to draw particles, to measure against: blended GL_POINTS from a vertex buffer into
// a float frame buffer. One context of its own; used on one thread.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "server/render/egl/egl_context.h"

namespace mote::bench {

class GlPoints {
  public:
    /// `over`: front-to-back blending into 8 bits a channel; otherwise added up in half floats.
    GlPoints(std::uint32_t width, std::uint32_t height, const std::vector<glm::vec3>& points, bool over);

    /// Seconds from the first command to the last pixel.
    double draw(const glm::mat4& toClip);
    /// Pixels that some point touched, so that the measurement shows that something was drawn.
    std::uint64_t pixelsTouched();

  private:
    render::EglContext context_;
    std::uint32_t width_, height_;
    std::size_t count_;
    bool over_;
    unsigned program_ = 0;
};

}  // namespace mote::bench
