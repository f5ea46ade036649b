// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/frame_block.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include "protocol/base/mote_check.h"
#include "server/render/blank_picture.h"
#include "server/render/plan/ray_map.h"
#include "server/render/plan/screen_map.h"
#include "server/render/plan/transfer_table.h"

namespace mote::render {
namespace {

/// How closely segments of pictures in motion are looked at, beside those of exact ones.
constexpr float looseness = 0.1F;
constexpr double originUnits = 2147483648.0;  // of the box's edge: 2^31

/// The rays by the picture's slabs, as they are in a section.
RayMap raysIn(const FramePlan& plan, const DepthSection& section, const glm::dmat4& boxToEye) {
    const double thickness = section.thickness();
    return {plan, boxToEye, section.nearDepth - section.firstSlab * thickness, thickness};
}

/// Sets the rays if there is one section; else composite.comp takes them from sectionRays.
void setRays(LayerBlock& block, const RayMap& rays) {
    for (std::size_t i = 0; i < 3; ++i) {
        block.entry[i] = glm::vec4(rays.entry[i], 0.0);
        block.advance[i] = glm::vec4(rays.advance[i], 0.0);
    }
}

void setClips(LayerBlock& block, const FieldPlan& field) {
    MOTE_CHECK(field.clips.size() <= mostClips);
    block.scale.y = static_cast<float>(field.clips.size());
    for (std::size_t i = 0; i < field.clips.size(); ++i)
        block.clips[i] = glm::vec4(field.clips[i].normal, field.clips[i].distance);
}

/// Sums of weights stay below 2^32 whatever pixel the points meet in, with half a unit of rounding each.
std::uint32_t weightUnit(std::uint64_t points) {
    constexpr std::uint64_t most = 1U << 16;
    return static_cast<std::uint32_t>(
        std::clamp<std::uint64_t>(0xffffffffULL / std::max<std::uint64_t>(points, 1), 1, most));
}

/// Into how many segments the edge of a cell is cut that is cut into so many in exact pictures.
float segmentsPerCell(const FramePlan& plan, double exact) {
    return static_cast<float>(exact * std::max(0.25 * plan.samplesPerCell, 0.25));
}

}  // namespace

std::vector<LayerSlot> layerSlots(const FramePlan& plan) {
    std::vector<LayerSlot> slots;
    for (const auto& points : plan.points) slots.push_back({.points = &points});
    for (const auto& field : plan.fields) {
        if (field.density() == nullptr) continue;
        const auto own = std::find_if(slots.begin(), slots.end(), [&](const LayerSlot& slot) {
            return slot.points != nullptr && slot.points->layer == field.layer;
        });
        if (own != slots.end()) {
            own->densities = &field;
        } else {
            slots.push_back({.densities = &field});
        }
    }
    return slots;
}

PointNumbers pointNumbers(const FramePlan& plan, const PointsPlan& points) {
    const double size = points.look.size;
    const bool lit = points.look.light > 0.0, weighted = !points.selection->weights.empty();
    const double opacity = lit ? 0.0 : points.look.opacity * std::min(size * size, 1.0);
    const glm::dmat4 toScreen = boxToScreen(plan, points.boxToEye);
    // Relative to the camera's target, for a camera that comes close to something looks at it.
    const glm::dvec3 target(glm::inverse(points.boxToEye) *
                            (plan.camera.worldToEye() * glm::dvec4(plan.camera.target, 1.0)));
    const glm::uvec3 origin(glm::clamp(target, 0.0, 1.0) * (originUnits - 1.0));
    const glm::dmat4 toBox = glm::scale(glm::translate(glm::dmat4(1.0), glm::dvec3(origin) / originUnits),
                                        glm::dvec3(1.0 / originUnits));
    return {.toScreen = glm::mat4(toScreen * toBox),
            .origin = origin,
            // A little less, for rounding at the very border of the box.
            .nearest = plan.camera.perspective() ? static_cast<float>(plan.nearDepth * (1.0 - 1e-5)) : 0.0F,
            .discs = size > 1.0,
            .radius = static_cast<float>(0.5 * size + 0.5),
            .opacity = static_cast<float>(opacity),
            .tau = static_cast<float>(points.look.tauAt(1.0, lit && plan.camera.perspective())),
            .byDepth = lit && plan.camera.perspective(),
            // Weights may be those of the heaviest points of the step.
            .unit = weightUnit(weighted ? 2 * points.step->pointCount() : points.pointsDrawn)};
}

BendBlock::BendBlock(const SlabBends& slabs) : shape(slabs.bends.size(), slabs.first.firstSlab, slabs.slabs) {
    MOTE_CHECK(slabs.bends.size() <= bends.size());
    for (std::size_t i = 0; i < slabs.bends.size(); ++i)
        bends[i] = {slabs.bends[i].at, slabs.bends[i].slab, slabs.bends[i].slope};
}

void BendBlock::set(std::uint32_t program) const {
    glProgramUniform3fv(program, glGetUniformLocation(program, "bends"), static_cast<GLsizei>(bends.size()),
                        &bends[0].x);
    glProgramUniform3fv(program, glGetUniformLocation(program, "bendShape"), 1, &shape.x);
}

std::vector<glm::vec4> sectionRays(const FramePlan& plan) {
    std::vector<glm::vec4> rays;
    const auto add = [&](const DepthSection& section, const glm::dmat4& boxToEye) {
        const RayMap map = raysIn(plan, section, boxToEye);
        for (const auto& row : map.entry) rays.emplace_back(row, 0.0);
        for (const auto& row : map.advance) rays.emplace_back(row, 0.0);
    };
    const auto slots = layerSlots(plan);
    for (const auto& section : plan.sections) {
        rays.emplace_back(section.endSlab(), section.firstSlab, section.nearDepth, section.thickness());
        for (const auto& slot : slots) add(section, slot.boxToEye());
        for (std::size_t i = plan.densities(); i < plan.fields.size(); ++i)
            add(section, plan.fields[i].boxToEye);
    }
    return rays;
}

GridBlock gridBlock(const FramePlan& plan, const FieldPlan& field, const CorrectedField& samples,
                    const glm::uvec3& size, std::uint32_t firstBrick, std::uint32_t firstSlope) {
    const GridField& grid = *samples.grid;
    const ValueRange& span = field.transfer.span;
    const double scale = TransferTable::cells / (span.high - span.low);
    GridBlock block{};
    block.grid = glm::vec4(size, segmentsPerCell(plan, GridBlock::fineSegments));
    block.low = glm::vec4(grid.coarse.size, segmentsPerCell(plan, GridBlock::lowSegments));
    block.table =
        glm::vec4((grid.valueOf(1.0) - grid.valueOf(0.0)) * scale,
                  (grid.valueOf(0.0) - span.low) * scale + 1.0, samples.correction, samples.steepness);
    block.place = glm::ivec4(firstBrick, firstSlope, 0, 0);
    for (std::size_t axis = 0; axis < 3; ++axis)
        block.toLayer[axis] = glm::vec4(grid.boxToLayer[static_cast<int>(axis)]);
    block.toLayer[0].w = static_cast<float>(samples.gradient);
    return block;
}

FrameBlock frameBlock(const FramePlan& plan, PixelFormat format, std::uint32_t firstRow, std::uint32_t rows) {
    const std::uint32_t tilesAcross = (plan.width + 7) / 8;
    const double half = plan.camera.halfHeight();
    FrameBlock block{};
    block.picture = glm::ivec4(plan.width, plan.height, tilesAcross, firstRow);
    const std::uint32_t pixelRows = std::min(rows * 8, plan.height - firstRow * 8);
    block.band = glm::ivec4(tilesAcross * rows, plan.slabs, format == PixelFormat::linearHalf, pixelRows);
    block.window = glm::vec4(half * plan.width / plan.height, half, plan.samplesPerCell,
                             plan.samplesPerCell >= 2.0 ? 1.0F : looseness);
    block.background = glm::vec4(plan.background, 1.0);
    const auto blank = blankPixel(plan.background, format);
    std::memcpy(&block.blank, blank.data(), blank.size());
    const DepthSection& first = plan.sections.front();
    block.depths = glm::vec4(first.nearDepth, first.thickness(), 0.0, 0.0);
    const auto slots = layerSlots(plan);
    for (std::size_t i = 0; i < slots.size(); ++i) {
        LayerBlock& result = block.layers[i];
        result.boxToScreen = glm::mat4(boxToScreen(plan, slots[i].boxToEye()));
        setRays(result, raysIn(plan, plan.sections.front(), slots[i].boxToEye()));
        if (const FieldPlan* const field = slots[i].densities) {
            const DensityField& cells = *field->density();
            setClips(result, *field);
            result.cells = glm::vec4(cells.grid->size, cells.strength);
            for (int axis = 0; axis < 3; ++axis)
                result.edges[axis] = static_cast<float>(field->boxToLayer[axis][axis]);
        }
        if (slots[i].points == nullptr) continue;
        const PointNumbers numbers = pointNumbers(plan, *slots[i].points);
        const PointLook& look = slots[i].points->look;
        result.point = glm::vec4(look.color, numbers.tau * look.thinned);
        result.scale.x = static_cast<float>(1.0 / numbers.unit);
        result.scale.w = numbers.byDepth ? 1.0F : 0.0F;
    }
    for (std::size_t i = plan.densities(), slot = slots.size(); i < plan.fields.size(); ++i, ++slot) {
        const FieldPlan& field = plan.fields[i];
        block.layers[slot].boxToScreen = glm::mat4(boxToScreen(plan, field.boxToEye));
        setRays(block.layers[slot], raysIn(plan, plan.sections.front(), field.boxToEye));
        setClips(block.layers[slot], field);
    }
    return block;
}

}  // namespace mote::render
