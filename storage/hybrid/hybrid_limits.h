// SPDX-License-Identifier: GPL-3.0-or-later
//
// How large a hybrid volume may be, and the sizes that its layout is built on. Constants.
#pragma once

#include <array>
#include <cstdint>

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

}  // namespace mote::storage
