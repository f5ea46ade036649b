// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/frame_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>
#include <zstd.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>

#include "client/frames/picture_file.h"
#include "protocol/base/mote_check.h"
#include "protocol/base/system_error.h"
#include "protocol/wire/row_filter.h"

namespace mote::client {
namespace {

namespace fs = std::filesystem;

constexpr int level = 1;  // of zstd: pictures of points are noise

/// The first line of a frame's file; the payload follows.
struct Heading {
    std::string key;
    std::uint32_t width = 0, height = 0;
    std::uint64_t payload = 0;  // bytes

    std::string text() const { return fmt::format("mote-frame {} {} {} {}\n", key, width, height, payload); }
};

std::optional<Heading> readHeading(std::istream& file) {
    std::string line(200, '\0');
    file.getline(line.data(), static_cast<std::streamsize>(line.size()));
    std::istringstream words(line.c_str());
    std::string kind;
    Heading heading;
    words >> kind >> heading.key >> heading.width >> heading.height >> heading.payload;
    if (!file || words.fail() || kind != "mote-frame") return std::nullopt;
    return heading;
}

std::vector<std::uint8_t> packed(const FramePixels& pixels) {
    std::vector<std::uint8_t> filtered(std::size_t{pixels.width} * pixels.height *
                                       wire::filteredPixelSize(pixels.format));
    wire::filterRows(pixels.format, pixels.width, pixels.bytes, filtered);
    std::vector<std::uint8_t> payload(ZSTD_compressBound(filtered.size()));
    const std::unique_ptr<ZSTD_CCtx, std::size_t (*)(ZSTD_CCtx*)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, level);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
    const auto size =
        ZSTD_compress2(context.get(), payload.data(), payload.size(), filtered.data(), filtered.size());
    MOTE_CHECK(!ZSTD_isError(size));
    payload.resize(size);
    return payload;
}

}  // namespace

FrameStore::FrameStore(const fs::path& video)
    : folder_(video.parent_path() / fmt::format(".{}.frames", video.filename().string())) {}

FrameStore::~FrameStore() {
    if (lock_ >= 0) ::close(lock_);
}

Status FrameStore::open(bool keep) {
    MOTE_RETURN_IF_ERROR(makeFolder());
    if (lock_ < 0) lock_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock_ < 0) return systemError(errno, folder_.string(), "cannot be opened");
    if (::flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return Error{ErrorCode::alreadyExists, folder_.string(), "another process makes this film"};
    if (keep) return success();
    std::error_code code;
    for (const auto& entry : fs::directory_iterator(folder_, code)) fs::remove_all(entry.path(), code);
    return success();
}

Status FrameStore::makeFolder() const {
    std::error_code code;
    fs::create_directories(folder_, code);
    if (!code && fs::is_directory(folder_, code)) return success();
    if (!code) return Error{ErrorCode::alreadyExists, folder_.string(), "is no folder"};
    const bool denied = code == std::errc::permission_denied;
    return Error{denied ? ErrorCode::permissionDenied : ErrorCode::internal, folder_.string(),
                 "the folder for the film's frames cannot be made: " + code.message()};
}

fs::path FrameStore::fileOf(std::size_t index) const {
    return folder_ / fmt::format("frame-{:06}", index);
}

bool FrameStore::has(std::size_t index, std::string_view key) const {
    std::ifstream file(fileOf(index), std::ios::binary);
    const auto heading = readHeading(file);
    if (!heading || heading->key != key) return false;
    std::error_code code;
    return fs::file_size(fileOf(index), code) == heading->text().size() + heading->payload && !code;
}

Status FrameStore::put(std::size_t index, std::string_view key, const FramePixels& pixels,
                       std::vector<std::uint8_t> payload) const {
    MOTE_CHECK(pixels.format == proto::SRGB8);
    if (payload.empty()) payload = packed(pixels);
    const Heading heading{std::string(key), pixels.width, pixels.height, payload.size()};
    const auto text = heading.text();
    payload.insert(payload.begin(), text.begin(), text.end());
    return writeFile(fileOf(index), payload);
}

Result<FramePixels> FrameStore::read(std::size_t index) const {
    const auto path = fileOf(index);
    std::ifstream file(path, std::ios::binary);
    const auto heading = readHeading(file);
    if (!heading) return Error{ErrorCode::notFound, path.string(), "the film's frame is not there"};
    const std::vector<std::uint8_t> payload{std::istreambuf_iterator<char>(file), {}};
    proto::Frame message;
    message.set_width(heading->width);
    message.set_height(heading->height);
    message.set_encoding(proto::Frame::ZSTD);
    message.set_format(proto::SRGB8);
    auto pixels = decodeFrame(message, payload);
    if (!pixels.ok()) return Error{ErrorCode::corrupt, path.string(), pixels.error().message};
    return pixels;
}

void FrameStore::discard() const {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
}

}  // namespace mote::client
