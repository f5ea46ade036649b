// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/datasets/dataset_thumbnails.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/scene/dataset.h"

namespace mote::client {
namespace {

/// Servers of this minor version and above keep thumbnails.
constexpr std::uint32_t thumbnailsFromMinor = 4;

/// One that is made anew under its name has another, as far as the catalogue tells.
std::string thumbnailKey(const proto::Catalogue::Entry& entry) {
    return fmt::format("{} {} {} {} {}", entry.name(), entry.kind(), entry.steps(), entry.particles(),
                       entry.prepared_ms());
}

}  // namespace

void* DatasetThumbnails::handle(const proto::Catalogue::Entry& entry) const {
    const auto found = found_.find(thumbnailKey(entry));
    return found == found_.end() ? nullptr : found->second->texture->handle();
}

void DatasetThumbnails::rest() {
    connection_.reset();
    awaited_.clear();
    arrived_.clear();
}

void DatasetThumbnails::show(const std::vector<const proto::Catalogue::Entry*>& seen) {
    takeFrames();
    for (const auto* entry : seen) {
        const auto key = thumbnailKey(*entry);
        if (const auto found = found_.find(key); found != found_.end()) {
            pictures_.splice(pictures_.begin(), pictures_, found->second);
        } else if (!failed_.contains(key) && !awaited_.contains(key) &&
                   !layersThatDraw(entry->kind()).empty()) {
            ask(*entry);
        }
    }
}

void DatasetThumbnails::connect() {
    if (connection_) return;
    ConnectionSettings settings;
    settings.client = "mote-view, thumbnails";
    settings.wake = [] { Window::wake(); };
    settings.background = true;
    connection_ = std::make_unique<Connection>(file_, settings);
    connection_->onViewFailed([this](std::uint64_t view, const Error&) {
        // What cannot be drawn says so when it is opened.
        if (view == view_) failed_.merge(awaited_);
        awaited_.clear();
    });
}

/// As soon as it is known what the server can do, and as many at a time as it takes.
void DatasetThumbnails::ask(const proto::Catalogue::Entry& entry) {
    connect();
    if (connection_->state() != Connection::State::connected) return;
    if (connection_->welcome().minor() < thumbnailsFromMinor) return askForView(entry);
    if (awaited_.size() >= mostAwaited) return;
    const auto key = thumbnailKey(entry);
    awaited_.insert(key);
    connection_->thumbnail(entry.name(),
                           [this, key](const Result<FramePixels>& pixels) { answered(key, pixels); });
}

void DatasetThumbnails::askForView(const proto::Catalogue::Entry& entry) {
    if (!awaited_.empty()) return;
    const auto view = firstView(entry.name(), entry.kind(), static_cast<int>(entry.steps()), width, height);
    if (!view) return;
    awaited_.insert(thumbnailKey(entry));
    ViewRequest request;
    request.finalOnly = true;
    view_ = connection_->setView(*view, request);
}

void DatasetThumbnails::takeFrames() {
    if (!connection_) return;
    connection_->poll();
    while (const auto frame = connection_->takeFrame()) {
        if (frame->message.view_id() != view_ || !frame->message.final() || awaited_.empty()) continue;
        const auto of = *awaited_.begin();
        awaited_.clear();
        keep(of, frame->pixels);
    }
    if (arrived_.empty()) return;
    const auto [of, pixels] = std::move(arrived_.front());
    arrived_.pop_front();
    awaited_.erase(of);
    keep(of, pixels);
    if (!arrived_.empty()) Window::wake();
}

/// One that was given up, or whose line broke, may be asked for again.
void DatasetThumbnails::answered(const std::string& of, const Result<FramePixels>& pixels) {
    if (pixels.ok()) return static_cast<void>(arrived_.emplace_back(of, *pixels));
    awaited_.erase(of);
    const bool lost = connection_->state() != Connection::State::connected;
    if (!lost && pixels.error().code != ErrorCode::resourceExhausted) failed_.insert(of);
}

void DatasetThumbnails::keep(const std::string& of, const FramePixels& pixels) {
    if (pixels.format != proto::SRGB8 || pixels.width == 0) return static_cast<void>(failed_.insert(of));
    if (pictures_.size() >= most) {
        found_.erase(pictures_.back().of);
        pictures_.pop_back();
    }
    pictures_.push_front({of, std::make_unique<PictureTexture>()});
    pictures_.front().texture->upload(pixels.bytes, pixels.width, pixels.height);
    found_[of] = pictures_.begin();
}

}  // namespace mote::client
