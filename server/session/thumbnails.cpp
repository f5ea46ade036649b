// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/thumbnails.h"

#include <fmt/format.h>

#include <algorithm>
#include <asio/post.hpp>
#include <span>
#include <utility>

#include "protocol/scene/dataset.h"
#include "server/session/frame_sender.h"
#include "storage/hash.h"

namespace mote::server {
namespace {

/// By which the renderer knows us; sessions begin at 1.
constexpr SessionId thumbnailSession = 0;

/// A manifest holds the hashes of all files of its dataset.
std::string keyOf(const storage::Catalogue::Entry& entry) {
    const auto bytes = entry.manifest->SerializeAsString();
    return storage::hash128(std::as_bytes(std::span(bytes)));
}

}  // namespace

Thumbnails::Thumbnails(StepSource& data, RenderService& render, const CrashRecord* crashes,
                       std::filesystem::path folder)
    : data_(data), render_(render), crashes_(crashes), files_(std::move(folder)) {
    EncodingTarget target;
    target.jpeg = true;
    render_.open(thumbnailSession, 1, events(), true);
    render_.setTarget(thumbnailSession, target);
}

Thumbnails::~Thumbnails() = default;

void Thumbnails::stop() {
    thread_.stop();
    thread_.join();
    render_.close(thumbnailSession);
}

RenderEvents Thumbnails::events() {
    return {[this](RenderedFrame frame) {
                const auto shared = std::make_shared<RenderedFrame>(std::move(frame));
                asio::post(thread_, [this, shared] { drawn(std::move(*shared)); });
            },
            [this](const ViewTask& task, Error error) {
                asio::post(thread_,
                           [this, view = task.viewId, error = std::move(error)] { settle(view, error); });
            }};
}

void Thumbnails::ask(std::string dataset, std::weak_ptr<const void> wanted, Answered answered) {
    asio::post(thread_, [this, dataset = std::move(dataset),
                         asker = Asker{std::move(wanted), std::move(answered)}] { look(dataset, asker); });
}

void Thumbnails::look(const std::string& dataset, Asker asker) {
    if (asker.wanted.expired()) return;
    const auto entry = data_.dataset(dataset);
    if (!entry.ok()) return asker.answered(entry.error());
    const auto key = keyOf(*entry);
    if (auto kept = files_.find(key))
        return asker.answered(std::make_shared<const Thumbnail>(*std::move(kept)));
    if (drawing_ && drawing_->key == key) return drawing_->join(std::move(asker));
    std::erase_if(missing_, [](Missing& one) { return !one.wanted(); });
    const auto known = std::ranges::find(missing_, key, &Missing::key);
    if (known == missing_.end())
        missing_.push_back({dataset, key, {}});
    else
        std::rotate(known, known + 1, missing_.end());
    missing_.back().join(std::move(asker));
    drawNext();
}

bool Thumbnails::Missing::wanted() {
    std::erase_if(askers, [](const Asker& asker) { return asker.wanted.expired(); });
    return !askers.empty();
}

void Thumbnails::Missing::join(Asker asker) {
    wanted();
    askers.push_back(std::move(asker));
}

void Thumbnails::drawNext() {
    while (!drawing_ && !missing_.empty()) {
        drawing_ = std::move(missing_.back());
        missing_.pop_back();
        if (!drawing_->wanted()) {
            drawing_.reset();
            continue;
        }
        ++view_;
        const auto begun = draw(*drawing_);
        if (!begun.ok()) tell(*std::exchange(drawing_, std::nullopt), begun.error());
    }
}

/// A view that has ended the server before is drawn for those who look at it, and for no list.
Status Thumbnails::draw(const Missing& missing) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, data_.dataset(missing.dataset));
    auto view = firstView(missing.dataset, entry.manifest->kind(), stepCount(*entry.manifest),
                          Thumbnail::width, Thumbnail::height);
    if (!view)
        return unsupported("dataset", fmt::format("a dataset of kind \"{}\" is not drawn by itself",
                                                  entry.manifest->kind()));
    proto::SetView message;
    *message.mutable_view() = *std::move(view);
    message.set_view_id(view_);
    message.set_final_only(true);
    MOTE_ASSIGN_OR_RETURN(auto task, makeTask(0, message));
    if (crashes_ != nullptr && crashes_->deaths(task->bytes) > 0)
        return Error{ErrorCode::internal, "dataset", "drawing it has ended the server before"};
    return render_.setView(thumbnailSession, std::move(task));
}

void Thumbnails::drawn(RenderedFrame frame) {
    render_.addCredits(thumbnailSession, 1);
    if (!drawing_ || frame.message.view_id() != view_) return;
    auto made = std::make_shared<Thumbnail>(Thumbnail{std::move(frame.payload)});
    // It may show what took the dataset's place meanwhile.
    const auto entry = data_.dataset(drawing_->dataset);
    if (entry.ok() && keyOf(*entry) == drawing_->key) files_.keep(drawing_->key, *made);
    settle(view_, std::shared_ptr<const Thumbnail>(std::move(made)));
}

void Thumbnails::settle(std::uint64_t view, const Answer& answer) {
    if (!drawing_ || view != view_) return;
    tell(*std::exchange(drawing_, std::nullopt), answer);
    drawNext();
}

void Thumbnails::tell(const Missing& whom, const Answer& answer) {
    for (const auto& asker : whom.askers) {
        if (!asker.wanted.expired()) asker.answered(answer);
    }
}

SessionThumbnails::SessionThumbnails(Thumbnails* service, asio::any_io_executor executor)
    : service_(service), executor_(std::move(executor)) {}

Result<std::optional<std::uint64_t>> SessionThumbnails::ask(std::uint64_t request, const std::string& dataset,
                                                            std::function<void()> ready) {
    if (service_ == nullptr) return unsupported("message", "this server makes no thumbnails");
    std::optional<std::uint64_t> givenUp;
    if (!desk_) return givenUp;
    const auto asked = std::make_shared<Asked>(Asked{request, dataset, std::nullopt});
    desk_->push_back(asked);
    const std::weak_ptr<Asked> wanted = asked;
    service_->ask(dataset, wanted,
                  [executor = executor_, wanted, ready = std::move(ready)](Thumbnails::Answer answer) {
                      asio::post(executor, [wanted, ready, answer = std::move(answer)] {
                          const auto own = wanted.lock();
                          if (!own) return;
                          own->answer = answer;
                          ready();
                      });
                  });
    if (desk_->size() > mostAsked) {
        givenUp = desk_->front()->request;
        desk_->pop_front();
    }
    return givenUp;
}

std::optional<SessionThumbnails::Answered> SessionThumbnails::take() {
    if (!desk_) return std::nullopt;
    const auto ready =
        std::ranges::find_if(*desk_, [](const auto& asked) { return asked->answer.has_value(); });
    if (ready == desk_->end()) return std::nullopt;
    const auto asked = *ready;
    desk_->erase(ready);
    return Answered{asked->request, asked->dataset, *asked->answer};
}

}  // namespace mote::server
