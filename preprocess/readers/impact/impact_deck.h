// SPDX-License-Identifier: GPL-3.0-or-later
//
// ImpactDeck: the input file of an IMPACT-Z or IMPACT-T run (ImpactZ.in, ImpactT.in), as far as its particle
// files need it: units, mass, and where in the machine each file was written. A value.
//
// The numbers stand one Fortran read after the other: after values separated by blanks or commas the rest of
// a line is not looked at, '/' ends a read early, '!' begins a comment, a read goes on in the next line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"

namespace mote::prep {

struct ImpactDeck {
    enum class Code : std::uint8_t { impactZ, impactT };

    double particles = 0.0;                ///< macro-particles at the start
    double current = 0.0;                  ///< A, averaged over a period of the frequency
    double kineticEnergy = 0.0;            ///< eV, of the reference particle at the start
    double mass = 0.0;                     ///< eV/c^2
    double charge = 0.0;                   ///< elementary charges
    double frequency = 0.0;                ///< Hz, of the scaling
    std::map<std::int64_t, double> dumps;  ///< path length in m at which file fort.N was written (IMPACT-Z)

    /// Reads a deck, gzipped or not. Errors: notFound, corrupt (with the line), those of LineReader.
    static Result<ImpactDeck> read(const std::filesystem::path& path, Code code);

    /// The deck in the same folder as a particle file; nothing where there is none that may be read.
    static std::optional<std::filesystem::path> beside(const std::filesystem::path& file, Code code);
};

/// `name`, or it with ".txt", ".gz" or ".txt.gz", in the same folder as `file`. Nothing where there is none.
std::optional<std::filesystem::path> fileBeside(const std::filesystem::path& file, std::string_view name);

/// Fort.18 of an IMPACT-Z run, the reference particle along the machine.
struct ReferenceTrack {
    struct Point {
        double path = 0.0;   ///< m
        double phase = 0.0;  ///< rad, of the scaling frequency: angular frequency times time
        double gamma = 1.0;  ///< total over rest energy
    };
    std::vector<Point> points;  ///< by path, at least one

    /// The track at a path length, between its points by straight lines; of points at one place the last.
    Point at(double path) const;

    /// Reads the file (columns path, phase, gamma, ...). Where the path falls back, an earlier run stands
    /// before and is left out. Errors: corrupt (with the line), those of LineReader.
    static Result<ReferenceTrack> read(const std::filesystem::path& path);
};

}  // namespace mote::prep
