// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobFiles: the directory of one job, through which a server and a running job speak: request.json in,
// progress (lines of JobProgress), log and result out. What a job writes is not trusted: it is bounded and
// made plain text. Owned by the queue and used on its thread.
//
// An artifact is what stays with a job that makes no dataset, a film or an export: files in a folder of the
// job's, whose names are made here, from the request, and never a client's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::server {

class JobFiles {
  public:
    /// How the job's program ended.
    struct Outcome {
        bool signalled = false;
        bool timedOut = false;  ///< its time limit ended it
        int number = 0;         ///< exit code, or signal; of a time limit the limit, s
    };

    explicit JobFiles(std::filesystem::path directory) : directory_(std::move(directory)) {}

    const std::filesystem::path& directory() const { return directory_; }

    /// Makes the directory (0700) with the request and where its output is to lie, without results of an
    /// earlier attempt. Errors: permissionDenied, resourceExhausted (the disk), internal.
    Status prepare(const proto::JobRequest& request, const std::filesystem::path& output);
    /// Makes the directory of a film or an export with its request, which is too large to be kept anywhere
    /// else. Errors: as prepare; nothing is left then.
    Status keepRequest(const proto::JobRequest& request);
    /// The same directory before an attempt: a place for what it makes, no results of an earlier one; what is
    /// made of a film stays. Errors: as prepare.
    Status prepareArtifact();

    /// An empty folder of the job's. Errors: as prepare.
    static Status makeScratch(const std::filesystem::path& folder);

    /// Puts what the job has written into `status`; false where nothing is new since the last call.
    bool refresh(proto::JobStatus& status);

    /// Nothing: it has not ended, or was interrupted. Errors: resourceExhausted, permissionDenied, internal
    /// (what it has left cannot be read now).
    Result<std::optional<Outcome>> outcome() const;

    /// Adds a line to the job's log.
    void note(const std::string& line) const;
    void remove() const;
    /// All but its request and what it made.
    void removeRest() const;

  private:
    void forgetResults();

    std::filesystem::path directory_;
    std::uint64_t progressSize_ = 0;  // bytes at the last refresh
    std::uint64_t logSize_ = 0;
};

/// Printable and valid UTF-8, whatever a program wrote: other bytes become "?"; cut to `longest` bytes.
std::string plainText(std::string_view text, std::size_t longest);

/// ArtifactPiece: some bytes of a file of an artifact, and what they are. A value.
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
