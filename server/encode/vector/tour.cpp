// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/tour.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>

namespace mote::server {
namespace {

constexpr std::uint32_t curveSide = 1U << 16;  ///< cells of the Hilbert curve along a side
constexpr std::size_t window = 64;             ///< dots ahead that a 2-opt exchange may reach
constexpr int mostPasses = 6;

/// How far along the curve a cell lies (Warren, "Hacker's Delight", 16.2, from the coarsest bits on).
std::uint64_t hilbert(std::uint32_t x, std::uint32_t y) {
    std::uint64_t along = 0;
    for (std::uint32_t side = curveSide / 2; side > 0; side /= 2) {
        const std::uint32_t right = (x & side) > 0 ? 1 : 0;
        const std::uint32_t below = (y & side) > 0 ? 1 : 0;
        along += std::uint64_t{side} * side * ((3 * right) ^ below);
        if (below != 0) continue;
        if (right != 0) {
            x = curveSide - 1 - x;
            y = curveSide - 1 - y;
        }
        std::swap(x, y);
    }
    return along;
}

std::vector<std::uint32_t> alongCurve(std::span<const glm::dvec2> places) {
    glm::dvec2 low(std::numeric_limits<double>::max());
    glm::dvec2 high(std::numeric_limits<double>::lowest());
    for (const auto& place : places) {
        low = glm::min(low, place);
        high = glm::max(high, place);
    }
    const double span = std::max({high.x - low.x, high.y - low.y, 1e-9});
    std::vector<std::uint64_t> keys(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto cell = (places[i] - low) * ((curveSide - 1) / span);
        keys[i] = hilbert(static_cast<std::uint32_t>(cell.x), static_cast<std::uint32_t>(cell.y));
    }
    std::vector<std::uint32_t> order(places.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return keys[a] < keys[b]; });
    return order;
}

/// Turns stretches around if that shortens the way; whether any did.
bool shorten(std::span<const glm::dvec2> places, std::vector<std::uint32_t>& order) {
    const auto gap = [&](std::size_t a, std::size_t b) {
        return glm::distance(places[order[a]], places[order[b]]);
    };
    bool shortened = false;
    for (std::size_t i = 0; i + 3 < order.size(); ++i) {
        const std::size_t last = std::min(order.size() - 2, i + window);
        for (std::size_t j = i + 2; j <= last; ++j) {
            const double before = gap(i, i + 1) + gap(j, j + 1);
            if (gap(i, j) + gap(i + 1, j + 1) >= before - 1e-12) continue;
            std::reverse(order.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                         order.begin() + static_cast<std::ptrdiff_t>(j) + 1);
            shortened = true;
        }
    }
    return shortened;
}

}  // namespace

std::vector<std::uint32_t> shortTour(std::span<const glm::dvec2> places) {
    if (places.empty()) return {};
    auto order = alongCurve(places);
    for (int pass = 0; pass < mostPasses && shorten(places, order); ++pass) {
    }
    return order;
}

}  // namespace mote::server
