// SPDX-License-Identifier: GPL-3.0-or-later
//
// DraftFile: an output file while it is made: "NAME.partial-PID" beside its final place, published by one
// rename and removed in every other case. Move-only; one owner, one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>

#include "protocol/base/error.h"

namespace mote::prep {

class DraftFile {
  public:
    /// An empty file beside `output`, which must not exist. Errors: alreadyExists, notFound (the folder),
    /// permissionDenied, resourceExhausted, internal.
    static Result<DraftFile> create(const std::filesystem::path& output);

    DraftFile(DraftFile&& other) noexcept;
    DraftFile& operator=(DraftFile&&) = delete;
    ~DraftFile();

    const std::filesystem::path& path() const { return path_; }

    /// Takes the disk space for `bytes` now, so that a full disk shows before the work and not after it.
    /// If the file system cannot, it asks whether there is room. Errors: resourceExhausted, internal.
    Status reserve(std::uint64_t bytes) const;

    /// Puts the file on the disk and gives it its name. Errors: alreadyExists, resourceExhausted, internal.
    Status publish();

  private:
    DraftFile(std::filesystem::path output, std::filesystem::path path)
        : output_(std::move(output)), path_(std::move(path)) {}

    std::filesystem::path output_;
    std::filesystem::path path_;  ///< empty once published or moved from
};

}  // namespace mote::prep
