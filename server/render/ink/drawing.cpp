// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/drawing.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>

#include "server/render/ink/carry.h"
#include "server/render/ink/choose_lines.h"
#include "server/render/ink/complexity.h"
#include "server/render/ink/hatch.h"
#include "server/render/ink/hatch_field.h"
#include "server/render/ink/paint/painting.h"
#include "server/render/ink/paint/wash.h"
#include "server/render/ink/pen.h"
#include "server/render/ink/segments.h"
#include "server/render/ink/show.h"
#include "server/render/ink/solid.h"
#include "server/render/ink/tone_grid.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double pieceShare = 2.0;  // of the reading distance: what is drawn or left out as one
constexpr double hatchBlur = 1.5;   // strokes' spacings over which the tone of hatches is even
// Pixels of a cell in which hatches have a direction; of the view, over which a surface's bend is told.
constexpr double leastCell = 2.0, mostCell = 8.0, fieldLength = 90.0;
constexpr double sideShare = 0.5;        // of the reading distance: tones beside a line are taken so far off
constexpr double contrast = 0.25;        // of tones that part two sides without a line, share of the paper
constexpr double besideNothing = 0.999;  // step of a line
constexpr std::size_t pixelsPerTask = std::size_t{1} << 16;  // pixels of a step

/// take(value, the pixel's middle) for each pixel.
template <class Take>
void eachPixel(Raster<float>& picture, const Take& take) {
    forInTurns(std::uint32_t{0}, picture.height, [&](std::uint32_t row) {
        for (std::uint32_t column = 0; column < picture.width; ++column)
            take(picture.at(column, row), glm::dvec2(column + 0.5, row + 0.5));
    });
}

/// How much of each pixel ink is to cover.
Raster<float> wantedOf(const Modalities& modalities, bool inkIsDark) {
    auto wanted = modalities.grey.copy();
    if (inkIsDark) eachPixel(wanted, [](float& value, const glm::dvec2&) { value = 1.0F - value; });
    return wanted;
}

/// Tells crumbs of lines: what is shorter than one and a half spacings of hatches, and has nothing longer
/// within a spacing of its middle. Outer contours are none.
class Crumbs {
  public:
    Crumbs(const std::vector<InkLine>& lines, const std::vector<HatchStroke>& strokes, const glm::uvec2& size,
           double spacing)
        : spacing_(spacing),
          inked_(static_cast<std::uint32_t>(size.x / spacing) + 1,
                 static_cast<std::uint32_t>(size.y / spacing) + 1) {
        for (const auto& line : lines) {
            giveWay();
            if (isShort(line)) continue;
            for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
                mark(line.points[i].at, line.points[i + 1].at);
        }
        for (const auto& stroke : strokes) {
            for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i)
                mark(stroke.points[i], stroke.points[i + 1]);
        }
    }

    bool has(const InkLine& line) const {
        return isShort(line) && isAlone(line.points[line.points.size() / 2].at);
    }

  private:
    static constexpr double shortest = 1.5;  // spacings

    bool isShort(const InkLine& line) const {
        double length = 0.0;
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
            if (line.points[i].step >= besideNothing) return false;
            length += glm::distance(line.points[i].at, line.points[i + 1].at);
            if (length >= shortest * spacing_) return false;
        }
        return true;
    }
    void mark(const glm::dvec2& from, const glm::dvec2& to) {
        eachSquare(from / spacing_, to / spacing_, inked_.width, inked_.height,
                   [&](std::uint32_t column, std::uint32_t row, double) { inked_.at(column, row) = 1; });
    }
    bool isAlone(const glm::dvec2& middle) const {
        for (int down = -1; down <= 1; ++down) {
            for (int across = -1; across <= 1; ++across) {
                if (inked_.near(middle.x / spacing_ + across, middle.y / spacing_ + down) != 0) return false;
            }
        }
        return true;
    }

    double spacing_;
    Raster<std::uint8_t> inked_;  // squares of a spacing
};

