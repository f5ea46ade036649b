// SPDX-License-Identifier: GPL-3.0-or-later
//
// DatasetThumbnails: small pictures of datasets, by a line of their own to the server, of those that are on
// the screen; those that were seen last are kept. A server of minor 4 keeps them too. An older one is asked
// for views, one at a time: the session is one of the background, whose pictures are made while nobody else
// waits for one. Owned by the viewer; main thread, with the window's context current.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/shared/connection.h"
#include "client/view/window.h"
#include "protocol/mote.pb.h"

namespace mote::client {

class DatasetThumbnails {
  public:
    static constexpr std::uint32_t width = 128, height = 72;  ///< pixels, of an older server
    static constexpr std::size_t mostAwaited = 8;             ///< of a server that keeps them
    static constexpr std::size_t most = 256;                  ///< that are kept

    /// The connection file of the server, which is not asked before there is something to draw.
    explicit DatasetThumbnails(std::filesystem::path connection) : file_(std::move(connection)) {}

    /// What is seen now: takes what has come, and asks for the first that is missing.
    void show(const std::vector<const proto::Catalogue::Entry*>& seen);
    /// Nothing is seen: the line is closed.
    void rest();
    /// What Dear ImGui calls it; null while there is none.
    void* handle(const proto::Catalogue::Entry& entry) const;

  private:
    struct Picture {
        std::string of;
        std::unique_ptr<PictureTexture> texture;
    };

    void connect();
    void takeFrames();
    void keep(const std::string& of, const FramePixels& pixels);
    void ask(const proto::Catalogue::Entry& entry);
    void askForView(const proto::Catalogue::Entry& entry);
    void answered(const std::string& of, const Result<FramePixels>& pixels);

    std::filesystem::path file_;
    std::list<Picture> pictures_;  // those that were seen last in front
    std::map<std::string, std::list<Picture>::iterator> found_;
    std::set<std::string> failed_;                             // of which there can be none
    std::set<std::string> awaited_;                            // that are asked for, or have arrived
    std::deque<std::pair<std::string, FramePixels>> arrived_;  // and are to become textures, one a frame
    std::uint64_t view_ = 0;                                   // that was asked for, of an older server
    std::unique_ptr<Connection> connection_;
};

}  // namespace mote::client
