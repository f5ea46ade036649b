// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/server_line.h"

#include <fmt/format.h>

#include <utility>

namespace mote::client {
namespace {

/// A server of a node that is down for the night is still waited for.
constexpr std::chrono::hours untiringPatience{24 * 30};
/// A server that does not answer is not told goodbye for longer.
constexpr std::chrono::milliseconds farewellPatience{200}, farewellPause{10};

}  // namespace

Result<std::unique_ptr<ServerLine>> ServerLine::open(const std::string& program, const ServerChoice& choice,
                                                     Wakeup& wakeup, const Interrupt& interrupt) {
    std::unique_ptr<ServerLine> server(new ServerLine(interrupt, wakeup));
    if (!choice.connect) {
        MOTE_ASSIGN_OR_RETURN(server->server_, PrivateServer::start(program, choice.spawn, interrupt));
    }
    ConnectionSettings settings;
    settings.client = program + " " MOTE_VERSION;
    settings.wake = [&wakeup] { wakeup(); };
    settings.background = choice.background;
    server->waitsWhile_ = choice.waitsWhile;
    if (!choice.waitsWhile.empty()) settings.returnPatience = untiringPatience;
    const auto file = server->server_ ? server->server_->connectionFile() : *choice.connect;
    server->line_ = std::make_unique<Connection>(file, settings);
    return server;
}

Status ServerLine::waitUntil(const std::function<bool()>& done) {
    while (true) {
        line_->poll();
        if (interrupt_.requested()) return Error{ErrorCode::cancelled, "", "interrupted"};
        if (done()) return success();
        if (const auto reason = lost()) return *reason;
        wakeup_.wait(signalPatience);
    }
}

Status ServerLine::waitUntilConnected() {
    return waitUntil([&] { return line_->state() == Connection::State::connected; });
}

void ServerLine::farewell() {
    // Messages are read in their order: who answers a ping has heard all before it.
    const auto heard = std::make_shared<bool>(false);
    line_->ping([heard](const Result<double>&) { *heard = true; });
    const auto end = std::chrono::steady_clock::now() + farewellPatience;
    while (!*heard && std::chrono::steady_clock::now() < end) {
        line_->poll();
        if (!*heard) wakeup_.wait(farewellPause);
    }
}

std::optional<Error> ServerLine::lost() const {
    if (givenUp_) return givenUp_;
    std::error_code code;
    if (!waitsWhile_.empty() && line_->state() == Connection::State::connecting &&
        !std::filesystem::exists(waitsWhile_, code))
        return Error{ErrorCode::notFound, waitsWhile_.string(), "is gone, and the server with it"};
    if (line_->state() != Connection::State::lost) return std::nullopt;
    const auto reason = line_->lostReason().value_or(Error{});
    if (!server_ || server_->lastWords().empty()) return reason;
    return Error{reason.code, "mote-server",
                 fmt::format("{}; it last said: {}", reason.toString(), server_->lastWords())};
}

}  // namespace mote::client
