// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <span>
#include <string>

#include "protocol/base/json.h"
#include "protocol/base/system_error.h"
#include "protocol/base/utf8.h"
#include "protocol/scene/film/film_job.h"
#include "storage/files/dataset_file.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {
namespace {

using storage::FileDescriptor;

constexpr std::uint64_t kTail = 16 << 10;         // bytes of a file that are looked at
constexpr std::uint64_t kLargestFile = 16 << 20;  // bytes; then it begins anew
constexpr std::size_t kLongestResult = 256;       // bytes
constexpr std::size_t kLogLines = 50;
constexpr std::size_t kLongestLine = 300;   // bytes
constexpr std::size_t kLongestPhase = 200;  // bytes

/// The last bytes of a file that has another size than before, from a line's begin; nothing where it is the
/// same.
std::optional<std::string> newTail(const std::filesystem::path& path, std::uint64_t& knownSize) {
    const FileDescriptor file(open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    struct stat information {};
    if (!file.valid() || fstat(file.get(), &information) != 0 || !S_ISREG(information.st_mode)) return {};
    const auto size = static_cast<std::uint64_t>(information.st_size);
    if (size == knownSize) return {};
    const auto begin = size - std::min(size, kTail);
    std::string text(size - begin, '\0');
    const auto got = pread(file.get(), text.data(), text.size(), static_cast<off_t>(begin));
    text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    if (begin > 0) text.erase(0, text.find('\n') + 1);
    knownSize = size;
    // Its writers append, so that they go on at the new end.
    if (size > kLargestFile && ftruncate(file.get(), 0) == 0) knownSize = 0;
    return text;
}

std::vector<std::string_view> linesOf(std::string_view text) {
    std::vector<std::string_view> lines;
    while (!text.empty()) {
        const auto end = text.find('\n');
        if (const auto line = text.substr(0, end); !line.empty()) lines.push_back(line);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
    return lines;
}

/// The latest line that is whole and sound.
std::optional<proto::JobProgress> latestProgress(std::string_view text) {
    const auto end = text.rfind('\n');
    if (end == std::string_view::npos) return {};
    const auto lines = linesOf(text.substr(0, end));
    for (auto line = lines.rbegin(); line != lines.rend(); ++line) {
        proto::JobProgress progress;
        if (parseJson(*line, progress, "progress").ok() && std::isfinite(progress.progress()))
            return progress;
    }
    return {};
}

Status makeFolder(const std::filesystem::path& folder) {
    if (mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST) return success();
    return systemError(errno, folder.string(), "cannot be made");
}

Status writeFile(const std::filesystem::path& path, const std::string& text) {
    const FileDescriptor file(open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be written");
    return storage::writeAt(file.get(), 0, std::as_bytes(std::span(text)), path);
}

/// The line that mote-supervise leaves; nothing where it is not there, or not whole.
std::optional<JobFiles::Outcome> parseOutcome(const std::string& text) {
    JobFiles::Outcome outcome;
    if (std::sscanf(text.c_str(), "exit %d", &outcome.number) == 1) return outcome;
    outcome.timedOut = std::sscanf(text.c_str(), "timeout %d", &outcome.number) == 1;
    if (outcome.timedOut) return outcome;
    outcome.signalled = true;
    if (std::sscanf(text.c_str(), "signal %d", &outcome.number) == 1) return outcome;
    return {};
}

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

std::string plainText(std::string_view text, std::size_t longest) {
    std::string plain;
    while (!text.empty()) {
        const auto length = characterLength(text);
        const bool printable = length > 0 && !isControl(text.substr(0, length));
        const auto piece = printable ? text.substr(0, length) : text[0] == '\t' ? std::string_view(" ") : "?";
        if (plain.size() + piece.size() > longest) break;
        plain += piece;
        text.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return plain;
}

void JobFiles::forgetResults() {
    for (const char* name : {"result", "result.new", "progress"}) unlink((directory_ / name).c_str());
    progressSize_ = 0;
}

Status JobFiles::prepare(const proto::JobRequest& request, const std::filesystem::path& output) {
    MOTE_RETURN_IF_ERROR(makeFolder(directory_));
    forgetResults();
    MOTE_RETURN_IF_ERROR(writeFile(directory_ / "output", output.string()));
    return writeFile(directory_ / "request.json", toJson(request));
}

Status JobFiles::keepRequest(const proto::JobRequest& request) {
    MOTE_RETURN_IF_ERROR(makeFolder(directory_));
    // On the disk before anybody is told that there is such a job.
    auto written = storage::writeNewFile(directory_ / "request.json", toJsonLine(request));
    if (!written.ok()) remove();
    return written;
}

Status JobFiles::prepareArtifact() {
    forgetResults();
    return makeFolder(artifactFolder(directory_));
}

Status JobFiles::makeScratch(const std::filesystem::path& folder) {
    std::error_code code;
    std::filesystem::remove_all(folder, code);
    return makeFolder(folder);
}

bool JobFiles::refresh(proto::JobStatus& status) {
    bool changed = false;
    if (const auto text = newTail(directory_ / "progress", progressSize_)) {
        if (const auto latest = latestProgress(*text)) {
            status.set_progress(std::clamp(latest->progress(), 0.0, 1.0));
            status.set_phase(plainText(latest->phase(), kLongestPhase));
            changed = true;
        }
    }
    if (const auto text = newTail(directory_ / "log", logSize_)) {
        const auto lines = linesOf(*text);
        status.clear_log();
        for (auto i = lines.size() - std::min(lines.size(), kLogLines); i < lines.size(); ++i) {
            status.add_log(plainText(lines[i], kLongestLine));
        }
        changed = true;
    }
    return changed;
}

Result<std::optional<JobFiles::Outcome>> JobFiles::outcome() const {
    const auto text = storage::readWhole(directory_ / "result", kLongestResult);
    if (text.ok()) return parseOutcome(*text);
    // Something else in its place is no result; a file that cannot be opened now may well be one.
    if (text.error().code == ErrorCode::notFound || text.error().code == ErrorCode::corrupt)
        return std::optional<Outcome>();
    return text.error();
}

void JobFiles::note(const std::string& line) const {
    const FileDescriptor file(
        open((directory_ / "log").c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600));
    const auto text = line + "\n";
    if (!file.valid() || write(file.get(), text.data(), text.size()) < 0) return;
}

void JobFiles::remove() const {
    std::error_code code;
    std::filesystem::remove_all(directory_, code);
}

void JobFiles::removeRest() const {
    for (const char* name : {"output", "log", "progress", "result", "result.new"})
        unlink((directory_ / name).c_str());
}

// -------------------------------------------------------------------------------------- artifacts

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
