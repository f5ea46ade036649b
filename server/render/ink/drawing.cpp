// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/drawing.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "server/render/ink/choose_lines.h"
#include "server/render/ink/complexity.h"
#include "server/render/ink/hatch.h"
#include "server/render/ink/pen.h"
#include "server/render/ink/segments.h"
#include "server/render/ink/show.h"
#include "server/render/ink/tone.h"

namespace mote::render {
namespace {

constexpr double pieceShare = 2.0;  // of the reading distance: what is drawn or left out as one
constexpr double hatchBlur = 1.5;   // strokes' spacings over which the tone of hatches is even
constexpr double sideShare = 0.5;   // of the reading distance: tones beside a line are taken so far off
constexpr double contrast = 0.25;   // of tones that part two sides without a line, share of the paper

/// How much of each pixel ink is to cover.
Raster<float> wantedOf(const Modalities& modalities, bool inkIsDark) {
    Raster<float> wanted = modalities.grey;
    if (inkIsDark) {
        for (auto& value : wanted.values) value = 1.0F - value;
    }
    return wanted;
}

/// take(value, the pixel's middle) for each pixel.
template <class Take>
void eachPixel(Raster<float>& picture, const Take& take) {
    tbb::parallel_for(std::uint32_t{0}, picture.height, [&](std::uint32_t row) {
        for (std::uint32_t column = 0; column < picture.width; ++column)
            take(picture.at(column, row), glm::dvec2(column + 0.5, row + 0.5));
    });
}

/// One drawing's stages.
class DrawingMaker {
  public:
    DrawingMaker(const InkScene& scene, const InkStyle& style, double pixels, const std::stop_token& stop)
        : scene_(scene),
          style_(style),
          pixels_(pixels),
          stop_(stop),
          reading_(std::max(1.0, style.reading * pixels)),
          cells_(scene.modalities.grey.width, scene.modalities.grey.height, reading_),
          wanted_(wantedOf(scene.modalities, style.inkIsDark)),
          target_(blurred(meansOf(wanted_, cells_), cells_.blur)) {}

    Drawing make() {
        Drawing drawing;
        drawing.strokes.color = style_.color;
        if (style_.show != InkPicture::drawing) {
            drawing.shown = shown();
            return drawing;
        }
        ChosenLines chosen;
        Segments regions;
        const bool hatches = style_.hatch.strength > 0.0;
        tbb::parallel_invoke([&] { chosen = choose(); },
                             [&] {
                                 if (hatches) regions = segments();
                             });
        Pen pen(scene_.modalities, {.waver = style_.waver * pixels_, .taper = style_.taper}, drawing.strokes);
        for (const auto& line : chosen.lines) pen.draw(line, style_.silhouettes.width * pixels_);
        if (!hatches) return drawing;
        for (const auto& stroke : hatched(regions, chosen.density))
            pen.draw(stroke, style_.hatch.width * pixels_);
        return drawing;
    }

  private:
    LineTarget lineTarget() const {
        return {cells_, target_, style_.silhouettes.width * pixels_, pieceShare * reading_};
    }
    ChosenLines choose() const {
        if (!style_.silhouettes.omit)
            return chooseLines(scene_.lines, style_.silhouettes, lineTarget(), stop_);
        return chooseLines(needed(), style_.silhouettes, lineTarget(), stop_);
    }
    /// Lines without those between tones that differ enough.
    std::vector<InkLine> needed() const {
        std::vector<InkLine> lines;
        for (const auto& line : scene_.lines) {
            InkLine part{line.kind, {line.points.front()}};
            for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
                if (parted(line.points[i].at, line.points[i + 1].at)) {
                    if (part.points.size() > 1) lines.push_back(part);
                    part.points.clear();
                }
                part.points.push_back(line.points[i + 1]);
            }
            if (part.points.size() > 1) lines.push_back(part);
        }
        return lines;
    }
    bool parted(const glm::dvec2& from, const glm::dvec2& to) const {
        const glm::dvec2 way = to - from;
        const double length = glm::length(way);
        if (!(length > 0.0)) return false;
        const glm::dvec2 off = sideShare * reading_ / length * glm::dvec2(-way.y, way.x);
        const glm::dvec2 one = 0.5 * (from + to) + off, other = 0.5 * (from + to) - off;
        return std::abs(wanted_.near(one.x, one.y) - wanted_.near(other.x, other.y)) >=
               static_cast<float>(contrast);
    }

