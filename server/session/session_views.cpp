// SPDX-License-Identifier: GPL-3.0-or-later
//
// A session's views and frames: from the message to the renderer and back.
#include <asio/post.hpp>

#include "server/session/session.h"

namespace mote::server {
namespace {

Result<std::shared_ptr<ViewTask>> makeTask(std::uint64_t request, const proto::SetView& message) {
    if (message.format() != proto::PIXEL_FORMAT_UNSPECIFIED && message.format() != proto::SRGB8 &&
        message.format() != proto::LINEAR_HALF) {
        return Error{ErrorCode::unsupported, "format", "this pixel format is not known here"};
    }
    auto view = parseView(message.view());
    if (!view.ok()) return view.error().within("view");
    auto task = std::make_shared<ViewTask>();
    task->view = *std::move(view);
    task->viewId = message.view_id();
    task->request = request;
    task->finalOnly = message.final_only();
    task->moving = message.moving();
    task->format =
        message.format() == proto::LINEAR_HALF ? render::PixelFormat::linearHalf : render::PixelFormat::srgb8;
    task->askedNs = message.asked_ns();
    return task;
}

}  // namespace

asio::awaitable<void> Session::setView(std::uint64_t request, const proto::SetView& message) {
    const auto arrived = Clock::now();
    auto task = makeTask(request, message);
    if (!task.ok()) {
        reply(request, failureMessage(request, task.error(), false));
        co_return;
    }
    (*task)->arrived = arrived;
    co_await findDatasets((*task)->view);
    if (!closed_) context_.render->setView(id_, *std::move(task));
}

/// A dataset that was published a moment ago may not be known yet: only then is the disk asked first.
asio::awaitable<void> Session::findDatasets(const View& view) {
    bool known = true;
    for (const auto& layer : view.layers) known = known && context_.datasets->contains(layer.dataset);
    if (known) co_return;
    const auto done = std::make_shared<bool>(false);
    context_.datasets->rescan([weak = weak_from_this(), executor = executor_, done] {
        asio::post(executor, [weak, done] {
            *done = true;
            if (const auto self = weak.lock()) self->readerWake_.notify();
        });
    });
    while (!*done && !closed_) co_await readerWake_.wait();
}

void Session::returnCredit(const proto::Credit& message) {
    if (message.frames() > outstanding_) {
        return leave({ErrorCode::invalidArgument, "credit.frames",
                      "more frames were returned than the server has sent"});
    }
    outstanding_ -= message.frames();
    context_.render->addCredits(id_, message.frames());
}

RenderEvents Session::renderEvents() {
    const auto weak = weak_from_this();
    const auto executor = executor_;
    return {[weak, executor](RenderedFrame frame) {
                asio::post(executor, [weak, frame = std::move(frame)]() mutable {
                    if (const auto self = weak.lock()) self->frameReady(std::move(frame));
                });
            },
            [weak, executor](std::uint64_t request, Error error) {
                asio::post(executor, [weak, request, error = std::move(error)] {
                    if (const auto self = weak.lock()) self->viewFailed(request, error);
                });
            }};
}

void Session::frameReady(RenderedFrame frame) {
    if (closed_ || leaving_) return;
    outbox_.frame(std::move(frame));
    writerWake_.notify();
}

void Session::viewFailed(std::uint64_t request, const Error& error) {
    outbox_.viewFailed(failureMessage(request, error, false));
    writerWake_.notify();
}

}  // namespace mote::server
