// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/stroke_bands.h"

#include <algorithm>
#include <limits>

#include "server/render/plan/in_turns.h"

namespace mote::render {
namespace {

/// Where points lie.
struct Extent {
    double left = std::numeric_limits<double>::infinity(), right = -left;
    double top = left, bottom = -left;
    double widest = 0.0;

    void add(std::span<const StrokePoint> points) {
        for (const auto& point : points) {
            left = std::min<double>(left, point.x);
            right = std::max<double>(right, point.x);
            top = std::min<double>(top, point.y);
            bottom = std::max<double>(bottom, point.y);
            widest = std::max<double>(widest, point.width);
        }
    }
    /// The bands that it touches with all that lies within `reach`.
    PixelSpan bands(double reach, std::uint32_t width, std::uint32_t height) const {
        if (pixelsBetween(left - reach, right + reach, width).empty()) return {};
        const auto touched = pixelsBetween(top - reach, bottom + reach, height);
        if (touched.empty()) return {};
        return {touched.begin / StrokeBands::rows, (touched.end - 1) / StrokeBands::rows + 1};
    }
};

std::span<const StrokePoint> pointsOf(const Strokes& strokes, const Stroke& stroke) {
    return std::span(strokes.points).subspan(stroke.begin, stroke.end - stroke.begin);
}

}  // namespace

StrokeBands::StrokeBands(const Strokes& strokes, std::uint32_t width, std::uint32_t height)
    : reach_(strokes.lines.size()), begin_((height + rows - 1) / rows + 1) {
    const std::size_t lines = strokes.lines.size();
    std::vector<PixelSpan> touched(lines + strokes.areas.size());
    const auto touch = [&](std::size_t i) {
        Extent extent;
        if (i < lines) {
            extent.add(pointsOf(strokes, strokes.lines[i]));
            reach_[i] = 0.5 * extent.widest + 0.5;
            if (extent.widest > 0.0) touched[i] = extent.bands(reach_[i], width, height);
        } else {
            const InkArea& area = strokes.areas[i - lines];
            for (auto j = area.begin; j < area.end; ++j) extent.add(pointsOf(strokes, strokes.outlines[j]));
            touched[i] = extent.bands(0.5, width, height);
        }
    };
    constexpr std::size_t grain = 256;
    forRangesInTurns(touched.size(), grain, [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) touch(i);
    });
    for (const auto& bands : touched) {
        for (auto band = bands.begin; band < bands.end; ++band) ++begin_[band + 1];
    }
    for (std::size_t band = 1; band < begin_.size(); ++band) begin_[band] += begin_[band - 1];
    items_.resize(begin_.back());
    auto next = begin_;
    for (std::size_t i = 0; i < touched.size(); ++i) {
        for (auto band = touched[i].begin; band < touched[i].end; ++band)
            items_[next[band]++] = static_cast<std::uint32_t>(i);
    }
}

}  // namespace mote::render
