// SPDX-License-Identifier: GPL-3.0-or-later
//
// FodoChannel: a periodic channel of hard-edge quadrupoles (half F, drift, D, drift, half F) with linear rf
// focusing everywhere, and its exact linear maps. The longitudinal coordinate is zeta = gamma z, the distance
// from the synchronous particle in the bunch's own frame, so that all three planes obey u'' + k_u(s) u =
// space charge. Plain values, free of threads.
#pragma once

#include <array>
#include <vector>

#include "preprocess/constants.h"

namespace mote::prep {

/// CODATA 2018.
inline constexpr double protonMassEv = 938.27208816e6;             ///< eV/c^2
inline constexpr double classicalProtonRadius = 1.5346982672e-18;  ///< m: e^2 / (4 pi eps0 m c^2)

/// The numbers of the synthetic run: particle, energy, bunch, lattice and mismatch. Its defaults
/// are the run that `mote-prep synth beam` writes; docs/SYNTH.md says where each comes from. Plain values,
/// free of threads.
struct BeamDesign {
    double kineticEnergy = 6.7e6;                                ///< eV
    double current = 0.075;                                      ///< A, mean over an rf period
    double rfFrequency = 350.0e6;                                ///< Hz: one bunch a period
    std::array<double, 3> emittance{0.25e-6, 0.25e-6, 0.30e-6};  ///< m rad, normalised rms, planes x, y, z
    double periodLength = 0.42;                                  ///< m, one FODO cell
    double quadrupoleLength = 0.07;                              ///< m, each of the two in a cell
    double quadrupoleGradient = 36.0;                            ///< T/m
    double rfFocusing = 5.0;  ///< 1/m^2, longitudinal; defocuses x and y with half of it
    std::array<double, 3> mismatch{1.0, 1.0, 1.0};  ///< initial envelope over the matched one, planes x, y, z
};

/// The design mismatched by `mismatch` on the mean of x and y: the breathing mode, with a part of the
/// quadrupole mode (x more, y less) so that the two transverse planes grow different halos, and a little more
/// along.
BeamDesign mismatched(BeamDesign design, double mismatch);

/// What follows from a design's energy and current alone.
struct BeamKinematics {
    double beta = 0.0;      ///< v / c
    double gamma = 1.0;     ///< total energy over rest energy
    double momentum = 0.0;  ///< eV/c, of the synchronous particle
    double particlesPerBunch = 0.0;
    double perveance = 0.0;  ///< m: N r_p / (beta gamma)^2, the strength of a bunch's own field
};

/// Needs a positive energy, frequency and a current of at least 0.
BeamKinematics kinematics(const BeamDesign& design);

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
