// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/volume_rims.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr float steepest = 0.025F;  // a pixel, that an opacity falls by where matter thins out

struct Neighbour {
    int column, row;
    float distance;
};

/// One of the two passes of a distance transform, by the neighbours that come before a pixel (Borgefors 1986,
/// Distance transformations in digital images).
void spread(Raster<float>& distance, int direction) {
    constexpr float aslant = 1.41421356F;
    constexpr std::array<Neighbour, 4> before{
        {{-1, 0, 1.0F}, {-1, -1, aslant}, {0, -1, 1.0F}, {1, -1, aslant}}};
    const auto width = static_cast<int>(distance.width), height = static_cast<int>(distance.height);
    const auto at = [&](int column, int row) -> float& {
        return distance.at(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row));
    };
    for (int i = 0; i < height; ++i) {
        giveWay();
        for (int k = 0; k < width; ++k) {
            const int row = direction > 0 ? i : height - 1 - i, column = direction > 0 ? k : width - 1 - k;
            for (const auto& one : before) {
                const int x = column + direction * one.column, y = row + direction * one.row;
                if (x < 0 || y < 0 || x >= width || y >= height) continue;
                at(column, row) = std::min(at(column, row), at(x, y) + one.distance);
            }
        }
    }
}

}  // namespace

Raster<std::uint8_t> rimsOf(const Raster<float>& opacity) {
    Raster<float> distance(opacity.width, opacity.height, HUGE_VALF);
    for (std::size_t i = 0; i < opacity.values.size(); ++i) {
        if (opacity.values[i] >= surfaceOpacity) distance.values[i] = 0.0F;
    }
    spread(distance, 1);
    spread(distance, -1);
    Raster<std::uint8_t> rims(opacity.width, opacity.height);
    for (std::size_t i = 0; i < rims.values.size(); ++i) {
        const float fallen = surfaceOpacity - opacity.values[i];
        rims.values[i] = fallen > 0.0F && fallen > steepest * distance.values[i] ? 1 : 0;
    }
    return rims;
}

}  // namespace mote::render
