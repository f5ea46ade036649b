// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/volume_modalities.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "server/render/layers/ink/volume_lines.h"
#include "server/render/layers/ink/volume_rays.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double leastOpacity = 0.02;          // of a ray that sees something
constexpr double leastAcross = 1e-3;           // of a normal's length, if it has an angle
constexpr std::uint64_t mostFine = 1U << 23U;  // pixels of a picture with four rays in some
constexpr float evenOpacity = 0.1F;            // around a pixel of which one ray tells enough
constexpr std::uint32_t between = 64;          // pixels between looks for a request to stop

/// Parts of rows of a field's modalities, one thread's.
class RowMaker {
  public:
    struct Part {
        std::uint32_t row, from, to;  ///< columns
    };

    RowMaker(const VolumeRays& rays, float paper, VolumeModalities& made)
        : rays_(rays), paper_(static_cast<double>(paper)), side_(made.side), made_(made) {}

    void make(const Part& part, const std::stop_token& stop) {
        const auto [row, from, to] = part;
        for (std::uint32_t column = from; column < to; ++column) {
            if (column % between == 0 && isStopped(stop)) return;
            makePixel(column, row);
        }
    }

    /// Where one ray a pixel sees no detail its values are good for all.
    void refine(const VolumeModalities& first, const Part& part, const std::stop_token& stop) {
        const auto [row, from, to] = part;
        for (std::uint32_t column = from; column < to; ++column) {
            if (column % between == 0 && isStopped(stop)) return;
            if (detailed(first, column, row)) {
                clear(column, row);
                makePixel(column, row);
            } else {
                copy(first, column, row);
            }
        }
    }

  private:
    /// Whether one of the pixels around sees something else.
    static bool detailed(const VolumeModalities& first, std::uint32_t column, std::uint32_t row) {
        const auto& opacity = first.opacity;
        const float own = opacity.at(column, row), depth = first.depth.at(column, row);
        const auto even = static_cast<float>(0.5 * leastDepthStep * first.modalities.extent);
        const std::uint32_t right = std::min(column + 1, opacity.width - 1),
                            bottom = std::min(row + 1, opacity.height - 1);
        for (std::uint32_t y = row > 0 ? row - 1 : 0; y <= bottom; ++y) {
            for (std::uint32_t x = column > 0 ? column - 1 : 0; x <= right; ++x) {
                const float other = opacity.at(x, y);
                const bool surface = other >= surfaceOpacity;
                if (surface != (own >= surfaceOpacity) || std::abs(other - own) > evenOpacity) return true;
                if (surface && std::abs(first.depth.at(x, y) - depth) > even) return true;
            }
        }
        return false;
    }
    template <class Take>
    void eachRay(std::uint32_t column, std::uint32_t row, const Take& take) const {
        for (std::uint32_t y = side_ * row; y < side_ * (row + 1); ++y) {
            for (std::uint32_t x = side_ * column; x < side_ * (column + 1); ++x) take(x, y);
        }
    }
    void copy(const VolumeModalities& first, std::uint32_t column, std::uint32_t row) {
        eachRay(column, row, [&](std::uint32_t x, std::uint32_t y) {
            made_.opacity.at(x, y) = first.opacity.at(column, row);
            made_.depth.at(x, y) = first.depth.at(column, row);
        });
    }
    /// The one ray that was seen there.
    void clear(std::uint32_t column, std::uint32_t row) {
        made_.modalities.angle.at(column, row) = made_.modalities.across.at(column, row) = 0.0F;
        made_.modalities.part.at(column, row) = Modalities::nothing;
    }
    void makePixel(std::uint32_t column, std::uint32_t row) {
        double grey = 0.0;
        glm::dvec3 normal(0.0);
        float nearest = HUGE_VALF;
        eachRay(column, row, [&](std::uint32_t x, std::uint32_t y) {
            const auto seen = rays_.look((x + 0.5) / side_, (y + 0.5) / side_, leastOpacity, scratch_);
            if (!(seen.opacity >= leastOpacity)) {
                grey += paper_;
                return;
            }
            grey += seen.light + (1.0 - seen.opacity) * paper_;
            normal += seen.normal;
            made_.opacity.at(x, y) = static_cast<float>(seen.opacity);
            nearest = std::min(nearest, made_.depth.at(x, y) = static_cast<float>(seen.depth));
        });
        put(column, row, {grey / (side_ * side_), nearest, normal});
    }
    struct Pixel {
        double grey;
        float depth;
        glm::dvec3 normal;
    };
    void put(std::uint32_t column, std::uint32_t row, const Pixel& pixel) {
        auto& made = made_.modalities;
        made.grey.at(column, row) = static_cast<float>(pixel.grey);
        made.depth.at(column, row) = pixel.depth;
        if (!std::isfinite(pixel.depth)) return;
        made.part.at(column, row) = 0;
        const glm::dvec2 across(pixel.normal.x, -pixel.normal.y);
        const double length = glm::length(pixel.normal), sine = glm::length(across);
        if (!(sine > leastAcross * length)) return;
        made.angle.at(column, row) = angleOf(across);
        made.across.at(column, row) = static_cast<float>(std::copysign(sine / length, pixel.normal.z));
    }

