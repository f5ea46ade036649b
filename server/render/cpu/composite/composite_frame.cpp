// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/composite/composite_frame.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "server/render/blank_picture.h"
#include "server/render/cpu/point_footprint.h"
#include "server/render/cpu/resident_fields.h"
#include "server/render/plan/point_values.h"
#include "server/render/plan/screen_map.h"

namespace mote::render {
namespace {

/// The pixels around the box's projection; all there are where that is unbounded, since the box reaches
/// behind the eye.
PixelRange screenOf(const glm::dmat4& toScreen) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    constexpr double margin = 1.0;  // for rounding
    PixelRange range{glm::dvec2(infinite), glm::dvec2(-infinite)};
    for (unsigned i = 0; i < 8; ++i) {
        const glm::dvec4 corner = toScreen * glm::dvec4(i & 1U, i >> 1 & 1U, i >> 2 & 1U, 1.0);
        if (!(corner.w > 0.0)) return {glm::dvec2(-infinite), glm::dvec2(infinite)};
        const glm::dvec2 at(corner.x / corner.w, corner.y / corner.w);
        range = {glm::min(range.low, at - margin), glm::max(range.high, at + margin)};
    }
    return range;
}

double meanSlab(const FramePlan& plan) {
    return (plan.farDepth - plan.nearDepth) / plan.slabs;
}

RayMap raysOf(const FramePlan& plan, const glm::dmat4& boxToEye) {
    return {plan, boxToEye, plan.nearDepth, meanSlab(plan)};
}

std::vector<FrameSection> sectionsOf(const FramePlan& plan) {
    std::vector<FrameSection> sections;
    const double mean = meanSlab(plan);
    for (const auto& section : plan.sections) {
        // One section is the whole, to the last bit.
        const bool only = plan.sections.size() == 1;
        sections.push_back({section.firstSlab, section.slabs, (section.nearDepth - plan.nearDepth) / mean,
                            only ? 1.0 : section.thickness() / mean});
    }
    return sections;
}

std::vector<SlabDepth> depthsOf(const FramePlan& plan) {
    std::vector<SlabDepth> depths;
    for (const auto& section : plan.sections) {
        for (std::uint32_t i = 0; i < section.slabs; ++i) {
            depths.push_back({static_cast<float>(section.nearDepth + i * section.thickness()),
                              static_cast<float>(section.thickness())});
        }
    }
    return depths;
}

std::array<std::uint32_t, 256> packedShades(const Shades& shades) {
    std::array<std::uint32_t, 256> packed{};
    const auto bits = [](float x) {
        return static_cast<std::uint32_t>(std::lround(x * GridSamples::fullShade));
    };
    for (std::size_t code = 0; code < packed.size(); ++code) {
        const auto& shade = shades[code];
        packed[code] = bits(shade.diffuse) | bits(shade.specular) << 16;
    }
    return packed;
}

/// The edge of the cube with the volume of a cell, in pixels of the picture, in the middle of the box; where
/// the eye is nearer than half the box's edge, at that distance.
double pixelsPerCell(const FramePlan& plan, const glm::dmat4& boxToEye, const glm::dvec3& cells) {
    const double volume = std::abs(glm::determinant(glm::dmat3(boxToEye)));
    const double edge = std::cbrt(volume / (cells.x * cells.y * cells.z));
    const double depth = -(boxToEye * glm::dvec4(0.5, 0.5, 0.5, 1.0)).z;
    const double away = plan.camera.perspective() ? std::max(depth, 0.5 * std::cbrt(volume)) : 1.0;
    return edge / away * plan.height / (2.0 * plan.camera.halfHeight());
}

/// Ray segments to the edge of a cell of a field of samples. At rest they bound what is leapt over and what
/// is mixed in one step. In motion they are the distances of samples: no shorter than a pixel is wide, up to
/// four cells, as what is finer no pixel shows either.
double gridSegments(const FramePlan& plan, const FieldPlan& field, const glm::dvec3& cells) {
    constexpr double least = 0.25;
    const double most = field.grid()->corrected() ? 1.25 : 6.0;
    if (plan.exact) return most;
    return std::clamp(plan.samplesPerCell * std::min(1.0, pixelsPerCell(plan, field.boxToEye, cells)), least,
                      most);
}

GridSamples gridSamples(const CorrectedField& field, const VisibleField& visible, const glm::dvec3& cells) {
    const SeenField& seen = visible.seen;
    const TransferTable& table = *seen.table;
    const GridField& grid = *field.grid;
    const glm::dvec3 coarse(grid.coarse.size), ratio = cells / coarse;
    return {
        .table = &table,
        .places = CodePlaces(grid, table),
        .coarse = &grid.coarse,
        .bricks = field.corrected() ? grid.bricks.get() : nullptr,
        .dark = visible.dark.get(),
        .correction = static_cast<float>(field.correction),
        .steepness = static_cast<float>(field.steepness),
        .slopes = seen.slopes.get(),
        .gradient = static_cast<float>(field.gradient),
        // Twice as many to a cell of the coarse grid as to one of a brick; whole, so that both meet.
        .stride = std::max(1.0F, std::floor(static_cast<float>(0.5 * std::min({ratio.x, ratio.y, ratio.z})))),
        .coarseScale = glm::vec3(coarse / cells),
        .coarseShift = glm::vec3(0.5 * coarse / cells - 0.5),
        .shades = packedShades(field.shades)};
}

/// `even`: samples a cell where they are evenly spaced.
BoxSpace spaceOf(const FramePlan& plan, const FieldPlan& field, const VisibleField& visible, double even) {
    BoxSpace space{.toLayer = field.boxToLayer, .clips = field.clips};
    if (const auto* const samples = field.grid()) {
        const GridField& grid = *samples->grid;
        space.cells = glm::dvec3(samples->corrected() ? grid.bricks->size : grid.coarse.size);
        space.shift = -0.5;
        space.samples = gridSegments(plan, field, space.cells);
    } else if (visible.volume != nullptr) {
        space.cells = glm::dvec3(visible.volume->size());
        space.shift = 0.5;
        space.samples = even;
    }
    return space;
}

/// The least edge of a cell in pixels, where the box is farthest.
double leastCell(const FramePlan& plan, const glm::dmat4& boxToEye, const glm::dvec3& cells) {
    double edge = std::numeric_limits<double>::infinity(), away = 0.0;
    for (int axis = 0; axis < 3; ++axis)
        edge = std::min(edge, glm::length(glm::dvec3(boxToEye[axis])) / cells[axis]);
    for (unsigned i = 0; i < 8; ++i)
        away = std::max(away, -(boxToEye * glm::dvec4(i & 1U, i >> 1 & 1U, i >> 2 & 1U, 1.0)).z);
    if (!plan.camera.perspective()) away = 1.0;
    return edge / std::max(away, 1e-300) * plan.height / (2.0 * plan.camera.halfHeight());
}

/// How far apart rays may be so that none of a field's cells lies between them unseen, in nodes; 0 where they
/// may not, and where there are no fields or others than densities.
std::uint8_t smoothIn(const FramePlan& plan, const std::vector<FrameField>& fields) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < fields.size(); ++i) {
        if (fields[i].grid || !fields[i].space.clips.empty()) return 0;
        least = std::min(least, leastCell(plan, plan.fields[i].boxToEye, fields[i].space.cells));
    }
    if (fields.empty() || !(least >= 2.0)) return 0;
    return least >= 8.0 ? 4 : least >= 4.0 ? 2 : 1;
}

