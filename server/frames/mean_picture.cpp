// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/mean_picture.h"

#include <algorithm>
#include <utility>

#include "server/frames/planning.h"

namespace mote::server {
namespace {

/// The part that a place is in.
std::size_t partAt(const std::vector<ViewPart>& parts, double place) {
    std::size_t part = 0;
    for (double end = parts[0].weight; part + 1 < parts.size() && end <= place; end += parts[part].weight)
        ++part;
    return part;
}

double workMs(const proto::Frame& message) {
    return message.plan_ms() + message.render_ms();
}

}  // namespace

MeanPicture::MeanPicture(const RenderJob& job, std::vector<ViewPart> parts, const PictureHistory& history,
                         MeanPicture* before)
    : task_(job.task), stage_(job.stage), parts_(std::move(parts)), nearest_(partAt(parts_, nearestPlace)) {
    if (before != nullptr && before->histories_.size() == parts_.size())
        histories_ = std::move(before->histories_);
    while (histories_.size() < parts_.size()) histories_.push_back({history.quality});
    for (auto& its : histories_) its.dots = copyOf(history.dots);
    histories_[0].quality =
        history.quality.within(history.quality.budgetMs() / static_cast<double>(parts_.size()));
}

Result<Making> MeanPicture::goOn(const RenderJob& job, PictureHistory& history, const Make& make) {
    while (next_ < parts_.size()) {
        RenderJob part = job;
        part.part = PicturePart{parts_[next_].place, resolutionScale_};
        MOTE_ASSIGN_OR_RETURN(auto made, make(part, histories_[next_]));
        if (!made.picture) return made;
        take(*std::move(made.picture));
        if (next_ == parts_.size()) break;
        // What one of them teaches of the device holds for the next.
        histories_[next_].quality = histories_[next_ - 1].quality;
        if (job.pause.stop_requested()) return Making();
    }
    Making all;
    all.picture = finished(job, history);
    return all;
}

/// The picture of the next part.
void MeanPicture::take(MadePicture made) {
    resolutionScale_ = made.resolutionScale;
    const auto begun = Clock::now();
    made.memory.shrink(made.picture.pixels.capacity());
    memory_.push_back(std::move(made.memory));
    mean_.add(std::move(made.picture), parts_[next_].weight);
    if (memory_.size() > 2) memory_.erase(memory_.begin());
    auto& message = made.message;
    message.set_render_ms(message.render_ms() + milliseconds(Clock::now() - begun));
    if (!made_) {
        made_ = std::move(made);
    } else {
        auto& all = made_->message;
        all.set_queued_ms(std::max(0.0, message.queued_ms() - workMs(all)));
        all.set_points_drawn(all.points_drawn() + message.points_drawn());
        all.set_point_fraction(std::min(all.point_fraction(), message.point_fraction()));
        all.set_plan_ms(all.plan_ms() + message.plan_ms());
        all.set_render_ms(all.render_ms() + message.render_ms());
        made_->next = std::min(made_->next, made.next);
        if (next_ == nearest_) made_->annotations = std::move(made.annotations);
    }
    made_->onlyShapes = false;
    ++next_;
}

MadePicture MeanPicture::finished(const RenderJob& job, PictureHistory& history) {
    const auto begun = Clock::now();
    MadePicture all = *std::exchange(made_, std::nullopt);
    task_ = nullptr;  // once more is anew
    all.picture = mean_.take(stage_ == Stage::exact ? job.task->format : render::PixelFormat::srgb8);
    all.message.set_render_ms(all.message.render_ms() + milliseconds(Clock::now() - begun));
    all.memory = std::move(memory_.back());
    all.memory.become(encodingBytes(all.picture, all.annotations != nullptr, false));
    memory_.clear();
    history.quality = histories_.back().quality.within(history.quality.budgetMs());
    history.dots = copyOf(histories_.front().dots);
    return all;
}

}  // namespace mote::server
