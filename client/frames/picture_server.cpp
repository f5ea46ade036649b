// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/picture_server.h"

#include <fmt/format.h>

#include <utility>

namespace mote::client {
namespace {

/// A server of a node that is down for the night is still waited for.
constexpr std::chrono::hours untiringPatience{24 * 30};

}  // namespace

Result<std::unique_ptr<PictureServer>> PictureServer::open(const ServerChoice& choice, Wakeup& wakeup,
                                                           const Interrupt& interrupt) {
    std::unique_ptr<PictureServer> server(new PictureServer(interrupt, wakeup));
    if (!choice.connect) {
        MOTE_ASSIGN_OR_RETURN(server->server_, PrivateServer::start(choice.spawn, interrupt));
    }
    ConnectionSettings settings;
    settings.client = "mote-frames " MOTE_VERSION;
    settings.wake = [&wakeup] { wakeup(); };
    settings.background = choice.background;
    server->waitsWhile_ = choice.waitsWhile;
    if (!choice.waitsWhile.empty()) settings.returnPatience = untiringPatience;
    const auto file = server->server_ ? server->server_->connectionFile() : *choice.connect;
    server->line_ = std::make_unique<Connection>(file, settings);
    server->listen();
    return server;
}

void PictureServer::listen() {
    line_->onState([this](Connection::State state) {
        if (state != Connection::State::connected) return;
        if (std::exchange(connected_, true)) ++returns_;
    });
    line_->onViewFailed([this](std::uint64_t view, const Error& error) {
        if (asked_.erase(view) > 0) {
            failures_.push_back({view, error});
        } else {
            complaint_ = error;
        }
    });
}

std::uint64_t PictureServer::ask(const proto::View& view, proto::PixelFormat format,
                                 const std::optional<proto::Page>& page) {
    ViewRequest request;
    request.finalOnly = true;
    request.queued = true;
    request.format = format;
    request.page = page;
    const auto id = line_->setView(view, request);
    asked_[id] = page ? Asked{} : Asked{view.width(), view.height()};
    return id;
}

Result<ReceivedFrame> PictureServer::checked(const Asked& asked, ReceivedFrame frame) const {
    const bool document = asked.width == 0;
    if (document || (frame.pixels.width == asked.width && frame.pixels.height == asked.height)) return frame;
    return Error{ErrorCode::corrupt, "", "the server sent a picture of another size"};
}

std::vector<Answer> PictureServer::poll() {
    line_->poll();
    auto answers = std::exchange(failures_, {});
    while (auto frame = line_->takeFrame()) {
        const auto found = asked_.find(frame->message.view_id());
        if (found == asked_.end() || !frame->message.final()) continue;
        const auto [view, asked] = *found;
        asked_.erase(found);
        answers.push_back({view, checked(asked, *std::move(frame))});
    }
    return answers;
}

Status PictureServer::waitUntil(const std::function<bool()>& done) {
    while (true) {
        line_->poll();
        if (interrupt_.requested()) return Error{ErrorCode::cancelled, "", "interrupted"};
        if (done()) return success();
        if (const auto reason = lost()) return *reason;
        wakeup_.wait(signalPatience);
    }
}

std::optional<Error> PictureServer::lost() const {
    if (complaint_) return complaint_;
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
