// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/paint/wash.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/vec2.hpp>
#include <utility>
#include <vector>

#include "protocol/scene/srgb.h"
#include "server/render/ink/complexity.h"
#include "server/render/ink/paint/mask.h"
#include "server/render/ink/tone_grid.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

// Lengths are in units of a sixth of the reading distance: pixels of a picture of 720 lines.
constexpr double unitsOfReading = 6.0;
constexpr double washBlur = 6.0;      // standard deviation of the tone that layers follow
constexpr double outlineBlur = 0.8;   // of the distance to an edge: rounds the steps of pixels
constexpr double leastRegion = 80.0;  // square units of a layer, or of a gap in it
constexpr double waterReach = 24.0;   // from an edge, beyond which water has left no trace
constexpr double gouache = 0.92;      // opacity of all layers of opaque pigment together
constexpr float leastPigment = 2e-3F;

// Where water goes (after Curtis and others 1997, Computer-Generated Watercolor, and Bousseau and others
// 2006, Interactive Watercolor Rendering with Temporal Coherence and Abstraction).
constexpr float longWave = 30.0F, shortWave = 8.0F;  // of outlines off their way
constexpr float crisp = 0.7F, soft = 11.0F;          // half of an edge's width, on dry paper and on wet
constexpr float wetPatch = 60.0F;                    // size of what stays wet while the next layer comes
constexpr float rim = 1.3F, drained = 10.0F;         // width of the dark edge; of what it was drained of
constexpr float rimMore = 2.4F, drainedLess = 0.3F;  // pigment there, of the layer's
constexpr float flowSize = 80.0F, flowMore = 1.0F;   // of pigment that is laid unevenly
constexpr float grainSize = 2.6F, grainMore = 1.1F;  // of the paper's hills
constexpr double partingStep = 0.01;  // of the extent, where one region ends and another begins
constexpr float partGap = 0.7F;       // of the bleed: how far layers of two regions lie over each other
constexpr double early = 0.3;         // of the way to a layer's lightness, where it begins

/// Smooth noise between -1 and 1 with a feature in each unit square: of the picture's plane, which lies
/// still whatever is drawn on it (Perlin 1985, An Image Synthesizer; values at the corners). `seed`: each
/// has noise of its own.
float noiseAt(const glm::vec2& place, std::uint32_t seed) {
    const float left = std::floor(place.x), top = std::floor(place.y);
    const auto column = static_cast<std::int32_t>(left), row = static_cast<std::int32_t>(top);
    const auto corner = [&](std::int32_t right, std::int32_t down) {
        std::uint32_t mixed = (static_cast<std::uint32_t>(column + right) * 0x8DA6B343U) ^
                              (static_cast<std::uint32_t>(row + down) * 0xD8163841U) ^ (seed * 0xCB1AB31FU);
        mixed = (mixed ^ (mixed >> 16U)) * 0x7FEB352DU;
        mixed = (mixed ^ (mixed >> 15U)) * 0x846CA68BU;
        return static_cast<float>((mixed ^ (mixed >> 16U)) >> 8U) * 0x1p-23F - 1.0F;
    };
    const auto ease = [](float share) {
        return share * share * share * (share * (share * 6.0F - 15.0F) + 10.0F);
    };
    const float across = ease(place.x - left), down = ease(place.y - top);
    const float above = corner(0, 0) + across * (corner(1, 0) - corner(0, 0));
    const float below = corner(0, 1) + across * (corner(1, 1) - corner(0, 1));
    return above + down * (below - above);
}

/// In octaves, each of half the size and half the height of the one before; seldom beyond -1 to 1.
float roughNoiseAt(glm::vec2 place, std::uint32_t seed, int octaves) {
    float sum = 0.0F, height = 1.0F, heights = 0.0F;
    place = {0.8F * place.x + 0.6F * place.y, 0.8F * place.y - 0.6F * place.x};
    for (int octave = 0; octave < octaves; ++octave) {
        sum += height * noiseAt(place, seed + 101U * static_cast<std::uint32_t>(octave));
        heights += height;
        height *= 0.5F;
        // Turned, so that the squares of octaves do not lie on one another.
        place = {1.6F * place.x + 1.2F * place.y, 1.6F * place.y - 1.2F * place.x};
    }
    return 1.4F * sum / heights;
}

