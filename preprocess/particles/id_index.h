// SPDX-License-Identifier: GPL-3.0-or-later
//
// The id index of a step: its points by ascending id, of equal ids by ascending point. Made from the ids in
// the order of the points, as they lie in the file; ranges of ids one after another where the memory does not
// hold all. A function without state; uses all threads of the calling arena.
#pragma once

#include <cstddef>
#include <cstdint>

#include "preprocess/job.h"
#include "protocol/scene/error.h"
#include "storage/arrays/array_file.h"

namespace mote::prep {

struct IdArrays {
    std::size_t ids = 0, index = 0;  ///< in the file: u64, u32
    std::uint64_t points = 0;        ///< fewer than 2^32
};

/// `memory`: bytes that may be taken. Errors: resourceExhausted (disk full), internal, cancelled.
Status writeIdIndex(const storage::ArrayFileWriter& file, const IdArrays& arrays, std::uint64_t memory,
                    const Progress& progress);

}  // namespace mote::prep
