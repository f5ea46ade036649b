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

#include "server/render/plan/frame_plan.h"
#include "server/render/plan/picture.h"

namespace mote::render {

/// Of a layer: planes, and the sides of a box.
inline constexpr std::size_t mostClips = 12;

struct LayerBlock {
    glm::mat4 boxToScreen;  ///< see frame.glsl
    std::array<glm::vec4, 3> entry;
    std::array<glm::vec4, 3> advance;
    glm::vec4 point;
    glm::vec4 scale;
    glm::vec4 cells;
    glm::vec4 edges;
    std::array<glm::vec4, mostClips> clips;
};

/// A field of samples, as shaders/grid.glsl declares it (std140).
struct GridBlock {
    /// Segments that a cell's edge is cut into in exact pictures, where they absorb much.
    static constexpr double fineSegments = 1.6, lowSegments = 2.5;

    glm::vec4 grid;    ///< samples of the grid that is cut into bricks; segments a cell
    glm::vec4 low;     ///< samples of the coarse grid; segments a cell
    glm::vec4 table;   ///< code * x + y is a place in the transfer table (TransferTable); correction and
                       ///< steepness (CorrectedField)
    glm::ivec4 place;  ///< where its bricks begin among all fields'; the first texel of its slopes
    std::array<glm::vec4, 3>
        toLayer;  ///< the box's edges in layer space; of the first, w is CorrectedField's gradient
};
static_assert(sizeof(GridBlock) == 7 * 16);

struct FrameBlock {
    glm::ivec4 picture;
    glm::ivec4 band;
    glm::vec4 window;
    glm::vec4 background;
    glm::uvec4 blank;
    glm::uvec4 counts;  ///< set by FrameRun
    glm::vec4 depths;
    std::array<LayerBlock, 8> layers;
};
static_assert(sizeof(LayerBlock) == 416 && sizeof(FrameBlock) == 112 + 8 * 416);

/// How the points of a layer are placed on the screen and weighted.
struct PointNumbers {
    glm::mat4 toScreen;  ///< from integers relative to `origin` to (px * w, py * w, slab, w), before bends
    glm::uvec3 origin;   ///< units of 2^-31 of the box
    float nearest;       ///< w below which nothing is seen
    bool discs;          ///< larger than a pixel
    float radius;        ///< where a disc's coverage reaches 0, pixels
    float opacity;  ///< of a whole point, in the pixel that it covers most; 0: a disc is spread by coverage
    float tau;      ///< its optical depth there; of one that is lit (PointLook::light) at depth 1
    bool byDepth;   ///< and that goes with the inverse square of the depth
    std::uint32_t unit;  ///< weight of a whole point; the sum over all points drawn stays below 2^32
};

PointNumbers pointNumbers(const FramePlan& plan, const PointsPlan& points);

/// What the shaders count as a layer: the points and the densities of one layer of the view share a slot,
/// each field of samples has one of its own, after these.
struct LayerSlot {
    const PointsPlan* points = nullptr;    ///< null: none
    const FieldPlan* densities = nullptr;  ///< likewise

    /// Of the box that rays go through.
    const glm::dmat4& boxToEye() const {
        return densities != nullptr ? densities->boxToEye : points->boxToEye;
    }
};

/// Those of points and densities.
std::vector<LayerSlot> layerSlots(const FramePlan& plan);

/// How the slabs of a layer are bent, for shaders/bends.glsl.
struct BendBlock {
    /// x: where a bend is, in slabs of the layer's first section; y: the slab there; z: the slope beyond.
    std::array<glm::vec3, mostSections> bends{};
    glm::vec3 shape;  ///< how many bends; the layer's first slab; how many it has

    explicit BendBlock(const SlabBends& slabs);
    /// Sets the uniforms of a program that includes bends.glsl.
    void set(std::uint32_t program) const;
};

/// Each section's end and first slab, then each layer's entry and advance of rays (ray.glsl, SECTIONS).
std::vector<glm::vec4> sectionRays(const FramePlan& plan);

/// `samples`: the field's; `size`: samples of the grid that is cut into bricks; `firstBrick`: where its
/// bricks begin among those of all fields; `firstSlope`: the texel where its slopes do, if there are any.
GridBlock gridBlock(const FramePlan& plan, const FieldPlan& field, const CorrectedField& samples,
                    const glm::uvec3& size, std::uint32_t firstBrick, std::uint32_t firstSlope);

/// The block for the tile rows [firstRow, firstRow + rows).
FrameBlock frameBlock(const FramePlan& plan, PixelFormat format, std::uint32_t firstRow, std::uint32_t rows);

}  // namespace mote::render
