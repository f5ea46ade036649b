// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/volume_modalities.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "server/render/layers/ink/volume_rays.h"

namespace mote::render {
namespace {

constexpr double leastOpacity = 0.02;          // of a ray that sees something
constexpr double leastAcross = 1e-3;           // of a normal's length, where it has an angle
constexpr std::uint64_t mostFine = 1U << 23U;  // pixels of a picture with four rays each
constexpr std::uint32_t between = 64;          // pixels between looks for a request to stop

/// Rows of a field's modalities, one thread's.
class RowMaker {
  public:
    RowMaker(const VolumeRays& rays, float paper, VolumeModalities& made)
        : rays_(rays), paper_(static_cast<double>(paper)), side_(made.side), made_(made) {}

    void make(std::uint32_t row, const std::stop_token& stop) {
        const std::uint32_t width = made_.modalities.grey.width;
        for (std::uint32_t column = 0; column < width; ++column) {
            if (column % between == 0 && stop.stop_requested()) return;
            makePixel(column, row);
        }
    }

  private:
    void makePixel(std::uint32_t column, std::uint32_t row) {
        double grey = 0.0;
        glm::dvec3 normal(0.0);
        float nearest = HUGE_VALF;
        for (std::uint32_t y = side_ * row; y < side_ * (row + 1); ++y) {
            for (std::uint32_t x = side_ * column; x < side_ * (column + 1); ++x) {
                const auto seen = rays_.look((x + 0.5) / side_, (y + 0.5) / side_, marks_);
                if (!(seen.opacity >= leastOpacity)) {
                    grey += paper_;
                    continue;
                }
                grey += seen.light + (1.0 - seen.opacity) * paper_;
                normal += seen.normal;
                made_.opacity.at(x, y) = static_cast<float>(seen.opacity);
                nearest = std::min(nearest, made_.depth.at(x, y) = static_cast<float>(seen.depth));
            }
        }
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
        if (glm::length(across) > leastAcross * glm::length(pixel.normal))
            made.angle.at(column, row) = static_cast<float>(std::atan2(across.y, across.x));
    }

    const VolumeRays& rays_;
    const double paper_;
    const std::uint32_t side_;
    VolumeModalities& made_;
    VolumeRays::Marks marks_;
};

VolumeModalities blank(const FramePlan& plan, float paper) {
    const std::uint32_t width = plan.width, height = plan.height;
    VolumeModalities made;
    made.modalities.grey = Raster<float>(width, height, paper);
    made.modalities.depth = Raster<float>(width, height, HUGE_VALF);
    made.modalities.angle = Raster<float>(width, height);
    made.modalities.part = Raster<std::uint32_t>(width, height, Modalities::nothing);
    made.side = plan.exact && std::uint64_t{width} * height <= mostFine ? 2 : 1;
    made.opacity = Raster<float>(made.side * width, made.side * height);
    made.depth = Raster<float>(made.side * width, made.side * height, HUGE_VALF);
    return made;
}

}  // namespace

VolumeModalities modalitiesOf(const InkVolume& volume, const glm::dmat4& transform, const InkStyle& style,
                              const FramePlan& plan, const std::stop_token& stop) {
    const float paper = style.inkIsDark ? 1.0F : 0.0F;
    auto made = blank(plan, paper);
    const VolumeRays rays(volume, transform, style.light, plan);
    const Bounds inEye = rays.visible().transformed(plan.camera.worldToEye() * transform);
    const double nearest = std::max(-inEye.max.z, nearLimit(plan.camera));
    made.modalities.extent = std::max(-inEye.min.z - nearest, 1e-300);
    if (!rays.any()) return made;
    tbb::parallel_for(std::uint32_t{0}, plan.height,
                      [&](std::uint32_t row) { RowMaker(rays, paper, made).make(row, stop); });
    return made;
}

}  // namespace mote::render