std::vector<glm::vec3> shadesOf(const FramePlan& plan, const PointsPlan& points) {
    std::vector<glm::vec3> shades;
    if (!shadesCells(plan, points)) return shades;
    constexpr unsigned last = DensityLevels::last * FramePointLook::shadesOfLevel;
    for (unsigned i = 0; i <= last; ++i)
        shades.emplace_back(points.colors->color(static_cast<double>(i) / last));
    return shades;
}

}  // namespace

CompositeFrame::CompositeFrame(const FramePlan& plan, PixelFormat chosen,
                               const std::vector<VisibleField>& visible, const FrameColors& colors)
    : width(plan.width),
      height(plan.height),
      slabs(plan.slabs),
      sections(sectionsOf(plan)),
      depths(depthsOf(plan)),
      samplesPerCell(static_cast<float>(std::clamp(plan.samplesPerCell, 0.25, 64.0))),
      smooth(0),
      cellByCell(render::cellByCell(plan)),
      window(plan.camera.halfHeight() * plan.width / plan.height, plan.camera.halfHeight()),
      background(plan.background),
      format(chosen),
      blank(blankPixel(plan.background, chosen)),
      reach(plan, visible) {
    for (std::size_t i = 0; i < plan.points.size(); ++i) {
        const PointLook& look = plan.points[i].look;
        const bool byDepth = look.light > 0.0 && plan.camera.perspective();
        points.push_back({glm::vec3(look.color), static_cast<float>(look.tauAt(1.0, byDepth) * look.thinned),
                          byDepth, colors[i].get(), shadesOf(plan, plan.points[i])});
    }
    for (std::size_t i = 0; i < plan.fields.size(); ++i) {
        const FieldPlan& field = plan.fields[i];
        fields.push_back({.rays = raysOf(plan, field.boxToEye),
                          .screen = screenOf(boxToScreen(plan, field.boxToEye)),
                          .space = spaceOf(plan, field, visible[i], cellByCell ? 1.0 : samplesPerCell),
                          .visible = visible[i]});
        FrameField& made = fields.back();
        if (field.grid() != nullptr) made.grid = gridSamples(*field.grid(), visible[i], made.space.cells);
    }
    smooth = smoothIn(plan, fields);
}

}  // namespace mote::render
