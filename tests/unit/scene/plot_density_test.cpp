// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/plot_density.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace mote {
namespace {

/// Densities of so many particles that fill a plot unevenly, from a millionth of their mean density to
/// 10^4 times that.
PlotDensity plotOf(std::uint64_t particles, double weight) {
    const double mean = static_cast<double>(particles) * weight;
    return {.scale = {1e-6 * mean, 1e4 * mean}, .particles = particles, .meanWeight = weight};
}

ParticlesStyle resolved(const PlotDensity& plot, const proto::ParticlesStyle& message = {},
                        bool onLight = false) {
    auto style = particlesStyleOf(parseParticlesStyle(message).value());
    resolveByPlot(style, plot, onLight);
    return style;
}

/// The extinction of matter at a scaled log density, as points and as volume: per unit of layer space.
double extinction(const ParticlesStyle& style, const PlotDensity& plot, double t) {
    const double density = plot.scale.min * std::pow(plot.scale.max / plot.scale.min, t);
    const double asPoints = density / (8.0 * plot.meanWeight) * style.pointArea;
    return style.pointFraction(t) * asPoints + style.transfer().extinction(t);
}

TEST(PlotDensity, DenserMatterNeverHidesLess) {
    for (const std::uint64_t particles : {100'000ULL, 4'000'000ULL, 300'000'000ULL}) {
        for (const double weight : {1.0, 1e-12, 3e7}) {
            const auto plot = plotOf(particles, weight);
            const auto style = resolved(plot);
            ASSERT_GT(style.volumeOpacity.maximum(), 0.0);
            double before = 0.0;
            for (int i = 0; i <= 2000; ++i) {
                const double here = extinction(style, plot, i / 2000.0);
                EXPECT_GE(here, before * (1.0 - 1e-3)) << particles << ' ' << weight << ' ' << i;
                before = here;
            }
        }
    }
}

TEST(PlotDensity, PointsMeetTheVolumeWithoutAStep) {
    const auto plot = plotOf(4'000'000, 1.0);
    const auto style = resolved(plot);
    double end = 0.0;  // of the points
    while (style.pointFraction(end) > 0.0) end += 1e-4;
    EXPECT_NEAR(extinction(style, plot, end - 2e-3) / extinction(style, plot, end + 2e-3), 1.0, 0.03);
}

/// Over curves: wherever a view puts the seam, a point has the light of the volume there.
TEST(PlotDensity, PointsOfCurvesThatAreSaidMeetTheVolume) {
    const auto plot = plotOf(4'000'000, 2.0);
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (int i = 0; i < 100; ++i) {
        proto::ParticlesStyle message;
        auto* knot = message.mutable_volume()->add_curve();
        knot->set_density(0.45 + 0.05 * share(random));
        knot = message.mutable_volume()->add_curve();
        knot->set_density(0.6 + 0.1 * share(random));
        knot->set_opacity(0.1 + 0.2 * share(random));
        const auto style = resolved(plot, message);
        const double end = style.pointFraction.knots().back().x;
        EXPECT_NEAR(extinction(style, plot, end) * (1.0 + 1e-9),
                    plot.scale.min * std::pow(plot.scale.max / plot.scale.min, end) / 16.0 * style.pointArea,
                    1e-6 * extinction(style, plot, end));
    }
}

TEST(PlotDensity, FewParticlesAreAllPoints) {
    for (const std::uint64_t particles : {1ULL, 56ULL, 10'000ULL, 65'536ULL}) {
        const auto style = resolved(plotOf(particles, 1.0));
        EXPECT_EQ(style.volumeOpacity.maximum(), 0.0);
        EXPECT_EQ(style.pointFraction(1.0), 1.0);
    }
    EXPECT_GT(resolved(plotOf(65'537, 1.0)).volumeOpacity.maximum(), 0.0);
}

TEST(PlotDensity, AGasThatIsNowhereDenseIsAllPoints) {
    const double mean = 5e5;
    const PlotDensity gas{.scale = {0.8 * mean, 1.2 * mean}, .particles = 500'000, .meanWeight = 1.0};
    const auto style = resolved(gas);
    EXPECT_EQ(style.volumeOpacity.maximum(), 0.0);
    // And what counting leaves to chance is no range of colours.
    EXPECT_NEAR(std::pow(1.5, style.colorRange.high - style.colorRange.low), 16.0, 1e-9);
    EXPECT_NEAR(style.colorRange.high + style.colorRange.low, 1.0, 1e-12);
}

TEST(PlotDensity, TheVolumeBeginsInTheColourOfThePoints) {
    for (const double ratio : {1.5, 1e3, 1e9}) {
        const PlotDensity plot{.scale = {1e7, 1e7 * ratio}, .particles = 1'000'000, .meanWeight = 1.0};
        for (const bool onLight : {false, true}) {
            const auto style = resolved(plot, {}, onLight);
            const auto& knots = style.volumeOpacity.knots();
            const auto transfer = style.transfer();
            EXPECT_NEAR(transfer.color(knots.front().x).y, style.pointColor.y, 1e-9) << ratio;
            // Points in the volume's colours at any density, from the one in which it begins.
            ASSERT_TRUE(style.pointShade);
            const auto& [t, colors] = *style.pointShade;
            for (const double way : {0.0, 0.3, 1.0}) {
                const double at = t.low + way * (t.high - t.low);
                const double share = colors.low + way * (colors.high - colors.low);
                const auto& range = style.colorRange;
                EXPECT_NEAR((at - range.low) / (range.high - range.low), share, 1e-9) << ratio;
            }
            EXPECT_EQ(style.colorMap(colors.low), style.pointColor);
            // Of a factor of 16 at least.
            const double end = onLight ? 0.35 : 1.0, begin = onLight ? 0.6 : 0.75;
            const double width = style.colorRange.high - style.colorRange.low;
            EXPECT_GE(width * (end - begin) * std::log(ratio), std::log(16.0) - 1e-9) << ratio;
            // What is dense stands out more than points do.
            if (ratio > 16.0) {
                EXPECT_EQ(transfer.color(1.0).y < style.pointColor.y, onLight);
            }
        }
    }
}

TEST(PlotDensity, ARangeThatIsSaidHoldsBetweenPlots) {
    proto::ParticlesStyle message;
    message.mutable_volume()->add_density_range(10.0);
    message.mutable_volume()->add_density_range(1e5);
    auto* knot = message.mutable_volume()->add_curve();
    knot->set_density(0.25);
    knot = message.mutable_volume()->add_curve();
    knot->set_density(0.75);
    knot->set_opacity(0.4);
    const auto densityOf = [](const PlotDensity& plot, double t) {
        return plot.scale.min * std::pow(plot.scale.max / plot.scale.min, t) / plot.span;
    };
    for (const double max : {1e4, 1e6, 1e9}) {
        const PlotDensity plot{.scale = {1.0, max}, .particles = 1'000'000, .meanWeight = 1.0, .span = 7.0};
        const auto style = resolved(plot, message);
        for (int i = 0; i <= 100; ++i) {
            const double t = i / 100.0, u = std::log(densityOf(plot, t) / 10.0) / std::log(1e4);
            EXPECT_NEAR(style.volumeOpacity(t), 0.4 * std::clamp((u - 0.25) / 0.5, 0.0, 1.0), 1e-9)
                << max << ' ' << t;
        }
        EXPECT_NEAR(densityOf(plot, style.colorRange.low), 10.0, 1e-9);
        EXPECT_NEAR(densityOf(plot, style.colorRange.high), 1e5, 1e-4);
    }
}

TEST(PlotDensity, FewParticlesHaveMoreLightEach) {
    EXPECT_GT(defaultPointArea(56), 10.0 * defaultPointArea(250'000));
    EXPECT_EQ(defaultPointArea(250'000), defaultPointArea(1'000'000'000));
    EXPECT_TRUE(std::isfinite(defaultPointArea(0)));
}

TEST(PlotDensity, ParticlesWithoutWeightAreAllPoints) {
    const auto style = resolved({.scale = {1.0, 2.0}, .particles = 1'000'000, .meanWeight = 0.0});
    EXPECT_EQ(style.volumeOpacity.maximum(), 0.0);
    EXPECT_GT(style.pointArea, 0.0);
}

TEST(PlotDensity, ComesFromTheStepsOfAManifest) {
    proto::ParticlesManifest plot;
    plot.set_density_min(2.0);
    plot.set_density_max(8.0);
    for (const double weight : {10.0, 30.0}) {
        auto& step = *plot.add_steps();
        step.set_particles(static_cast<std::uint64_t>(weight / 5.0));
        step.set_total_weight(weight);
    }
    const auto density = PlotDensity::of(plot);
    EXPECT_EQ(density.particles, 6U);
    EXPECT_DOUBLE_EQ(density.meanWeight, 5.0);
    EXPECT_EQ(density.scale.max, 8.0);
    EXPECT_EQ(PlotDensity::of({}).meanWeight, 0.0);
}

}  // namespace
}  // namespace mote
