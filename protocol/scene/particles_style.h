// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParticlesStyle: the two linked transfer functions of a hybrid particle picture and the look of its points.
// Source: section 3.3.3 of the dissertation. A value; a parsed one is valid.
//
// Density enters as *scaled log density* t: 0 at the plot's least leaf density, 1 at its greatest
// (log_density.h).
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "protocol/mote.pb.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/curve.h"
#include "protocol/scene/error.h"
#include "protocol/scene/transfer_function.h"

namespace mote {

struct ParticlesStyle {
    /// The length, in layer space, over which a volume of constant density has the curve's opacity: one cell
    /// of a 64^3 volume across the plot's edge of 2, the slice distance of the dissertation.
    static constexpr double opacityLength = 2.0 / 64.0;
    static constexpr double opacityLimit = TransferFunction::opacityLimit;

    Curve volumeOpacity;    ///< t -> opacity over opacityLength
    ColorMap colorMap;      ///< t -> linear RGB
    Curve pointFraction;    ///< t -> fraction of a leaf's points that are drawn; already resolved when linked
    double pointOpacity;    ///< of one point, 0 to opacityLimit
    double pointSize;       ///< diameter, pixels of the full-resolution picture
    glm::dvec3 pointColor;  ///< linear RGB
    bool opacityByPlot = false;  ///< the view leaves the opacity of a point to defaultPointOpacity()

    /// The transfer function of t; see log_density.h for t < 0.
    TransferFunction transfer() const;

    bool operator==(const ParticlesStyle&) const = default;
};

/// The opacity of a point where a view says nothing: a quarter in plots of up to four million particles; in
/// larger ones the extinction of all points together stays what it is there, so that a core is seen through
/// any number of them.
double defaultPointOpacity(std::uint64_t particles);

/// The point curve that mirrors a volume curve: 1 - opacity / max(opacity), sampled at its knots; all points
/// where the volume is nowhere opaque.
Curve linkedFraction(const Curve& volumeOpacity);

/// Fills every default; the opacity of a point for a small plot, as the plot is not known here. Errors: a
/// curve, colour map, colour, size (0.1 to 64) or opacity out of range; a point curve given while linked.
Result<ParticlesStyle> parseParticlesStyle(const proto::ParticlesStyle& message);

}  // namespace mote
