// SPDX-License-Identifier: GPL-3.0-or-later
//
// ScratchFile: a file of pieces that a job puts aside while it does not know yet where they will lie, in the
// folder of the dataset that it makes. Gone with its owner; where the process is killed, with the folder.
// append() and read() may be called from any thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "protocol/scene/error.h"
#include "storage/files/file_descriptor.h"

namespace mote::storage {

class ScratchFile {
  public:
    /// A new one, removed in the end. Errors: alreadyExists, permissionDenied, resourceExhausted.
    static Result<std::unique_ptr<ScratchFile>> create(const std::filesystem::path& path);
    /// Another process' own, to read. Errors: notFound, permissionDenied.
    static Result<std::unique_ptr<ScratchFile>> open(const std::filesystem::path& path);

    ScratchFile(const ScratchFile&) = delete;
    ScratchFile& operator=(const ScratchFile&) = delete;
    ~ScratchFile();

    /// Returns where the bytes lie. Errors: resourceExhausted (disk full), internal.
    Result<std::uint64_t> append(std::span<const std::byte> bytes);
    /// Errors: internal, also where the file ends.
    Status read(std::uint64_t at, std::span<std::byte> bytes) const;
    /// So that processes of other machines can read it. Errors: resourceExhausted, internal.
    Status sync() const;

  private:
    ScratchFile(std::filesystem::path path, FileDescriptor file, bool own)
        : path_(std::move(path)), file_(std::move(file)), own_(own) {}

    std::filesystem::path path_;
    FileDescriptor file_;
    bool own_;
    std::atomic<std::uint64_t> end_{0};
};

}  // namespace mote::storage
