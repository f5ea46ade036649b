// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <exception>

#include "client/view/viewer.h"

int main(int argc, char** argv) {
    using namespace mote::client;
    const auto parsed = parseViewOptions(argc, argv);
    if (const int* status = std::get_if<int>(&parsed)) return *status;
    try {
        Viewer viewer(std::get<ViewOptions>(parsed));
        if (!viewer.loaded().ok()) {
            fmt::print(stderr, "mote-view: {}\n", viewer.loaded().error().toString());
            return 1;
        }
        return viewer.run();
    } catch (const std::exception& error) {
        fmt::print(stderr, "mote-view: {}\n", error.what());
        return 1;
    }
}
