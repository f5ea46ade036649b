// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where an openPMD file keeps its iterations and, in each, its particles: `basePath` and `particlesPath` in
// every form that writers use. Values and functions without state.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/base/error.h"

namespace mote::prep {

struct OpenpmdIteration {
    std::int64_t number = 0;
    std::string path;       ///< "/data/550"
    bool numbered = false;  ///< false where basePath has no %T and the file holds one iteration
};

/// A group of particles in an iteration.
struct OpenpmdSpeciesPath {
    std::string name;  ///< "" where the records lie directly in particlesPath
    std::string path;
};

struct OpenpmdLayout {
    std::string version;                       ///< "1.1.0"
    std::optional<std::string> particlesPath;  ///< within an iteration; nothing where the file does not say
    std::vector<OpenpmdIteration> iterations;  ///< by number
    /// Groups of particles that were found where no root says where they are: those of the one iteration.
    std::vector<OpenpmdSpeciesPath> bare;
};

/// True where the root has what only openPMD files have.
bool looksLikeOpenpmd(const H5File& file);

/// The group below the root that says what only openPMD's root says, as archives of LUME have it; "" where
/// that is the root itself, or there is none. Errors: corrupt.
Result<std::string> findOpenpmdRoot(const H5File& file);

/// True where groups of openPMD particles lie anywhere in a file whose root says nothing of it.
bool holdsOpenpmd(const H5File& file);

/// Errors: unsupported (a version that is not 1 or 2), notFound (no iteration), corrupt.
Result<OpenpmdLayout> readOpenpmdLayout(const H5File& file);

/// All groups of particles in one iteration; none where it has no particles. Errors: corrupt, unsupported.
Result<std::vector<OpenpmdSpeciesPath>> listSpecies(const H5File& file, const OpenpmdLayout& layout,
                                                    const OpenpmdIteration& iteration);

/// The number that "%T" or "%06T" in `pattern` has in `name`; nothing where they do not match.
std::optional<std::int64_t> matchIteration(std::string_view pattern, std::string_view name);

}  // namespace mote::prep
