// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a film or export job has made: the files in the folder film/ of its own. Their names are made here,
// from the request, and never a client's. Functions without state, any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::server {

/// ArtifactPiece: some bytes of a file of a film, or of an export, and what they are. A value.
struct ArtifactPiece {
    proto::FilmPiece message;
    std::vector<std::uint8_t> bytes;
};

inline constexpr std::size_t largestArtifactPiece = std::size_t{1} << 20;  ///< bytes

/// `directory`: of the job; here and below.
inline std::filesystem::path artifactFolder(const std::filesystem::path& directory) {
    return directory / "film";
}

/// The one file of an export.
inline constexpr const char* exportName = "export.h5";

/// Whether the export or the video is there, or of a film without one its first picture.
bool artifactIsThere(const std::filesystem::path& directory, const proto::JobRequest& job);

/// The piece that is asked for, as long as the file has bytes and largestArtifactPiece allows. Errors:
/// notFound (the film has no video, no pictures, or fewer pictures; an export has none), invalidArgument
/// (beyond the file's end), corrupt (no regular file), permissionDenied, internal; with the field of the
/// request.
Result<ArtifactPiece> readArtifact(const std::filesystem::path& directory, const proto::JobRequest& job,
                                   const proto::FetchFilm& request);

}  // namespace mote::server
