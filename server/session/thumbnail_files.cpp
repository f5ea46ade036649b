// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "protocol/base/system_error.h"
#include "protocol/base/utf8.h"
#include "protocol/wire/private_file.h"
#include "server/jobs/state_directory.h"
#include "server/log.h"
#include "server/session/thumbnails.h"
#include "storage/files/file_descriptor.h"
#include "storage/hash.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view thumbnailSuffix = ".thumbnail";
constexpr std::size_t keyDigits = 32;
constexpr std::size_t largestThumbnail = std::size_t{1} << 20;  // bytes of a file

/// What a file begins with: its version and size, and what its other bytes hash to.
std::string headerOf(std::string_view jpeg) {
    return fmt::format("mote thumbnail 1, {} x {}, {}\n", Thumbnail::width, Thumbnail::height,
                       storage::hash128(std::as_bytes(std::span(jpeg))));
}

/// Empty of other files.
std::string keyIn(const fs::path& file) {
    const auto name = file.filename().string();
    const auto key = name.substr(0, keyDigits);
    const bool digits = key.find_first_not_of("0123456789abcdef") == std::string::npos;
    return digits && name == key + std::string(thumbnailSuffix) ? key : std::string();
}

/// What a server that was killed had not renamed yet.
bool isUnfinished(const fs::path& file) {
    return file.filename().string().find(std::string(thumbnailSuffix) + ".") == keyDigits;
}

/// Appears by one rename. Nothing waits for the disk, as who else writes there would wait too: what a machine
/// that crashes leaves of it is told by its hash, and drawn anew.
Status writeThumbnail(const fs::path& path, std::string_view text) {
    auto temporary = path.string() + ".XXXXXX";
    const storage::FileDescriptor file(::mkostemp(temporary.data(), O_CLOEXEC));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be made");
    const auto written = ::write(file.get(), text.data(), text.size());
    const bool whole = written >= 0 && static_cast<std::size_t>(written) == text.size();
    if (whole && ::rename(temporary.c_str(), path.c_str()) == 0) return success();
    const int error = written >= 0 && !whole ? ENOSPC : errno;
    ::unlink(temporary.c_str());
    return systemError(error, path.string(), "cannot be written");
}

}  // namespace

ThumbnailFiles::ThumbnailFiles(fs::path folder, std::uint64_t most)
    : folder_(std::move(folder)), most_(most) {
    const auto made = makeOwnFolder(folder_);
    usable_ = made.ok();
    if (usable_)
        look();
    else
        log::warn("no thumbnails are kept: {}", toLogText(made.error().toString()));
}

fs::path ThumbnailFiles::path(const std::string& key) const {
    return folder_ / (key + std::string(thumbnailSuffix));
}

/// Those of servers before, in the order in which they were used.
void ThumbnailFiles::look() {
    std::vector<std::tuple<fs::file_time_type, std::string, std::uint64_t>> found;
    std::error_code code;
    for (fs::directory_iterator at(folder_, code), end; !code && at != end; at.increment(code)) {
        std::error_code ignored;
        const auto key = keyIn(at->path());
        const bool file = at->is_regular_file(ignored) && !at->is_symlink(ignored);
        if (file && isUnfinished(at->path())) fs::remove(at->path(), ignored);
        if (!file || key.empty()) continue;
        const auto size = at->file_size(ignored);
        if (!ignored) found.emplace_back(at->last_write_time(ignored), key, size);
    }
    std::ranges::sort(found);
    for (const auto& [time, key, size] : found) add(key, size);
}

/// Makes room for it, if need be.
void ThumbnailFiles::add(const std::string& key, std::uint64_t bytes) {
    order_.push_front(key);
    files_[key] = {bytes, order_.begin()};
    bytes_ += bytes;
    while (bytes_ > most_ && order_.size() > 1) forget(order_.back());
}

void ThumbnailFiles::forget(const std::string& key) {
    const auto found = files_.find(key);
    if (found == files_.end()) return;
    std::error_code ignored;
    fs::remove(path(key), ignored);
    bytes_ -= found->second.bytes;
    order_.erase(found->second.place);
    files_.erase(found);
}

std::optional<Thumbnail> ThumbnailFiles::find(const std::string& key) {
    const auto found = files_.find(key);
    if (found == files_.end()) return std::nullopt;
    const auto text = wire::readPrivateFile(path(key), largestThumbnail);
    const auto begin = std::min(headerOf({}).size(), text.ok() ? text->size() : 0);
    if (!text.ok() || !text->starts_with(headerOf(std::string_view(*text).substr(begin)))) {
        forget(std::string(key));
        return std::nullopt;
    }
    order_.splice(order_.begin(), order_, found->second.place);
    // Its time tells the next server that it was used.
    ::utimensat(AT_FDCWD, path(key).c_str(), nullptr, AT_SYMLINK_NOFOLLOW);
    Thumbnail kept;
    kept.jpeg.assign(text->begin() + static_cast<std::ptrdiff_t>(begin), text->end());
    return kept;
}

void ThumbnailFiles::keep(const std::string& key, const Thumbnail& thumbnail) {
    const std::string_view jpeg(reinterpret_cast<const char*>(thumbnail.jpeg.data()), thumbnail.jpeg.size());
    const auto text = headerOf(jpeg).append(jpeg);
    if (!usable_ || text.size() > std::min<std::uint64_t>(most_, largestThumbnail)) return;
    forget(std::string(key));
    const auto written = writeThumbnail(path(key), text);
    // A full disk is said once, not at every thumbnail.
    if (!written.ok() && !saidFull_)
        log::warn("a thumbnail is not kept: {}", toLogText(written.error().toString()));
    saidFull_ = !written.ok();
    if (written.ok()) add(key, text.size());
}

}  // namespace mote::server
