// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/hybrid/hybrid_step.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace mote::render {
namespace {

template <class T>
std::uint64_t bytesOf(const std::vector<T>& values) {
    return values.capacity() * sizeof(T);
}

}  // namespace

double HybridStep::longestEdge() const {
    double longest = 0.0;
    for (int axis = 0; axis < 3; ++axis)
        longest = std::max(longest, glm::length(glm::dvec3(boxToLayer[axis])));
    return longest;
}

std::uint64_t HybridStep::bytes() const {
    std::uint64_t sum = bytesOf(low.values) + bytesOf(low.normals);
    if (bricks) sum += bytesOf(bricks->numbers) + bytesOf(bricks->values) + bytesOf(bricks->normals);
    return sum;
}

}  // namespace mote::render
