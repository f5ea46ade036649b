// SPDX-License-Identifier: GPL-3.0-or-later
//
// The hashes of a dataset: XXH3-64 of the blocks of an array, XXH3-128 of whole files. They find damage, not
// malice. Pure functions, but for the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "protocol/base/error.h"

namespace mote::storage {

/// Bytes of an array that share one XXH3-64.
inline constexpr std::uint64_t blockBytes = 1ULL << 20;

std::uint64_t hashBlock(std::span<const std::byte> bytes);

/// XXH3-128 as 32 hexadecimal digits, in canonical (big-endian) order, as `xxhsum -H2` prints it.
std::string hash128(std::span<const std::byte> bytes);

struct FileHash {
    std::uint64_t size = 0;  ///< bytes
    std::string xxh3_128;    ///< 32 hexadecimal digits
};

/// The hash of a whole file, of which part comes after part. One thread at a time.
class FileHasher {
  public:
    FileHasher();
    ~FileHasher();
    void add(std::span<const std::byte> bytes);
    FileHash hash() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
    std::uint64_t size_ = 0;
};

/// Reads a regular file to its end, past the system's cache. Errors: notFound, permissionDenied, internal,
/// cancelled.
Result<FileHash> hashFile(const std::filesystem::path& path, const std::function<bool()>& cancelled = {});
/// The same of an open one, called `name`; where it is read next stays the same.
Result<FileHash> hashFile(int descriptor, const std::filesystem::path& name,
                          const std::function<bool()>& cancelled = {});

}  // namespace mote::storage
