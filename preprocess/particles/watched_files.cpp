// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/watched_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "storage/files/file_descriptor.h"

namespace mote::prep {
namespace {

constexpr std::size_t mostInFolder = 4096;

enum class Writer : std::uint8_t { none, some, unknown };

/// The kernel gives a lease of a file to read only while nobody has it open to write. It is given back at
/// once: whoever opens the file meanwhile waits for that. Of files of others, and on network file systems, it
/// gives none.
Writer writerOf(const std::filesystem::path& path) {
    const storage::FileDescriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    if (!file.valid()) return Writer::unknown;
    if (::fcntl(file.get(), F_SETLEASE, F_RDLCK) == 0) {
        ::fcntl(file.get(), F_SETLEASE, F_UNLCK);
        return Writer::none;
    }
    return errno == EAGAIN ? Writer::some : Writer::unknown;
}

std::string stampOfOne(const std::filesystem::path& path, bool& folder) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return {};
    folder = S_ISDIR(status.st_mode);
    return fmt::format("{} {} {} {}.{:09} {}.{:09}\n", status.st_dev, status.st_ino, status.st_size,
                       status.st_mtim.tv_sec, status.st_mtim.tv_nsec, status.st_ctim.tv_sec,
                       status.st_ctim.tv_nsec);
}

/// How long it has been as it is by the file system's clock, at most the patience.
WatchedFiles::Clock::duration ageOf(const std::filesystem::path& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return {};
    const auto changed = std::max(status.st_mtim.tv_sec, status.st_ctim.tv_sec);
    const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    return std::clamp<WatchedFiles::Clock::duration>(std::chrono::seconds(now - changed),
                                                     std::chrono::seconds(0), WatchedFiles::patience);
}

WatchedFiles::State stateOf(const WatchedFiles::File& file, bool seenBefore,
                            WatchedFiles::Clock::time_point now) {
    using State = WatchedFiles::State;
    if (file.stamp.empty() || !seenBefore) return State::changing;
    switch (writerOf(file.file.path)) {
        case Writer::none:
            return State::complete;
        case Writer::some:
            return State::open;
        default:
            return file.still(now) ? State::complete : State::changing;
    }
}

}  // namespace

std::string stampOf(const std::filesystem::path& path) {
    bool folder = false;
    auto stamp = stampOfOne(path, folder);
    if (!folder) return stamp;
    std::vector<std::string> inside;
    std::error_code code;
    for (std::filesystem::directory_iterator entry(path, code), end; !code && entry != end;
         entry.increment(code)) {
        bool ignored = false;
        inside.push_back(entry->path().filename().string() + " " + stampOfOne(entry->path(), ignored));
        if (inside.size() == mostInFolder) break;
    }
    std::sort(inside.begin(), inside.end());
    for (const auto& line : inside) stamp += line;
    return stamp;
}

Status WatchedFiles::look() {
    auto found = inputFiles(inputs_);
    if (!found.ok() && found.error().code != ErrorCode::notFound) return found.error();
    std::map<std::filesystem::path, const File*> before;
    for (const auto& file : files_) before.emplace(file.file.path, &file);
    const auto now = Clock::now();
    std::vector<File> files;
    for (auto& input : found.ok() ? *found : std::vector<InputFile>()) {
        File file{std::move(input), {}, now, State::changing};
        file.stamp = stampOf(file.file.path);
        if (file.stamp.empty()) continue;
        const auto known = before.find(file.file.path);
        const bool seen = known != before.end() && known->second->stamp == file.stamp;
        file.since = seen ? known->second->since : now;
        if (known == before.end()) file.since = now - ageOf(file.file.path);
        const bool settled = seen && known->second->state == State::complete;
        file.state = settled ? State::complete : stateOf(file, seen, now);
        files.push_back(std::move(file));
    }
    files_ = std::move(files);
    return success();
}

}  // namespace mote::prep
