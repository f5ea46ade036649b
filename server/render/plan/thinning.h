// SPDX-License-Identifier: GPL-3.0-or-later
//
// Thinning: how the light of points of different weights is kept where fewer of them, or fewer pixels, are
// drawn (docs/PICTURE.md, "What a device may do"). A point hides no more than all: of what is heavy more are
// drawn. Values.
#pragma once

#include <vector>

namespace mote::render {

struct Thinning {
    double tau = 0.0;     ///< of a point of the mean weight in the exact picture; 0: all are thinned alike
    double rest = 1.0;    ///< diameter of a point there, in its pixels
    double here = 1.0;    ///< and here
    double pixels = 1.0;  ///< of here, a pixel of the exact picture: across or down
    double most = 0.0;    ///< optical depth of a point here

    /// To a few thousandths: a camera that turns about what it looks at does not choose anew for each
    /// picture.
    static Thinning roughly(const Thinning& exactly);

    bool operator==(const Thinning&) const = default;
};

/// The same for a share of the points; made once for many leaves.
class ThinnedWeights {
  public:
    ThinnedWeights(const Thinning& thinning, double share);

    /// Of points of a weight above 0, how many are drawn: `share` at least.
    double share(double weight) const;
    /// Their optical depth here, over that of points of the mean weight.
    double weightHere(double weight) const;

  private:
    static double between(const std::vector<double>& table, double weight);

    std::vector<double> shares_, weights_;  // by the logarithm of the weight; the second as a logarithm
};

}  // namespace mote::render
