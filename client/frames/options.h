// SPDX-License-Identifier: GPL-3.0-or-later
//
// The command line of mote-frames. A value.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/frames/picture_file.h"

namespace mote::client {

struct FramesOptions {
    std::filesystem::path script;
    std::optional<std::filesystem::path> connect;  ///< a running server's connection file, or
    std::vector<std::string> roots;                ///< "NAME=DIR" of the private server to start
    std::optional<std::string> device;             ///< of the private server
    std::filesystem::path out;                     ///< folder of the pictures
    PictureFormat format = PictureFormat::png;
    proto::Page page;     ///< of documents
    bool resume = false;  ///< keep pictures that are whole and of the same view
    bool json = false;    ///< one JSON object a frame on stdout
    bool quiet = false;   ///< no progress on stderr
};

/// The options, or the exit status after help (0) or wrong usage (2), which has been printed.
std::variant<FramesOptions, int> parseFramesOptions(int argc, const char* const* argv);

}  // namespace mote::client
