// SPDX-License-Identifier: GPL-3.0-or-later
//
// CompositeFrame: what the composite of every tile of one picture has in common. A value that points to
// volumes and tables which the device keeps while the picture is drawn; read by any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "server/render/cpu/box_space.h"
#include "server/render/cpu/packed_volume.h"
#include "server/render/cpu/volume_blocks.h"
#include "server/render/picture.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/ray_map.h"
#include "server/render/plan/volume_table.h"

namespace mote::render {

/// A volume that is somewhere visible; nothing is owned.
struct VisibleVolume {
    const PackedVolume* volume = nullptr;  ///< null: there is none
    const VolumeTable* table = nullptr;
    const VisibleBlocks* blocks = nullptr;
};

/// The same of a hybrid layer.
struct VisibleHybrid {
    const VolumeTable* table = nullptr;
    const VisibleBlocks* blocks = nullptr;  ///< null: nothing of its volume is seen
    const BlockRanges* ranges = nullptr;    ///< of the same blocks; null with them
};

/// Pixels, from the picture's upper left corner; may reach beyond it.
struct PixelRange {
    glm::dvec2 low, high;

    /// Whether a square of pixels may touch it.
    bool meets(double x, double y, double edge) const {
        return x <= high.x && y <= high.y && x + edge >= low.x && y + edge >= low.y;
    }
};

struct CompositeLayer {
    RayMap rays;        ///< by mean slabs, see FrameSection
    PixelRange screen;  ///< outside of which no ray meets the box
    VisibleVolume visible;
    glm::vec3 pointColor;  ///< linear RGB
    float pointTau;        ///< optical depth of a whole point
};

/// A hybrid layer whose volume is somewhere visible; nothing is owned but a few numbers.
struct HybridLayer {
    RayMap rays;
    PixelRange screen;
    BoxSpace space;
    const VisibleBlocks* blocks;  ///< null: nothing of it is seen
    const VolumeTable* table;
    float tableScale, tableShift;  ///< a code times the scale, plus the shift, is what the table takes
    const HybridGrid* low;
    const HybridBricks* bricks;    ///< null: it is not corrected
    float correction, steepness;   ///< HybridPlan's
    float coarse;                  ///< in motion: stretches to one where nothing is corrected
    glm::vec3 lowScale, lowShift;  ///< from a place in the space's cells to one in samples of the low volume
    static constexpr float fullShade = 32767.0F;
    /// Of each normal, times fullShade: diffuse in the low 15 bits, specular from bit 16.
    std::array<std::uint32_t, 256> shades;
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
    CompositeFrame(const FramePlan& plan, PixelFormat format, const std::vector<VisibleVolume>& volumes,
                   const std::vector<VisibleHybrid>& visibleHybrids = {});

    std::uint32_t width, height;         ///< pixels
    std::uint32_t slabs;                 ///< of all sections
    std::vector<FrameSection> sections;  ///< front to back
    float samplesPerCell;
    bool cellByCell;       ///< rays go from cell to cell, for their kinks: at two samples a cell or more
    glm::dvec2 window;     ///< half width and half height of the picture at depth 1
    glm::vec3 background;  ///< linear RGB
    PixelFormat format;
    std::array<std::uint8_t, 8> blank;  ///< a pixel of background, in its first bytes
    std::vector<CompositeLayer> layers;
    std::vector<HybridLayer> hybrids;
};

}  // namespace mote::render
