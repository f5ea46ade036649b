// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/page_sight.h"

#include <cmath>
#include <limits>
#include <utility>

namespace mote::server {
namespace {

using render::Dot, render::Dots, render::Fragments, render::Strokes;

/// Of a dot in a pixel's middle that covers all of this pixel and nothing of others (docs/PICTURE.md,
/// "Dots").
const float pixelRadius = std::sqrt(1.0F / 3.0F);

/// In front of others of their depth.
Dots dotProbes(const std::vector<SightPlace>& places, std::uint32_t width, const glm::vec3& color,
               const Dots* others) {
    Dots dots;
    for (const auto& [pixel, depth] : places) {
        const auto column = pixel % width, row = pixel / width;
        dots.push_back({static_cast<float>(column) + 0.5F, static_cast<float>(row) + 0.5F, depth, pixelRadius,
                        1.0F, color});
    }
    if (others != nullptr) dots.insert(dots.end(), others->begin(), others->end());
    return dots;
}

Fragments fragmentProbes(const std::vector<SightPlace>& places, std::uint32_t width, const glm::vec3& color) {
    Fragments fragments;
    for (const auto& [pixel, depth] : places)
        fragments.push_back({pixel % width, pixel / width, depth, 1.0F, color});
    return fragments;
}

}  // namespace

PageShapes takeShapes(render::FramePlan& plan, const Page& page) {
    PageShapes shapes;
    const bool paleStays = page.format == proto::Page::EPS && !page.plotter;
    const auto stays = [&](float opacity) { return paleStays && opacity < 1.0F; };
    for (auto& strokes : std::exchange(plan.strokes, {}))
        (stays(strokes->opacity) ? plan.strokes : shapes.strokes).push_back(std::move(strokes));
    const auto all = std::exchange(plan.dots, nullptr);
    if (all == nullptr) return shapes;
    Dots taken, left;
    for (const auto& dot : *all) (stays(dot.opacity) ? left : taken).push_back(dot);
    if (!taken.empty()) shapes.dots = std::make_shared<const Dots>(std::move(taken));
    if (!left.empty()) plan.dots = std::make_shared<const Dots>(std::move(left));
    return shapes;
}

PageSight::PageSight(render::FramePlan plan, PageShapes shapes)
    : plan_(std::move(plan)),
      fragments_(plan_.fragments),
      plansDots_(plan_.dots),
      shapes_(std::move(shapes)),
      left_(shapes_.strokes.size() + 1),
      sights_(left_) {}

/// The last list of strokes is drawn first, the dots last. Whether anything is to be found of the list.
bool PageSight::beginList() {
    --left_;
    const bool ofDots = left_ == 0;
    const PictureSize size{plan_.width, plan_.height};
    plan_.fragments = fragments_;
    plan_.dots = plansDots_;
    const auto& strokes = shapes_.strokes;
    if (left_ < strokes.size()) plan_.strokes.insert(plan_.strokes.begin(), strokes[left_]);
    if (plan_.blank() || (ofDots && shapes_.dots == nullptr)) return false;
    probe_ = std::make_unique<SightProbe>(
        plan_.width, ofDots ? placesOf(*shapes_.dots, size) : placesOf(*strokes[left_ - 1], size));
    return true;
}

void PageSight::setProbes(const glm::vec3& color) {
    const auto& places = probe_->wanted();
    if (left_ == 0) {
        plan_.dots = std::make_shared<const Dots>(dotProbes(places, plan_.width, color, plansDots_.get()));
        return;
    }
    plan_.fragments = fragments_;
    plan_.fragments.push_back(std::make_shared<const Fragments>(fragmentProbes(places, plan_.width, color)));
}

bool PageSight::drawn(render::Device& device, const std::stop_token& pause, const std::stop_token& stop) {
    if (picture_ == nullptr) {
        setProbes(glm::vec3(pictures_.empty() ? 0.0F : 1.0F));
        picture_ = device.begin(plan_, render::PixelFormat::linearHalf, stop);
    }
    if (picture_ == nullptr || !picture_->advance(pause)) return false;
    pictures_.push_back(picture_->take());
    picture_.reset();
    return true;
}

bool PageSight::advance(render::Device& device, const std::stop_token& pause, const std::stop_token& stop) {
    while (left_ > 0 || probe_ != nullptr) {
        if (probe_ == nullptr && !beginList()) continue;
        if (!probe_->wanted().empty()) {
            if (!drawn(device, pause, stop)) return false;
            if (pictures_.size() < 2) continue;
            probe_->learn(pictures_[0], pictures_[1]);
            pictures_.clear();
            continue;
        }
        // Strokes in their order, then the dots.
        const auto place = left_ == 0 ? shapes_.strokes.size() : left_ - 1;
        sights_[place] = std::make_shared<const Sight>(probe_->take());
        probe_.reset();
    }
    return true;
}

std::uint64_t PageSight::bytes() const {
    std::uint64_t bytes = picture_ ? picture_->bytes() : 0;
    for (const auto& picture : pictures_) bytes += picture.pixels.size();
    if (plan_.dots) bytes += plan_.dots->size() * sizeof(Dot);
    if (plan_.fragments.size() > fragments_.size())
        bytes += plan_.fragments.back()->size() * sizeof(render::Fragment);
    return bytes + (probe_ ? probe_->bytes() : 0);
}

void PageSight::giveUp() {
    if (picture_) picture_->giveUp();
}

}  // namespace mote::server
