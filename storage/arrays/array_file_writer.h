// SPDX-License-Identifier: GPL-3.0-or-later
//
// ArrayFileWriter: a dataset's file of arrays while it is written in parts: NAME.h5 and NAME.digest, laid out
// as docs/FORMAT.md says. Move-only; one owner, one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "protocol/scene/error.h"
#include "storage/arrays/array_layout.h"
#include "storage/files/file_descriptor.h"

namespace mote::storage {

class ArrayFileWriter {
  public:
    /// Makes `directory`/NAME.h5, which must be new. The same layout and bytes give the same file. Errors: as
    /// layOutFile.
    static Result<ArrayFileWriter> create(const std::filesystem::path& directory, const std::string& name,
                                          FileLayout layout);

    /// Bytes of an array, by its index in the layout, from its byte `at` on. Errors: resourceExhausted (disk
    /// full), internal.
    Status write(std::size_t array, std::uint64_t at, std::span<const std::byte> bytes) const;

    /// Puts the file on the disk and writes the digest of what is in it. Errors: resourceExhausted, internal.
    Status finish() const;

  private:
    ArrayFileWriter(std::filesystem::path path, FileLayout layout, std::vector<ArrayPlace> places,
                    FileDescriptor file)
        : path_(std::move(path)),
          layout_(std::move(layout)),
          places_(std::move(places)),
          file_(std::move(file)) {}

    std::filesystem::path path_;
    FileLayout layout_;
    std::vector<ArrayPlace> places_;
    FileDescriptor file_;
};

}  // namespace mote::storage
