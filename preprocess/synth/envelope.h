// SPDX-License-Identifier: GPL-3.0-or-later
//
// The core's envelope: the semi-axes of the uniform ellipsoid with the beam's rms sizes, driven by the
// channel, its own field and its emittances, integrated with RK4 element by element so that no step crosses a
// hard edge. Pure values.
#pragma once

#include <array>

#include "preprocess/synth/fodo_channel.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// Semi-axes in x, y, zeta and their slopes. A uniform ellipsoid's semi-axis is sqrt(5) times its rms size.
struct Envelope {
    std::array<double, 3> axes{};    ///< m
    std::array<double, 3> slopes{};  ///< rad
};

class EnvelopeModel {
  public:
    explicit EnvelopeModel(const BeamDesign& design);

    const FodoChannel& channel() const { return channel_; }
    double perveance() const { return perveance_; }                        ///< m
    const std::array<double, 3>& emittance() const { return emittance_; }  ///< m rad, 5 times the rms one

    /// Advances it from `begin` to `end` (m) in steps of at most `step` (m).
    Envelope advance(Envelope envelope, double begin, double end, double step) const;

    /// The envelope at the start of a period that repeats after it, to 1e-12 relative, by Newton's method.
    /// Error: invalidArgument where the design has none.
    Result<Envelope> matched() const;

    /// Phase advance of a particle inside a matched core over one period, rad (depressed by space charge).
    std::array<double, 3> depressedAdvance(const Envelope& matched) const;

    static constexpr double defaultStep = 0.42 / 420;  ///< m

  private:
    Envelope derivative(const Envelope& envelope, const std::array<double, 3>& focusing) const;
    Envelope rungeKutta(const Envelope& envelope, const std::array<double, 3>& focusing, double step) const;
    Envelope smoothGuess() const;

    FodoChannel channel_;
    double perveance_;
    std::array<double, 3> emittance_{};
};

}  // namespace mote::prep
