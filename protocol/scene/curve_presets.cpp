// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/curve_presets.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "protocol/scene/particles_style.h"

namespace mote {
namespace {

/// The first bin above the threshold that parts the bins into the two most different classes.
std::size_t otsuBin(std::span<const std::uint64_t> histogram) {
    double total = 0.0, moment = 0.0;
    for (std::size_t i = 0; i < histogram.size(); ++i) {
        total += static_cast<double>(histogram[i]);
        moment += static_cast<double>(histogram[i]) * static_cast<double>(i);
    }
    double below = 0.0, belowMoment = 0.0, best = 0.0;
    std::size_t bin = 0;
    for (std::size_t i = 0; i + 1 < histogram.size(); ++i) {
        below += static_cast<double>(histogram[i]);
        belowMoment += static_cast<double>(histogram[i]) * static_cast<double>(i);
        const double above = total - below;
        if (below == 0.0 || above == 0.0) continue;
        const double apart = belowMoment / below - (moment - belowMoment) / above;
        const double variance = below * above * apart * apart;
        if (variance <= best) continue;
        best = variance;
        bin = i + 1;
    }
    return bin;
}

/// The values of a histogram's bins from the first one on.
class Quantiles {
  public:
    Quantiles(std::span<const std::uint64_t> histogram, const ValueRange& values, std::size_t first)
        : histogram_(histogram), values_(values), first_(first) {}

    double threshold() const { return edge(first_); }
    /// The upper edge of the bin that holds it; ascending in `share`.
    double operator()(double share) const {
        const auto above = histogram_.subspan(first_);
        const double total =
            static_cast<double>(std::accumulate(above.begin(), above.end(), std::uint64_t{0}));
        double sum = 0.0;
        std::size_t i = 0;
        while (i < above.size() && (sum += static_cast<double>(above[i])) < share * total) ++i;
        return edge(std::min(first_ + i + 1, histogram_.size()));
    }

  private:
    double edge(std::size_t bin) const {
        return values_.low + (values_.high - values_.low) * static_cast<double>(bin) /
                                 static_cast<double>(histogram_.size());
    }

    std::span<const std::uint64_t> histogram_;
    ValueRange values_;
    std::size_t first_;
};

/// How many values of a histogram lie between two, which it may cut bins at.
class CountBetween {
  public:
    CountBetween(std::span<const std::uint64_t> histogram, const ValueRange& values)
        : histogram_(histogram), low_(values.low), width_((values.high - values.low) / bins()) {}

    double binWidth() const { return width_; }
    double operator()(double from, double to) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < histogram_.size(); ++i) {
            const double begin = low_ + width_ * static_cast<double>(i);
            const double inside = std::min(to, begin + width_) - std::max(from, begin);
            if (inside > 0.0) sum += inside / width_ * static_cast<double>(histogram_[i]);
        }
        return sum;
    }

  private:
    double bins() const { return static_cast<double>(histogram_.size()); }

    std::span<const std::uint64_t> histogram_;
    double low_, width_;
};

constexpr double leastBone = 150.0, surelyBone = 290.0;  // HU

/// Whether values of which none is air are those of a patient.
bool isTissue(std::span<const std::uint64_t> histogram, const ValueRange& values) {
    constexpr int light = -200, dense = 250, window = 20;  // HU
    constexpr double widestBin = 40.0;
    if (histogram.empty()) return false;
    const CountBetween count(histogram, values);
    const double tissue = count(light, dense), lighter = count(values.low, light);
    const double denser = count(dense, values.high);
    if (count.binWidth() > widestBin || tissue < lighter + denser || denser < lighter) return false;
    double most = 0.0, usual = light;
    for (int at = light; at < dense; at += window / 4) {
        const double here = count(at - window / 2, at + window / 2);
        if (here <= most) continue;
        most = here;
        usual = at;
    }
    return (usual >= -130.0 && usual <= -60.0) || (usual >= 15.0 && usual <= 120.0);
}