float smoothstep(float from, float to, float at) {
    const float share = std::clamp((at - from) / (to - from), 0.0F, 1.0F);
    return share * share * (3.0F - 2.0F * share);
}

/// As the eye has it (CIE 1976 L*), 0 to 1, and back.
double lightnessOf(double luminance) {
    return luminance > 0.008856 ? 1.16 * std::cbrt(luminance) - 0.16 : 9.033 * luminance;
}
double luminanceOf(double lightness) {
    return lightness > 0.08 ? std::pow((lightness + 0.16) / 1.16, 3.0) : lightness / 9.033;
}

/// What is covered where each next layer begins: where it is wanted a little darker than without it, as the
/// eye has it. So paper is left for what is lightest, and ink takes nothing back.
std::vector<float> beginsOf(const WashStyle& style, bool inkIsDark) {
    std::vector<float> begins;
    if (!(style.strength > 0.0)) return begins;
    const auto lightness = [&](int layers) {
        const double cover = washCover(static_cast<std::uint8_t>(layers), style, inkIsDark);
        return lightnessOf(inkIsDark ? 1.0 - cover : cover);
    };
    for (int layer = 1; layer <= style.tones; ++layer) {
        const double between = luminanceOf(std::lerp(lightness(layer - 1), lightness(layer), early));
        begins.push_back(static_cast<float>((inkIsDark ? 1.0 - between : between) / style.strength));
    }
    return begins;
}

/// Lays the layers of one wash.
class Washing {
  public:
    Washing(const WashScene& scene, const WashStyle& style, double unit, double pixels,
            const std::stop_token& stop)
        : scene_(scene),
          style_(style),
          width_(scene.wanted.width),
          height_(scene.wanted.height),
          unit_(unit),
          bleed_(static_cast<float>(style.bleed * pixels / unit)),
          most_((waterReach + 2.0 * static_cast<double>(bleed_)) * unit),
          stop_(stop) {}

    Wash lay(const std::vector<float>& begins) {
        auto tone = blurredWithin(scene_.wanted, scene_.modalities.depth, scene_.modalities.extent,
                                  washBlur * unit_, stop_);
        borders_ = distanceTo(borders(), most_, stop_);
        outlines_ = distanceTo(outside(), most_, stop_);
        Wash wash;
        wash.pigment = Raster<float>(width_, height_);
        wash.layers = Raster<std::uint8_t>(width_, height_);
        for (std::size_t layer = 0; layer < begins.size() && !isStopped(stop_); ++layer) {
            auto mask = maskOf(tone, begins[layer]);
            if (std::none_of(mask.values.begin(), mask.values.end(), [](auto one) { return one != 0; }))
                break;
            for (std::size_t i = 0; i < mask.values.size(); ++i) wash.layers.values[i] += mask.values[i];
            dry(withinOf(std::move(mask)), static_cast<std::uint32_t>(layer), wash.pigment);
        }
        if (isStopped(stop_)) return {};
        settle(wash.pigment);
        return wash;
    }

