// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/quality_controller.h"

#include <algorithm>
#include <cmath>

#include "server/render/calibration.h"
#include "server/render/layers/particles/moving_look.h"

namespace mote::server {
namespace {

using render::Quality;

constexpr double million = 1e6;
constexpr double forget = 0.75;        // weight of a picture against the one after it
constexpr double priorWeight = 1e-3;   // of the initial costs, against one million points or pixels
constexpr double leastPoints = 20000;  // fewer say nothing about a plot
constexpr double growth = 2.5;         // of the points from one quick picture to the next, at most
constexpr double intermediateBudgets = 5.0;
constexpr double longExactBudgets = 10.0;
constexpr double muchMore = 3.0;  // of the points than previews hold
constexpr double tooLong = 1.1;   // of the budget
constexpr double surprise = 2.0;  // how far above its expectation a picture may lie and still be believed

Quality quickQuality() {
    return {.resolutionScale = 1.0, .pointFraction = 1.0, .slabs = 24, .samplesPerCell = 1.0};
}

double millionPixels(double pixels, const Quality& quality) {
    return pixels * quality.resolutionScale * quality.resolutionScale * render::pixelWork(quality) / million;
}

}  // namespace

void QualityController::startFrom(const render::DeviceCosts& costs) {
    if (learned_) return;
    perPoint_ = costs.millionPoints;
    perPixel_ = costs.millionPixels;
}

QualityController QualityController::within(double budgetMs) const {
    QualityController other = *this;
    other.budgetMs_ = budgetMs;
    return other;
}

double QualityController::expectedMs(const ViewLoad& load, const Quality& quality) const {
    return perPoint_ * load.points * quality.pointFraction / million +
           perPixel_ * millionPixels(load.pixels, quality);
}

/// Points get what the pixels leave, but never less than a fifth.
double QualityController::fractionWithin(const ViewLoad& load, const Quality& quality,
                                         double budgetMs) const {
    const double forPoints =
        std::max(budgetMs - perPixel_ * millionPixels(load.pixels, quality), 0.2 * budgetMs);
    const double allMs = perPoint_ * load.points / million;
    if (allMs <= forPoints) return 1.0;
    return std::clamp(forPoints / allMs, std::min(1.0, leastPoints / load.points), 1.0);
}

/// The nearest power of the square root of 1/2 that is not above `wanted`, or the last one while that is not
/// far off. Of a share that is not much more than the previews hold, what they hold: for a little more, all
/// leaves would have to be looked at.
double QualityController::steadyShare(double wanted, double previewShare) {
    constexpr double tooMuch = 1.2, tooLittle = 0.5;
    if (wanted >= previewShare && wanted < muchMore * previewShare) return lastShare_ = previewShare;
    const bool near = lastShare_ > 0.0 && lastShare_ <= tooMuch * wanted && lastShare_ >= tooLittle * wanted;
    if (!near) lastShare_ = std::exp2(-0.5 * std::ceil(-2.0 * std::log2(wanted)));
    return lastShare_;
}

/// Half the resolution where the pixels alone would take most of the time, a third where those of half would
/// leave too little for the points; back only where they clearly would not, or the picture would flicker.
std::uint32_t QualityController::divisorWithin(double pixelMs) const {
    constexpr double mostOfWhole = 0.65, mostOfHalf = 0.85, back = 0.7;
    const auto fits = [&](std::uint32_t divisor, double most) {
        return pixelMs / (divisor * divisor) <= most * (level_ > divisor ? back : 1.0) * budgetMs_;
    };
    return fits(1, mostOfWhole) ? 1 : fits(2, mostOfHalf) ? 2 : 3;
}

/// `wanted` at once where that is coarser, and one level more where pictures of this one took too long,
/// whatever the model thinks of them; where it is finer, when it has been wanted for long enough.
std::uint32_t QualityController::steadyLevel(std::uint32_t wanted) {
    constexpr std::uint32_t coarsest = 3, mostOver = 2, leastPatience = 15, mostPatience = 240;
    if (over_ >= mostOver) wanted = std::max(wanted, std::min(level_ + 1, coarsest));
    if (wanted >= level_) {
        if (wanted > level_) patience_ = std::clamp(2 * patience_, leastPatience, mostPatience);
        calm_ = 0;
    } else if (++calm_ <= patience_) {
        return level_;
    }
    if (wanted != level_) calm_ = over_ = 0;
    return level_ = wanted;
}

/// Many points of a pixel do not grow for those that are left out, and hide no more than their pixel: in
/// larger pixels they keep their light. `wanted`: the share that there is time for.
std::uint32_t QualityController::lightDivisor(const ViewLoad& load, double wanted) const {
    constexpr double back = 1.4;
    const bool preview = wanted >= load.previewShare && wanted < muchMore * load.previewShare;
    const double share = preview ? load.previewShare : std::sqrt(0.5) * wanted;  // as steadyShare(), at least
    const double cling = lightDivisor_ > 1 ? back : 1.0;
    if (share * load.points * cling <= render::LessDrawn::fewDiscs) return 1;
    const auto lit = [&](std::uint32_t divisor) {
        return share >= render::LessDrawn::leastShare(1.0 / divisor) * (lightDivisor_ > divisor ? back : 1.0);
    };
    return lit(1) ? 1 : lit(2) ? 2 : 3;
}

Quality QualityController::quick(const ViewLoad& load) {
    // A cost that was measured wrongly shall not freeze the hand: the points grow step by step.
    const double affordable = 0.5 * budgetMs_ / perPoint_ * million;
    const double first = learned_ ? 10 * leastPoints : std::max(affordable, 10 * leastPoints);
    const double mostPoints = std::max(growth * lastPoints_, first);
    Quality quality = quickQuality();
    const bool exact = load.points <= mostPoints && expectedMs(load, Quality::exact()) <= budgetMs_;
    const double pixelMs = perPixel_ * millionPixels(load.pixels, quality);
    if (const auto level = steadyLevel(exact ? 0 : divisorWithin(pixelMs)); level == 0)
        return lastQuick_ = Quality::exact();
    const auto fraction = [&] {
        return std::min(fractionWithin(load, quality, budgetMs_),
                        mostPoints / std::max(load.points, mostPoints));
    };
    quality.resolutionScale = 1.0 / level_;
    lightDivisor_ = lightDivisor(load, fraction());
    quality.resolutionScale = 1.0 / std::max(level_, lightDivisor_);
    quality.pointFraction = fraction();
    if (quality.pointFraction < 1.0)
        quality.pointFraction = steadyShare(quality.pointFraction, load.previewShare);
    return lastQuick_ = quality;
}

Quality QualityController::intermediate(const ViewLoad& load) const {
    Quality quality{.resolutionScale = 1.0, .pointFraction = 1.0, .slabs = 48, .samplesPerCell = 2.0};
    quality.pointFraction = fractionWithin(load, quality, intermediateBudgets * budgetMs_);
    return quality;
}

bool QualityController::worthIntermediate(const ViewLoad& load) const {
    return expectedMs(load, Quality::exact()) > longExactBudgets * budgetMs_;
}

void QualityController::learn(double pixels, double points, const Quality& quality, double ms) {
    learned_ = true;
    if (quality == lastQuick_) over_ = ms > tooLong * budgetMs_ ? over_ + 1 : 0;
    // `pixels` are those of the payload: the scale is already in them.
    lastPoints_ = points;
    const double p = points / million;
    const double w = pixels * render::pixelWork(quality) / million;
    // The first picture of a step uploads its data, and a machine may be busy: one such picture must not
    // ruin the next twenty. Where all of them take so long, a few pictures are enough to learn it.
    ms = std::min(ms, surprise * (perPoint_ * p + perPixel_ * w) + 0.2 * budgetMs_);
    pp_ = forget * pp_ + p * p;
    pw_ = forget * pw_ + p * w;
    ww_ = forget * ww_ + w * w;
    pt_ = forget * pt_ + p * ms;
    wt_ = forget * wt_ + w * ms;
    solve();
}

/// Normal equations with a weak pull towards the present costs; a cost is never negative.
void QualityController::solve() {
    const double pp = pp_ + priorWeight, ww = ww_ + priorWeight;
    const double pt = pt_ + priorWeight * perPoint_, wt = wt_ + priorWeight * perPixel_;
    const double determinant = pp * ww - pw_ * pw_;
    double a = determinant > 0.0 ? (pt * ww - wt * pw_) / determinant : -1.0;
    double b = determinant > 0.0 ? (pp * wt - pw_ * pt) / determinant : -1.0;
    if (a < 0.0) {
        a = 0.0;
        b = wt / ww;
    } else if (b < 0.0) {
        b = 0.0;
        a = pt / pp;
    }
    // Not quite zero: what costs nothing now may cost something in the next view.
    perPoint_ = std::max(a, 1e-3);
    perPixel_ = std::max(b, 1e-3);
}

}  // namespace mote::server
