// SPDX-License-Identifier: GPL-3.0-or-later
//
// Files compressed as a whole with Zstandard, as its command-line tool makes and reads them. The same bytes
// give the same file. A PackedSource has one owner and one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <streambuf>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "storage/files/file_descriptor.h"
#include "storage/files/path_beneath.h"

namespace mote::storage {

/// What a packed file's name ends with.
inline constexpr std::string_view packedSuffix = ".zst";

/// Of the window within which bytes refer to others: most of the memory that reading takes.
inline constexpr std::uint64_t unpackingBytes = std::uint64_t{1} << 24;

/// Puts `path` + ".zst", which is replaced, in the place of `path`. The file is not synced. Errors: notFound,
/// resourceExhausted (it cannot be written whole), internal.
Status packFile(const std::filesystem::path& path);

/// A packed file's bytes as they were, for a std::istream; in the memory of a window of 16 MiB at most.
/// If the file is damaged or shortened the bytes end.
class PackedSource final : public std::streambuf {
  public:
    /// Errors: as openRegular.
    static Result<std::unique_ptr<PackedSource>> open(const PathBeneath& path);
    /// Of an open file, from where it is read next.
    explicit PackedSource(FileDescriptor file);
    ~PackedSource() override;

  private:
    int_type underflow() override;
    bool readMore();

    struct Stream;
    std::unique_ptr<Stream> stream_;
    FileDescriptor file_;
    std::vector<char> packed_, plain_;
    std::size_t begin_ = 0, end_ = 0;  ///< of what is left of `packed_`
};

}  // namespace mote::storage
