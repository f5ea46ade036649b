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

#include "protocol/scene/error.h"

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

}  // namespace mote::prep
