// SPDX-License-Identifier: GPL-3.0-or-later
//
// PictureFiles: each frame as a file of a folder, DIR/frame-000000.EXT. See frame_sink.h.
#pragma once

#include "client/frames/frame_sink.h"
#include "client/frames/picture_file.h"

namespace mote::client {

class PictureFiles final : public FrameSink {
  public:
    PictureFiles(std::filesystem::path folder, PictureFormat format)
        : folder_(std::move(folder)), format_(format) {}
    /// Takes the folder away where it was made and nothing came to lie in it.
    ~PictureFiles() override;

    Status open(bool resume) override;
    bool has(std::size_t index, std::string_view key, std::uint32_t width,
             std::uint32_t height) const override;
    Status put(DrawnFrame frame) override;
    std::size_t backlog() const override { return 0; }
    Status finish(const std::function<bool(std::size_t)>&) override { return success(); }
    std::filesystem::path fileOf(std::size_t index) const override;

  private:
    std::filesystem::path folder_;
    PictureFormat format_;
    bool made_ = false;
};

}  // namespace mote::client
