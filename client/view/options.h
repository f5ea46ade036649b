// SPDX-License-Identifier: GPL-3.0-or-later
//
// The command line of mote-view. A value.
#pragma once

#include <filesystem>
#include <optional>
#include <variant>

namespace mote::client {

struct ViewOptions {
    std::filesystem::path connection;           ///< connection file of the server
    std::optional<std::filesystem::path> view;  ///< a saved view, or a script, to start with
    std::optional<std::filesystem::path> film;  ///< a script of keyframes to start with
    int width = 1600;                           ///< of the window, screen coordinates
    int height = 900;
    std::optional<std::filesystem::path>
        screenshot;  ///< PNG of the window, once the first exact picture is shown
    std::optional<std::filesystem::path>
        saveView;                 ///< a file that is not there, for the view that was shown then
    bool exitAfterStill = false;  ///< and then the program ends
};

/// The options, or the exit status after help or a mistake, which has been printed.
std::variant<ViewOptions, int> parseViewOptions(int argc, const char* const* argv);

}  // namespace mote::client
