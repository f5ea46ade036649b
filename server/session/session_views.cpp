// SPDX-License-Identifier: GPL-3.0-or-later
//
// A session's views and frames: from the message to the renderer and back.
#include <asio/post.hpp>

#include "protocol/scene/lengths_in_pixels.h"
#include "server/session/session.h"

namespace mote::server {
namespace {

/// Others have seen a picture by then.
constexpr std::chrono::seconds suspectDelay{1};

Result<std::shared_ptr<ViewTask>> makeTask(std::uint64_t request, const proto::SetView& message) {
    if (message.format() != proto::PIXEL_FORMAT_UNSPECIFIED && message.format() != proto::SRGB8 &&
        message.format() != proto::LINEAR_HALF) {
        return Error{ErrorCode::unsupported, "format", "this pixel format is not known here"};
    }
    std::optional<Page> page;
    if (message.has_page()) {
        const auto parsed = parsePage(message.page());
        if (!parsed.ok()) return parsed.error().within("page");
        page = *parsed;
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
        return Error{ErrorCode::invalidArgument, "queued",
                     "only views of which the exact picture alone is wanted (final_only) can be queued"};
    }
    task->moving = message.moving();
    task->format =
        message.format() == proto::LINEAR_HALF ? render::PixelFormat::linearHalf : render::PixelFormat::srgb8;
    task->askedNs = message.asked_ns();
    return task;
}

}  // namespace

std::uint32_t frameCredits(const proto::Hello& hello) {
    return hello.receipts() ? wire::measuredFrameCredits : wire::frameCredits;
}

asio::awaitable<void> Session::setView(std::uint64_t request, const proto::SetView& message) {
    const auto arrived = Clock::now();
    auto task = makeTask(request, message);
    if (!task.ok()) {
        reply(request, failureMessage(request, task.error(), false));
        co_return;
    }
    (*task)->arrived = arrived;
    if (!message.queued()) context_.parked->setView(id_, message);
    const auto found = co_await findDatasets((*task)->view);
    if (closed_) co_return;
    if (!found.ok()) {
        reply(request, failureMessage(request, found.error(), false));
        co_return;
    }
    if (!message.queued()) {
        context_.following->unfollow(id_);
        context_.following->viewChanged(id_, message);
    }
    draw(*std::move(task));
}

/// A view of another session's, which that has found its data for.
void Session::drawFollowed(const proto::SetView& message) {
    auto task = makeTask(followRequest_, message);
    if (!task.ok()) return reply(followRequest_, failureMessage(followRequest_, task.error(), false));
    (*task)->arrived = Clock::now();
    draw(*std::move(task));
}

/// Or says why not.
void Session::draw(std::shared_ptr<ViewTask> task) {
    const auto request = task->request;
    const auto safe = beware(*task);
    if (!safe.ok()) return reply(request, failureMessage(request, safe.error(), false));
    if (!task->queued) {
        viewId_ = task->viewId;
        outbox_.dropOutdated(dropped());
    }
    const auto taken = context_.render->setView(id_, std::move(task));
    if (!taken.ok()) reply(request, failureMessage(request, taken.error(), false));
    beginFrames();
}

/// A view that ended a server once is drawn when all others have had their turn, and after the second time
/// never again.
Status Session::beware(ViewTask& task) const {
    const unsigned deaths = context_.crashes != nullptr ? context_.crashes->deaths(task.bytes) : 0;
    if (deaths >= refusedAfterDeaths) {
        return Error{ErrorCode::internal, "view",
                     "drawing it has ended the server before, so it is not drawn again; the server's log "
                     "holds its text"};
    }
    if (deaths > 0) task.notBefore = task.arrived + suspectDelay;
    return success();
}

/// A dataset that was published a moment ago may not be known yet: only then is the disk asked first.
asio::awaitable<Status> Session::findDatasets(const View& view) {
    bool known = true;
    for (const auto& layer : view.layers) {
        known = known && context_.datasets->contains(layer.dataset);
        const auto* const stipple = layer.stipple();
        if (stipple != nullptr && !stipple->image().empty())
            known = known && context_.datasets->contains(stipple->image());
    }
    if (known) co_return success();
    co_return co_await rescan(readerWake_);
}

/// Flow control and the renderer learn who it is; nothing is drawn before.
void Session::begin(const proto::Hello& hello) {
    flow_.emplace(hello.receipts(), frameCredits(hello));
    target_.measured = hello.receipts();
    for (const int encoding : hello.decodes()) target_.h264 = target_.h264 || encoding == proto::Frame::H264;
    context_.render->open(id_, 0, renderEvents(), hello.background());
    context_.render->setTarget(id_, target_);
    beginFrames();
}

/// Lets the renderer make as many frames as the link is ready for; comes back when it is ready for more.
void Session::beginFrames() {
    // While one waits that a newer one would replace, nobody would see what is made.
    if (closed_ || leaving_ || outbox_.anyReplaceable()) return;
    const auto now = Clock::now();
    if (const auto count = flow_->begin(now); count > 0) context_.render->addCredits(id_, count);
    const auto due = flow_->due(now);
    if (!due) return;
    pace_.expires_at(*due);
    pace_.async_wait([weak = weak_from_this()](const asio::error_code& code) {
        const auto self = weak.lock();
        if (code || !self || self->closed_) return;
        self->writerWake_.notify();
        self->orClose([&] { self->beginFrames(); });
    });
}

void Session::returnCredit(const proto::Credit& message) {
    const auto status = flow_->returned(Clock::now(), message);
    if (!status.ok()) return leave(status.error());
    if (message.key_wanted()) context_.render->wantKey(id_);
    if (const auto bytes = flow_->frameBytes(); bytes != target_.frameBytes) {
        target_.frameBytes = bytes;
        context_.render->setTarget(id_, target_);
    }
    writerWake_.notify();
    beginFrames();
}

std::size_t Session::piece(const RenderedFrame& frame, std::size_t begin, std::size_t left) const {
    return flow_->piece(Clock::now(), begin, left, frame.canWait);
}

/// The first piece carries all that there is to say, the others only whose they are.
void Session::fillFrame(Outbox::Item& item) {
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
    beginFrames();
}

RenderEvents Session::renderEvents() {
    const auto weak = weak_from_this();
    const auto executor = executor_;
    return {[weak, executor](RenderedFrame frame) {
                asio::post(executor, [weak, frame = std::move(frame)]() mutable {
                    const auto self = weak.lock();
                    if (self) self->orClose([&] { self->frameReady(std::move(frame)); });
                });
            },
            [weak, executor](const ViewTask& task, Error error) {
                asio::post(executor,
                           [weak, request = task.request, queued = task.queued, error = std::move(error)] {
                               const auto self = weak.lock();
                               if (self) self->orClose([&] { self->viewFailed(request, queued, error); });
                           });
            }};
}

void Session::frameReady(RenderedFrame frame) {
    if (closed_ || leaving_) return;
    const auto& message = frame.message;
    flow_->made(frame.payload.size(), message.plan_ms() + message.render_ms() + message.encode_ms(),
                frame.quick);
    if (frame.canWait && !frame.wanted && message.view_id() != viewId_) {
        // A newer view came while it was encoded.
        flow_->dropped(false);
        return beginFrames();
    }
    outbox_.frame(std::move(frame), Clock::now(), dropped());
    writerWake_.notify();
    beginFrames();  // where it was dropped itself
}

Outbox::Dropped Session::dropped() {
    return [this](bool partlySent, bool ofStream) {
        flow_->dropped(partlySent);
        // Those that follow are told by what the client never got.
        if (ofStream) context_.render->wantKey(id_);
    };
}

/// A client that reads again after a while sees the newest, not what it asked for when it stopped.
void Session::dropStaleFrames() {
    const auto before = outbox_.frames();
    outbox_.dropStale(Clock::now() - context_.staleAfter, viewId_, dropped());
    if (outbox_.frames() < before) beginFrames();
}

/// Of queued views each is waited for; as long as failures find no room, no more views are read.
void Session::viewFailed(std::uint64_t request, bool queued, const Error& error) {
    auto failure = failureMessage(request, error, false);
    if (queued) return reply(request, std::move(failure));
    outbox_.viewFailed(std::move(failure));
    writerWake_.notify();
}

}  // namespace mote::server
