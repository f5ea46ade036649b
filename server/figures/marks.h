// SPDX-License-Identifier: GPL-3.0-or-later
//
// Marks: a drawing of lines, areas, text and small images, in the order in which they are drawn: what figures
// and a frame's annotations are before they become pixels or a document. Places in whatever unit its maker
// says, x right, y down; colours sRGB-encoded. A value.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <variant>
#include <vector>

#include "server/figures/rich_text.h"

namespace mote::server {

struct Ink {
    glm::dvec3 color{0.0};  ///< sRGB-encoded
    double opacity = 1.0;

    bool operator==(const Ink&) const = default;
};

/// An axis-aligned box, y down.
struct Box {
    glm::dvec2 low{0.0}, high{0.0};

    glm::dvec2 size() const { return high - low; }
    glm::dvec2 center() const { return 0.5 * (low + high); }
    bool meets(const Box& other) const {
        return low.x < other.high.x && other.low.x < high.x && low.y < other.high.y && other.low.y < high.y;
    }
    bool holds(const Box& other) const {
        return low.x <= other.low.x && low.y <= other.low.y && high.x >= other.high.x &&
               high.y >= other.high.y;
    }
    Box grown(double by) const { return {low - by, high + by}; }
};

struct LineMark {
    std::vector<glm::dvec2> points;
    double width = 1.0;
    Ink ink;
    bool closed = false;
    bool dashed = false;
};

/// What a closed way surrounds.
struct AreaMark {
    std::vector<glm::dvec2> points;
    Ink ink;
};

struct TextMark {
    RichText text;
    glm::dvec2 place{0.0};
    double size = 1.0;  ///< of an em
    glm::dvec2 anchor{
        0.0, 1.0};  ///< what lies at the place: across 0 to 1; down from the capitals' top to the baseline
    double angle = 0.0;  ///< radians, about the place, clockwise
    Ink ink;
    Ink halo = {{}, 0.0};  ///< drawn around the glyphs, beneath them
};

/// Pixels without smoothing between them, row 0 on top.
struct ImageMark {
    Box box;
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> rgba;  ///< sRGB-encoded, opacity not multiplied in
};

using Mark = std::variant<ImageMark, AreaMark, LineMark, TextMark>;
using Marks = std::vector<Mark>;

}  // namespace mote::server
