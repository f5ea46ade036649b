// SPDX-License-Identifier: GPL-3.0-or-later
//
// KnotCurve: a curve as a hand edits it: its knots ascend in x, their y lies within [0, 1], and each has a
// colour or none has. A value, free of any window. EditedCurve is what the curve editor needs of it, or of
// two that are linked.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/curve.h"

namespace mote::client {

/// What an axis spans; low < high.
struct Interval {
    double low = 0.0;
    double high = 1.0;

    bool operator==(const Interval&) const = default;
};

class EditedCurve {
  public:
    virtual ~EditedCurve() = default;

    virtual const std::vector<Curve::Knot>& knots() const = 0;
    /// Held between its neighbours, on the axis.
    virtual void move(std::size_t knot, Curve::Knot to) = 0;
    /// Returns its index.
    virtual std::size_t insert(Curve::Knot at) = 0;
    /// The last one stays.
    virtual void remove(std::size_t knot) = 0;
    /// It was taken hold of.
    virtual void choose(std::size_t /*knot*/) {}
};

class KnotCurve final : public EditedCurve {
  public:
    using Color = std::array<float, 3>;  ///< sRGB-encoded

    /// More cannot be told apart by hand; the schema allows 256.
    static constexpr std::size_t mostKnots = 64;

    const std::vector<Curve::Knot>& knots() const override { return knots_; }
    /// The colours, one a knot; none if a colour map has them.
    const std::vector<Color>& colors() const { return colors_; }
    /// The range of the values, and what knots there are beyond it.
    Interval axis() const;
    /// The span from the first knot to the last, for a colour map; the axis where they are at one place.
    Interval extent() const;
    /// The range of the values; [0, 1] unless told otherwise.
    void setValues(const Interval& values) { values_ = values; }

    void move(std::size_t knot, Curve::Knot to) override;
    /// Adds a knot, in the colour of the curve at its place; before the first one or behind the last also one
    /// at that end of the axis, so that the rest stays as it is. If there are the most already, none is
    /// added.
    std::size_t insert(Curve::Knot at) override;
    void remove(std::size_t knot) override;
    void choose(std::size_t knot) override { chosen_ = knot; }

    /// Takes knots in ascending order; if there is none, one that leaves nothing to be drawn.
    void take(std::vector<Curve::Knot> knots, std::vector<Color> colors = {});
    /// The colour of the knot that was last taken hold of; null if a colour map has the colours.
    Color* chosenColor();
    void dropColors() { colors_.clear(); }
    /// Linear RGB; black if a colour map has the colours.
    glm::dvec3 color(double value) const;

    bool operator==(const KnotCurve& other) const {
        return knots_ == other.knots_ && colors_ == other.colors_ && values_ == other.values_;
    }

  private:
    void pinEnds(double x);

    Interval values_;
    std::vector<Curve::Knot> knots_{{0.0, 0.0}};  // one at least
    std::vector<Color> colors_;
    std::size_t chosen_ = 0;
};

}  // namespace mote::client
