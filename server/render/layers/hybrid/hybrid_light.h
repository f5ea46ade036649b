// SPDX-License-Identifier: GPL-3.0-or-later
//
// HybridLight: what a light makes of each one-byte normal (docs/PICTURE.md, "Light"). A value, made for one
// picture; safe on any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>

#include "protocol/scene/light.h"

namespace mote::render {

class HybridLight {
  public:
    /// Factor of the colour, and what is added to it in white; each 0 to 1.
    struct Shade {
        float diffuse, specular;
    };

    /// `layerToEye`: takes normals of layer space to eye space; `worldToEye`: a fixed light.
    HybridLight(const Light& light, const glm::dmat4& layerToEye, const glm::dmat4& worldToEye);

    const Shade& of(std::uint8_t normal) const { return shades_[normal]; }
    const std::array<Shade, 256>& shades() const { return shades_; }

  private:
    std::array<Shade, 256> shades_;
};

}  // namespace mote::render
