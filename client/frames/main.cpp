// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <memory>

#include "client/frames/frame_run.h"
#include "client/frames/interrupt.h"
#include "client/frames/options.h"
#include "client/frames/private_server.h"
#include "client/frames/script.h"
#include "client/shared/connection.h"

namespace mote::client {
namespace {

constexpr int failure = 1;
constexpr int killedBy = 128;  // and the signal's number, as shells say it

int fail(const Error& error, const Interrupt& interrupt) {
    fmt::print(stderr, "mote-frames: {}\n", error.toString());
    return interrupt.requested() ? killedBy + interrupt.signal() : failure;
}

Status draw(const FramesOptions& options, const std::vector<proto::View>& views, const Interrupt& interrupt) {
    std::unique_ptr<PrivateServer> server;
    if (!options.connect) {
        MOTE_ASSIGN_OR_RETURN(
            server, PrivateServer::start({serverBesideUs(), options.roots, options.device}, interrupt));
    }
    ConnectionSettings settings;
    settings.client = "mote-frames " MOTE_VERSION;
    Connection connection(server ? server->connectionFile() : *options.connect, settings);
    const auto drawn = FrameRun(options, views, connection, interrupt).run();
    const bool died = server && connection.state() == Connection::State::lost;
    if (drawn.ok() || !died || server->lastWords().empty()) return drawn;
    return Error{drawn.error().code, "mote-server",
                 fmt::format("{}; it last said: {}", drawn.error().toString(), server->lastWords())};
}

int run(int argc, const char* const* argv) {
    const Interrupt interrupt;
    const auto parsed = parseFramesOptions(argc, argv);
    if (const int* status = std::get_if<int>(&parsed)) return *status;
    const auto& options = std::get<FramesOptions>(parsed);
    const auto views = readScript(options.script);
    if (!views.ok()) return fail(views.error(), interrupt);
    const auto drawn = draw(options, *views, interrupt);
    return drawn.ok() ? 0 : fail(drawn.error(), interrupt);
}

}  // namespace
}  // namespace mote::client

int main(int argc, char** argv) {
    try {
        return mote::client::run(argc, argv);
    } catch (const std::exception& error) {
        fmt::print(stderr, "mote-frames: {}\n", error.what());
        return 1;
    }
}
