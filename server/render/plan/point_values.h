// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointValues: a number of each point of a step, by which it is coloured (docs/PICTURE.md, "Colour by a
// column"), and DensityLevels: the density of its leaf ("Colour by density"). Values; shared by plans.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/scene/color_map.h"
#include "protocol/scene/log_density.h"
#include "protocol/scene/particles_style.h"
#include "protocol/scene/transfer_function.h"

namespace mote::render {

/// A point's value, told as a share of a colour map's range in 65535 even steps.
using ValueCode = std::uint16_t;
inline constexpr ValueCode noValue = 65535;
inline constexpr ValueCode greatestValue = 65534;

/// What lies beyond the range counts as its end, NaN as no value; in a range of one value that is the middle.
inline ValueCode codeOf(double value, const ValueRange& range) {
    if (std::isnan(value)) return noValue;
    const double width = range.high - range.low;
    if (!(width > 0.0)) return value < range.low ? 0 : value > range.high ? greatestValue : greatestValue / 2;
    const double share = (value - range.low) / width;
    return static_cast<ValueCode>(std::lround(greatestValue * std::fmin(std::fmax(share, 0.0), 1.0)));
}

struct PointValues {
    std::vector<ValueCode> codes;  ///< by point of the step; or:
    bool byLeaf = false;           ///< by leaf of the step, the same for all its points
    bool complete = true;          ///< each has a value

    std::uint64_t bytes() const { return codes.capacity() * sizeof(ValueCode); }
};

/// The densities by which points are coloured, told in 256 even steps of t: the same on every device.
class DensityLevels {
  public:
    static constexpr unsigned last = 255;

    /// `scale`: of the step whose densities are told.
    DensityLevels(const PointShade& shade, const LogDensity& scale) {
        constexpr float infinite = std::numeric_limits<float>::infinity();
        const double logRatio = scale.max > scale.min ? std::log(scale.max / scale.min) : 0.0;
        for (unsigned i = 0; i < last; ++i) {
            const double t = shade.t.low + (i + 0.5) / levelsOf(shade);
            if (logRatio > 0.0) {
                from_[i] = static_cast<float>(scale.min * std::exp(std::min(t, 2.0) * logRatio));
            } else {
                from_[i] = t <= 0.0 ? 0.0F : infinite;  // all leaves have t = 0
            }
        }
    }

    std::uint8_t of(float density) const {
        return static_cast<std::uint8_t>(std::upper_bound(from_.begin(), from_.end(), density) -
                                         from_.begin());
    }
    /// So much of that of a t, 0 to 1.
    static std::uint8_t at(const PointShade& shade, double t, double much) {
        const double level = std::clamp((t - shade.t.low) * levelsOf(shade), 0.0, double{last});
        // Not negative: NOLINTNEXTLINE(bugprone-incorrect-roundings)
        return static_cast<std::uint8_t>(std::clamp(much, 0.0, 1.0) * level + 0.5);
    }
    /// Levels to a t.
    static double levelsOf(const PointShade& shade) { return last / (shade.t.high - shade.t.low); }
    /// As the value of a point is told that is coloured by a column.
    static ValueCode code(unsigned level) {
        return static_cast<ValueCode>((level * std::uint32_t{greatestValue} + last / 2) / last);
    }

  private:
    std::array<float, last> from_;  // the densities at which all levels but the first begin
};

/// Levels by what a scaled log density is told as, before they are held to [0, last] and rounded.
struct LevelLine {
    float slope = 0.0F, shift = 0.0F;

    /// `told`: the scale by which PreviewPoint::density tells densities; `scale`: of the step.
    static LevelLine ofPreview(const PointShade& shade, const LogDensity& told, const LogDensity& scale) {
        constexpr double greatest = 65535.0;
        const double logRatio = scale.max > scale.min ? std::log(scale.max / scale.min) : 0.0;
        const double slope = logRatio > 0.0 ? std::log(told.max / told.min) / (logRatio * greatest) : 0.0;
        const double first = logRatio > 0.0 ? std::log(told.min / scale.min) / logRatio : 0.0;
        const double levels = DensityLevels::levelsOf(shade);
        return {static_cast<float>(slope * levels), static_cast<float>((first - shade.t.low) * levels)};
    }
};

/// How points take their colour from their values.
struct PointColors {
    std::shared_ptr<const PointValues> values;  ///< of all points of the step; null where there is a `shade`
    ColorMap map = ColorMap::standard();
    bool nearest = false;                  ///< that of a pixel's nearest point; or of the mean of all
    std::optional<PointShade> shade = {};  ///< the values are the densities of leaves (DensityLevels)

    /// The colour of a value, a share of all codes. Linear RGB.
    glm::dvec3 color(double value) const {
        return map(shade ? shade->colors.low + value * (shade->colors.high - shade->colors.low) : value);
    }
};

}  // namespace mote::render
