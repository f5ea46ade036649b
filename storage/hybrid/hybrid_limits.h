// SPDX-License-Identifier: GPL-3.0-or-later
//
// The grids of a hybrid volume: how large they may be, the sizes that its layout is built on, and where the
// samples of one grid lie in another that covers the same box, and in the world. Values lie at cell centres;
// beyond the first and the last a grid is constant. Constants and pure functions, shared by the job, the
// renderers and the tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat4x4.hpp>

namespace mote::storage {

/// Samples along x, y and z.
using GridSize = std::array<std::uint32_t, 3>;

inline constexpr std::uint32_t maxGridSide = 1U << 16;
inline constexpr std::uint64_t maxGridSamples = std::uint64_t{1} << 36;
/// The low-resolution volume's limit: a server holds it whole.
inline constexpr std::uint64_t maxLowSamples = std::uint64_t{1} << 30;
inline constexpr int valueHistogramBins = 256;
/// A brick of points, in samples of the error grid a side: a place in it takes 15 bits.
inline constexpr std::uint32_t pointBrickSide = 32;
/// A brick of residuals, a leaf of OpenVDB's.
inline constexpr std::uint32_t residualBrickSide = 8;
inline constexpr std::uint32_t residualBrickSamples =
    residualBrickSide * residualBrickSide * residualBrickSide;
/// An error's byte: error = (code - 128) * the step's errorStep.
inline constexpr int errorCodeZero = 128;
/// The codes of a point's value: valueMin + code * (valueMax - valueMin) / 255 of the manifest.
inline constexpr int pointValueCodes = 256;

inline std::uint64_t samplesOf(const GridSize& size) {
    return std::uint64_t{size[0]} * size[1] * size[2];
}

/// Bricks along each axis that cover a grid.
inline GridSize bricksOf(const GridSize& size, std::uint32_t side) {
    return {(size[0] + side - 1) / side, (size[1] + side - 1) / side, (size[2] + side - 1) / side};
}

/// The place of sample j of `samples` in indices of a grid of `others`: 0 is the centre of its first cell.
inline double placeIn(std::uint32_t j, std::uint32_t samples, std::uint32_t others) {
    return (j + 0.5) * others / samples - 0.5;
}

/// A place between two samples: (1 - fraction) * value[first] + fraction * value[second].
struct Between {
    std::uint32_t first = 0, second = 0;
    float fraction = 0.0F;  ///< in [0, 1)
};

/// Linear interpolation at `place` of a grid of `samples`, constant beyond its ends.
inline Between between(double place, std::uint32_t samples) {
    const double inside = std::clamp(place, 0.0, samples - 1.0);
    const double below = std::floor(inside);
    const auto first = static_cast<std::uint32_t>(below);
    return {first, std::min(first + 1, samples - 1), static_cast<float>(inside - below)};
}

/// The map from indices of `grid` to the world, if `source` covers the same box and has `indexToWorld`.
inline glm::dmat4 gridToWorld(const glm::dmat4& indexToWorld, const GridSize& source, const GridSize& grid) {
    glm::dvec3 first(0.0);
    glm::dvec3 spacing(1.0);
    for (int a = 0; a < 3; ++a) {
        const auto at = static_cast<std::size_t>(a);
        first[a] = placeIn(0, grid[at], source[at]);
        spacing[a] = static_cast<double>(source[at]) / grid[at];
    }
    return indexToWorld * glm::scale(glm::translate(glm::dmat4(1.0), first), spacing);
}

}  // namespace mote::storage
