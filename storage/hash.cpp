// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hash.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cerrno>
#include <memory>

#include "protocol/base/system_error.h"
#include "storage/files/dataset_file.h"
#include "storage/files/file_descriptor.h"
#include "storage/hash_kernel.h"

namespace mote::storage {
namespace {

std::string toHex(XXH128_hash_t hash) {
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

#ifdef MOTE_HASH_BY_AVX2
const bool hasAvx2 = __builtin_cpu_supports("avx2") != 0;
#endif

}  // namespace

std::uint64_t hashBlock(std::span<const std::byte> bytes) {
#ifdef MOTE_HASH_BY_AVX2
    if (hasAvx2) return hashByAvx2(bytes.data(), bytes.size());
#endif
    return XXH3_64bits(bytes.data(), bytes.size());
}

std::string hash128(std::span<const std::byte> bytes) {
    return toHex(XXH3_128bits(bytes.data(), bytes.size()));
}

struct FileHasher::State {
    XXH3_state_t hash{};
};

FileHasher::FileHasher() : state_(std::make_unique<State>()) {
    XXH3_128bits_reset(&state_->hash);
}

FileHasher::~FileHasher() = default;

void FileHasher::add(std::span<const std::byte> bytes) {
    size_ += bytes.size();
#ifdef MOTE_HASH_BY_AVX2
    if (hasAvx2) return addByAvx2(&state_->hash, bytes.data(), bytes.size());
#endif
    XXH3_128bits_update(&state_->hash, bytes.data(), bytes.size());
}

FileHash FileHasher::hash() const {
    return {size_, toHex(XXH3_128bits_digest(&state_->hash))};
}

Result<FileHash> hashFile(const std::filesystem::path& path, const std::function<bool()>& cancelled) {
    const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be opened");
    return hashFile(file.get(), path, cancelled);
}

Result<FileHash> hashFile(int descriptor, const std::filesystem::path& name,
                          const std::function<bool()>& cancelled) {
    FileHasher hasher;
    constexpr std::size_t piece = 4 * blockBytes;
    const auto buffer = std::make_unique_for_overwrite<std::byte[]>(piece);  // not cleared: most are short
    std::uint64_t size = 0;
    while (true) {
        if (cancelled && cancelled()) return Error{ErrorCode::cancelled, name.string(), "cancelled"};
        const auto got = readPast(descriptor, size, {buffer.get(), piece});
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return systemError(errno, name.string(), "cannot be read");
        if (got == 0) break;
        hasher.add({buffer.get(), static_cast<std::size_t>(got)});
        size += static_cast<std::uint64_t>(got);
    }
    return hasher.hash();
}

}  // namespace mote::storage
