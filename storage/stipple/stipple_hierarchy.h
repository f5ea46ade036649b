// SPDX-License-Identifier: GPL-3.0-or-later
//
// StippleHierarchy: a point set that thins out evenly (a dynamic Voronoi hierarchy, section 2.2 of the
// dissertation, docs/STIPPLES.md). Points are removed one by one; at each removal some of those that stay
// move a little, and these moves are kept. A value; whoever makes or reads it owns it. On disk it is
// hierarchy.h5 and hierarchy.digest (docs/FORMAT.md); writing has one thread at a time in a process (HDF5),
// reading any.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/files/path_beneath.h"

namespace mote::storage {

/// P points, M moves.
struct StippleHierarchy {
    std::vector<glm::vec3> positions;  ///< [P] before any removal; world units, the plane: unit square, z = 0
    std::vector<glm::vec3> normals;    ///< [P] of the surface there, unit length; the plane: 0, 0, 1
    std::vector<std::uint32_t> removal;  ///< [P] place in the order of removal, 0 the first; "/points/rank"
    std::vector<float> deathArea;        ///< [P] the largest cell that the point ever had, square world units
    std::vector<std::uint8_t> locked;    ///< [P] 1: could not move at some removal

    /// [P + 1] the moves of point p are movesBegin[p] to movesBegin[p + 1], in the order in which they were
    /// made: by ascending removal of the neighbour, which is below the point's own.
    std::vector<std::uint64_t> movesBegin;
    std::vector<std::uint32_t> moveNeighbour;  ///< [M] the point whose removal caused the move
    std::vector<glm::vec3> movePosition;       ///< [M] where the point then lies; the plane: not wrapped

    std::size_t size() const { return positions.size(); }
    std::uint64_t bytes() const;  ///< that it takes in memory
};

/// Whether the arrays agree with each other and hold what they must: removals a permutation, moves in order,
/// neighbours in range, numbers finite. Errors: corrupt, with the array's name ("/points/rank").
Status checkHierarchy(const StippleHierarchy& hierarchy);

inline constexpr const char* hierarchyName = "hierarchy";

/// Makes both files in `directory`; the hierarchy must be consistent. Errors: as writeArrayFile.
Status writeHierarchy(const std::filesystem::path& directory, const StippleHierarchy& hierarchy);

/// Reads all of it, every byte held to its digest, and checks it (checkHierarchy) and that it has the
/// manifest's points and moves. Errors: notFound, corrupt (with file and array), invalidArgument (a dataset
/// of another kind).
Result<StippleHierarchy> readHierarchy(const PathBeneath& directory, const proto::Manifest& manifest);

}  // namespace mote::storage
