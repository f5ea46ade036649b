// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/quad.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace mote::server {
namespace {

/// Whether a line along a side of the first keeps both apart (the separating axis theorem).
bool apart(const Quad& first, const Quad& second) {
    for (std::size_t i = 0; i < first.size(); ++i) {
        const glm::dvec2 side = first[(i + 1) % 4] - first[i], across(side.y, -side.x);
        const auto span = [&](const Quad& quad) {
            double low = glm::dot(quad[0], across), high = low;
            for (const auto& corner : quad) {
                low = std::min(low, glm::dot(corner, across));
                high = std::max(high, glm::dot(corner, across));
            }
            return std::pair(low, high);
        };
        const auto [lowA, highA] = span(first);
        const auto [lowB, highB] = span(second);
        if (highA <= lowB || highB <= lowA) return true;
    }
    return false;
}

}  // namespace

Quad quadOf(const Box& box) {
    return {box.low, {box.high.x, box.low.y}, box.high, {box.low.x, box.high.y}};
}

Quad quadOf(const TextMark& text, const Typeface& typeface) {
    const double width = typeface.layOut(text.text, text.size).width;
    double above = Typeface::ascent, below = Typeface::descent;
    for (const auto& run : text.text) {
        if (run.script == Script::above)
            above = std::max(above, Typeface::raise + Typeface::scriptSize * Typeface::ascent);
        if (run.script == Script::below)
            below = std::max(below, Typeface::lower + Typeface::scriptSize * Typeface::descent);
    }
    const double left = -text.anchor.x * width;
    const double baseline = (1.0 - text.anchor.y) * Typeface::capHeight * text.size;
    Quad quad =
        quadOf(Box{{left, baseline - above * text.size}, {left + width, baseline + below * text.size}});
    const double sine = std::sin(text.angle), cosine = std::cos(text.angle);
    for (auto& corner : quad)
        corner =
            text.place + glm::dvec2(cosine * corner.x - sine * corner.y, sine * corner.x + cosine * corner.y);
    return quad;
}

Box boxAround(const Quad& quad) {
    Box box{quad[0], quad[0]};
    for (const auto& corner : quad) box = {glm::min(box.low, corner), glm::max(box.high, corner)};
    return box;
}

bool meet(const Quad& first, const Quad& second) {
    return !apart(first, second) && !apart(second, first);
}

}  // namespace mote::server
