// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5Column: a foreign dataset as one column of numbers, read piece by piece. Owned by a reader; used from one
// thread at a time, unless it says otherwise.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "preprocess/readers/hdf5/h5_chunks.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/hdf5/h5_numbers.h"
#include "protocol/base/error.h"
#include "storage/files/file_descriptor.h"

namespace mote::prep {

class H5Column {
  public:
    /// `dataset` is of `file`. Errors: unsupported (external or virtual storage, a filter other than
    /// deflate, lzf, shuffle and fletcher32, no numbers, more than one dimension longer than 1), corrupt
    /// (declares more than the file can hold).
    static Result<H5Column> open(const H5File& file, H5Object dataset);

    std::uint64_t rows() const { return rows_; }
    const H5Object& object() const { return numbers_.object(); }
    /// Whether several threads may read doubles at once: values as this machine has them that lie in the file
    /// one behind another, which are read without HDF5, or in chunks of at most a MiB.
    bool readsAtOnce() const { return own_.has_value(); }
    /// The same of integers.
    bool readsIntegersAtOnce() const;
    /// Bytes that it keeps while so many threads read: a decoded chunk each, or one if they take turns.
    std::uint64_t keptBytes(std::size_t threads) const {
        return numbers_.chunks() != nullptr ? numbers_.chunks()->bytes() * (own_ ? threads : 1) : 0;
    }

    /// Values [begin, begin + count), which must lie within the rows, as doubles. Error: corrupt.
    Status read(std::uint64_t begin, std::size_t count, double* values) const;
    /// The same as unsigned integers: negative ones wrap, so that any 64-bit id survives.
    Status read(std::uint64_t begin, std::size_t count, std::uint64_t* values) const;

  private:
    /// What values are in the file; the number itself says nothing.
    using Stored = std::variant<double, float, std::int8_t, std::int16_t, std::int32_t, std::int64_t,
                                std::uint8_t, std::uint16_t, std::uint32_t, std::uint64_t>;
    /// What is read by our own code.
    struct Own {
        Stored stored;
        std::shared_ptr<const storage::FileDescriptor> file;  ///< null: values are in chunks
        std::uint64_t offset = 0;                             ///< of the first
        std::unique_ptr<H5ChunkStore> chunks;
        std::uint64_t chunkRows = 0;
    };

    explicit H5Column(H5Numbers numbers) : numbers_(std::move(numbers)) {}
    static std::optional<Stored> storedAs(hid_t type);
    std::optional<Own> ownReading(const H5File& file) const;
    Status check(std::uint64_t begin, std::size_t count) const;
    template <class As, class Value>
    Status readOwn(std::uint64_t begin, std::size_t count, Value* values) const;
    Status fetch(std::uint64_t begin, std::size_t valueBytes, std::span<std::byte> bytes) const;
    Status fetchChunks(std::uint64_t begin, std::size_t valueBytes, std::span<std::byte> bytes) const;
    Status readAs(hid_t memoryType, std::uint64_t begin, std::size_t count, void* values) const;

    H5Numbers numbers_;
    std::optional<Own> own_;
    mutable std::vector<float> floats_;  // as they were read last by HDF5
    std::size_t axis_ = 0;               // the one dimension that is longer than 1
    std::uint64_t rows_ = 1;
};

}  // namespace mote::prep