/// The preset that shows most of a patient.
std::string_view bestOf(std::span<const std::uint64_t> histogram, const ValueRange& values, double bones) {
    constexpr double fewest = 1.0 / 2000.0;  // of what is no air
    constexpr double air = -950.0, lung = -500.0, fat = -200.0;
    if (histogram.empty()) return "bones";
    const CountBetween count(histogram, values);
    if (count(bones, values.high) >= fewest * count(lung, values.high)) return "bones";
    return count(air, lung) > count(fat, values.high) ? "lungs" : "soft tissue";
}

}  // namespace

double boneThreshold(std::span<const std::uint64_t> histogram, const ValueRange& values) {
    constexpr double begin = 300.0, middle = 500.0, end = 700.0, step = 10.0;
    constexpr double widestBin = 50.0, fewest = 100.0;  // of values, for their ratio
    constexpr double more = 1.25;                       // than follows from those above
    if (histogram.empty()) return surelyBone;
    const CountBetween count(histogram, values);
    const double dense = count(begin, middle), denser = count(middle, end);
    if (count.binWidth() > widestBin || denser < fewest || dense <= denser) return surelyBone;
    // Of values v there are exp(-fall v), as those from 300 to 500 and from 500 to 700 say.
    const double fall = std::log(dense / denser) / (middle - begin);
    const auto expected = [&](double from) {
        return dense * std::expm1(fall * (begin - from)) / -std::expm1(-fall * (middle - begin));
    };
    double least = surelyBone;
    constexpr auto steps = static_cast<int>((surelyBone - leastBone) / step);
    for (int i = 1; i <= steps; ++i) {
        const double from = surelyBone - i * step;
        if (count(from, begin) > more * expected(from)) break;
        least = from;
    }
    return least;
}

double highestShown(std::span<const std::uint64_t> histogram, const ValueRange& values) {
    constexpr double below = 0.9999;
    return histogram.empty() ? values.high : Quantiles(histogram, values, 0)(below);
}

ValueRange readableColors(const ValueRange& knots) {
    constexpr double darkest = 0.4;  // of the colour map
    return {knots.low - (knots.high - knots.low) * darkest / (1.0 - darkest), knots.high};
}

bool inHounsfieldUnits(std::string_view unit, const ValueRange& values,
                       std::span<const std::uint64_t> histogram) {
    if (!unit.empty()) return unit == "HU";
    if (!(values.high >= 300.0 && values.high <= 33000.0)) return false;
    if (values.low >= -3100.0 && values.low <= -900.0) return true;
    return values.low > -900.0 && values.low <= -50.0 && isTissue(histogram, values);
}

std::span<const CurvePreset> tomographyPresets() {
    static const std::array<CurvePreset, 5> presets{{
        {"bones",
         {{surelyBone, 0}, {surelyBone, 0.42}, {450, 0.65}, {1300, 0.9}},
         {{{0.8F, 0.55F, 0.4F}}, {{0.9F, 0.74F, 0.58F}}, {{0.96F, 0.9F, 0.78F}}, {{1, 1, 0.96F}}}},
        {"vessels",
         {{110, 0}, {170, 0.1}, {260, 0.4}, {400, 0.6}, {1300, 0.85}},
         {{{0.45F, 0.02F, 0.03F}},
          {{0.72F, 0.07F, 0.06F}},
          {{0.9F, 0.3F, 0.2F}},
          {{0.97F, 0.82F, 0.64F}},
          {{1, 1, 0.96F}}}},
        {"soft tissue",
         {{-30, 0}, {10, 0.02}, {60, 0.07}, {120, 0.1}, {250, 0.25}, {1300, 0.8}},
         {{{0.85F, 0.65F, 0.35F}},
          {{0.75F, 0.4F, 0.3F}},
          {{0.78F, 0.25F, 0.22F}},
          {{0.9F, 0.45F, 0.35F}},
          {{0.97F, 0.87F, 0.72F}},
          {{1, 1, 0.96F}}}},
        {"skin",
         {{-500, 0}, {-300, 0.12}, {-150, 0.4}, {100, 0.6}, {1300, 0.9}},
         {{{0.7F, 0.45F, 0.35F}},
          {{0.85F, 0.62F, 0.5F}},
          {{0.93F, 0.75F, 0.64F}},
          {{0.8F, 0.45F, 0.38F}},
          {{1, 1, 0.96F}}}},
        {"lungs",
         {{-960, 0}, {-880, 0.006}, {-750, 0.03}, {-550, 0.06}, {-420, 0}},
         {{{0.2F, 0.3F, 0.6F}},
          {{0.35F, 0.5F, 0.8F}},
          {{0.65F, 0.75F, 0.9F}},
          {{0.95F, 0.75F, 0.7F}},
          {{0.9F, 0.6F, 0.5F}}}},
    }};
    return presets;
}

