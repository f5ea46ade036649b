// SPDX-License-Identifier: GPL-3.0-or-later
//
// DepthOrder: which layer of a view is nearest in each pixel, and what of its contours has to be strengthened
// so that a picture tells it (docs/PICTURE.md, "Depth contrast"). It knows no layers' data: pictures go in,
// and fragments come out. Values; pure functions that work in parallel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <stop_token>
#include <vector>

#include "server/render/ink/raster.h"
#include "server/render/plan/fragment.h"

namespace mote::render {

/// What is seen in the middle of each pixel.
struct DepthOrder {
    static constexpr std::uint8_t nothing = 255;

    /// Whose matter or surface takes what makes half of all that the pixel's light loses: its number among
    /// those that take part, or `nothing`.
    Raster<std::uint8_t> layer;
    /// Along the line of sight, world units, of that layer: where half of what it takes is taken, and where
    /// it begins (a twentieth).
    Raster<float> depth, front;
    /// Of the pixel's light, what that layer takes, 0 to 1; how light it is (CIE L*, 0 to 1).
    Raster<float> share, tone;
    /// One a layer that takes part: what of the light it would take alone, in 255ths.
    std::vector<Raster<std::uint8_t>> own;
    /// What the depths of a whole scene differ by, world units, above 0.
    double extent = 1.0;

    DepthOrder(std::uint32_t width, std::uint32_t height, std::size_t layers);
};

/// How it is drawn.
struct ContrastStyle {
    double amount = 1.0;      ///< View::depthContrast
    double pixels = 1.0;      ///< of the picture, a pixel of one of 720 lines
    glm::vec3 contour{0.0F};  ///< linear RGB; of what is nearer
    double line = 0.8,
           rim = 0.0;  ///< opacities of the contour where all is ambiguous, and along its inner side
    glm::vec3 background{0.0F};  ///< likewise; what holds the farther back
};

/// How much the order of depth cannot be read at a pixel, of the nearer layer and the farther: where they
/// meet, how many contours come together there, how much of both is seen, and how alike they are.
struct Ambiguity {
    double complexity = 0.0;  ///< of contours around, as one straight line alone: 1
    double shares = 0.0;      ///< the lesser of both layers' shares
    double gap = 0.0;         ///< in depth, by the extent
    double ends =
        0.0;  ///< of the farther layer's pixels around, those in which there is nothing of the nearer
    double tones = 0.0;  ///< their difference

    /// 0 to 1.
    double amount() const;
};

/// How far from a pixel anything lies that what is drawn there depends on, pixels.
double contrastReach(double pixels);

/// Null where nothing is ambiguous. If `stop` is requested meanwhile, something is missing.
std::shared_ptr<const FragmentMaker> contrastOf(const DepthOrder& order, const ContrastStyle& style,
                                                const std::stop_token& stop);

/// What marks of a whole picture take in memory at most, bytes a pixel; besides, until they are made, the
/// order, and for each layer.
inline constexpr double contrastBytes = 24.0, orderBytes = 17.0, contrastLayerBytes = 7.0;

}  // namespace mote::render
