// SPDX-License-Identifier: GPL-3.0-or-later
//
// The core's envelope: the semi-axes of the uniform ellipsoid with the beam's rms sizes, driven by the
// channel, its own field and its emittances, integrated with RK4 element by element so that no step crosses a
// hard edge. Pure values.
//
// The field of the core: a uniform ellipsoid, linear inside, falling off outside. The exact form by
// Carlson's integrals, and CoreKick, the same as a polynomial that a loop over particles can vectorise.
#pragma once

#include <array>
#include <cstddef>

#include "preprocess/synth/fodo_channel.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// Carlson's R_D(x, y, z) = 3/2 int_0^inf dt / (sqrt((t+x)(t+y)) (t+z)^(3/2)), to a relative error below
/// 1e-15 (truncation) for positive arguments.
double carlsonRd(double x, double y, double z);

/// R_D with each of `squares` in turn as the last argument: the inner field of a uniform ellipsoid with
/// semi-axes sqrt(squares) is charge / (4 pi eps0) times these times the coordinates.
std::array<double, 3> ellipsoidForm(const std::array<double, 3>& squares);

/// The confocal coordinate of a point: 0 inside or on the ellipsoid; outside the positive root lambda of
/// sum u_i^2 / (squares_i + lambda) = 1. Iterated to the last bits.
double confocalCoordinate(const std::array<double, 3>& squares, const std::array<double, 3>& point);

/// The field of a uniform ellipsoid of unit charge over 4 pi eps0 at any point, exact to rounding.
std::array<double, 3> ellipsoidField(const std::array<double, 3>& squares,
                                     const std::array<double, 3>& point);

/// One space-charge kick: u_i' += u_i t^(3/2) P_i(2t - 1), where t = scale / (scale + lambda) is 1 inside the
/// core and goes to 0 far away. P_i is entire but for a cut well off [0, 1]: a polynomial through Chebyshev
/// nodes differs from it by less than 1e-6 for axes in the ratio 3 and less.
struct CoreKick {
    static constexpr std::size_t terms = 12;
    std::array<double, 3> squares{};                          ///< m^2, semi-axes squared
    double largest = 0.0;                                     ///< m^2, of `squares`
    double least = 0.0;                                       ///< m^2, of `squares`
    std::array<double, 3> leastOver{};                        ///< least / squares
    double scale = 1.0;                                       ///< m^2
    std::array<std::array<double, terms>, 3> coefficients{};  ///< 1/m, by plane, ascending powers of 2t - 1
};

/// `strength` in m^2: perveance times the length the kick stands for.
CoreKick coreKick(const std::array<double, 3>& axes, double strength);

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
    /// Error: invalidArgument if the design has none.
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
