// SPDX-License-Identifier: GPL-3.0-or-later
//
// What text headers (NRRD, MetaImage) have in common: named fields, asked for by name, and the files beside
// the header that hold its numbers. A header may name what lies in its own folder or below, and nothing else:
// who wrote it must not choose which files a job reads. Values, free of threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/volume/byte_stream.h"
#include "preprocess/volume/volume_shape.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// The files that a header names: by `field`, one name, or a pattern with its least and greatest number and
/// their step ("slice%03d.raw 1 99 1"; one below 0 counts down), or, if `field` begins with LIST, by the
/// lines of `list`. Errors, at `where`: corrupt (no file; more than VolumeShape::maxDimension).
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

/// Gives all numbers, `bytes` of them, one file after the other; each file has the same share of them and is
/// unwrapped. Errors: permissionDenied (a file of another folder), corrupt (a file of another length), those
/// of fileStream and `unwrap`.
Result<ByteStreamPtr> dataStream(DataFiles files, std::uint64_t bytes, const Unwrap& unwrap);

/// What follows the first `skip` bytes or, without them, the last `needed` bytes of a file; a compressed one
/// is read once to its end for that. Errors: as of read.
Result<ByteStreamPtr> skipHeader(ByteStreamPtr file, std::optional<std::uint64_t> skip, std::uint64_t needed);

/// A format's word for a scalar type.
struct ScalarTypeName {
    std::string_view name;
    ScalarType type;
};

class HeaderFields {
  public:
    /// `file` is the header's name, for errors.
    explicit HeaderFields(std::string file) : file_(std::move(file)) {}

    /// Case and blanks of a name do not matter. Errors: corrupt (a field that is there already).
    Status add(std::string_view name, std::string_view value);
    bool has(std::string_view name) const { return fields_.contains(plain(name)); }
    /// "" if there is no such field.
    std::string_view text(std::string_view name) const;
    /// All numbers of a field, blanks between them; empty if there is no such field. Errors: corrupt (no
    /// number; more than 64 of them).
    Result<std::vector<double>> numbers(std::string_view name) const;
    /// Returns exactly `count` finite numbers. Errors: corrupt.
    Result<std::vector<double>> numbers(std::string_view name, std::size_t count) const;
    /// All numbers of a field, whole and not negative. Errors: corrupt.
    Result<std::vector<std::uint64_t>> wholeNumbers(std::string_view name) const;
    /// Returns one such number; `otherwise` if there is no such field. Errors: corrupt.
    Result<std::uint64_t> wholeNumber(std::string_view name, std::uint64_t otherwise) const;
    /// Case does not matter. Errors: unsupported (none of `names`).
    Result<ScalarType> type(std::string_view name, std::span<const ScalarTypeName> names) const;
    /// A field that says yes or no, "True" or "1"; `otherwise` if there is none.
    bool flag(std::string_view name, bool otherwise) const;

    const std::string& file() const { return file_; }
    std::string where(std::string_view name) const { return file_ + ": " + std::string(name); }
    Error unsupported(std::string_view name, std::string message) const {
        return {ErrorCode::unsupported, where(name), std::move(message)};
    }
    Error corrupt(std::string_view name, std::string message) const {
        return {ErrorCode::corrupt, where(name), std::move(message)};
    }

  private:
    static std::string plain(std::string_view name);

    std::string file_;
    std::map<std::string, std::string> fields_;
};

}  // namespace mote::prep
