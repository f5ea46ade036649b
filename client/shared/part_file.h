// SPDX-License-Identifier: GPL-3.0-or-later
//
// PartFile: a file that grows under a hidden name beside its final one, ".NAME.part", and appears by one
// rename. It is locked while its owner lives, so that two processes do not write the same file, and so that
// what a killed process left is taken over and does not stay. One owner, one thread at a time.
#pragma once

#include <google/protobuf/message.h>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "protocol/base/error.h"

namespace mote::client {

class PartFile {
  public:
    /// Makes the hidden file, empty. Errors: those of the system for its folder; alreadyExists: `path` is a
    /// folder, or another process is writing it.
    static Result<std::unique_ptr<PartFile>> create(const std::filesystem::path& path);
    /// Removes the hidden file, unless it was published.
    ~PartFile();
    PartFile(const PartFile&) = delete;
    PartFile& operator=(const PartFile&) = delete;

    const std::filesystem::path& hidden() const { return hidden_; }
    /// Puts bytes at its end. Errors: those of the system.
    Status append(std::span<const std::uint8_t> bytes);
    /// Puts bytes over those at a place that was written before. Errors: those of the system.
    Status overwrite(std::uint64_t begin, std::span<const std::uint8_t> bytes);
    /// What was written is on the disk from then on. Errors: those of the system.
    Status sync();
    /// Gives it its final name; a file that had the name is replaced. Errors: those of the system.
    Status publish();
    /// The same, but whatever has that name stays. Errors: also alreadyExists.
    Status publishNew();

  private:
    PartFile(std::filesystem::path path, std::filesystem::path hidden, int file);
    Status write(std::span<const std::uint8_t> bytes);
    Status closeCopy();

    std::filesystem::path path_, hidden_;
    int file_;  ///< holds the lock
    bool published_ = false;
};

// Messages as JSON files that are there whole or not at all. Pure, but for the files.

/// What becomes of a file that has the name already.
enum class SameName { stays, isReplaced };

/// Writes the message as toJson() has it. What was there stays as it was where anything fails. Errors:
/// PartFile's; alreadyExists where it stays.
Status saveJson(const std::filesystem::path& path, const google::protobuf::Message& message,
                SameName sameName);

}  // namespace mote::client