/// One drawing's stages.
class DrawingMaker {
  public:
    DrawingMaker(const InkScene& scene, const InkStyle& style, double pixels, const std::stop_token& stop,
                 InkMemory* memory)
        : scene_(scene),
          style_(style),
          pixels_(pixels),
          stop_(stop),
          reading_(std::max(1.0, style.reading * pixels)),
          cells_(scene.modalities.grey.width, scene.modalities.grey.height, reading_),
          wanted_(wantedOf(scene.modalities, style.inkIsDark)),
          target_(blurred(meansOf(wanted_, cells_), cells_.blur)),
          memory_(memory) {
        if (memory_ != nullptr && memory_->style == style && !memory_->depth.values.empty())
            carry_.emplace(scene.modalities, scene.camera, *memory_);
    }

    Drawing make() {
        Drawing drawing;
        drawing.strokes.color = style_.color;
        if (style_.show != InkPicture::drawing) {
            drawing.shown = shown();
            return drawing;
        }
        const bool hatches = style_.hatch.strength > 0.0 || said(RegionFill::hatch);
        const bool washes = style_.wash.everywhere || said(RegionFill::wash);
        Rest rest;
        ChosenLines chosen;
        Segments regions;
        part(hatches || washes, rest, chosen, regions);
        if (isStopped(stop_)) return drawing;
        Wash wash;
        if (washes) wash = washed(regions);
        Pen pen(scene_.modalities, {.waver = style_.waver * pixels_, .taper = style_.taper}, drawing.strokes);
        pen.fill(rest.solid.outlines, stop_);
        Raster<float> density;
        std::vector<HatchStroke> strokes;
        if (hatches) {
            density = missing(rest, chosen.density, hatchOptions().spacing, densityUnder(wash.layers));
            if (carry_) carry_->even(density);
            strokes = hatched(density, regions);
        }
        drawing.pigment = std::move(wash.pigment);
        const Crumbs crumbs(chosen.lines, strokes, {wanted_.width, wanted_.height}, hatchOptions().spacing);
        // Of a film's lines those stay that were there before.
        const bool chooses =
            style_.silhouettes.mode == SilhouetteMode::adjusted && !scene_.quick && memory_ == nullptr;
        for (const auto& line : chosen.lines) {
            giveWay();
            if (!chooses || !crumbs.has(line)) pen.draw(line, style_.silhouettes.width * pixels_);
        }
        for (const auto& stroke : strokes) {
            giveWay();
            pen.draw(stroke, style_.hatch.width * pixels_);
        }
        if (memory_ != nullptr && !isStopped(stop_))
            remember(std::move(chosen), std::move(strokes), std::move(density));
        return drawing;
    }

  private:
    /// What is drawn beside solid ink: all if there is none.
    struct Rest {
        SolidInk solid;              // without pixels where the style has none
        std::vector<InkLine> lines;  // likewise without any
        ToneGrid target;

        bool isSimple(std::size_t pixel) const {
            return solid.ground.values.empty() || solid.ground.values[pixel] == Ground::simple;
        }
    };

    /// What is inked solid, which lines are drawn, and, if they are asked for or painted, the regions.
    void part(bool needsRegions, Rest& rest, ChosenLines& chosen, Segments& regions) {
        const auto chooseRest = [&] {
            rest = inkSolid();
            chosen = choose(rest);
        };
        if (style_.regions.empty())
            return bothInTurns(chooseRest, [&] {
                if (needsRegions) regions = segments();
            });
        regions = segments();
        painting_ = Painting(scene_.modalities, scene_.camera, style_.regions, regions, stop_);
        chooseRest();
    }
    /// Whether a painted region is drawn so.
    bool said(RegionFill fill) const {
        return std::any_of(style_.regions.begin(), style_.regions.end(),
                           [fill](const auto& region) { return region.fill == fill; });
    }
    Wash washed(const Segments& regions) const {
        const bool painted = !style_.wash.everywhere || !style_.regions.empty();
        Raster<std::uint8_t> where;
        if (painted) {
            where = Raster<std::uint8_t>(wanted_.width, wanted_.height);
            for (std::size_t i = 0; i < where.values.size(); ++i) {
                const auto fill = painting_.fillAt(i);
                const bool usual = fill == RegionFill::usual && style_.wash.everywhere;
                where.values[i] = usual || fill == RegionFill::wash ? 1 : 0;
            }
        }
        return washOf({scene_.modalities, wanted_, regions, where}, style_.wash, style_.inkIsDark, reading_,
                      pixels_, stop_);
    }
    /// What layers of a wash cover, to which ink adds up; without pixels where there is none.
    Raster<float> densityUnder(const Raster<std::uint8_t>& layers) const {
        if (layers.values.empty()) return {};
        std::vector<float> densities;
        for (int count = 0; count <= style_.wash.tones; ++count) {
            const double cover = washCover(static_cast<std::uint8_t>(count), style_.wash, style_.inkIsDark);
            densities.push_back(static_cast<float>(densityOf(cover)));
        }
        Raster<float> made(layers.width, layers.height);
        for (std::size_t i = 0; i < made.values.size(); ++i) made.values[i] = densities[layers.values[i]];
        return made;
    }
    /// Of what is missing, the share that is hatched.
    double hatchedAt(std::size_t pixel) const {
        switch (painting_.fillAt(pixel)) {
            case RegionFill::usual:
                return style_.hatch.strength;
            case RegionFill::hatch:
                return style_.hatch.strength > 0.0 ? style_.hatch.strength : 1.0;
            default:
                return 0.0;
        }
    }

