// SPDX-License-Identifier: GPL-3.0-or-later
//
// Bytes in blocks, each compressed for itself by zlib, as VTK writes them: going back needs no more than the
// block. One owner, one thread at a time.
#pragma once

#include <vector>

#include "preprocess/volume/byte_stream.h"

namespace mote::prep {

struct ZlibBlocks {
    std::uint64_t blockBytes = 0;           ///< of each block, decompressed, but for the last one
    std::uint64_t bytes = 0;                ///< decompressed, in all
    std::vector<std::uint64_t> compressed;  ///< bytes of each block, one after the other
};

/// What comes out of the blocks in `data`, which begins with the first one. Errors: corrupt (more than the
/// data can hold), internal.
Result<ByteStreamPtr> zlibBlockStream(ByteStreamPtr data, ZlibBlocks blocks);

}  // namespace mote::prep
