// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/datasets/dataset_thumbnails.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/scene/dataset.h"

namespace mote::client {
namespace {

/// One that is made anew under its name has another, as far as the catalogue tells.
std::string thumbnailKey(const proto::Catalogue::Entry& entry) {
    return fmt::format("{} {} {} {}", entry.name(), entry.kind(), entry.steps(), entry.particles());
}

/// Its usual kind of layer, every field left to the server, in the middle of its time.
proto::View thumbnailView(const proto::Catalogue::Entry& entry, proto::Layer::KindCase kind) {
    proto::View view;
    view.set_width(DatasetThumbnails::width);
    view.set_height(DatasetThumbnails::height);
    auto& layer = *view.add_layers();
    layer.set_dataset(entry.name());
    layer.set_step(entry.steps() / 2);
    layer.GetReflection()->MutableMessage(&layer, proto::Layer::descriptor()->FindFieldByNumber(kind));
    return view;
}

}  // namespace

void* DatasetThumbnails::handle(const proto::Catalogue::Entry& entry) const {
    const auto found = found_.find(thumbnailKey(entry));
    return found == found_.end() ? nullptr : found->second->texture->handle();
}

void DatasetThumbnails::rest() {
    connection_.reset();
    awaited_.clear();
}

void DatasetThumbnails::show(const std::vector<const proto::Catalogue::Entry*>& seen) {
    takeFrames();
    const proto::Catalogue::Entry* missing = nullptr;
    for (const auto* entry : seen) {
        const auto key = thumbnailKey(*entry);
        if (const auto found = found_.find(key); found != found_.end()) {
            pictures_.splice(pictures_.begin(), pictures_, found->second);
        } else if (missing == nullptr && failed_.count(key) == 0 && !layersThatDraw(entry->kind()).empty()) {
            missing = entry;
        }
    }
    if (missing != nullptr && awaited_.empty()) ask(*missing);
}

void DatasetThumbnails::ask(const proto::Catalogue::Entry& entry) {
    if (!connection_) {
        ConnectionSettings settings;
        settings.client = "mote-view, thumbnails";
        settings.wake = [] { Window::wake(); };
        settings.background = true;
        connection_ = std::make_unique<Connection>(file_, settings);
        connection_->onViewFailed([this](std::uint64_t view, const Error&) {
            // What cannot be drawn says so when it is opened.
            if (view == view_) failed_.insert(std::exchange(awaited_, {}));
        });
    }
    awaited_ = thumbnailKey(entry);
    ViewRequest request;
    request.finalOnly = true;
    view_ = connection_->setView(thumbnailView(entry, layersThatDraw(entry.kind()).front()), request);
}

void DatasetThumbnails::takeFrames() {
    if (!connection_) return;
    connection_->poll();
    while (const auto frame = connection_->takeFrame()) {
        if (frame->message.view_id() == view_ && frame->message.final() && !awaited_.empty())
            keep(std::exchange(awaited_, {}), frame->pixels);
    }
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
