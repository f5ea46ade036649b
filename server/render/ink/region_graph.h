// SPDX-License-Identifier: GPL-3.0-or-later
//
// RegionGraph: regions as nodes that stand for all their pixels, and how much of the graph of pixels
// lies within each and between two of them. Pure; deterministic.
//
// PixelWeights: the graph of a picture's pixels, in which each is beside the one to its right and the one
// below, and how sure it is that a boundary runs between two of them. Values.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "server/render/ink/modalities.h"
#include "server/render/ink/segments.h"

namespace mote::render {

struct PixelWeights {
    static constexpr std::uint16_t most = 65534;       ///< a boundary, if anything is
    static constexpr std::uint16_t parted = 65535;     ///< nothing is seen in one of the two
    static constexpr std::size_t right = 0, down = 1;  ///< of pixel i, at `of[2 * i + right]`

    std::uint32_t width = 0, height = 0;
    std::vector<std::uint16_t> of;

    /// The other pixel of a pair.
    std::size_t other(std::size_t pair) const { return pair / 2 + (pair % 2 == right ? 1 : width); }
    /// How much two pixels belong together, 0 to 1.
    static double affinity(std::uint16_t weight) { return 1.0 - std::min(weight, most) / double{most}; }
};

/// Steps between pixels that leave them an affinity of 1/e.
struct StepScales {
    double grey = 0.08;
    double angle = 0.35;   ///< radians
    double depth = 0.006;  ///< of the extent
};

/// How much steps there are around each pixel, in the mean: what is rough has many.
struct Roughness {
    Raster<float> grey, angle;  ///< the latter by the sine
};

/// Over a window of a standard deviation in pixels, within a surface. Steps from part to part are none.
Roughness roughnessOf(const Modalities& modalities, double deviation, const std::stop_token& stop);

/// Weights 1 - exp(-(sum of squared steps)), steps in units of their scales. A step is what neither the slope
/// before nor that behind it explains; grey is taken over two pixels on either side, as one pixel mixes what
/// is on both sides of a boundary. With `roughness`, its multiple `rough` adds to a scale, by squares: steps
/// like all around are no boundary. Between pixels of different parts is always one.
PixelWeights stepWeights(const Modalities& modalities, const StepScales& scales, const std::stop_token& stop,
                         const Roughness* roughness = nullptr, double rough = 0.0);

struct RegionGraph {
    struct Link {
        std::uint32_t a, b;  ///< regions beside each other, a < b
        double affinity;     ///< summed over pairs of pixels, 0 to 1 each
        double length;       ///< pairs of pixels, above 0
    };

    std::vector<double> inside;  ///< affinity of each region's pixels among themselves, each pair twice
    std::vector<Link> links;     ///< each pair of regions once, in their order
};

/// If `stop` is requested meanwhile, it lacks something.
RegionGraph regionGraphOf(const Segments& segments, const PixelWeights& weights, const std::stop_token& stop);

/// Melts boundaries that are none (Brice and Fennema 1970, Scene Analysis Using Regions): two regions become
/// one, those that belong together most first, where the mean affinity across their boundary is above `most`
/// and their mean directions are less than `turn` apart, radians.
Segments melted(Segments segments, const Modalities& modalities, const PixelWeights& weights, double most,
                double turn, const std::stop_token& stop);

}  // namespace mote::render
