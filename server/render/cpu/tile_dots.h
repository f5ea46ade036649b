// SPDX-License-Identifier: GPL-3.0-or-later
//
// TileDots: the dots of one tile, and points that stand alone, spread over its pixels: what each pixel meets
// of them, front to back. The thread that owns it uses it again from tile to tile.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "server/render/cpu/tile.h"
#include "server/render/plan/pixel_colors.h"
#include "server/render/plan/screen_dots.h"

namespace mote::render {

/// What a dot is in one pixel.
struct DotHit {
    float place;    ///< slabs
    float opacity;  ///< of the dot times its coverage, above 0
    glm::vec3 color;
};

/// What touches a tile: a dot, or a point that stands alone.
struct TileDot {
    const ScreenDot* dot;
    double thinned = 1.0;                 ///< what is left of its optical depth in each pixel, as PointLook's
    float tau = -1.0F;                    ///< as LonePoint's
    const PixelColors* colors = nullptr;  ///< in place of the dot's, by pixel; null: none
};

class TileDots {
  public:
    /// `dots`: those that touch the tile, front to back; one without a reach lies in one pixel alone.
    void set(Tile tile, std::span<const TileDot> dots, std::uint32_t slabs);

    /// Front to back. `pixel`: a Tile::pixelIndex.
    std::span<const DotHit> of(std::uint32_t pixel) const {
        return {hits_.data() + begin_[pixel], begin_[pixel + 1] - begin_[pixel]};
    }
    /// One bit a packet, from bit 0: whether its pixels have dots in a slab.
    std::uint64_t occupied(std::uint32_t slab) const { return occupied_[slab]; }

  private:
    struct Placed {
        std::uint32_t pixel;
        DotHit hit;
    };
    void spread(Tile tile, const TileDot& one, std::uint32_t slabs);

    std::vector<Placed> placed_;  // the first `placedCount_`; room beyond
    std::size_t placedCount_ = 0;
    std::vector<DotHit> hits_;
    std::array<std::uint32_t, Tile::pixels + 1> begin_{};
    std::array<float, Tile::pixels> left_;  // of the light behind those placed so far
    std::vector<std::uint64_t> occupied_;
};

}  // namespace mote::render
