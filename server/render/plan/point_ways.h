// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointWays: where the points of a step go on their way to another step of the run (docs/PICTURE.md, "Between
// steps"). A value; shared by plans.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace mote::render {

struct PointWays {
    /// What a Hermite curve's tangent is more than the straight way: at its begin, then at its end; in
    /// `unit`.
    using Bend = std::array<std::int16_t, 6>;
    /// How all points together go along an axis: as a body that swings by an angle, whose mean and deviation
    /// change evenly.
    struct Swing {
        double angle = 0.0;  ///< 0: each goes straight
        double mean = 0.0, spread = 1.0, endMean = 0.0, endSpread = 1.0;
    };

    std::vector<glm::vec3> ends;       ///< by point: its place in the other step, in the plot's box [0, 1]^3;
                                       ///< NaN where it stays, since the other step has it not
    std::array<Swing, 3> swings = {};  ///< by axis
    std::vector<Bend> bends = {};      ///< by point; empty: nothing is bent
    float unit = 0.0F;                 ///< parts of the box
};

/// The same at one share of the way. The ways outlive it.
class PlacesOnTheWay {
  public:
    PlacesOnTheWay(const PointWays& ways, double share) : ways_(ways) {
        const double left = 1.0 - share;
        first_ = ways.unit * share * left * left;
        last_ = ways.unit * share * share * left;
        for (int axis = 0; axis < 3; ++axis) {
            const auto& [angle, mean, spread, endMean, endSpread] =
                ways.swings[static_cast<std::size_t>(axis)];
            begin_[axis] = left;
            end_[axis] = share;
            offset_[axis] = 0.0;
            if (angle == 0.0) continue;
            const double here = (left * spread + share * endSpread) / std::sin(angle);
            begin_[axis] = here * std::sin(left * angle) / spread;
            end_[axis] = here * std::sin(share * angle) / endSpread;
            offset_[axis] = (left - begin_[axis]) * mean + (share - end_[axis]) * endMean;
        }
    }

    /// Of a point that begins at `place`.
    glm::dvec3 operator()(std::size_t point, const glm::dvec3& place) const {
        const glm::vec3& end = ways_.ends[point];
        if (std::isnan(end.x)) return place;
        const glm::dvec3 there = begin_ * place + end_ * glm::dvec3(end) + offset_;
        if (ways_.bends.empty()) return there;
        const auto& bend = ways_.bends[point];
        return there + first_ * glm::dvec3(bend[0], bend[1], bend[2]) -
               last_ * glm::dvec3(bend[3], bend[4], bend[5]);
    }

  private:
    const PointWays& ways_;
    glm::dvec3 begin_, end_, offset_;
    double first_, last_;
};

}  // namespace mote::render
