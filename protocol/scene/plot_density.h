// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlotDensity: what of a particle plot its default picture follows from, and the functions that fill in what
// a view leaves to the plot (docs/PICTURE.md, "Points"): where points give way to the volume, and how much
// light a particle has. Values and pure functions.
#pragma once

#include <cstdint>

#include "protocol/mote.pb.h"
#include "protocol/scene/log_density.h"
#include "protocol/scene/particles_style.h"

namespace mote {

struct PlotDensity {
    LogDensity scale;             ///< of all steps
    std::uint64_t particles = 0;  ///< of the step that has most
    double meanWeight = 0.0;      ///< of a particle of all steps; 0: they weigh nothing
    double span = 1.0;            ///< the product of what the axes span, in their units

    static PlotDensity of(const proto::ParticlesManifest& plot, std::uint32_t step = 0);
};

/// The optical area of a particle of the mean weight in a plot of so many, in square units of layer space,
/// where a view says nothing of it: a fifth of a pixel where the plot, whole in view, stands in a picture of
/// 720 lines; of fewer than a quarter of a million particles more, so that few are seen as well; and on a
/// light background, on which what hides little is seen less than what shines, four times as much.
double defaultPointArea(std::uint64_t particles, bool onLight = false);

/// Fills in what a style leaves to its plot: curves (curveByPlot), and the light of a point (opacityByPlot);
/// and brings what is told between two densities (densityRange) to the plot's t.
/// By default points give way to the volume over a factor of three in density, some of them at once, up to
/// where as many particles hide as much as the volume does. Where the curves are said, a point has so much
/// light that it is as much there, where the points end. `onLight`: the background is light; denser matter
/// stands out from it as it does from a dark one.
void resolveByPlot(ParticlesStyle& style, const PlotDensity& plot, bool onLight = false);

}  // namespace mote
