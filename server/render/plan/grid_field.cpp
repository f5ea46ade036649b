// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/grid_field.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace mote::render {
namespace {

template <class T>
std::uint64_t bytesOf(const std::vector<T>& values) {
    return values.capacity() * sizeof(T);
}

}  // namespace

CodeRange rangeOf(std::span<const std::uint16_t> codes) {
    CodeRange range;
    for (const std::uint16_t code : codes) range.add(code);
    return range;
}

CodeRange GridBricks::rangeOf(std::size_t number) const {
    if (!ranges.empty()) return ranges[number];
    return render::rangeOf(std::span(values).subspan(number * volume, volume));
}

double GridField::longestEdge() const {
    double longest = 0.0;
    for (int axis = 0; axis < 3; ++axis)
        longest = std::max(longest, glm::length(glm::dvec3(boxToLayer[axis])));
    return longest;
}

std::uint64_t GridField::bytes() const {
    std::uint64_t sum = bytesOf(coarse.values) + bytesOf(coarse.normals);
    if (bricks)
        sum += bytesOf(bricks->numbers) + bytesOf(bricks->values) + bytesOf(bricks->normals) +
               bytesOf(bricks->ranges);
    return sum;
}

}  // namespace mote::render
