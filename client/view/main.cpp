// SPDX-License-Identifier: GPL-3.0-or-later

#include <exception>

#include "client/view/viewer.h"
#include "protocol/scene/complain.h"

int main(int argc, char** argv) {
    using namespace mote::client;
    try {
        const auto parsed = parseViewOptions(argc, argv);
        if (const int* status = std::get_if<int>(&parsed)) return *status;
        Viewer viewer(std::get<ViewOptions>(parsed));
        if (!viewer.loaded().ok()) {
            mote::complain("mote-view", viewer.loaded().error().toString());
            return 1;
        }
        return viewer.run();
    } catch (const std::exception& error) {
        mote::complainAtEnd("mote-view", error);
        return 1;
    }
}
