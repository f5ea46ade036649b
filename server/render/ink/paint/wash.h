// SPDX-License-Identifier: GPL-3.0-or-later
//
// Watercolour (docs/INK.md, "Watercolour"): flat layers of pigment that end where the tone asks for no more
// of them, with what water does at their edges and in the paper's grain. Pure; the same on any number of
// threads.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <stop_token>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/modalities.h"
#include "server/render/ink/segments.h"

namespace mote::render {

/// What a wash is made from: pictures of one size.
struct WashScene {
    const Modalities& modalities;
    const Raster<float>& wanted;  ///< share of each pixel that is to be covered
    const Segments& regions;      ///< layers end where they do; or without labels
    const Raster<std::uint8_t>&
        washed;  ///< not 0 where it may be; without pixels: wherever something is seen
};

struct Wash {
    /// How much pigment dries in each pixel: of what all layers have together, 1 in the mean where all lie.
    /// Without pixels where nothing is washed.
    Raster<float> pigment;
    /// How many layers were laid there, before water moved them.
    Raster<std::uint8_t> layers;
};

/// `reading`: the reading distance in pixels, a sixth of which is the measure of the paper's grain and of
/// what water does; `pixels`: of the scene, a pixel of the view. If `stop` is requested meanwhile, no wash.
Wash washOf(const WashScene& scene, const WashStyle& style, bool inkIsDark, double reading, double pixels,
            const std::stop_token& stop);

/// What is to be covered that so many layers cover, on the mean: of dark ink's paper by what they take of
/// light, of light ink's by what they give.
double washCover(std::uint8_t layers, const WashStyle& style, bool inkIsDark);

/// What lies on the paper as a surface: of a colour, linear RGB, and of an opacity above 0.
struct WashColor {
    glm::vec3 color;
    float opacity;
};

/// Pigment on a paper (linear RGB): under dark ink transparent, as watercolour is, where light passes it
/// twice; under light ink opaque, as gouache is. None where there is hardly any. The surface is as
/// transparent as it can be and look so.
std::optional<WashColor> onPaper(float pigment, const WashStyle& style, bool inkIsDark,
                                 const glm::dvec3& paper);

}  // namespace mote::render
