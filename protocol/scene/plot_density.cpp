// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/plot_density.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "protocol/quantity/plot_axes.h"

namespace mote {
namespace {

constexpr double boxVolume = 8.0;  // of a plot, in layer space
constexpr double seamFactor = 3.0;
/// The volume begins with this share at once: a haze that is too thin to see would lie around all matter.
constexpr double seamBegins = 0.4;
/// So few are drawn in a moment, and no cell holds enough of them for its density to mean much: they are
/// points.
constexpr std::uint64_t fewParticles = std::uint64_t{1} << 16;

/// What a density would be as a scaled log density; beyond 0 and 1 where the plot has no such leaf.
double unclamped(const LogDensity& scale, double density) {
    constexpr double far = 1e6;
    if (!(scale.max > scale.min)) return density > scale.max ? far : -far;
    return std::log(density / scale.min) / std::log(scale.max / scale.min);
}

/// The seam between points and volume, as scaled log densities: all are points below `from`, none from `to`
/// on.
struct Seam {
    double from, to;

    /// How far through it a density is, 0 to 1.
    double share(double t) const {
        if (t < from) return 0.0;
        return t < to ? seamBegins + (1.0 - seamBegins) * (t - from) / (to - from) : 1.0;
    }
};

/// Beyond the seam extinction grows with a root of the density: a core lets the eye in, and what is thin and
/// dense is still seen.
double opacityBeyond(const PlotDensity& plot, double seam, double t) {
    constexpr double root = 0.25;
    const double ratio = plot.scale.min * std::pow(plot.scale.max / plot.scale.min, t) / seam;
    return -std::expm1(std::log1p(-ParticlesStyle::fullOpacity) * std::pow(std::max(ratio, 1.0), root));
}

/// Densities that differ by less differ by chance: they do not take all colours.
constexpr double leastRange = 16.0;

/// What of a colour map stands out from a background, from thin to dense: denser matter is brighter on a dark
/// one and darker on a light one, so that lone points before it never are what stands out.
ValueRange colorsOn(bool light) {
    return light ? ValueRange{0.6, 0.35} : ValueRange{0.75, 1.0};
}

/// The volume begins in colours that stand out. Points have those too: thin ones the one in which it begins.
void takeSeamColor(ParticlesStyle& style, const LogDensity& scale, double seam, bool onLight) {
    if (style.densityRange) return;
    const auto [begins, ends] = colorsOn(onLight);
    const double logRatio = std::log(scale.max / scale.min);
    const double from = std::max(seam, 0.0);
    const double span = logRatio > 0.0 ? std::max(1.0 - from, std::log(leastRange) / logRatio) : 1.0;
    const double low = from - span * begins / (ends - begins);
    style.colorRange = {low, low + span / (ends - begins)};
    if (!style.colorByPlot) return;
    style.pointColor = style.colorMap(begins);
    style.pointShade = PointShade{{from, from + span}, {begins, ends}};
}

void resolveCurves(ParticlesStyle& style, const PlotDensity& plot, bool onLight) {
    const double extinction = -std::log1p(-ParticlesStyle::fullOpacity) / ParticlesStyle::opacityLength;
    const double density =
        boxVolume * plot.meanWeight * extinction / defaultPointArea(plot.particles, onLight);
    const Seam seam{unclamped(plot.scale, density / seamFactor), unclamped(plot.scale, density)};
    if (plot.particles <= fewParticles || seam.from >= 1.0 || !(plot.meanWeight > 0.0)) {
        style.volumeOpacity = Curve::constant(0.0);
        style.pointFraction = Curve::constant(1.0);
        return;
    }
    takeSeamColor(style, plot.scale, seam.from, onLight);
    const double from = std::clamp(seam.from, 0.0, 1.0), to = std::clamp(seam.to, 0.0, 1.0);
    std::vector<Curve::Knot> opacity{{from, 0.0}, {from, seam.share(from) * ParticlesStyle::fullOpacity}};
    constexpr int beyond = 8;  // knots
    for (int i = 0; i <= beyond; ++i) {
        const double t = to + (1.0 - to) * i / beyond;
        opacity.push_back({t, seam.share(t) * opacityBeyond(plot, density, t)});
    }
    style.volumeOpacity = Curve::create(std::move(opacity)).value();
    style.pointFraction =
        Curve::create({{from, 1.0}, {from, 1.0 - seam.share(from)}, {to, 1.0 - seam.share(to)}}).value();
}

/// A curve told over a range as one over [0, 1].
Curve within(const Curve& curve, const ValueRange& range) {
    const double width = range.high - range.low;
    const auto at = [&](double t) { return Curve::Knot{t, curve((t - range.low) / width)}; };
    std::vector<Curve::Knot> knots{at(0.0)};
    for (const auto& knot : curve.knots()) {
        const double t = range.low + knot.x * width;
        if (t > 0.0 && t < 1.0 && knots.size() < 254) knots.push_back({t, knot.y});
    }
    knots.push_back(at(1.0));
    return Curve::create(std::move(knots)).value();
}

void takeColorRange(ParticlesStyle& style, const PlotDensity& plot) {
    const double ratio = plot.scale.max / plot.scale.min;
    if (!(ratio > 1.0) || ratio >= leastRange) return;
    const double half = 0.5 * std::log(leastRange) / std::log(ratio);
    style.colorRange = {0.5 - half, 0.5 + half};
}

void takeDensityRange(ParticlesStyle& style, const PlotDensity& plot) {
    if (!style.densityRange) return takeColorRange(style, plot);
    if (!(plot.scale.max > plot.scale.min)) return;
    const ValueRange range{unclamped(plot.scale, style.densityRange->low * plot.span),
                           unclamped(plot.scale, style.densityRange->high * plot.span)};
    if (!(range.high > range.low)) return;
    style.colorRange = range;
    if (style.curveByPlot) return;
    style.volumeOpacity = within(style.volumeOpacity, range);
    style.pointFraction = within(style.pointFraction, range);
}

/// The scaled log density from which on no points are drawn, and the volume's extinction there; false where
/// there is no such.
bool findSeam(const ParticlesStyle& style, double& t, double& extinction) {
    const auto& knots = style.pointFraction.knots();
    if (knots.back().y > 0.0) return false;
    const auto drawn =
        std::find_if(knots.rbegin(), knots.rend(), [](const auto& knot) { return knot.y > 0.0; });
    t = drawn == knots.rend() ? 0.0 : drawn.base()->x;
    extinction = style.transfer().extinction(t);
    return extinction > 0.0;
}

}  // namespace

PlotDensity PlotDensity::of(const proto::ParticlesManifest& plot, std::uint32_t step) {
    PlotDensity density{.scale = {plot.density_min(), plot.density_max()}};
    double weight = 0.0, particles = 0.0;
    for (const auto& each : plot.steps()) {
        density.particles = std::max<std::uint64_t>(density.particles, each.particles());
        weight += each.total_weight();
        particles += static_cast<double>(each.particles());
    }
    if (particles > 0.0) density.meanWeight = weight / particles;
    for (int a = 0; a < std::min(plot.axes_size(), axesOfPlot); ++a) {
        const auto& axis = axisOf(plot, a, step);
        density.span *= axis.max() - axis.min();
    }
    return density;
}

double defaultPointArea(std::uint64_t particles, bool onLight) {
    const double pixels = onLight ? 0.8 : 0.2;
    constexpr double pixelsOfAUnit = 200.0;
    constexpr double few = 2.5e5, growth = 0.36;
    const double rare = few / static_cast<double>(std::max<std::uint64_t>(particles, 1));
    return pixels / (pixelsOfAUnit * pixelsOfAUnit) * std::max(1.0, std::pow(rare, growth));
}

void resolveByPlot(ParticlesStyle& style, const PlotDensity& plot, bool onLight) {
    if (style.colorByPlot && onLight) style.pointColor = style.colorMap(colorsOn(onLight).low);
    takeDensityRange(style, plot);
    if (style.curveByPlot) resolveCurves(style, plot, onLight);
    if (!style.opacityByPlot) return;
    const double usual = defaultPointArea(plot.particles, onLight);
    style.pointArea = usual;
    style.meanWeight = plot.meanWeight;
    double t = 0.0, extinction = 0.0;
    if (style.curveByPlot || !(plot.meanWeight > 0.0) || !findSeam(style, t, extinction)) return;
    const double density = plot.scale.max > plot.scale.min
                               ? plot.scale.min * std::pow(plot.scale.max / plot.scale.min, t)
                               : plot.scale.max;
    constexpr double most = 16.0;  // times the usual, or a part of it
    style.pointArea =
        std::clamp(boxVolume * plot.meanWeight * extinction / density, usual / most, usual * most);
}

}  // namespace mote
