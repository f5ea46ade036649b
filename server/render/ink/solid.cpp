// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/solid.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "server/render/ink/complexity.h"
#include "server/render/ink/paint/mask.h"
#include "server/render/ink/tone_grid.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double toneBlur = 0.5;     // of the reading distance: details of a brush
constexpr float softness = 0.1F;     // of the tone around the threshold, within which outlines are exact
constexpr double crowdBlur = 2.0;    // reading distances: wider than a line is blurred
constexpr float crowded = 0.4F;      // share of what is around: half at a straight side
constexpr double lessComplex = 0.5;  // share of what is complex that is so among others
constexpr double edgeBlur = 1.0;     // pixels: rounds the steps of pixels where regions end sharply
constexpr double everyOnLine = 0.5;  // pixels between places of a line that are looked at
constexpr double mostHiddenPlaces = 65536;  // on one straight part

std::size_t leastPixels(double reading) {
    return static_cast<std::size_t>(std::max(1.0, reading * reading));
}

/// change(pixel's index) for each pixel.
template <class Change>
void eachIndex(std::uint32_t width, std::uint32_t height, const Change& change) {
    forInTurns(std::uint32_t{0}, height, [&](std::uint32_t row) {
        const std::size_t first = std::size_t{row} * width;
        for (std::size_t i = first; i < first + width; ++i) change(i);
    });
}

/// One where a picture is complex, and something is seen. Beside a lone line it is so, too, as far as this is
/// blurred: only those complex pixels count that are much of what is around them. There what is less complex
/// does as well, but no surface without lines behind a step in depth.
Raster<std::uint8_t> complexOf(const SolidScene& scene, double least, double reading,
                               const std::stop_token& stop) {
    // By name: clang 14 lets no lambda use a structured binding.
    const auto& modalities = scene.modalities;
    const auto& cover = scene.cover;
    const auto complexity = blurredWithin(cover, modalities.depth, modalities.extent, reading, stop);
    Raster<float> crowd(cover.width, cover.height);
    eachIndex(crowd.width, crowd.height, [&](std::size_t i) {
        crowd.values[i] = static_cast<double>(complexity.values[i]) >= least ? 1.0F : 0.0F;
    });
    const ToneCells cells(cover.width, cover.height, crowdBlur * reading);
    const auto around = blurred(meansOf(crowd, cells), cells.blur);
    Raster<std::uint8_t> mask(cover.width, cover.height);
    eachIndex(mask.width, mask.height, [&](std::size_t i) {
        const std::size_t column = i % mask.width, row = i / mask.width;
        const glm::dvec2 middle(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5);
        const bool counts = toneAt(around, cells, middle) >= crowded &&
                            static_cast<double>(complexity.values[i]) >= lessComplex * least;
        mask.values[i] = counts && std::isfinite(modalities.depth.values[i]) ? 1 : 0;
    });
    dropSpecksAndHoles(mask, leastPixels(reading), stop);
    return mask;
}

/// Above 0 what is to be solid: what is dark where it is complex, and what is painted so.
Raster<float> excessOf(const SolidScene& scene, const Raster<std::uint8_t>& complex, const SolidStyle& style,
                       double reading, const std::stop_token& stop) {
    const auto tone = blurredWithin(scene.wanted, scene.modalities.depth, scene.modalities.extent,
                                    toneBlur * reading, stop);
    Raster<float> excess(complex.width, complex.height);
    const auto threshold = static_cast<float>(1.0 - style.strength);
    eachIndex(complex.width, complex.height, [&](std::size_t i) {
        const auto fill = scene.fillAt(i);
        if (fill != RegionFill::usual)
            excess.values[i] = fill == RegionFill::ink ? 1.0F : -1.0F;
        else
            excess.values[i] = complex.values[i] == 0
                                   ? -1.0F
                                   : std::clamp((tone.values[i] - threshold) / softness, -1.0F, 1.0F);
    });
    return excess;
}

/// Where a line's parts are looked at.
class LineParting {
  public:
    LineParting(const Raster<Ground>& ground, const Modalities& modalities, const BesideOptions& options)
        : ground_(ground), modalities_(modalities), options_(options) {}

    void add(const InkLine& line, std::vector<InkLine>& out) {
        kind_ = line.kind;
        rank_ = line.rank;
        cut_ = false;
        drawn_ = isDrawn(line.points.front().at, line.points.front().step);
        begin(line.points.front());
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
            walk(line.points[i], line.points[i + 1], out);
        finish(out);
    }