    std::vector<HatchStroke> hatched(const Segments& segments, const ToneGrid& drawn) const {
        const auto& hatchStyle = style_.hatch;
        const HatchOptions options{.spacing = std::max(1.0, hatchStyle.spacing * pixels_),
                                   .width = hatchStyle.width * pixels_,
                                   .shortest = std::max(2.0, 2.0 * hatchStyle.width * pixels_)};
        const auto density = missing(drawn, options.spacing);
        return hatch({segments.label, segments.count, scene_.modalities.angle, density}, options, stop_);
    }
    Segments segments() const {
        SegmentOptions options{.method = style_.hatch.segments};
        options.leastPixels = static_cast<std::size_t>(std::max(1.0, reading_ * reading_));
        return segmentsOf(scene_.modalities, options, stop_);
    }
    /// The density that lines leave to be hatched.
    Raster<float> missing(const ToneGrid& drawn, double spacing) const {
        const auto& modalities = scene_.modalities;
        auto density = blurredWithin(wanted_, modalities.depth, modalities.extent, hatchBlur * spacing);
        auto inked = density;  // once it is hatched
        eachPixel(density, [&](float& value, const glm::dvec2& place) {
            const double lines = static_cast<double>(toneAt(drawn, cells_, place));
            const double more =
                style_.hatch.strength * std::max(0.0, densityOf(static_cast<double>(value)) - lines);
            inked.values[inked.index(static_cast<std::uint32_t>(place.x),
                                     static_cast<std::uint32_t>(place.y))] =
                static_cast<float>(coverOf(lines + more));
            value = static_cast<float>(more);
        });
        const auto share = neededOf(drawn, blurred(meansOf(inked, cells_), cells_.blur));
        eachPixel(density,
                  [&](float& value, const glm::dvec2& place) { value *= toneAt(share, cells_, place); });
        return density;
    }
    /// Lines are too dark in one place where they are too light in another: of what hatches would add, the
    /// share that brings the whole, blurred, to the target.
    ToneGrid neededOf(const ToneGrid& drawn, const ToneGrid& inked) const {
        ToneGrid share(drawn.width, drawn.height, 1.0F);
        for (std::size_t i = 0; i < share.values.size(); ++i) {
            const double lines = coverOf(static_cast<double>(drawn.values[i]));
            const double wanted = style_.hatch.strength * (static_cast<double>(target_.values[i]) - lines);
            const double added = static_cast<double>(inked.values[i]) - lines;
            if (added > wanted) share.values[i] = static_cast<float>(std::max(0.0, wanted) / added);
        }
        return share;
    }

    Raster<float> complexity() const {
        const auto& modalities = scene_.modalities;
        const auto cover = coverOf(scene_.lines, modalities.grey.width, modalities.grey.height,
                                   style_.silhouettes.width * pixels_);
        return blurredWithin(cover, modalities.depth, modalities.extent, reading_);
    }
    Raster<glm::vec3> shown() const {
        const auto& modalities = scene_.modalities;
        const std::uint32_t width = modalities.grey.width, height = modalities.grey.height;
        const double lineWidth = style_.silhouettes.width * pixels_;
        switch (style_.show) {
            case InkPicture::depth:
                return depthPicture(modalities);
            case InkPicture::angle:
                return anglePicture(modalities);
            case InkPicture::edges:
                return paperPicture(coverOf(scene_.lines, width, height, lineWidth));
            case InkPicture::complexity:
                return greyPicture(complexity());
            case InkPicture::segments:
                return labelPicture(segments().label);
            case InkPicture::target:
                return paperPicture(spread(target_, cells_, width, height));
            case InkPicture::lighten:
                return greyPicture(spread(tooDark(1.0), cells_, width, height));
            case InkPicture::darken:
                return greyPicture(spread(tooDark(-1.0), cells_, width, height));
            default:
                return greyPicture(modalities.grey);
        }
    }
    /// By how much all lines are darker than the target, or lighter.
    ToneGrid tooDark(double side) const {
        auto grid = densityOf(scene_.lines, cells_, style_.silhouettes.width * pixels_);
        for (std::size_t i = 0; i < grid.values.size(); ++i) {
            const double off =
                coverOf(static_cast<double>(grid.values[i])) - static_cast<double>(target_.values[i]);
            grid.values[i] = static_cast<float>(std::clamp(side * off, 0.0, 1.0));
        }
        return grid;
    }

    const InkScene& scene_;
    const InkStyle& style_;
    const double pixels_;
    const std::stop_token& stop_;
    const double reading_;  // pixels of the scene
    const ToneCells cells_;
    const Raster<float> wanted_;
    const ToneGrid target_;
};

}  // namespace

Drawing drawInk(const InkScene& scene, const InkStyle& style, double pixels, const std::stop_token& stop) {
    return DrawingMaker(scene, style, pixels, stop).make();
}

}  // namespace mote::render
