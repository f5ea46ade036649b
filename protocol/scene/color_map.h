// SPDX-License-Identifier: GPL-3.0-or-later
//
// ColorMap: a named table of colours over [0, 1], interpolated linearly in linear RGB. A value that refers to
// an embedded table. The tables are perceptual maps by others; their sources and licences stand in
// docs/COLORMAPS.md.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string_view>

#include "protocol/base/error.h"

namespace mote {

class ColorMap {
  public:
    static constexpr std::string_view defaultName = "inferno";

    /// Errors: notFound, naming the known maps.
    static Result<ColorMap> find(std::string_view name);
    static ColorMap standard();
    static std::span<const std::string_view> names();

    std::string_view name() const { return name_; }
    /// Linear RGB at x, clamped to [0, 1].
    glm::dvec3 operator()(double x) const;

    bool operator==(const ColorMap& other) const { return name_ == other.name_; }

  private:
    ColorMap(std::string_view name, std::span<const std::uint8_t> srgb) : name_(name), srgb_(srgb) {}
    std::string_view name_;
    std::span<const std::uint8_t> srgb_;  // three bytes a colour, sRGB-encoded
};

}  // namespace mote
