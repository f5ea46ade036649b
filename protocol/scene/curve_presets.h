// SPDX-License-Identifier: GPL-3.0-or-later
//
// CurvePresets: opacity curves to begin with: for computed tomography in Hounsfield units, and for any volume
// by where its values lie; the first of a dataset's is what it is drawn with where nobody chose. And pairs of
// curves for particle plots. Pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/scene/curve.h"
#include "protocol/scene/hybrid_style.h"

namespace mote {

struct CurvePreset {
    std::string_view name;
    std::vector<Curve::Knot> knots;            ///< x: a value in the source's unit; y: opacity
    std::vector<std::array<float, 3>> colors;  ///< sRGB-encoded, one a knot; none: the colour map's
};

/// Whether values are Hounsfield units: by their unit, or, where it is not said, by what they span: air is
/// -1000, water 0, and bones are 300 to 3000. A part of a patient may have no air: it is known by its
/// histogram, of which half at least is tissue, most of it fat (-130 to -60) or muscles and organs (15 to
/// 120), and more is denser than that than lighter.
bool inHounsfieldUnits(std::string_view unit, const ValueRange& values,
                       std::span<const std::uint64_t> histogram = {});

/// Bones, vessels (with a contrast agent), soft tissue, skin, lungs.
std::span<const CurvePreset> tomographyPresets();

/// From which value on bones are drawn, HU: 290, or as far below, down to 150, as there is hardly more than
/// bone. That is where the histogram goes on as it falls from 300 to 700, exponentially: blood and organs
/// with a contrast agent would stand out of it. Where voxels are as large as bones are thin, much of these is
/// there.
double boneThreshold(std::span<const std::uint64_t> histogram, const ValueRange& values);

/// The object, its denser parts, its densest, layers of it and everything. What is the object and not what is
/// around it, is where Otsu's threshold lies (A threshold selection method from gray-level histograms, 1979);
/// the rest goes by quantiles of the values above it. `histogram`: even bins over `values`.
std::vector<CurvePreset> histogramPresets(std::span<const std::uint64_t> histogram, const ValueRange& values);

/// Where a colour map begins and ends if nobody says so: a curve from its first knot to its last, `knots`,
/// has the part of the map that can be read on black.
ValueRange readableColors(const ValueRange& knots);

/// Up to which value a picture of the greatest values has different colours: a 10,000th of all values lies
/// above it. `values.high` without a histogram.
double highestShown(std::span<const std::uint64_t> histogram, const ValueRange& values);

/// Those that suit values, the best first; one at least, also without a histogram. Of a patient: bones if a
/// 2000th of what is no air is, else lungs or soft tissue, of whichever there is more.
std::vector<CurvePreset> presetsOf(std::string_view unit, const ValueRange& values,
                                   std::span<const std::uint64_t> histogram);

/// The two curves of a particle plot.
struct DensityPreset {
    std::string_view name;
    std::vector<Curve::Knot> opacity;   ///< of the volume; x: scaled log density
    std::vector<Curve::Knot> fraction;  ///< of the points that are drawn, likewise
};

/// Halo and core, the core alone, the halo alone, all as volume, all as points.
std::span<const DensityPreset> densityPresets();

}  // namespace mote
