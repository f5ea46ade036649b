// SPDX-License-Identifier: GPL-3.0-or-later
//
// ZipDirectory: what a zip archive holds, as its central directory says, with every size held against the
// file's. Read from bytes that nobody vouches for. A value, free of threads.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/text/byte_source.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// One file of an archive.
struct ZipEntry {
    std::string name;
    std::uint64_t offset = 0;       ///< of its first byte, in the archive
    std::uint64_t storedBytes = 0;  ///< as they lie in the archive
    std::uint64_t bytes = 0;        ///< when they are unpacked
    std::uint32_t checksum = 0;     ///< CRC-32 of the unpacked bytes
    bool deflated = false;
};

/// True for the beginning of an archive, also of an empty one.
bool looksLikeZip(std::string_view begin);

/// The entries, in the order of the directory; zip64 is understood, what comes before the first entry is
/// stepped over. Errors, naming archive and entry: corrupt (sizes that contradict the file, entries that
/// overlap or have one name), unsupported (encrypted, split, packed by another method than deflate),
/// resourceExhausted (more than `most` entries), those of ByteSource.
Result<std::vector<ZipEntry>> readZipDirectory(ByteSource& archive, std::uint64_t most = 4096);

}  // namespace mote::prep
