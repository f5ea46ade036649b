// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sight: what lies before the shapes of a page, in each pixel that one covers: how much light comes through
// to it from there, and the light that what lies before it sends itself. So a page draws its shapes in the
// colours in which the screen shows them, and leaves out what is hidden (docs/STIPPLES.md, "Paper"). A value;
// immutable once it is made.
#pragma once

#include <compare>
#include <cstdint>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

namespace mote::server {

struct InFront {
    glm::vec3 light{0.0F};  ///< linear RGB
    float through = 1.0F;   ///< transmittance

    /// What one sees of a surface of that colour, linear RGB, that hides all behind it.
    glm::vec3 seen(const glm::vec3& color) const { return light + through * color; }
    bool clear() const;   ///< nothing to speak of
    bool hidden() const;  ///< nothing to speak of comes through
};

/// A place of a picture.
struct SightPlace {
    std::uint32_t pixel = 0;  ///< row times the picture's width, and column
    double depth = 0.0;       ///< along the line of sight, world units; may be infinite

    auto operator<=>(const SightPlace&) const = default;
};

class Sight {
  public:
    /// `places`: ascending, each once, with what lies before it. `width`: of the picture.
    Sight(std::uint32_t width, std::vector<SightPlace> places, std::vector<InFront> inFront)
        : width_(width), places_(std::move(places)), inFront_(std::move(inFront)) {}

    /// Nothing lies before what is not one of its places.
    InFront at(std::uint32_t column, std::uint32_t row, double depth) const;

  private:
    std::uint32_t width_;
    std::vector<SightPlace> places_;
    std::vector<InFront> inFront_;
};

}  // namespace mote::server
