// SPDX-License-Identifier: GPL-3.0-or-later
//
// A GridField is a scalar field of samples as devices draw it: a coarse grid, and bricks of a finer one that
// correct it, with their normals, all in codes of few bits (docs/PICTURE.md, "Hybrid volumes").
// layers/hybrid/hybrid_load.h makes it; all devices and the reference renderer read it. Immutable once made,
// safe on any number of threads.
//
// A value's code is 16 bits over the field's range. A normal's code is an index into
// storage/hybrid/normal_table.h, a direction in layer space.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "protocol/scene/bounds.h"
#include "protocol/scene/hybrid_style.h"
#include "storage/step_origin.h"

namespace mote::render {

/// A grid of samples over a volume's box, x fastest. Four entries more than there are samples can be read.
struct SampleGrid {
    glm::uvec3 size{0};                 ///< samples
    std::vector<std::uint16_t> values;  ///< codes
    std::vector<std::uint8_t> normals;  ///< codes

    std::size_t index(const glm::uvec3& at) const {
        return (std::size_t{at.z} * size.y + at.y) * size.x + at.x;
    }
};

/// The least and the greatest code of some samples.
struct CodeRange {
    std::uint16_t low = 65535, high = 0;

    void add(std::uint16_t code) {
        low = code < low ? code : low;
        high = code > high ? code : high;
    }
    bool operator==(const CodeRange&) const = default;
};
CodeRange rangeOf(std::span<const std::uint16_t> codes);

/// Where the error grid is corrected. A brick has the cells of 8 x 8 x 8 first corners, so 9 x 9 x 9 samples;
/// beyond the grid its last sample is repeated.
struct GridBricks {
    static constexpr std::uint32_t edge = 8;     ///< cells
    static constexpr std::uint32_t samples = 9;  ///< along an edge
    static constexpr std::uint32_t volume = samples * samples * samples;
    static constexpr std::int32_t none = -1;
    static constexpr std::size_t most =
        (std::size_t{1} << 31) / (std::size_t{2} * volume) - 1;  ///< bytes in 31 bits

    glm::uvec3 size{0};                 ///< of the error grid, samples
    glm::uvec3 count{0};                ///< bricks
    std::vector<std::int32_t> numbers;  ///< each brick's place among the corrected, x fastest, or none
    std::vector<std::uint16_t> values;  ///< codes of the corrected bricks, x fastest; four more can be read
    std::vector<std::uint8_t> normals;  ///< likewise
    std::vector<CodeRange> ranges;      ///< of each corrected brick's codes; empty: they are looked for

    /// Of a corrected brick.
    CodeRange rangeOf(std::size_t number) const;
    std::size_t index(const glm::uvec3& brick) const {
        return (std::size_t{brick.z} * count.y + brick.y) * count.x + brick.x;
    }
    std::size_t corrected() const { return values.size() / volume; }
};

struct GridField {
    storage::StepOrigin origin;     ///< without a file where it was made in memory
    glm::dmat4 boxToLayer{1.0};     ///< the volume's box as [0, 1]^3 to layer space
    ValueRange range{0.0, 1.0};     ///< of the codes 0 and 65535, in the source's unit
    std::string unit;               ///< of a value: "HU"; empty: not known
    std::vector<double> histogram;  ///< of the source's values, even bins over the range; may be empty
    SampleGrid coarse;
    /// What the bricks were made of: residual or points; volume without any. Never `best`.
    HybridRepresentation parts = HybridRepresentation::volume;
    std::shared_ptr<const GridBricks> bricks;  ///< null: there are none, or they were not asked for

    double valueOf(double code) const { return range.low + code / 65535.0 * (range.high - range.low); }
    double codeOf(double value) const { return (value - range.low) / (range.high - range.low) * 65535.0; }
    Bounds bounds() const { return Bounds{glm::dvec3(0.0), glm::dvec3(1.0)}.transformed(boxToLayer); }
    /// The box's longest edge, layer units.
    double longestEdge() const;
    std::uint64_t bytes() const;  ///< that it takes in memory
};

}  // namespace mote::render
