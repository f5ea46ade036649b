// SPDX-License-Identifier: GPL-3.0-or-later
//
// ServerSettings: what a server is started with. A value.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "server/frames/render_service.h"
#include "server/render/device.h"

namespace mote::server {

struct ServerSettings {
    std::vector<std::string> roots;        ///< "NAME=DIR"
    std::filesystem::path stateDirectory;  ///< jobs and the socket; made where absent
    std::filesystem::path connectionFile;  ///< written when the server accepts, removed when it ends
    std::filesystem::path prep;            ///< the program mote-prep, for jobs
    render::DeviceKind device = render::DeviceKind::automatic;
    std::string token;         ///< what clients must know; empty: a fresh one
    std::uint64_t memory = 0;  ///< bytes that the server may use, and a job besides; 0: no limit
    unsigned threads = 0;      ///< of a job, and of the cpu device; 0: their own choice

    bool stopOnSignals = false;  ///< SIGTERM, SIGINT and SIGHUP end run()
    RenderSettings render;
    std::size_t maxSessions = 64;
    std::chrono::milliseconds handshakeTimeout{5000};
    std::chrono::milliseconds rescanInterval{2000};  ///< while clients are connected
};

}  // namespace mote::server
