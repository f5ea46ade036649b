// SPDX-License-Identifier: GPL-3.0-or-later
//
// EditedCurve: what the curve editor needs of a curve. Implementations keep the knots in order and in range.
#pragma once

#include <cstddef>
#include <vector>

#include "protocol/scene/curve.h"

namespace mote::client {

class EditedCurve {
  public:
    virtual ~EditedCurve() = default;

    virtual const std::vector<Curve::Knot>& knots() const = 0;
    virtual void move(std::size_t knot, Curve::Knot to) = 0;
    /// Returns its index.
    virtual std::size_t insert(Curve::Knot at) = 0;
    /// The last one stays.
    virtual void remove(std::size_t knot) = 0;
    /// It was taken hold of.
    virtual void choose(std::size_t /*knot*/) {}
};

}  // namespace mote::client
