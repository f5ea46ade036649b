// SPDX-License-Identifier: GPL-3.0-or-later
//
// MappedFile: a regular file's bytes, mapped read-only, unmapped when it goes. Move-only; the bytes may be
// read from any thread. Published files never change; who shortens one while it is mapped makes its readers
// fail.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "protocol/scene/error.h"

namespace mote::storage {

class MappedFile {
  public:
    /// Errors: as openRegular, corrupt (its size is not `expectedSize`), resourceExhausted.
    static Result<MappedFile> open(const std::filesystem::path& path, std::uint64_t expectedSize);

    MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
    MappedFile& operator=(MappedFile&& other) noexcept {
        std::swap(bytes_, other.bytes_);
        return *this;
    }
    ~MappedFile();

    std::span<const std::byte> bytes() const { return bytes_; }

  private:
    explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}

    std::span<const std::byte> bytes_;
};

}  // namespace mote::storage
