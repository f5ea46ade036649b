// SPDX-License-Identifier: GPL-3.0-or-later
//
// ByteSource: the bytes of a regular file, those of a gzip file decompressed as they are read. One owner, one
// thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "preprocess/readers/text/inflater.h"
#include "protocol/scene/error.h"

namespace mote::prep {

class ByteSource {
  public:
    /// Errors: notFound, permissionDenied, unsupported (not a regular file), internal.
    static Result<std::unique_ptr<ByteSource>> open(const std::filesystem::path& path);
    ~ByteSource();
    ByteSource(const ByteSource&) = delete;
    ByteSource& operator=(const ByteSource&) = delete;

    const std::string& name() const { return name_; }
    bool compressed() const { return inflater_ != nullptr; }
    std::uint64_t fileBytes() const { return fileBytes_; }

    /// Fills as much of `bytes` as there is; 0 at the end. Errors: corrupt (damaged or cut gzip data),
    /// resourceExhausted (more than 1 TiB comes out), internal.
    Result<std::size_t> read(std::span<char> bytes);

    /// Goes to a place in a plain file, or to the beginning of a compressed one.
    Status seek(std::uint64_t offset);

  private:
    ByteSource() = default;
    Result<std::size_t> readFile(std::span<char> bytes);

    std::string name_;
    int descriptor_ = -1;
    std::uint64_t fileBytes_ = 0, offset_ = 0;
    std::unique_ptr<Inflater> inflater_;
};

}  // namespace mote::prep
