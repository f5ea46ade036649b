// SPDX-License-Identifier: GPL-3.0-or-later
//
// FodoChannel: a periodic channel of hard-edge quadrupoles (half F, drift, D, drift, half F) with linear rf
// focusing everywhere, and its exact linear maps. The longitudinal coordinate is zeta = gamma z, the distance
// from the synchronous particle in the bunch's own frame, so that all three planes obey u'' + k_u(s) u =
// space charge. Plain values, free of threads.
#pragma once

#include <array>
#include <vector>

#include "preprocess/synth/beam_design.h"

namespace mote::prep {

/// A linear map of one plane: (u, u') -> (uu u + up u', pu u + pp u').
struct PlaneMap {
    double uu = 1.0;
    double up = 0.0;  ///< m
    double pu = 0.0;  ///< 1/m
    double pp = 1.0;

    /// First `earlier`, then this.
    PlaneMap after(const PlaneMap& earlier) const;
};

using ChannelMap = std::array<PlaneMap, 3>;  ///< x, y, zeta

/// A stretch of constant focusing.
struct ChannelElement {
    double begin = 0.0;                ///< m, from the period's start
    double length = 0.0;               ///< m
    std::array<double, 3> focusing{};  ///< 1/m^2, x, y, zeta; negative: defocusing
};

class FodoChannel {
  public:
    explicit FodoChannel(const BeamDesign& design);

    double periodLength() const { return periodLength_; }  ///< m
    /// One period, from the centre of a quadrupole that focuses x.
    const std::vector<ChannelElement>& elements() const { return elements_; }

    /// The map through [begin, end] (m, end >= begin >= 0) without space charge; edges are honoured exactly.
    ChannelMap map(double begin, double end) const;

    /// Zero-current phase advance of a period in `plane`, rad, in (0, pi). Needs a stable channel.
    double phaseAdvance(std::size_t plane) const;

  private:
    double periodLength_;
    std::vector<ChannelElement> elements_;
};

/// The exact map of one plane through `length` (m) of constant focusing `k` (1/m^2) of either sign.
PlaneMap constantFocusing(double k, double length);

}  // namespace mote::prep
