// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/point_stream.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

namespace mote::render {
namespace {

constexpr std::size_t streamedLeaves = 4096;

/// A position in a cell of `level`, rounded down to steps of the whole box.
std::uint16_t inBox(std::uint32_t cell, std::uint16_t position, std::uint32_t level) {
    return static_cast<std::uint16_t>((cell << 16 | position) >> level);
}

/// `told`: the scale of the points' densities.
LevelLine levelsOf(const PointsPlan& layer, const LogDensity& told) {
    if (!layer.colors || !layer.colors->shade) return {};
    return LevelLine::ofPreview(*layer.colors->shade, told, layer.step->logDensity());
}

}  // namespace

bool PointStream::serves(const FramePlan& plan, const PointsPlan& layer, const PointMap& map) {
    if (plan.exact || !layer.leavesInView.empty() || !layer.selection->weights.empty()) return false;
    if (layer.selection->points == 0 || layer.selection->points > mostPoints) return false;
    // Sixteen steps a pixel, where the box is nearest.
    constexpr double most = 65536.0 / 16.0;
    return map.longestEdge() <= most;
}

std::span<const storage::PreviewPoint> PointStream::of(const PointsPlan& layer,
                                                       std::span<const LeafCell> cells) {
    if (selection_.lock() == layer.selection) return points_;
    selection_.reset();
    const auto leaves = layer.step->leaves();
    const auto& drawn = layer.selection->drawn;
    const std::size_t chunks = (cells.size() + streamedLeaves - 1) / streamedLeaves;
    std::vector<std::size_t> begin(chunks + 1, 0);
    for (std::size_t i = 0; i < cells.size(); ++i) begin[i / streamedLeaves + 1] += drawn[i];
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) begin[chunk + 1] += begin[chunk];
    points_.resize(begin.back());
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
        auto* out = points_.data() + begin[chunk];
        const std::size_t end = std::min(cells.size(), (chunk + 1) * streamedLeaves);
        for (std::size_t i = chunk * streamedLeaves; i < end; ++i) {
            if (drawn[i] == 0) continue;
            const LeafCell cell = cells[i];
            const std::uint16_t told = layer.selection->levelOf(i);
            const std::uint32_t level = cellLevel(cell);
            for (const auto& p : layer.step->positions(leaves.pointBegin[i], drawn[i])) {
                *out++ = {inBox(cellX(cell), p.x, level), inBox(cellY(cell), p.y, level),
                          inBox(cellZ(cell), p.z, level), told};
            }
        }
    });
    selection_ = layer.selection;
    return points_;
}

PreviewBlocks::PreviewBlocks(const PointsPlan& layer) : selection_(layer.preview.get()) {
    if (selection_ == nullptr) return;
    const storage::Preview preview = layer.step->preview(selection_->points);
    points_ = preview.points;
    threshold_ = preview.threshold;
    levels_ = levelsOf(layer, preview.scale);
}

PreviewBlocks::PreviewBlocks(std::span<const storage::PreviewPoint> points)
    : points_(points), levels_{1.0F, 0.0F} {}

PreviewRun PreviewBlocks::block(std::size_t index) const {
    static constexpr PreviewSelection all{.points = 0, .limit = {}};
    const std::size_t begin = index * blockPoints;
    return {.points = points_.data() + begin,
            .count = std::min(blockPoints, points_.size() - begin),
            .limit = selection_ != nullptr ? selection_->limit.data() : all.limit.data(),
            .threshold = selection_ != nullptr ? threshold_[index] : 0.0F,
            .levels = levels_};
}

}  // namespace mote::render