    Rest inkSolid() const {
        if (!(style_.solid.strength > 0.0) && !said(RegionFill::ink)) return {{}, {}, target_};
        Rest rest;
        const auto cover =
            coverOf(scene_.lines, wanted_.width, wanted_.height, style_.silhouettes.width * pixels_);
        rest.solid = solidInk({scene_.modalities, wanted_, cover, &painting_}, style_.solid, reading_, stop_);
        if (isStopped(stop_)) return {{}, {}, target_};
        rest.lines = linesBeside(scene_.lines, rest.solid.ground, scene_.modalities,
                                 {.leastStep = contourStep(), .shortest = reading_}, stop_);
        auto wanted = wanted_.copy();
        forRangesInTurns(wanted.values.size(), pixelsPerTask, [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                if (rest.solid.ground.values[i] == Ground::solid) wanted.values[i] = 0.0F;
            }
        });
        rest.target = blurred(meansOf(wanted, cells_), cells_.blur);
        return rest;
    }
    /// Of lines on paper in complex regions, only those may be drawn that always are, and those beside
    /// nothing.
    double contourStep() const { return std::min(style_.silhouettes.importance, besideNothing); }

    ChosenLines choose(const Rest& rest) const {
        const auto& lines = rest.solid.ground.values.empty() ? scene_.lines : rest.lines;
        const LineTarget target{cells_,
                                rest.target,
                                style_.silhouettes.width * pixels_,
                                pieceShare * reading_,
                                scene_.quick,
                                carry_ ? &*carry_ : nullptr};
        const bool omits = style_.silhouettes.omit;
        auto chosen = chooseLines(omits ? needed(lines) : lines, style_.silhouettes, target, stop_);
        if (!omits && style_.silhouettes.mode != SilhouetteMode::none && !isStopped(stop_))
            makeContoursWhole(scene_.field ? Raster<Sight>() : sightOf(rest), scene_.modalities.depth, target,
                              chosen, stop_);
        if (target.isOfFilm()) {
            for (auto* const some : {&chosen.lines, &chosen.left}) {
                for (auto& line : *some) simplify(line.points);
            }
        }
        return chosen;
    }
    Raster<Sight> sightOf(const Rest& rest) const {
        const auto& depth = scene_.modalities.depth;
        Raster<Sight> sight(depth.width, depth.height);
        for (std::size_t i = 0; i < sight.values.size(); ++i) {
            if (!std::isfinite(depth.values[i])) continue;
            const bool inked = !rest.isSimple(i) && rest.solid.ground.values[i] == Ground::solid;
            sight.values[i] = inked ? Sight::inked : Sight::something;
        }
        return sight;
    }
    /// Lines without those between tones that differ enough.
    std::vector<InkLine> needed(const std::vector<InkLine>& all) const {
        std::vector<InkLine> lines;
        for (const auto& line : all) {
            InkLine part{line.kind, {line.points.front()}, line.rank};
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

    HatchOptions hatchOptions() const {
        const auto& hatchStyle = style_.hatch;
        return {.spacing = std::max(1.0, hatchStyle.spacing * pixels_), .width = hatchStyle.width * pixels_};
    }
    std::vector<HatchStroke> hatched(const Raster<float>& density, const Segments& regions) const {
        const auto options = hatchOptions();
        const auto before = carry_ ? carry_->hatches() : std::vector<HatchStroke>();
        const auto field = hatchField(
            scene_.modalities, scene_.camera, regions, before,
            {.pixels = static_cast<std::uint32_t>(std::clamp(options.spacing, leastCell, mostCell)),
             .length = fieldLength * pixels_},
            stop_);
        return hatch({field, density, ContinuousSight(scene_.modalities, scene_.camera)}, before, options,
                     stop_);
    }
    Segments segments() const {
        SegmentOptions options{.method = style_.hatch.segments};
        options.leastPixels = static_cast<std::size_t>(std::max(1.0, reading_ * reading_));
        return segmentsOf(scene_.modalities, options, stop_);
    }
    Segments paintedSegments() const {
        auto regions = segments();
        const Painting painting(scene_.modalities, scene_.camera, style_.regions, regions, stop_);
        return regions;
    }
    void remember(ChosenLines chosen, std::vector<HatchStroke> hatches, Raster<float> density) {
        const auto& modalities = scene_.modalities;
        carry_.reset();
        *memory_ = {style_,
                    scene_.camera,
                    modalities.extent,
                    modalities.depth,
                    std::move(chosen.lines),
                    std::move(chosen.left),
                    std::move(hatches),
                    std::move(density)};
    }
    /// The density that lines, and the wash `under` them, leave to be hatched, where it is.
    Raster<float> missing(const Rest& rest, const ToneGrid& drawn, double spacing,
                          const Raster<float>& under) const {
        const auto& modalities = scene_.modalities;
        auto density =
            blurredWithin(wanted_, modalities.depth, modalities.extent, hatchBlur * spacing, stop_);
        auto inked = density.copy();  // once it is hatched
        eachPixel(density, [&](float& value, const glm::dvec2& place) {
            const double lines = static_cast<double>(toneAt(drawn, cells_, place));
            const auto pixel =
                inked.index(static_cast<std::uint32_t>(place.x), static_cast<std::uint32_t>(place.y));
            const double washed = under.values.empty() ? 0.0 : static_cast<double>(under.values[pixel]);
            const double more =
                hatchedAt(pixel) * std::max(0.0, densityOf(static_cast<double>(value)) - lines - washed);
            inked.values[pixel] = rest.isSimple(pixel) ? static_cast<float>(coverOf(lines + more)) : 0.0F;
            value = rest.isSimple(pixel) && std::isfinite(modalities.depth.values[pixel])
                        ? static_cast<float>(more)
                        : 0.0F;
        });
        const auto share = neededOf(rest, drawn, blurred(meansOf(inked, cells_), cells_.blur), under);
        eachPixel(density,
                  [&](float& value, const glm::dvec2& place) { value *= toneAt(share, cells_, place); });
        return density;
    }
    /// Lines are too dark in one place where they are too light in another: of what hatches would add, the
    /// share that brings the whole, blurred, to the target.
    ToneGrid neededOf(const Rest& rest, const ToneGrid& drawn, const ToneGrid& inked,
                      const Raster<float>& under) const {
        const double strength = style_.hatch.strength > 0.0 ? style_.hatch.strength : 1.0;
        const auto washed = under.values.empty() ? ToneGrid() : blurred(meansOf(under, cells_), cells_.blur);
        ToneGrid share(drawn.width, drawn.height, 1.0F);
        for (std::size_t i = 0; i < share.values.size(); ++i) {
            const double lines = coverOf(static_cast<double>(drawn.values[i]));
            double target = static_cast<double>(rest.target.values[i]);
            if (!washed.values.empty())
                target = coverOf(std::max(0.0, densityOf(target) - static_cast<double>(washed.values[i])));
            const double wanted = strength * (target - lines);
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
                return labelPicture(paintedSegments().label);
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
    InkMemory* const memory_;  // of the drawing before; or null
    std::optional<Carry> carry_;
    Painting painting_;
};

}  // namespace

Drawing drawInk(const InkScene& scene, const InkStyle& style, double pixels, const std::stop_token& stop,
                InkMemory* memory) {
    return DrawingMaker(scene, style, pixels, stop, memory).make();
}

}  // namespace mote::render
