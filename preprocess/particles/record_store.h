// SPDX-License-Identifier: GPL-3.0-or-later
//
// RecordStore: many records of one size, in memory or in a file that has no name and so is gone with the
// process, however it ends. Move-only. Different records may be written and read from different threads.
//
// StoreMemory: the memory of one job's stores. What one gives back the next one gets: a page that was touched
// once is there, where a fresh one is cleared first, and on a virtual machine fetched from its host. What is
// in use and what is kept for the next are together never more than was in use at once, or is now. Any
// thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/base/mote_check.h"
#include "storage/files/file_descriptor.h"

namespace mote::prep {

class StoreMemory {
  public:
    StoreMemory() = default;
    StoreMemory(const StoreMemory&) = delete;
    StoreMemory& operator=(const StoreMemory&) = delete;
    ~StoreMemory();

    /// At least so many bytes, of any content; nothing where there are none.
    std::span<std::byte> take(std::uint64_t bytes);
    void giveBack(std::span<std::byte> memory);
    /// Bytes that are kept for the next.
    std::uint64_t kept() const;

  private:
    std::span<std::byte> takeKept(std::uint64_t bytes);
    void release(std::uint64_t most);

    mutable std::mutex mutex_;
    std::vector<std::span<std::byte>> kept_;
    std::uint64_t keptBytes_ = 0, used_ = 0, most_ = 0;  ///< most_: that were used at once
};

class RecordStore {
  public:
    RecordStore() = default;
    /// Errors: resourceExhausted.
    static Result<RecordStore> inMemory(std::uint64_t bytes, std::shared_ptr<StoreMemory> memory);
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

    /// Asks the memory for records that are read soon; nothing if they are in a file.
    template <class T>
    void expect(std::uint64_t first, std::uint64_t count) const {
        constexpr std::size_t line = 64, most = 8;
        if (memory_.empty()) return;
        const auto* at = memory_.data() + first * sizeof(T);
        for (std::size_t i = 0; i < std::min<std::uint64_t>(count * sizeof(T) / line + 1, most); ++i)
            __builtin_prefetch(at + i * line);
    }

    /// Records of a store in memory, to be written to where they lie.
    template <class T>
    std::span<T> room(std::uint64_t first, std::uint64_t count) {
        MOTE_CHECK(first <= memory_.size() / sizeof(T) && count <= memory_.size() / sizeof(T) - first);
        return {reinterpret_cast<T*>(memory_.data()) + first, count};
    }

  private:
    Status writeBytes(std::uint64_t at, std::span<const std::byte> bytes);
    Status readBytes(std::uint64_t at, std::span<std::byte> bytes) const;

    std::shared_ptr<StoreMemory> owner_;  ///< of the memory
    std::span<std::byte> memory_;
    storage::FileDescriptor file_;
    std::filesystem::path folder_;
};

}  // namespace mote::prep