  private:
    bool isDrawn(const glm::dvec2& place, double step) const {
        const Ground ground = groundBeside(place);
        return ground == Ground::simple || (ground == Ground::paper && step > options_.leastStep);
    }
    Ground groundBeside(const glm::dvec2& place) const {
        Ground ground = ground_.near(place.x, place.y);
        float nearest = modalities_.depth.near(place.x, place.y);
        for (const double y : {-1.0, 0.0, 1.0}) {
            for (const double x : {-1.0, 0.0, 1.0}) {
                const float depth = modalities_.depth.near(place.x + x, place.y + y);
                if (!(depth < nearest)) continue;
                nearest = depth;
                ground = ground_.near(place.x + x, place.y + y);
            }
        }
        return ground;
    }
    void walk(const LinePoint& from, const LinePoint& to, std::vector<InkLine>& out) {
        const auto parts = static_cast<int>(
            std::clamp(std::ceil(glm::distance(from.at, to.at) / everyOnLine), 1.0, mostHiddenPlaces));
        for (int part = 0; part < parts; ++part) {
            const double share = (part + 0.5) / parts;
            const bool drawn = isDrawn(glm::mix(from.at, to.at, share), from.step);
            if (drawn == drawn_) continue;
            const double cut = static_cast<double>(part) / parts;
            const LinePoint place{glm::mix(from.at, to.at, cut), std::lerp(from.depth, to.depth, cut),
                                  from.step};
            points_.push_back(place);
            cut_ = true;
            finish(out);
            drawn_ = drawn;
            begin(place);
        }
        points_.push_back(to);
    }
    void begin(const LinePoint& point) { points_.assign(1, point); }
    void finish(std::vector<InkLine>& out) {
        double length = 0.0;
        for (std::size_t i = 0; i + 1 < points_.size(); ++i)
            length += glm::distance(points_[i].at, points_[i + 1].at);
        if (!drawn_ || !(length > 0.0) || (cut_ && length < options_.shortest)) return;
        out.push_back({kind_, points_, rank_});
    }

    const Raster<Ground>& ground_;
    const Modalities& modalities_;
    const BesideOptions options_;
    float rank_ = 0.0F;
    LineKind kind_ = LineKind::silhouette;
    bool drawn_ = false;  // the part that is looked at
    bool cut_ = false;    // the line before it or behind
    std::vector<LinePoint> points_;
};

}  // namespace

SolidInk solidInk(const SolidScene& scene, const SolidStyle& style, double reading,
                  const std::stop_token& stop) {
    const std::uint32_t width = scene.wanted.width, height = scene.wanted.height;
    const bool chosen = style.strength > 0.0;  // else only what is painted is inked
    const auto complex =
        chosen ? complexOf(scene, style.complexity, reading, stop) : Raster<std::uint8_t>(width, height);
    auto excess = excessOf(scene, complex, style, reading, stop);
    if (isStopped(stop)) return {};
    excess = blurred(excess, edgeBlur);
    Raster<std::uint8_t> solid(width, height);
    eachIndex(width, height, [&](std::size_t i) { solid.values[i] = excess.values[i] > 0.0F ? 1 : 0; });
    if (chosen) dropSpecksAndHoles(solid, leastPixels(reading), stop);
    SolidInk made{Raster<Ground>(width, height), {}};
    eachIndex(width, height, [&](std::size_t i) {
        const std::uint8_t inked = excess.values[i] > 0.0F ? 1 : 0;
        const auto fill = scene.fillAt(i);
        if (fill != RegionFill::usual) solid.values[i] = inked;  // what is painted is no speck
        if (solid.values[i] != inked) excess.values[i] = solid.values[i] != 0 ? 1.0F : -1.0F;
        if (solid.values[i] != 0)
            made.ground.values[i] = Ground::solid;
        else if (complex.values[i] != 0 && fill == RegionFill::usual)
            made.ground.values[i] = Ground::paper;
    });
    made.outlines = contoursOf(excess, std::numeric_limits<float>::min(), stop);
    return made;
}

std::vector<InkLine> linesBeside(const std::vector<InkLine>& lines, const Raster<Ground>& ground,
                                 const Modalities& modalities, const BesideOptions& options,
                                 const std::stop_token& stop) {
    std::vector<InkLine> made;
    LineParting parting(ground, modalities, options);
    for (const auto& line : lines) {
        if (isStopped(stop)) break;
        parting.add(line, made);
    }
    return made;
}

}  // namespace mote::render
