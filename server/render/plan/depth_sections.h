// SPDX-License-Identifier: GPL-3.0-or-later
//
// A DepthSection is a stretch of depth in which something is, cut into slabs as finely as each thing needs by
// itself (docs/PICTURE.md, "Slabs"). Values and pure functions, part of a FramePlan.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace mote::render {

/// Where something may be drawn.
struct DepthRange {
    double nearDepth, farDepth;  ///< world units along the line of sight
    std::uint32_t slabs;         ///< that it is to be cut into, by itself; 0: it needs no cuts
};

/// A part of the depth, cut into slabs of equal thickness.
struct DepthSection {
    double nearDepth, farDepth;  ///< world units along the line of sight
    std::uint32_t firstSlab;     ///< among those of all sections
    std::uint32_t slabs;         ///< at least one

    double thickness() const { return (farDepth - nearDepth) / slabs; }  ///< of a slab
    std::uint32_t endSlab() const { return firstSlab + slabs; }
    /// Depth told in slabs; linear, also beyond the section.
    double slabOf(double depth) const { return firstSlab + (depth - nearDepth) / thickness(); }
    bool operator==(const DepthSection&) const = default;
};

/// More slabs than a picture ever has.
inline constexpr std::uint32_t mostSlabs = 1024;
/// And more sections: two ends a layer, and those of dots.
inline constexpr std::uint32_t mostSections = 17;

/// The sections of what lies in some ranges, front to back. Each range that is longer than 0 is cut at least
/// as finely as it asks for, unless there would be more than mostSlabs; where there is nothing, there is no
/// section. Empty where there is nothing at all.
std::vector<DepthSection> depthSections(std::span<const DepthRange> contents);

/// How depths told in slabs of the first section in which something lies, linear in its place, become slabs
/// of the sections that it goes through.
struct SlabBends {
    struct Bend {
        float at;     ///< slabs of the first section, from its first on
        float slab;   ///< the slab there; likewise
        float slope;  ///< beyond
    };
    DepthSection first;   ///< its slabs are the unit, its first slab the zero, of what is bent
    std::uint32_t slabs;  ///< of all sections that it goes through
    std::vector<Bend> bends;

    /// Slabs from the first section's first on.
    float operator()(float linear) const {
        float slab = linear;
        for (const auto& bend : bends) {
            if (linear > bend.at) slab = bend.slab + (linear - bend.at) * bend.slope;
        }
        return slab;
    }
    /// The greatest slope.
    float steepest() const;
};

/// The bends of what lies between two depths. `sections`: not empty.
SlabBends slabBends(std::span<const DepthSection> sections, double nearDepth, double farDepth);

/// A depth told in slabs, held to the sections; in a gap, the border. `sections`: not empty.
double slabOf(std::span<const DepthSection> sections, double depth);
/// The depth of a place told in slabs, held to the sections. `sections`: not empty.
double depthAt(std::span<const DepthSection> sections, double slab);

}  // namespace mote::render
