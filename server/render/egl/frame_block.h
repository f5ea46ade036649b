// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameBlock: the uniform block that shaders/frame.glsl declares (std140), and the numbers of points'
// programs. Values, computed from a plan in double precision.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "server/render/picture.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

struct LayerBlock {
    glm::mat4 boxToScreen;  ///< see frame.glsl
    std::array<glm::vec4, 3> entry;
    std::array<glm::vec4, 3> advance;
    glm::vec4 point;
    glm::vec4 scale;
};

/// Of a hybrid layer, as shaders/hybrid.glsl declares it (std140).
struct HybridBlock {
    static constexpr std::size_t mostClips = 12;
    /// Of exact pictures, stretches that a cell's edge is cut into, where they absorb much.
    static constexpr double fineStretches = 1.6, lowStretches = 2.5;

    glm::vec4 grid;    ///< samples of the grid that is cut into bricks; stretches a cell
    glm::vec4 low;     ///< samples of the low volume; stretches a cell
    glm::vec4 table;   ///< code * x + y is a place in the transfer table (VolumeTable); correction and
                       ///< steepness (HybridPlan)
    glm::ivec4 place;  ///< of its first brick among all hybrid layers'; clips; unused
    std::array<glm::vec4, 3> toLayer;        ///< the box's edges in layer space
    std::array<glm::vec4, mostClips> clips;  ///< in the box: dot(xyz, place) >= w is drawn
};
static_assert(sizeof(HybridBlock) == 19 * 16);

struct FrameBlock {
    glm::ivec4 picture;
    glm::ivec4 band;
    glm::vec4 window;
    glm::vec4 background;
    glm::uvec4 blank;
    glm::uvec4 counts;  ///< set by FrameRun
    std::array<LayerBlock, 8> layers;
};
static_assert(sizeof(LayerBlock) == 192 && sizeof(FrameBlock) == 96 + 8 * 192);

/// How the points of a layer are placed on the screen and weighted.
struct PointNumbers {
    glm::mat4 toScreen;  ///< from integers relative to `origin` to (px * w, py * w, slab, w), before bends
    glm::uvec3 origin;   ///< units of 2^-31 of the box
    float nearest;       ///< w below which nothing is seen
    bool discs;          ///< larger than a pixel
    float radius;        ///< where a disc's coverage reaches 0, pixels
    float opacity;       ///< of a whole point, in the pixel that it covers most
    float tau;           ///< -log(1 - opacity)
    std::uint32_t unit;  ///< weight of a whole point; the sum over all points drawn stays below 2^32
};

PointNumbers pointNumbers(const FramePlan& plan, const LayerPlan& layer);

/// How the slabs of a layer are bent, for shaders/bends.glsl.
struct BendBlock {
    /// x: where a bend is, in slabs of the layer's first section; y: the slab there; z: the slope beyond.
    std::array<glm::vec3, mostSections> bends{};
    glm::vec3 shape;  ///< how many bends; the layer's first slab; how many it has

    explicit BendBlock(const SlabBends& slabs);
    /// Of the uniforms of a program that includes bends.glsl.
    void set(std::uint32_t program) const;
};

/// Of each section (composite.comp, SECTIONS): its end, and of each layer the entry and the advance of rays.
std::vector<glm::vec4> sectionRays(const FramePlan& plan);

/// `grid`: samples; `firstBrick`: of it among all hybrid layers'.
HybridBlock hybridBlock(const FramePlan& plan, const HybridPlan& layer, const glm::uvec3& grid,
                        std::uint32_t firstBrick);

/// Of the tile rows [firstRow, firstRow + rows); `volumeSizes[i]`: cells a side, 0 where nothing of it is
/// visible. Hybrid layers come after those of particles.
FrameBlock frameBlock(const FramePlan& plan, PixelFormat format, std::uint32_t firstRow, std::uint32_t rows,
                      const std::array<std::uint32_t, 8>& volumeSizes);

}  // namespace mote::render
