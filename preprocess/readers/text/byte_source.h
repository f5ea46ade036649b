// SPDX-License-Identifier: GPL-3.0-or-later
//
// ByteSource: the bytes of a regular file, those of a gzip file decompressed as they are read. One owner, one
// thread at a time.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// Deflated data decompressed as they come, through one buffer whatever their size. One owner,
/// one thread at a time.
class Inflater {
  public:
    /// gzip: what follows a member is another one, or padding. zlib: a stream as of RFC 1950, nothing behind
    /// it is looked at; gzip data are taken too. raw: deflated data without any header, as of RFC 1951.
    enum class Form : std::uint8_t { gzip, zlib, raw };
    /// Fills as much of the bytes as there is of compressed data; 0 at their end.
    using Refill = std::function<Result<std::size_t>(std::span<char>)>;

    /// `name` is the file's, for errors. Errors: internal.
    static Result<std::unique_ptr<Inflater>> make(Form form, std::string name);
    ~Inflater();
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;

    /// Fills as much of `bytes` as there is; 0 at the end. Errors: corrupt (damaged or cut data),
    /// resourceExhausted (more than 1 TiB comes out), those of `refill`.
    Result<std::size_t> read(std::span<char> bytes, const Refill& refill);
    /// Forgets what it has: the next bytes of `refill` are the beginning of compressed data.
    Status reset();

  private:
    Inflater(Form form, std::string name) : form_(form), name_(std::move(name)) {}
    const char* formName() const {
        return form_ == Form::gzip ? "gzip" : form_ == Form::zlib ? "zlib" : "deflated";
    }
    Status fill(const Refill& refill);
    Status endOfMember(const Refill& refill);

    Form form_;
    std::string name_;
    z_stream stream_{};
    std::vector<char> input_;
    std::uint64_t produced_ = 0;
    bool atEnd_ = false;
};

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

/// The first bytes of a file, at most so many. Errors: those of ByteSource.
Result<std::string> beginningOf(const std::filesystem::path& path, std::size_t most);

/// All of a file, taken a piece at a time, so that no size that it claims for itself is believed. Errors:
/// those of ByteSource, cancelled; resourceExhausted with the sentence `tooLong` where it is more than `most`
/// bytes.
Result<std::string> wholeFile(const std::filesystem::path& path, std::uint64_t most,
                              const std::string& tooLong, Progress& progress);

}  // namespace mote::prep