  private:
    template <class Change>
    void eachPixel(const Change& change) const {
        forInTurns(std::uint32_t{0}, height_, [&](std::uint32_t row) {
            if (isStopped(stop_)) return;
            for (std::uint32_t column = 0; column < width_; ++column)
                change(std::size_t{row} * width_ + column, placeOf(column, row));
        });
    }
    glm::vec2 placeOf(std::uint32_t column, std::uint32_t row) const {
        return {static_cast<float>((column + 0.5) / unit_), static_cast<float>((row + 0.5) / unit_)};
    }
    bool isWashed(std::size_t pixel) const {
        return std::isfinite(scene_.modalities.depth.values[pixel]) &&
               (scene_.washed.values.empty() || scene_.washed.values[pixel] != 0);
    }
    Raster<std::uint8_t> maskOf(const Raster<float>& tone, float begin) const {
        Raster<std::uint8_t> mask(width_, height_);
        eachPixel([&](std::size_t i, const glm::vec2&) {
            mask.values[i] = isWashed(i) && tone.values[i] > begin ? 1 : 0;
        });
        dropSpecksAndHoles(mask, static_cast<std::size_t>(std::max(1.0, leastRegion * unit_ * unit_)), stop_);
        // Holes are filled where nothing is seen, too.
        eachPixel([&](std::size_t i, const glm::vec2&) {
            if (!isWashed(i)) mask.values[i] = 0;
        });
        return mask;
    }
    /// How far inside a layer each pixel is, units; outside it less than 0.
    Raster<float> withinOf(Raster<std::uint8_t> mask) const {
        auto within = distanceTo(mask, most_, stop_);
        for (auto& value : mask.values) value = value == 0 ? 1 : 0;
        const auto inside = distanceTo(mask, most_, stop_);
        // From the side of a pixel on, which is half of one nearer than the middle of the next.
        eachPixel([&](std::size_t i, const glm::vec2&) {
            const float away = within.values[i];
            const float pixels = away > 0.0F ? 0.5F - away : inside.values[i] - 0.5F;
            within.values[i] = pixels / static_cast<float>(unit_);
        });
        return blurred(within, std::max(0.5, outlineBlur * unit_));
    }
    /// Whether something ends between two pixels: on what is round regions meet where nothing does.
    bool isStep(std::size_t one, std::size_t other) const {
        const auto& seen = scene_.modalities;
        const double step = std::abs(static_cast<double>(seen.depth.values[one]) -
                                     static_cast<double>(seen.depth.values[other]));
        return seen.part.values[one] != seen.part.values[other] || step > partingStep * seen.extent;
    }
    /// Pixels on either side of where regions meet: brushes do not go on from one to the next.
    Raster<std::uint8_t> borders() const {
        Raster<std::uint8_t> marks(width_, height_);
        const auto& label = scene_.regions.label;
        if (label.values.empty()) return marks;
        eachPixel([&](std::size_t i, const glm::vec2&) {
            const std::size_t column = i % width_, row = i / width_;
            const auto parted = [&](std::size_t other) {
                return label.values[i] < scene_.regions.count && label.values[other] < scene_.regions.count &&
                       label.values[other] != label.values[i] && isStep(i, other);
            };
            const bool any = (column > 0 && parted(i - 1)) || (column + 1 < width_ && parted(i + 1)) ||
                             (row > 0 && parted(i - width_)) || (row + 1 < height_ && parted(i + width_));
            marks.values[i] = any ? 1 : 0;
        });
        return marks;
    }
    Raster<std::uint8_t> outside() const {
        Raster<std::uint8_t> marks(width_, height_);
        eachPixel([&](std::size_t i, const glm::vec2&) { marks.values[i] = isWashed(i) ? 0 : 1; });
        return marks;
    }
    /// Adds the pigment of a layer.
    void dry(const Raster<float>& within, std::uint32_t layer, Raster<float>& pigment) const {
        const auto farthest = static_cast<float>(most_ / unit_);
        const auto share = 1.0F / static_cast<float>(style_.tones);
        const auto edges = static_cast<float>(style_.edges);
        eachPixel([&](std::size_t i, const glm::vec2& place) {
            const float inside = within.values[i];
            if (inside < -1.5F * bleed_ - soft) return;
            const std::uint32_t seed = 17U * layer;
            const auto away = std::min(outlines_.values[i], borders_.values[i]) / static_cast<float>(unit_);
            const bool deep = inside >= farthest - 1.0F && borders_.values[i] >= static_cast<float>(most_);
            // Outlines are drawn with care.
            const float wet = deep ? 0.0F : wetAt(place, seed) * smoothstep(3.0F, 16.0F, away);
            const float halfWidth = crisp + wet * (soft - crisp);
            const float wander = deep ? 0.0F : wanderAt(place, seed);
            const float edge = std::min(inside + wander * bleed_, borderAt(i, wander));
            const float laid = deep ? 1.0F : smoothstep(-halfWidth, halfWidth, edge);
            const float at = std::max(edge, 0.0F);
            const float dark = edges * (1.0F - wet) * rimMore * std::exp(-at / rim) -
                               edges * drainedLess * std::exp(-at / drained);
            pigment.values[i] += share * laid * (1.0F + dark);
        });
    }
    float wetAt(const glm::vec2& place, std::uint32_t seed) const {
        return smoothstep(-0.1F, 0.5F, roughNoiseAt(place / wetPatch, seed + 3U, 2));
    }
    /// How far an edge is off its way, outwards, of the bleed.
    float wanderAt(const glm::vec2& place, std::uint32_t seed) const {
        const float even =
            0.65F * noiseAt(place / longWave, seed + 1U) + 0.35F * noiseAt(place / shortWave, seed + 2U);
        return 0.1F + even;
    }
    /// How far inside its region a pixel is, as if the brush had gone a little beyond.
    float borderAt(std::size_t pixel, float wander) const {
        return borders_.values[pixel] / static_cast<float>(unit_) + (partGap + wander) * bleed_;
    }
    /// Pigment is laid unevenly, and settles between the hills of the paper.
    void settle(Raster<float>& pigment) const {
        const auto granulation = static_cast<float>(style_.granulation);
        if (!(granulation > 0.0F)) return;
        eachPixel([&](std::size_t i, const glm::vec2& place) {
            auto& here = pigment.values[i];
            if (!(here > 0.0F)) return;
            const float flow = roughNoiseAt(place / flowSize, 7U, 3);
            const float grain = roughNoiseAt(place / grainSize, 11U, 3);
            here *= std::max(0.0F, 1.0F + granulation * (flowMore * flow + grainMore * grain));
        });
    }

