// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/picture_server.h"

#include <utility>

namespace mote::client {

Result<std::unique_ptr<PictureServer>> PictureServer::open(const ServerChoice& choice, Wakeup& wakeup,
                                                           const Interrupt& interrupt) {
    MOTE_ASSIGN_OR_RETURN(auto line, ServerLine::open("mote-frames", choice, wakeup, interrupt));
    std::unique_ptr<PictureServer> server(new PictureServer(std::move(line)));
    server->listen();
    return server;
}

void PictureServer::listen() {
    line().onState([this](Connection::State state) {
        if (state != Connection::State::connected) return;
        if (std::exchange(connected_, true)) ++returns_;
    });
    line().onViewFailed([this](std::uint64_t view, const Error& error) {
        if (asked_.erase(view) > 0) {
            failures_.push_back({view, error});
        } else {
            server_->giveUp(error);  // about no view that we know
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
    const auto id = line().setView(view, request);
    asked_[id] = page ? Asked{} : Asked{view.width(), view.height()};
    return id;
}

Result<ReceivedFrame> PictureServer::checked(const Asked& asked, ReceivedFrame frame) const {
    const bool document = asked.width == 0;
    if (document || (frame.pixels.width == asked.width && frame.pixels.height == asked.height)) return frame;
    return Error{ErrorCode::corrupt, "", "the server sent a picture of another size"};
}

std::vector<Answer> PictureServer::poll() {
    line().poll();
    auto answers = std::exchange(failures_, {});
    while (auto frame = line().takeFrame()) {
        const auto found = asked_.find(frame->message.view_id());
        if (found == asked_.end() || !frame->message.final()) continue;
        const auto [view, asked] = *found;
        asked_.erase(found);
        answers.push_back({view, checked(asked, *std::move(frame))});
    }
    return answers;
}

}  // namespace mote::client
