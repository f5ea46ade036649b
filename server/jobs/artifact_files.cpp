// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/artifact_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <span>
#include <string>

#include "protocol/scene/film_job.h"
#include "protocol/scene/system_error.h"
#include "storage/files/dataset_file.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

using storage::FileDescriptor;

FileDescriptor openFramesFolder(const std::filesystem::path& directory) {
    const auto folder = artifactFolder(directory);
    return FileDescriptor(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
}

bool isThere(const FileDescriptor& folder, const std::string& name) {
    struct stat status {};
    return fstatat(folder.get(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(status.st_mode);
}

/// The file that is not one of pictures; empty where there is none.
std::string wholeName(const proto::JobRequest& job) {
    return job.has_export_() ? exportName : filmVideoName(job.film());
}

/// The pictures of a film that is done have no gaps: a search by halves finds where they end.
std::uint32_t countPictures(const FileDescriptor& folder, const proto::FilmJob& job) {
    const auto there = [&](std::uint32_t frame) { return isThere(folder, filmPictureName(job, frame)); };
    std::uint32_t end = 1;  // the count is below it
    while (end < (1U << 31) && there(end - 1)) end *= 2;
    std::uint32_t begin = end / 2;  // the count is at least it, of which the last one is there
    while (begin + 1 < end) {
        const auto middle = begin + (end - begin) / 2;
        (there(middle - 1) ? begin : end) = middle;
    }
    return begin;
}

Error missing(const FileDescriptor& folder, const proto::JobRequest& job, const proto::FetchFilm& request) {
    if (!request.has_frame()) return {ErrorCode::notFound, "", "what the job made is not there any more"};
    const auto count = countPictures(folder, job.film());
    if (count == 0)
        return {ErrorCode::notFound, "frame", "the film has no pictures any more, only its video"};
    return {ErrorCode::notFound, "frame",
            fmt::format("the film has {} pictures, the last of them number {}", count, count - 1)};
}

}  // namespace

bool artifactIsThere(const std::filesystem::path& directory, const proto::JobRequest& job) {
    const auto whole = wholeName(job);
    const auto file = artifactFolder(directory) / (whole.empty() ? filmPictureName(job.film(), 0) : whole);
    // Opens nothing: with no descriptors left it is as true. The job cannot put a link in its folder's place.
    struct stat status {};
    return lstat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode);
}

Result<ArtifactPiece> readArtifact(const std::filesystem::path& directory, const proto::JobRequest& job,
                                   const proto::FetchFilm& request) {
    if (request.has_frame() && job.has_export_())
        return Error{ErrorCode::notFound, "frame", "an export has no pictures"};
    const auto name = request.has_frame() ? filmPictureName(job.film(), request.frame()) : wholeName(job);
    if (name.empty()) {
        return Error{ErrorCode::notFound, "frame",
                     "is missing: the film has no video, only pictures, each asked for by its number"};
    }
    const auto folder = openFramesFolder(directory);
    // O_NONBLOCK: a named pipe in a file's place must not make anyone wait.
    const FileDescriptor file(
        openat(folder.get(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    if (!file.valid() && errno == ENOENT) return missing(folder, job, request);
    struct stat status {};
    if (!file.valid() || fstat(file.get(), &status) != 0) return systemError(errno, name, "cannot be opened");
    if (!S_ISREG(status.st_mode)) return Error{ErrorCode::corrupt, name, "is not a regular file"};
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (request.begin() > size) {
        return Error{ErrorCode::invalidArgument, "begin",
                     fmt::format("lies beyond the {} bytes of {}", size, name)};
    }
    ArtifactPiece piece;
    piece.message.set_name(name);
    piece.message.set_size(size);
    piece.message.set_begin(request.begin());
    piece.bytes.resize(std::min<std::uint64_t>(size - request.begin(), largestArtifactPiece));
    MOTE_RETURN_IF_ERROR(
        storage::readAt(file.get(), request.begin(), std::as_writable_bytes(std::span(piece.bytes)), name));
    return piece;
}

}  // namespace mote::server
