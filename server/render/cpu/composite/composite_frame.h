// SPDX-License-Identifier: GPL-3.0-or-later
//
// CompositeFrame: what the composite of every tile of one picture has in common. A value that points to
// fields and tables which the device keeps while the picture is drawn; read by any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "protocol/scene/hybrid_style.h"
#include "server/render/cpu/composite/field_reach.h"
#include "server/render/cpu/resident_fields.h"
#include "server/render/cpu/tile_cells.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/picture.h"
#include "server/render/plan/pixel_colors.h"
#include "server/render/plan/ray_map.h"

namespace mote::render {

/// BoxSpace: how a layer's volume fills its box [0, 1]^3, as rays go through it. A value that points to what
/// its plan keeps.
struct BoxSpace {
    glm::dvec3 cells{1.0};    ///< along each axis
    double shift = 0.0;       ///< the place of the box's first corner, in cells, on each axis
    double samples = 1.0;     ///< segments a cell's edge
    glm::dmat3 toLayer{2.0};  ///< box to layer space, without its place; a plot's box is [-1, 1]^3 there
    std::span<const HalfSpace> clips = {};  ///< in the box: nothing is seen outside of any
};

/// Pixels, from the picture's upper left corner; may reach beyond it.
struct PixelRange {
    glm::dvec2 low, high;

    /// Whether a square of pixels may touch it.
    bool meets(double x, double y, double edge) const {
        return x <= high.x && y <= high.y && x + edge >= low.x && y + edge >= low.y;
    }
};

/// Points of one look.
struct FramePointLook {
    glm::vec3 color;                      ///< linear RGB
    float tau;                            ///< optical depth of a whole point, thinned as its look says
    bool byDepth;                         ///< `tau` is that at depth 1, and goes with its inverse square
    const PixelColors* colors = nullptr;  ///< by pixel, in place of the one; null: none
    /// Likewise if cells tell the levels of points (TileCells): the colours of all levels, shadesOfLevel to
    /// each; else empty.
    std::vector<glm::vec3> shades = {};

    static constexpr unsigned shadesOfLevel = 8;
    const glm::vec3& colorOf(const PixelShade& shade) const {
        const float mean = shade.level / shade.weight;
        // Not negative: NOLINTNEXTLINE(bugprone-incorrect-roundings)
        return shades[static_cast<std::size_t>(mean * shadesOfLevel + 0.5F)];
    }
};

/// Where a slab lies.
struct SlabDepth {
    float nearest, thickness;  ///< world units along the line of sight
};

/// What is read of a field of samples with normals; nothing is owned but a few numbers.
struct GridSamples {
    const TransferTable* table;
    CodePlaces places;
    const SampleGrid* coarse;
    const GridBricks* bricks;            ///< null: it is not corrected
    const DarkCells* dark;               ///< where they show nothing; null: it is not known
    float correction, steepness;         ///< CorrectedField's
    const GridSlopes* slopes;            ///< null: extinction does not go by them
    float gradient;                      ///< CorrectedField's
    float stride;                        ///< in motion: ray segments to one where nothing is corrected
    glm::vec3 coarseScale, coarseShift;  ///< from a place in cells of the field to one in coarse samples
    static constexpr float fullShade = 32767.0F;
    /// Each normal's Shade times fullShade: diffuse in the low 15 bits, specular from bit 16.
    std::array<std::uint32_t, 256> shades;
};

/// A field as rays go through it. Its format is told once a ray segment: densities, or samples with normals.
struct FrameField {
    RayMap rays;        ///< by mean slabs, see FrameSection
    PixelRange screen;  ///< outside of which no ray meets the box
    BoxSpace space;
    VisibleField visible;               ///< its blocks are null where nothing of it is seen
    std::optional<GridSamples> grid{};  ///< none: of densities
};

/// A section of the depth (DepthSection), beside what rays are told by: s counts the picture's mean slabs
/// from its near depth on.
struct FrameSection {
    std::uint32_t firstSlab, slabs;
    double nearMean;  ///< s at its near end
    double meanSlab;  ///< of s, in one slab of its own
    std::uint32_t endSlab() const { return firstSlab + slabs; }
};

struct CompositeFrame {
    /// `visible`: of each field of the plan. `colors`: of each of its points.
    CompositeFrame(const FramePlan& plan, PixelFormat format, const std::vector<VisibleField>& visible,
                   const FrameColors& colors);

    std::uint32_t width, height;         ///< pixels
    std::uint32_t slabs;                 ///< of all sections
    std::vector<FrameSection> sections;  ///< front to back
    std::vector<SlabDepth> depths;       ///< of each slab
    float samplesPerCell;
    std::uint8_t
        smooth;       ///< how far apart the first rays of a TileLattice may be, in its nodes; 0: it has none
    bool cellByCell;  ///< rays go from cell to cell, for their kinks: at two samples a cell or more
    glm::dvec2 window;     ///< half width and half height of the picture at depth 1
    glm::vec3 background;  ///< linear RGB
    PixelFormat format;
    std::array<std::uint8_t, 8> blank;   ///< a pixel of background, in its first bytes
    std::vector<FramePointLook> points;  ///< one of the plan's each
    std::vector<FrameField> fields;      ///< likewise
    FieldReach reach;                    ///< where they show anything
};

}  // namespace mote::render
