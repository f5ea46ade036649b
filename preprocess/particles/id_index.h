// SPDX-License-Identifier: GPL-3.0-or-later
//
// The points of a step by ascending id: what lies as /ids/point beside a step's columns. Of equal ids the
// lesser point comes first. The same index by either way.
//
// IdTable: where ids are little further apart than they are many, and none is twice, each has a place of its
// own in a table, which then holds the points in their order. Ids go there as they come by; move-only.
//
// writeIdIndex: of ids that lie in the file, which are read back: by a table if that can be, else sorted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/particles/record_store.h"
#include "protocol/base/error.h"
#include "storage/arrays/array_file.h"

namespace mote::prep {

struct IdArrays {
    std::size_t ids = 0, index = 0;  ///< in the file: u64, u32
    std::uint64_t points = 0;        ///< fewer than 2^32
};

/// Least and greatest; least above greatest: there is none.
struct IdRange {
    std::uint64_t least = std::numeric_limits<std::uint64_t>::max(), greatest = 0;

    void add(std::span<const std::uint64_t> ids);
    void add(const IdRange& other);
};

class IdTable {
  public:
    /// None where ids are further apart, or where there are not as many bytes as `mostBytes` to hold it.
    /// `ids`: all that will be added are in it. Errors: resourceExhausted.
    static Result<std::optional<IdTable>> make(const IdRange& ids, std::uint64_t points,
                                               std::uint64_t mostBytes,
                                               const std::shared_ptr<StoreMemory>& stores);

    /// Ids of points that follow each other, from `point` on. Any thread.
    void add(std::uint64_t point, std::span<const std::uint64_t> ids);

    /// Writes the index, on all threads of the calling arena; called once. Returns whether it did: not if an
    /// id was twice. Errors: resourceExhausted (disk full), cancelled.
    Result<bool> write(const storage::ArrayFileWriter& file, const IdArrays& arrays,
                       const Progress& progress);

    /// Bytes of the index that was written, from its byte `at` on, both whole numbers of points. Any thread.
    void read(std::uint64_t at, std::span<std::byte> bytes) const;

  private:
    IdTable(std::uint64_t least, std::uint64_t places, RecordStore store);
    std::uint64_t parts() const;
    std::span<std::uint32_t> partOf(std::uint64_t part) const;

    std::uint64_t least_;
    RecordStore store_;
    std::span<std::uint32_t> table_;
    std::vector<std::uint64_t> begin_;  ///< by part of the table, once it is written: points before it
};

/// `mostBytes`: of memory that it may take. Uses all threads of the calling arena. Errors: resourceExhausted
/// (memory, disk full), internal, cancelled.
Status writeIdIndex(const storage::ArrayFileWriter& file, const IdArrays& arrays, std::uint64_t mostBytes,
                    const std::shared_ptr<StoreMemory>& stores, const Progress& progress);

}  // namespace mote::prep
