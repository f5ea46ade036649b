// SPDX-License-Identifier: GPL-3.0-or-later
//
// Strokes are what a pen draws (docs/PICTURE.md, "Strokes"): lines of a width, and areas that are inked
// solid. The processor makes them; to a device they come as fragments, to a sheet as shapes. Values; a list
// is immutable and shared by plans.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

namespace mote::render {

struct StrokePoint {
    float x = 0.0F;  ///< pixels from the picture's upper left corner
    float y = 0.0F;
    float width = 1.0F;  ///< pixels, here
    double depth = 0.0;  ///< along the line of sight, world units; finite

    bool operator==(const StrokePoint&) const = default;
};

/// Points from `begin` to `end` of those of its list, at least one: the way of a pen, or an outline.
struct Stroke {
    std::uint32_t begin = 0, end = 0;

    bool operator==(const Stroke&) const = default;
};

/// What is inked solid: the pixels' share that an odd number of closed outlines surrounds.
struct InkArea {
    std::uint32_t begin = 0, end = 0;  ///< of its list's outlines

    bool operator==(const InkArea&) const = default;
};

/// At what depth areas lie in each pixel of the picture: one region of it may show what is near and what is
/// far. An area is not drawn in a pixel that has none.
struct AreaDepths {
    static constexpr float none = std::numeric_limits<float>::infinity();

    std::uint32_t width = 0, height = 0;  ///< of the picture; 0 where there are no areas
    std::vector<float> values;  ///< [height][width]; along the line of sight, world units, or `none`

    float at(std::uint32_t column, std::uint32_t row) const {
        return column < width && row < height ? values[std::size_t{row} * width + column] : none;
    }
    bool operator==(const AreaDepths&) const = default;
};

/// What one ink draws.
struct Strokes {
    std::vector<StrokePoint> points;
    std::vector<Stroke> lines;
    std::vector<Stroke> outlines;  ///< closed; of areas
    std::vector<InkArea> areas;
    AreaDepths areaDepths;
    glm::vec3 color{0.0F};  ///< linear RGB
    float opacity = 1.0F;   ///< 0 to 1, of all of them together, as if they were on one sheet

    bool empty() const { return lines.empty() && areas.empty(); }
    bool operator==(const Strokes&) const = default;
};

}  // namespace mote::render