    const WashScene& scene_;
    const WashStyle& style_;
    const std::uint32_t width_, height_;
    const double unit_;  // pixels
    const float bleed_;  // units
    const double most_;  // pixels from an edge that count
    const std::stop_token& stop_;
    Raster<float> borders_;   // pixels to where regions meet
    Raster<float> outlines_;  // pixels to where nothing is washed
};

}  // namespace

Wash washOf(const WashScene& scene, const WashStyle& style, bool inkIsDark, double reading, double pixels,
            const std::stop_token& stop) {
    const auto begins = beginsOf(style, inkIsDark);
    if (begins.empty()) return {};
    return Washing(scene, style, reading / unitsOfReading, pixels, stop).lay(begins);
}

double washCover(std::uint8_t layers, const WashStyle& style, bool inkIsDark) {
    const double share = double{1.0} * layers / style.tones;
    if (inkIsDark) return 1.0 - luminance(glm::pow(style.color, glm::dvec3(share)));
    return (1.0 - std::pow(1.0 - gouache, share)) * luminance(style.color);
}

std::optional<WashColor> onPaper(float pigment, const WashStyle& style, bool inkIsDark,
                                 const glm::dvec3& paper) {
    if (!(pigment > leastPigment)) return std::nullopt;
    const auto share = static_cast<double>(pigment);
    if (!inkIsDark)
        return WashColor{glm::vec3(style.color), static_cast<float>(1.0 - std::pow(1.0 - gouache, share))};
    const glm::dvec3 passed = glm::pow(glm::max(style.color, glm::dvec3(1e-6)), glm::dvec3(share));
    const double left = std::min({passed.x, passed.y, passed.z});
    if (!(left < 1.0)) return std::nullopt;
    return WashColor{glm::vec3(paper * (passed - left) / (1.0 - left)), static_cast<float>(1.0 - left)};
}

}  // namespace mote::render
