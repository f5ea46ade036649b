// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hash.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cerrno>
#include <memory>

#include "protocol/scene/system_error.h"
#include "storage/files/file_descriptor.h"

namespace mote::storage {
namespace {

std::string toHex(XXH128_hash_t hash) {
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace

std::uint64_t hashBlock(std::span<const std::byte> bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

std::string hash128(std::span<const std::byte> bytes) {
    return toHex(XXH3_128bits(bytes.data(), bytes.size()));
}

Result<FileHash> hashFile(const std::filesystem::path& path, const std::function<bool()>& cancelled) {
    const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be opened");
    return hashFile(file.get(), path, cancelled);
}

Result<FileHash> hashFile(int descriptor, const std::filesystem::path& name,
                          const std::function<bool()>& cancelled) {
    XXH3_state_t state{};
    XXH3_128bits_reset(&state);
    constexpr std::size_t piece = 4 * blockBytes;
    const auto buffer = std::make_unique_for_overwrite<char[]>(piece);  // not cleared: most files are short
    FileHash result;
    while (true) {
        if (cancelled && cancelled()) return Error{ErrorCode::cancelled, name.string(), "cancelled"};
        const ssize_t got = ::pread(descriptor, buffer.get(), piece, static_cast<off_t>(result.size));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return systemError(errno, name.string(), "cannot be read");
        if (got == 0) break;
        XXH3_128bits_update(&state, buffer.get(), static_cast<std::size_t>(got));
        result.size += static_cast<std::uint64_t>(got);
    }
    result.xxh3_128 = toHex(XXH3_128bits_digest(&state));
    return result;
}

}  // namespace mote::storage
