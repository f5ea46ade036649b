// SPDX-License-Identifier: GPL-3.0-or-later
//
// The files beside a header that hold its numbers (NRRD, MetaImage). A header may name what lies in its own
// folder or below, and nothing else: who wrote it must not choose which files a job reads. Functions without
// state.
#pragma once

#include <sys/resource.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/volume/byte_stream.h"

namespace mote::prep {

/// The files that a header names: by `field`, one name, or a pattern with its least and greatest number and
/// their step ("slice%03d.raw 1 99 1"), or, where `field` begins with LIST, by the lines of `list`. Errors,
/// at `where`: corrupt (no file; more than VolumeShape::maxDimension).
Result<std::vector<std::string>> dataFileNames(std::string_view field, std::string_view list,
                                               const std::string& where);

/// Turns the bytes of one file into the `needed` bytes of numbers in it: decompressed, headers skipped.
using Unwrap = std::function<Result<ByteStreamPtr>(ByteStreamPtr file, std::uint64_t needed)>;

/// A header that was read, and the files that it names.
struct DataFiles {
    std::filesystem::path header;
    ByteStreamPtr headerFile;
    std::uint64_t headerBytes = 0;
    std::vector<std::string> names;  ///< none: the data follow the header
};

/// All numbers, `bytes` of them, one file after the other; each file has the same share of them and is
/// unwrapped. Errors: permissionDenied (a file of another folder), corrupt (a file of another length), those
/// of fileStream and `unwrap`.
Result<ByteStreamPtr> dataStream(DataFiles files, std::uint64_t bytes, const Unwrap& unwrap);

/// What follows the first `skip` bytes or, without them, the last `needed` bytes of a file that is not
/// compressed. Errors: unsupported (a compressed file's last bytes), as of read.
Result<ByteStreamPtr> skipHeader(ByteStreamPtr file, std::optional<std::uint64_t> skip, std::uint64_t needed);

/// While it lives, the process gets no more than some memory beyond what it has: an allocation
/// that would need it throws std::bad_alloc. For libraries that believe every length in a file. The limit is
/// the process's own (RLIMIT_DATA): one at a time, while no other thread needs much.
class DataLimit {
  public:
    /// `more` in bytes. Where the system does not say what the process has, nothing is limited.
    explicit DataLimit(std::uint64_t more);
    ~DataLimit();
    DataLimit(const DataLimit&) = delete;
    DataLimit& operator=(const DataLimit&) = delete;

  private:
    rlimit before_{};
    bool set_ = false;
};

}  // namespace mote::prep
