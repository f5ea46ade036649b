// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/picture_server.h"

#include <fmt/format.h>

#include <utility>

namespace mote::client {

Result<std::unique_ptr<PictureServer>> PictureServer::open(const ServerChoice& choice,
                                                           std::chrono::milliseconds patience, Wakeup& wakeup,
                                                           const Interrupt& interrupt) {
    MOTE_ASSIGN_OR_RETURN(auto line, ServerLine::open("mote-frames", choice, wakeup, interrupt));
    std::unique_ptr<PictureServer> server(new PictureServer(std::move(line), patience));
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
    if (asked_.empty()) progressAt_ = std::chrono::steady_clock::now();
    const auto id = line().setView(view, request);
    asked_[id] = page ? Asked{} : Asked{view.width(), view.height()};
    return id;
}

Result<ReceivedFrame> PictureServer::checked(const Asked& asked, ReceivedFrame frame) const {
    const bool document = asked.width == 0;
    if (document || (frame.pixels.width == asked.width && frame.pixels.height == asked.height)) return frame;
    return Error{ErrorCode::corrupt, "", "the server sent a picture of another size"};
}

Answer PictureServer::toAnswer(std::uint64_t view, ReceivedFrame frame) {
    const auto asked = asked_.extract(view).mapped();
    if (frame.message.final()) return {view, checked(asked, std::move(frame))};
    return {view, Error{ErrorCode::corrupt, "", "the server sent a picture that is not the exact one"}};
}

std::vector<Answer> PictureServer::poll() {
    line().poll();
    auto answers = std::exchange(failures_, {});
    while (auto frame = line().takeFrame()) {
        const auto view = frame->message.view_id();
        if (asked_.contains(view)) {
            answers.push_back(toAnswer(view, *std::move(frame)));
        } else {
            server_->giveUp({ErrorCode::corrupt, "", "the server sent a picture that nobody asked for"});
        }
    }
    watchProgress(!answers.empty());
    return answers;
}

/// A picture takes as long as it takes, but the bytes of one come without long pauses.
void PictureServer::watchProgress(bool answered) {
    const auto now = std::chrono::steady_clock::now();
    const auto bytes = line().statistics().pictureBytes;
    const bool waits = !asked_.empty() && line().state() == Connection::State::connected;
    if (!waits || answered || std::exchange(pictureBytes_, bytes) != bytes) progressAt_ = now;
    if (patience_.count() == 0 || now - progressAt_ < patience_) return;
    server_->giveUp({ErrorCode::internal, "",
                     fmt::format("the server answers, but has sent nothing of a picture for {:.3g} s; "
                                 "--patience says for how long it is waited for",
                                 static_cast<double>(patience_.count()) / 1000.0)});
}

}  // namespace mote::client
