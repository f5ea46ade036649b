// SPDX-License-Identifier: GPL-3.0-or-later
//
// Curve: a piecewise linear function, constant beyond its ends: one half of a transfer function.
// A value; knots ascend in x (equal x make a step: the later knot holds from there on).
#pragma once

#include <vector>

#include "protocol/base/error.h"

namespace mote {

class Curve {
  public:
    struct Knot {
        double x;  ///< scaled log density, 0 to 1, or a value in its source's unit
        double y;  ///< 0 to 1
        bool operator==(const Knot&) const = default;
    };

    static constexpr double largest = 1e300;  ///< of what x may be where nobody says more

    /// Errors: no knots, more than 256, x outside [least, greatest], y outside [0, 1], x that descends.
    static Result<Curve> create(std::vector<Knot> knots, double least = 0.0, double greatest = 1.0);
    static Curve constant(double y);

    double operator()(double x) const;
    double maximum() const;
    const std::vector<Knot>& knots() const { return knots_; }

    bool operator==(const Curve&) const = default;

  private:
    explicit Curve(std::vector<Knot> knots) : knots_(std::move(knots)) {}
    std::vector<Knot> knots_;
};

}  // namespace mote
