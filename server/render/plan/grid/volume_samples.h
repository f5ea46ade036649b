// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumeSamples: a grid field's values anywhere in its box, as it is drawn (docs/PICTURE.md, "Hybrid
// volumes"; points are smooth and fully applied), and their slopes. Refers to the field; any number of
// threads.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <span>

#include "server/render/plan/grid_field.h"

namespace mote::render {

/// The grids that samples are read from, a field's.
struct SampleGrids {
    const GridBricks* bricks = nullptr;  ///< null: the coarse grid is the finest
    const SampleGrid* coarse = nullptr;
    glm::vec3 last{0.0F};         ///< sample, finest grid
    glm::vec3 coarseScale{1.0F};  ///< coarse cells a cell
    glm::vec3 coarseLast{0.0F};   ///< coarse sample
};

/// Places in the finest grid's cells, each coordinate by itself, as vectors take them; finite.
struct SamplePlaces {
    static constexpr std::size_t together = 16;  ///< of any vector the lanes at most
    static constexpr std::size_t most = 6 * together;
    std::array<float, most> x, y, z;
    std::size_t size = 0;

    void add(const glm::vec3& place) {
        x[size] = place.x;
        y[size] = place.y;
        z[size] = place.z;
        ++size;
    }
};

using SampleCodes = std::array<float, SamplePlaces::most>;

/// What VolumeSamples::code() finds, of many places, with vectors. Each product and sum is rounded as there:
/// the numbers are the same, by any kind of vectors. What stands behind the places and codes is overwritten.
void sampleCodes(const SampleGrids& grids, SamplePlaces& places, SampleCodes& codes);

class VolumeSamples {
  public:
    /// `corrected`: whether its bricks are, where there are some.
    explicit VolumeSamples(const GridField& field, bool corrected = true);

    /// Of the finest grid, along each axis. Places are told in its cells from the box's corner.
    const glm::dvec3& cells() const { return cells_; }
    float code(const glm::vec3& place) const;
    /// The same of many places.
    void codes(SamplePlaces& places, SampleCodes& codes) const { sampleCodes(grids_, places, codes); }
    /// Codes a cell, by differences as far apart as samples lie there.
    glm::vec3 slope(const glm::vec3& place) const;
    /// The same of as many places as there are slopes.
    void slopes(std::span<const glm::vec3> places, std::span<glm::vec3> slopes) const;

  private:
    /// How samples lie in memory: the next row, the next sheet.
    struct Strides {
        std::size_t row, sheet;
    };

    /// The corrected brick that a place lies in, or GridBricks::none. In samples, from the first one's
    /// middle.
    std::int32_t brickAt(const glm::vec3& sample) const {
        const auto* const bricks = grids_.bricks;
        return bricks == nullptr ? GridBricks::none
                                 : bricks->numbers[bricks->index(glm::uvec3(sample) / GridBricks::edge)];
    }
    /// Nowhere beyond the outermost samples.
    glm::vec3 sampleAt(const glm::vec3& place) const {
        return glm::clamp(place - 0.5F, glm::vec3(0.0F), grids_.last);
    }
    static float mix(float from, float to, float share) { return from + share * (to - from); }
    static float interpolated(const std::uint16_t* samples, const glm::vec3& at, const glm::vec3& last,
                              const Strides& strides);

    glm::dvec3 cells_;
    SampleGrids grids_;
};

/// Between the eight samples around a place that lies among them; four rows of two together.
inline float VolumeSamples::interpolated(const std::uint16_t* samples, const glm::vec3& at,
                                         const glm::vec3& last, const Strides& strides) {
    static_assert(std::endian::native == std::endian::little, "of two samples in a word the first is lower");
    using Words = std::uint32_t __attribute__((vector_size(16)));
    using Whole = std::int32_t __attribute__((vector_size(16)));
    using Codes = float __attribute__((vector_size(16)));
    const glm::ivec3 below(at);
    const glm::vec3 share = at - glm::vec3(below);
    const std::uint16_t* const first = samples + static_cast<std::size_t>(below.z) * strides.sheet +
                                       static_cast<std::size_t>(below.y) * strides.row +
                                       static_cast<std::size_t>(below.x);
    const std::size_t y = at.y < last.y ? strides.row : 0, z = at.z < last.z ? strides.sheet : 0;
    // Behind the last sample of a row is another one, of which there is a share of 0.
    const auto two = [first](std::size_t offset) {
        std::uint32_t word = 0;
        std::memcpy(&word, first + offset, sizeof word);
        return word;
    };
    const Words words{two(0), two(y), two(z), two(z + y)};
    const Codes from = __builtin_convertvector((Whole)(words & 0xffffU), Codes);
    const Codes to = __builtin_convertvector((Whole)(words >> 16U), Codes);
    const Codes rows = from + share.x * (to - from);
    return mix(mix(rows[0], rows[1], share.y), mix(rows[2], rows[3], share.y), share.z);
}

inline float VolumeSamples::code(const glm::vec3& place) const {
    const glm::vec3 sample = sampleAt(place);
    const std::int32_t brick = brickAt(sample);
    if (brick == GridBricks::none) {
        const SampleGrid& coarse = *grids_.coarse;
        const glm::vec3 at =
            glm::clamp(place * grids_.coarseScale - 0.5F, glm::vec3(0.0F), grids_.coarseLast);
        return interpolated(coarse.values.data(), at, grids_.coarseLast,
                            {coarse.size.x, std::size_t{coarse.size.x} * coarse.size.y});
    }
    constexpr std::size_t row = GridBricks::samples;
    const glm::vec3 corner(glm::uvec3(sample) / GridBricks::edge * GridBricks::edge);
    return interpolated(grids_.bricks->values.data() + static_cast<std::size_t>(brick) * GridBricks::volume,
                        sample - corner, glm::vec3(GridBricks::edge), {row, row * row});
}

}  // namespace mote::render
