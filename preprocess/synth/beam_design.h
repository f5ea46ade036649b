// SPDX-License-Identifier: GPL-3.0-or-later
//
// BeamDesign: the numbers of the synthetic run: particle, energy, bunch, lattice and mismatch. Its defaults
// are the run that `mote-prep synth beam` writes; docs/SYNTH.md says where each comes from. Plain values,
// free of threads.
#pragma once

#include <array>

namespace mote::prep {

/// Exact by the definition of the SI.
inline constexpr double speedOfLight = 299'792'458.0;        ///< m/s
inline constexpr double elementaryCharge = 1.602176634e-19;  ///< C
/// CODATA 2018.
inline constexpr double protonMassEv = 938.27208816e6;             ///< eV/c^2
inline constexpr double classicalProtonRadius = 1.5346982672e-18;  ///< m: e^2 / (4 pi eps0 m c^2)

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

}  // namespace mote::prep