std::vector<CurvePreset> histogramPresets(std::span<const std::uint64_t> histogram,
                                          const ValueRange& values) {
    if (histogram.empty()) return {};
    const Quantiles object(histogram, values, otsuBin(histogram));
    const auto ramp = [](double from, double to, double most) {
        return std::vector<Curve::Knot>{{from, 0.0}, {to, most}};
    };
    std::vector<Curve::Knot> layers;
    for (const double share : {0.2, 0.5, 0.8}) {
        const double at = object(share), half = 0.02 * (values.high - values.low);
        const double low = layers.empty() ? at - half : std::max(at - half, layers.back().x);
        layers.insert(layers.end(), {{low, 0.0}, {std::max(low, at), 0.25 * share}, {at + half, 0.0}});
    }
    // Steeper towards the densest, and with colours up to there: what is inside shows through what is around.
    // It begins at once: a haze that is too thin to see would lie around it.
    const std::vector<Curve::Knot> whole{
        {object.threshold(), 0.0}, {object.threshold(), 0.1}, {object(0.5), 0.1}, {object(0.99), 0.35}};
    return {{"object", whole, {}},
            {"denser parts", ramp(object(0.5), object(0.97), 0.3), {}},
            {"densest", ramp(object(0.97), object(0.999), 0.6), {}},
            {"layers", layers, {}},
            {"everything", ramp(values.low, values.high, 0.1), {}}};
}

std::vector<CurvePreset> presetsOf(std::string_view unit, const ValueRange& values,
                                   std::span<const std::uint64_t> histogram) {
    std::vector<CurvePreset> presets;
    if (inHounsfieldUnits(unit, values, histogram)) {
        const auto tomography = tomographyPresets();
        presets.assign(tomography.begin(), tomography.end());
        const double bones = boneThreshold(histogram, values);
        for (auto& knot : presets.front().knots) {
            if (knot.x == surelyBone) knot.x = bones;
        }
        std::stable_partition(
            presets.begin(), presets.end(),
            [best = bestOf(histogram, values, bones)](const auto& each) { return each.name == best; });
    }
    constexpr std::array<std::uint64_t, 1> unknown{1};
    auto others = histogramPresets(histogram.empty() ? unknown : histogram, values);
    presets.insert(presets.end(), std::make_move_iterator(others.begin()),
                   std::make_move_iterator(others.end()));
    return presets;
}

std::span<const DensityPreset> densityPresets() {
    constexpr double full = ParticlesStyle::fullOpacity;
    static const std::array<DensityPreset, 5> presets{{
        {"halo and core", {{0.3, 0}, {0.6, 0.25 * full}, {1, full}}, {{0.3, 1}, {0.6, 0}}},
        {"core alone", {{0.6, 0}, {0.75, 0.25 * full}, {1, full}}, {{0, 0}, {1, 0}}},
        {"halo alone", {{0, 0}, {1, 0}}, {{0.4, 1}, {0.6, 0}}},
        {"all as volume", {{0, 0}, {0, 0.02 * full}, {1, full}}, {{0, 0}, {1, 0}}},
        {"all as points", {{0, 0}, {1, 0}}, {{0, 1}, {1, 1}}},
    }};
    return presets;
}

}  // namespace mote
