// SPDX-License-Identifier: GPL-3.0-or-later
//
// RecordStore: many records of one size, in memory or in a file that has no name and so is gone with the
// process, however it ends. Move-only. Different records may be written and read from different threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "protocol/scene/error.h"
#include "storage/files/file_descriptor.h"

namespace mote::prep {

class RecordStore {
  public:
    RecordStore() = default;
    /// Errors: resourceExhausted.
    static Result<RecordStore> inMemory(std::uint64_t bytes);
    /// A file in `folder`, its space taken at once. Errors: resourceExhausted (disk full), permissionDenied.
    static Result<RecordStore> inFile(const std::filesystem::path& folder, std::uint64_t bytes);

    RecordStore(RecordStore&& other) noexcept;
    RecordStore& operator=(RecordStore&& other) noexcept;
    ~RecordStore();

    /// Errors: resourceExhausted (disk full), internal.
    template <class T>
    Status write(std::uint64_t first, std::span<const T> records) {
        return writeBytes(first * sizeof(T), std::as_bytes(records));
    }
    /// Records [first, first + count), where they lie or copied into `buffer`. Errors: internal.
    template <class T>
    Result<std::span<const T>> read(std::uint64_t first, std::uint64_t count, std::vector<T>& buffer) const {
        if (!memory_.empty() || count == 0) {
            return std::span(reinterpret_cast<const T*>(memory_.data()) + first, count);
        }
        buffer.resize(count);
        MOTE_RETURN_IF_ERROR(readBytes(first * sizeof(T), std::as_writable_bytes(std::span(buffer))));
        return std::span<const T>(buffer);
    }

  private:
    Status writeBytes(std::uint64_t at, std::span<const std::byte> bytes);
    Status readBytes(std::uint64_t at, std::span<std::byte> bytes) const;

    std::span<std::byte> memory_;
    storage::FileDescriptor file_;
    std::filesystem::path folder_;
};

}  // namespace mote::prep
