// SPDX-License-Identifier: GPL-3.0-or-later
//
// The two linked transfer functions of a hybrid particle picture and the look of its points: their message,
// resolved (fields/resolve.h), and ParticlesStyle, which is made of it for who draws. Source: section 3.3.3
// of the dissertation. Values and pure functions.
//
// Density enters as *scaled log density* t: 0 at the plot's least leaf density, 1 at its greatest
// (log_density.h).
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/curve.h"
#include "protocol/scene/length_scale.h"
#include "protocol/scene/transfer_function.h"

namespace mote {

/// Points in the colours of their leaves' densities: from one share of the colour map to another between two
/// t, and beyond them that of the nearer one.
struct PointShade {
    ValueRange t, colors;

    bool operator==(const PointShade&) const = default;
};

/// As drawn.
struct ParticlesStyle {
    /// The length, in layer space, over which a volume of constant density has the curve's opacity: one cell
    /// of a 64^3 volume across the plot's edge of 2, the slice distance of the dissertation.
    static constexpr double opacityLength = 2.0 / 64.0;
    static constexpr double opacityLimit = TransferFunction::opacityLimit;
    /// What the default curve ends in: a volume that lets the eye in.
    static constexpr double fullOpacity = 0.12;

    Curve volumeOpacity;    ///< t -> opacity over opacityLength
    ColorMap colorMap;      ///< t -> linear RGB
    Curve pointFraction;    ///< t -> fraction of a leaf's points that are drawn; already resolved when linked
    double pointOpacity;    ///< of one point, 0 to opacityLimit
    double pointSize;       ///< diameter, pixels
    glm::dvec3 pointColor;  ///< linear RGB
    /// What the view leaves to the plot (plot_density.h): both curves; the opacity of a point, which then
    /// follows from its optical area; its size; and its colour.
    bool curveByPlot = false, opacityByPlot = false, sizeByPlot = false, colorByPlot = false;
    /// Where opacityByPlot: of a particle of the mean weight, square units of layer space; 0: not told yet, a
    /// point has `pointOpacity`.
    double pointArea = 0.0;
    double meanWeight = 0.0;  ///< of a particle of the plot, likewise; 0: all count alike
    /// The two densities that curves and colours are told between, weight over the product of what the axes
    /// span, in their units; absent: the plot's own.
    std::optional<ValueRange> densityRange = std::nullopt;
    ValueRange colorRange{0.0, 1.0};  ///< the two t where the colour map begins and ends
    /// In place of pointColor, if that is left to a plot that has points and a volume.
    std::optional<PointShade> pointShade = std::nullopt;

    /// The transfer function of t; see log_density.h for t < 0.
    TransferFunction transfer() const;
    static TransferFunction transferOf(const Curve& volumeOpacity, const ColorMap& colorMap);

    bool operator==(const ParticlesStyle&) const = default;
};

/// The point curve that mirrors a volume curve: 1 - opacity / max(opacity), sampled at its knots; all points
/// where the volume is nowhere opaque.
Curve linkedFraction(const Curve& volumeOpacity);

/// Fills every default; what is left to the plot stays so. Points that give way to the volume are linked,
/// whoever says it. Errors: a curve, colour map, colour, size (0.1 to 64) or opacity out of range; a point
/// curve given while linked.
Result<proto::ParticlesStyle> parseParticlesStyle(proto::ParticlesStyle message);

/// Of a parsed message whose lengths are in pixels, in a picture of so many lines; what is left to the plot,
/// as it is in a plot of which nothing is known.
ParticlesStyle particlesStyleOf(const proto::ParticlesStyle& message,
                                std::uint32_t lines = static_cast<std::uint32_t>(usualLines));

}  // namespace mote
