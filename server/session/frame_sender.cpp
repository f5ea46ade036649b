// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/frame_sender.h"

#include <asio/post.hpp>
#include <utility>

#include "protocol/scene/view_message.h"
#include "protocol/wire/framing.h"

namespace mote::server {
namespace {

/// Others have seen a picture by then.
constexpr std::chrono::seconds suspectDelay{1};

/// A sheet whose size nobody gives is as wide as the view says it will be printed.
void printedWide(const proto::Annotations& annotations, Page& page) {
    const double width = annotations.print_width() + 2.0 * page.margin;
    if (page.width == 0.0 && page.height == 0.0 && annotations.has_print_width() && width <= Page::maxSide)
        page.width = width;
}

}  // namespace

Result<std::shared_ptr<ViewTask>> makeTask(std::uint64_t request, const proto::SetView& message) {
    const auto arrived = Clock::now();
    if (message.format() != proto::PIXEL_FORMAT_UNSPECIFIED && message.format() != proto::SRGB8 &&
        message.format() != proto::LINEAR_HALF) {
        return unsupported("format", "this pixel format is not known here");
    }
    std::optional<Page> page;
    if (message.has_page()) {
        const auto parsed = parsePage(message.page());
        if (!parsed.ok()) return parsed.error().within("page");
        page = *parsed;
        printedWide(message.view().annotations(), *page);
    }
    auto view = parseView(message.view());
    if (!view.ok()) return view.error().within("view");
    auto task = std::make_shared<ViewTask>();
    task->view = lengthsInPixels(*std::move(view));
    task->viewId = message.view_id();
    task->bytes = message.view().SerializeAsString();
    task->request = request;
    task->page = page;
    // Nobody wants a document of a picture in motion.
    task->finalOnly = message.final_only() || page;
    task->queued = message.queued();
    if (task->queued && !task->finalOnly) {
        return invalid("queued",
                       "only views of which the exact picture alone is wanted (final_only) can be queued");
    }
    task->moving = message.moving();
    task->format =
        message.format() == proto::LINEAR_HALF ? render::PixelFormat::linearHalf : render::PixelFormat::srgb8;
    task->askedNs = message.asked_ns();
    task->arrived = arrived;
    return task;
}

std::uint32_t frameCredits(const proto::Hello& hello) {
    return hello.receipts() ? wire::measuredFrameCredits : wire::frameCredits;
}

FrameSender::FrameSender(SessionId id, asio::any_io_executor executor, RenderService& render,
                         const CrashRecord* crashes, Outbox& outbox, std::function<void()> wake)
    : id_(id),
      executor_(std::move(executor)),
      render_(render),
      crashes_(crashes),
      outbox_(outbox),
      wake_(std::move(wake)),
      pace_(executor_) {}

void FrameSender::open(const proto::Hello& hello) {
    flow_.emplace(hello.receipts(), frameCredits(hello));
    target_.measured = hello.receipts();
    for (const int encoding : hello.decodes()) target_.h264 = target_.h264 || encoding == proto::Frame::H264;
    render_.open(id_, 0, events(), hello.background());
    render_.setTarget(id_, target_);
    begin();
}

void FrameSender::close() {
    closed_ = true;
    pace_.cancel();
    render_.close(id_);
}

/// A view that ended a server once is drawn when all others have had their turn, and after the second time
/// never again.
Status FrameSender::draw(std::shared_ptr<ViewTask> task) {
    const unsigned deaths = crashes_ != nullptr ? crashes_->deaths(task->bytes) : 0;
    if (deaths >= refusedAfterDeaths) {
        return Error{ErrorCode::internal, "view",
                     "drawing it has ended the server before, so it is not drawn again; the server's log "
                     "holds its text"};
    }
    if (deaths > 0) task->notBefore = task->arrived + suspectDelay;
    if (!task->queued) {
        viewId_ = task->viewId;
        outbox_.dropOutdated(dropped());
    }
    auto taken = render_.setView(id_, std::move(task));
    begin();
    return taken;
}

/// Lets the renderer make as many frames as the link is ready for; comes back when it is ready for more.
void FrameSender::begin() {
    // While one waits that a newer one would replace, nobody would see what is made.
    if (closed_ || outbox_.anyReplaceable()) return;
    const auto now = Clock::now();
    if (const auto count = flow_->begin(now); count > 0) render_.addCredits(id_, count);
    const auto due = flow_->due(now);
    if (!due) return;
    pace_.expires_at(*due);
    pace_.async_wait([weak = weak_from_this()](const asio::error_code& code) {
        const auto self = weak.lock();
        if (code || !self || self->closed_) return;
        self->wake_();
        self->begin();
    });
}

Status FrameSender::returned(const proto::Credit& message) {
    MOTE_RETURN_IF_ERROR(flow_->returned(Clock::now(), message));
    if (message.key_wanted()) render_.wantKey(id_);
    if (const auto bytes = flow_->frameBytes(); bytes != target_.frameBytes) {
        target_.frameBytes = bytes;
        render_.setTarget(id_, target_);
    }
    wake_();
    begin();
    return success();
}

std::size_t FrameSender::piece(const RenderedFrame& frame, std::size_t begin, std::size_t left) const {
    return flow_->piece(Clock::now(), begin, left, frame.canWait);
}

/// The first piece carries all that there is to say, the others only whose they are.
void FrameSender::fill(Outbox::Item& item) {
    const bool first = item.begin == 0, last = item.begin + item.size == item.frame->payload.size();
    auto& message = *item.message.mutable_frame();
    if (first) {
        message = item.frame->message;
        ++sequence_;
        message.set_total_ms(milliseconds(Clock::now() - item.frame->arrived));
        message.set_link_bytes_per_second(flow_->link().rate().value_or(0.0));
        if (!last) message.set_payload_size(item.frame->payload.size());
    }
    message.set_sequence(sequence_);
    message.set_payload_begin(item.begin);
    flow_->sent(Clock::now(), item.size, first, last);
    begin();
}

RenderEvents FrameSender::events() {
    const auto weak = weak_from_this();
    const auto executor = executor_;
    return {[weak, executor](RenderedFrame frame) {
                asio::post(executor, [weak, frame = std::move(frame)]() mutable {
                    if (const auto self = weak.lock()) self->ready(std::move(frame));
                });
            },
            [weak, executor](const ViewTask& task, Error error) {
                asio::post(executor,
                           [weak, request = task.request, queued = task.queued, error = std::move(error)] {
                               if (const auto self = weak.lock()) self->failed(request, queued, error);
                           });
            }};
}

void FrameSender::ready(RenderedFrame frame) {
    if (closed_) return;
    const auto& message = frame.message;
    flow_->made(frame.payload.size(), message.plan_ms() + message.render_ms() + message.encode_ms(),
                frame.quick);
    if (frame.canWait && !frame.wanted && message.view_id() != viewId_) {
        // A newer view came while it was encoded.
        flow_->dropped(false);
        return begin();
    }
    outbox_.frame(std::move(frame), Clock::now(), dropped());
    wake_();
    begin();  // where it was dropped itself
}

/// Of queued views each is waited for; as long as failures find no room, no more views are read.
void FrameSender::failed(std::uint64_t request, bool queued, const Error& error) {
    if (closed_) return;
    auto failure = failureMessage(request, error, false);
    queued ? outbox_.reply(std::move(failure)) : outbox_.viewFailed(std::move(failure));
    wake_();
}

Outbox::Dropped FrameSender::dropped() {
    return [this](bool partlySent, bool ofStream) {
        flow_->dropped(partlySent);
        // Those that follow are told by what the client never got.
        if (ofStream) render_.wantKey(id_);
    };
}

void FrameSender::dropStale(Clock::duration after) {
    const auto before = outbox_.frames();
    outbox_.dropStale(Clock::now() - after, viewId_, dropped());
    if (outbox_.frames() < before) begin();
}

}  // namespace mote::server
