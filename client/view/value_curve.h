// SPDX-License-Identifier: GPL-3.0-or-later
//
// ValueCurve: the opacity curve of a volume as the user edits it, over values in the source's own unit, with
// a colour at each knot or none. A value, free of any window.
#pragma once

#include <algorithm>
#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "client/view/edited_curve.h"
#include "client/view/knots.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/curve_presets.h"

namespace mote::client {

class ValueCurve final : public EditedCurve {
  public:
    using Color = std::array<float, 3>;  ///< sRGB-encoded

    const std::vector<Curve::Knot>& knots() const override { return knots_; }
    /// One a knot; none where a colour map has them.
    const std::vector<Color>& colors() const { return colors_; }
    /// The range of the values, and what knots there are beyond it.
    Interval axis() const;
    /// That of the knots, for a colour map; low < high.
    Interval extent() const;
    void setValues(const Interval& values) { values_ = values; }

    void move(std::size_t knot, Curve::Knot to) override;
    /// Its colour is that of the curve at its place.
    std::size_t insert(Curve::Knot at) override;
    void remove(std::size_t knot) override;
    void choose(std::size_t knot) override { chosen_ = knot; }

    void take(const CurvePreset& preset);
    /// Null where a colour map has the colours.
    Color* chosenColor() {
        return colors_.empty() ? nullptr : &colors_[std::min(chosen_, colors_.size() - 1)];
    }
    void dropColors() { colors_.clear(); }
    /// Linear RGB; black where a colour map has the colours.
    glm::dvec3 color(double value) const;

    /// Fills the curve and leaves the rest alone.
    void write(proto::HybridStyle& style) const;
    /// Takes the curve of a style that has been parsed without error; an empty one leaves nothing to be
    /// drawn.
    void read(const proto::HybridStyle& style);

    bool operator==(const ValueCurve& other) const {
        return knots_ == other.knots_ && colors_ == other.colors_ && values_ == other.values_;
    }

  private:
    Interval values_;
    std::vector<Curve::Knot> knots_{{0.0, 0.0}};  // one at least
    std::vector<Color> colors_;
    std::size_t chosen_ = 0;  // last taken hold of
};

}  // namespace mote::client
