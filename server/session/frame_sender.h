// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameSender: what one client is shown: its views on their way to the renderer, and the frames on their way
// back, as many as the link to it is ready for. Shared by its session and what that has asked others to call
// later; one thread.
#pragma once

#include <asio/any_io_executor.hpp>
#include <asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/frames/crash_record.h"
#include "server/frames/render_service.h"
#include "server/session/flow_control.h"
#include "server/session/outbox.h"

namespace mote::server {

/// The view of a message. Errors: unsupported, invalidArgument, at the field.
Result<std::shared_ptr<ViewTask>> makeTask(std::uint64_t request, const proto::SetView& message);

/// What a client starts with.
std::uint32_t frameCredits(const proto::Hello& hello);

class FrameSender : public std::enable_shared_from_this<FrameSender> {
  public:
    /// `outbox` and what `wake` calls, whoever empties it, live until close(); `crashes` may be null: nothing
    /// is known.
    FrameSender(SessionId id, asio::any_io_executor executor, RenderService& render,
                const CrashRecord* crashes, Outbox& outbox, std::function<void()> wake);

    /// Flow control and the renderer learn who it is; nothing is drawn before.
    void open(const proto::Hello& hello);
    /// Nothing more is drawn or counted.
    void close();

    /// Errors: internal (drawing it has ended the server before), as RenderService::setView.
    Status draw(std::shared_ptr<ViewTask> task);
    /// Errors: as FlowControl::returned.
    Status returned(const proto::Credit& message);

    /// What of a frame may be sent now, as Outbox::Piece.
    std::size_t piece(const RenderedFrame& frame, std::size_t begin, std::size_t left) const;
    /// The message of a piece that is sent now.
    void fill(Outbox::Item& item);
    /// A client that reads again after a while sees the newest, not what it asked for when it stopped.
    void dropStale(Clock::duration after);

  private:
    RenderEvents events();
    void begin();
    void ready(RenderedFrame frame);
    void failed(std::uint64_t request, bool queued, const Error& error);
    Outbox::Dropped dropped();

    const SessionId id_;
    const asio::any_io_executor executor_;
    RenderService& render_;
    const CrashRecord* const crashes_;
    Outbox& outbox_;
    const std::function<void()> wake_;
    asio::steady_timer pace_;          // when the link is ready for more
    std::optional<FlowControl> flow_;  // once it is known what the client can do
    EncodingTarget target_;
    std::uint64_t viewId_ = 0;    // of the latest view that replaced those before it
    std::uint64_t sequence_ = 0;  // of the latest frame
    bool closed_ = false;
};

}  // namespace mote::server