    const VolumeRays& rays_;
    const double paper_;
    const std::uint32_t side_;
    VolumeModalities& made_;
    VolumeRays::Scratch scratch_;
};

/// The means of rays in each pixel.
Raster<float> opacityOf(const VolumeModalities& seen) {
    Raster<float> made(seen.modalities.grey.width, seen.modalities.grey.height);
    const float each = 1.0F / static_cast<float>(seen.side * seen.side);
    for (std::uint32_t y = 0; y < seen.opacity.height; ++y) {
        giveWay();
        for (std::uint32_t x = 0; x < seen.opacity.width; ++x)
            made.at(x / seen.side, y / seen.side) += each * seen.opacity.at(x, y);
    }
    return made;
}

void dropRims(float paper, VolumeModalities& made) {
    const auto rims = rimsOf(opacityOf(made));
    auto& modalities = made.modalities;
    for (std::size_t i = 0; i < rims.values.size(); ++i) {
        if (rims.values[i] == 0) continue;
        modalities.grey.values[i] = paper;
        modalities.depth.values[i] = HUGE_VALF;
        modalities.angle.values[i] = modalities.across.values[i] = 0.0F;
        modalities.part.values[i] = Modalities::nothing;
    }
}

/// One ray a pixel.
VolumeModalities blank(const FramePlan& plan, float paper) {
    const std::uint32_t width = plan.width, height = plan.height;
    VolumeModalities made;
    made.modalities.grey = Raster<float>(width, height, paper);
    made.modalities.depth = Raster<float>(width, height, HUGE_VALF);
    made.modalities.angle = Raster<float>(width, height);
    made.modalities.part = Raster<std::uint32_t>(width, height, Modalities::nothing);
    made.modalities.across = Raster<float>(width, height);
    made.opacity = Raster<float>(width, height);
    made.depth = Raster<float>(width, height, HUGE_VALF);
    return made;
}

/// Four rays in each pixel around which one sees that there is more.
VolumeModalities refined(const VolumeRays& rays, float paper, VolumeModalities first,
                         const std::stop_token& stop) {
    const std::uint32_t width = first.opacity.width, height = first.opacity.height;
    VolumeModalities made{.modalities = std::move(first.modalities),
                          .side = 2,
                          .opacity = Raster<float>(2 * width, 2 * height),
                          .depth = Raster<float>(2 * width, 2 * height, HUGE_VALF)};
    first.modalities.extent = made.modalities.extent;
    forPixelsInTurns(width, height, [&](std::uint32_t row, std::uint32_t from, std::uint32_t to) {
        RowMaker(rays, paper, made).refine(first, {row, from, to}, stop);
    });
    return made;
}

}  // namespace

VolumeModalities modalitiesOf(const InkVolume& volume, const glm::dmat4& transform, const InkStyle& style,
                              const FramePlan& plan, const std::stop_token& stop,
                              std::vector<InkLine>* lines) {
    const float paper = style.inkIsDark ? 1.0F : 0.0F;
    auto made = blank(plan, paper);
    VolumeRays rays(volume, transform, style.light, plan);
    const Bounds inEye = rays.visible().transformed(plan.camera.worldToEye() * transform);
    const double nearest = std::max(-inEye.max.z, nearLimit(plan.camera));
    made.modalities.extent = std::max(-inEye.min.z - nearest, 1e-300);
    if (!rays.any()) return made;
    rays.findSpans();
    forPixelsInTurns(plan.width, plan.height, [&](std::uint32_t row, std::uint32_t from, std::uint32_t to) {
        RowMaker(rays, paper, made).make({row, from, to}, stop);
    });
    if (isStopped(stop)) return made;
    if (plan.exact && std::uint64_t{plan.width} * plan.height <= mostFine)
        made = refined(rays, paper, std::move(made), stop);
    if (isStopped(stop)) return made;
    bothInTurns([&] { dropRims(paper, made); },
                [&] {
                    if (lines != nullptr) *lines = linesOf(made, stop);
                });
    return made;
}

std::optional<double> depthAt(const InkVolume& volume, const glm::dmat4& transform, const InkStyle& style,
                              const FramePlan& plan, glm::dvec2 at) {
    const VolumeRays rays(volume, transform, style.light, plan);
    if (!rays.any()) return std::nullopt;
    VolumeRays::Scratch scratch;
    const auto seen = rays.look(at.x, at.y, leastOpacity, scratch);
    return seen.opacity >= leastOpacity ? std::optional(seen.depth) : std::nullopt;
}

}  // namespace mote::render
