// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameStore: the frames of a film that becomes a video, each whole and without loss in a hidden folder
// beside it, so that a film that was killed goes on where it was. A frame appears by one rename. The folder
// is removed with discard(); else it stays. Any thread may put and read different frames at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/shared/decode.h"
#include "protocol/base/error.h"

namespace mote::client {

class FrameStore {
  public:
    /// The store of the video at that path.
    explicit FrameStore(const std::filesystem::path& video);

    ~FrameStore();
    FrameStore(const FrameStore&) = delete;
    FrameStore& operator=(const FrameStore&) = delete;

    const std::filesystem::path& folder() const { return folder_; }
    /// Makes the folder, without the frames of an earlier run unless they are to be kept; it is ours alone
    /// while the object lives. Errors: permissionDenied, alreadyExists (a file of its name, or another
    /// process has it), internal.
    Status open(bool keep);
    /// Tells whether a frame stands, made of what `key` says, and no shorter than it was written.
    bool has(std::size_t index, std::string_view key) const;
    /// `payload`: the lossless frame as it travelled; if it is empty the pixels are packed. SRGB8 only
    /// (our own invariant). Errors: as writeFile().
    Status put(std::size_t index, std::string_view key, const FramePixels& pixels,
               std::vector<std::uint8_t> payload) const;
    /// Errors: notFound, corrupt, with the file's name.
    Result<FramePixels> read(std::size_t index) const;
    void discard() const;

  private:
    Status makeFolder() const;
    std::filesystem::path fileOf(std::size_t index) const;

    std::filesystem::path folder_;
    int lock_ = -1;  // the folder, locked
};

}  // namespace mote::client
