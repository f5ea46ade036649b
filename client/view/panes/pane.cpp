// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/panes/pane.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/view/panel_widgets.h"
#include "protocol/base/mote_check.h"
#include "protocol/scene/annotations.h"
#include "protocol/scene/camera.h"
#include "protocol/scene/fields/facts.h"

namespace mote::client {

bool Pane::needs(const PictureArea& area, bool moving) const {
    const bool resized = area.columns != askedColumns_ || area.rows != askedRows_;
    return dirty || resized || (askedMoving_ && !moving);
}

void Pane::ask(Connection& line, proto::View view, const PictureArea& area, bool moving) {
    ViewRequest request;
    request.moving = moving;
    askedView_ = line.setView(std::move(view), request);
    if (firstView_ == 0) firstView_ = askedView_;
    askedMoving_ = moving;
    askedFitted_ = !model.hasCamera();
    askedColumns_ = area.columns;
    askedRows_ = area.rows;
    dirty = false;
}

void Pane::take(ReceivedFrame received) {
    const auto& message = received.message;
    if (!hears(message.view_id())) return;
    if (message.view_id() == askedView_) failure.clear();  // what failed is shown now
    if (message.view_id() == askedView_ && askedFitted_ && message.has_camera()) {
        if (const auto served = parseCamera(message.camera()); served.ok()) model.setServed(*served);
    }
    if (!texture_) texture_ = std::make_unique<PictureTexture>();
    texture_->upload(received.pixels.bytes, received.pixels.width, received.pixels.height);
    picture = std::move(received.pixels);
    frame = std::make_shared<const proto::Frame>(std::move(received.message));
}

void Pane::forgetAsked() {
    dirty = true;
    askedView_ = firstView_ = 0;
}

void Pane::drawPicture(const PictureArea& area) const {
    if (!texture_) return;
    texture_->drawnInto(area.columns, area.rows);
    ImGui::GetBackgroundDrawList()->AddImage(texture_->handle(), {area.left, area.top},
                                             {area.left + area.width, area.top + area.height});
}

PictureArea DataSaver::asked(PictureArea area) const {
    const auto fewer = [&](std::uint32_t side) {
        return std::max(static_cast<std::uint32_t>(std::lround(shareOfSide * side)), std::min(side, 1U));
    };
    if (!on) return area;
    area.columns = fewer(area.columns);
    area.rows = fewer(area.rows);
    return area;
}

void DataSaver::scale(proto::View& view) const {
    if (on) view.set_scale(shareOfSide * (view.has_scale() ? view.scale() : 1.0));
}

std::string DataSaver::said(const PictureArea& area, std::uint64_t bytes) const {
    const auto small = asked(area);
    return fmt::format("Data saver: {} x {} pixels, {:.0f} pictures a second in motion; {} so far",
                       small.columns, small.rows, 1.0 / pause, metric(static_cast<double>(bytes), "B"));
}

void Pane::copy(const Pane& other) {
    subject = other.subject;
    shown = other.shown;
    model.copy(other.model);
}

Panes::Panes(Connection& first, std::function<std::unique_ptr<Connection>()> further)
    : first_(first), makeLine_(std::move(further)) {
    panes_.push_back(std::make_unique<Pane>(++ids_));
}

Pane* Panes::find(std::uint64_t id) {
    const auto found = std::ranges::find_if(panes_, [&](const auto& pane) { return pane->id == id; });
    return found != panes_.end() ? found->get() : nullptr;
}

Connection& Panes::line(std::size_t index) {
    if (index == 0) return first_;
    while (further_.size() < index) {
        further_.push_back(makeLine_());
        further_.back()->onViewFailed([this, pane = further_.size()](std::uint64_t view, const Error& error) {
            if (pane < panes_.size() && panes_[pane]->hears(view)) panes_[pane]->failure = error.toString();
        });
    }
    return *further_[index - 1];
}

void Panes::pollFurther() {
    for (const auto& line : further_) line->poll();
}

void Panes::reconnectFurther() {
    for (const auto& line : further_) line->reconnect();
}

/// Lines go with places, not with panes: who came to another place asks over another one.
void Panes::keepLines(const std::vector<std::uint64_t>& before) {
    for (std::size_t i = 0; i < panes_.size(); ++i) {
        if (i >= before.size() || panes_[i]->id != before[i]) panes_[i]->forgetAsked();
    }
    if (further_.size() >= panes_.size()) further_.resize(panes_.size() - 1);
    linked_ = linkedTime_ = {};
}

void Panes::setCount(std::size_t count) {
    MOTE_CHECK(count >= 1 && count <= mostPanes);
    std::vector<std::uint64_t> before;
    for (const auto& pane : panes_) before.push_back(pane->id);
    if (active_ >= count) {
        std::swap(panes_[active_], panes_[count - 1]);
        active_ = count - 1;
    }
    panes_.resize(std::min(count, panes_.size()));
    while (panes_.size() < count) {
        auto pane = std::make_unique<Pane>(++ids_);
        pane->copy(active());
        panes_.push_back(std::move(pane));
    }
    keepLines(before);
}

void Panes::setIds(const std::vector<PaneState>& state) {
    const auto activeId = active().id;
    std::vector<std::uint64_t> before;
    for (const auto& pane : panes_) before.push_back(pane->id);
    auto known = std::exchange(panes_, {});
    for (const auto& each : state) {
        const auto found =
            std::ranges::find_if(known, [&](const auto& pane) { return pane && pane->id == each.id; });
        panes_.push_back(found != known.end() ? std::move(*found) : std::make_unique<Pane>(each.id));
    }
    active_ = 0;
    for (std::size_t i = 0; i < panes_.size(); ++i) {
        if (panes_[i]->id == activeId) active_ = i;
    }
    keepLines(before);
}

std::size_t Panes::timedIndex() const {
    if (active().model.timedSteps() > 1) return active_;
    for (std::size_t i = 0; i < panes_.size(); ++i) {
        if (panes_[i]->model.timedSteps() > 1) return i;
    }
    return active_;
}

std::vector<ViewModel*> Panes::others(std::size_t than, std::vector<Pane*>& of) const {
    std::vector<ViewModel*> models;
    of.clear();
    for (std::size_t i = 0; i < panes_.size(); ++i) {
        if (i == than) continue;
        of.push_back(panes_[i].get());
        models.push_back(&panes_[i]->model);
    }
    return models;
}

void Panes::follow() {
    if (size() < 2) return;
    std::vector<Pane*> of;
    auto models = others(active_, of);
    for (const auto changed : linked_.follow(active().model, models, links_)) of[changed]->dirty = true;
    const auto timed = timedIndex();
    if (timed == active_) {
        linkedTime_ = {};
        return;
    }
    models = others(timed, of);
    const Links steps{links_.steps, false, false};
    for (const auto changed : linkedTime_.follow(panes_[timed]->model, models, steps))
        of[changed]->dirty = true;
}

void Panes::setLinks(const Links& links) {
    const Links made{links.steps && !links_.steps, links.selections && !links_.selections,
                     links.cameras && !links_.cameras};
    links_ = links;
    const auto share = [&](std::size_t from, const Links& what) {
        std::vector<Pane*> of;
        const auto models = others(from, of);
        for (const auto changed : shareAll(panes_[from]->model, models, what)) of[changed]->dirty = true;
    };
    share(active_, {false, made.selections, made.cameras});
    share(timedIndex(), {made.steps, false, false});
}

std::vector<DeskPane> Panes::looked() const {
    std::vector<DeskPane> panes;
    for (const auto& pane : panes_) panes.push_back({pane->id, pane->subject, pane->model});
    return panes;
}

void keepLettersReadable(proto::View& view, const PictureArea& area) {
    const double least = 11.0 * area.scale;  // pixels
    auto& said = *view.mutable_annotations();
    const double scale = view.has_scale() ? view.scale() : 1.0;
    if (said.has_font_points() || said.has_print_width() || !checkAnnotations(said).ok() || !(scale > 0.0))
        return;
    if (fontPixels(said, area.columns, area.rows, scale) >= least) return;
    said.set_font_points(lengthOf(said, said.kFontPointsFieldNumber));
    const double pixels = fontPixels(said, area.columns, area.rows, scale);
    said.set_font_points(std::clamp(said.font_points() * least / pixels, 1.0, 200.0));
}

PictureArea paneArea(const PictureArea& whole, std::size_t index, std::size_t count) {
    PictureArea area = whole;
    const float gap = std::round(2.0F * whole.scale);
    const auto part = [&](float length, bool second, float& from) {
        const float first = std::max(std::floor((length - gap) / 2.0F), 1.0F);
        if (second) from += first + gap;
        return second ? std::max(length - first - gap, 1.0F) : first;
    };
    if (count > 1) area.width = part(whole.width, index % 2 == 1, area.left);
    if (count > 2) area.height = part(whole.height, index >= 2, area.top);
    const auto pixels = [](float side, float all, std::uint32_t ofAll) {
        return static_cast<std::uint32_t>(std::max(side / all * static_cast<float>(ofAll), 1.0F));
    };
    area.columns = pixels(area.width, whole.width, whole.columns);
    area.rows = pixels(area.height, whole.height, whole.rows);
    return area;
}

void drawPaneFrames(const Panes& panes, const PictureArea& whole) {
    if (panes.size() < 2) return;
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    for (std::size_t i = 0; i < panes.size(); ++i) {
        const auto area = paneArea(whole, i, panes.size());
        const auto held = heldStep(panes[i].model, panes.timed().model);
        if (held && panes.links().steps) {
            const auto said = fmt::format("step {}, its last", *held);
            const float inset = 8.0F * area.scale;
            const ImVec2 size = ImGui::CalcTextSize(said.c_str());
            // Beside the triad: the picture's own labels are above.
            const ImVec2 at{area.left + 100.0F * area.scale, area.top + area.height - 2.0F * inset - size.y};
            draw.AddRectFilled({at.x - inset, at.y - inset / 2.0F},
                               {at.x + size.x + inset, at.y + size.y + inset / 2.0F},
                               IM_COL32(20, 24, 32, 220), inset);
            draw.AddText(at, IM_COL32(235, 240, 250, 255), said.c_str());
        }
        const bool active = i == panes.activeIndex();
        const float thick = (active ? 2.0F : 1.0F) * area.scale;
        const float half = (thick - 1.0F) / 2.0F;  // a half more is AddRect's
        draw.AddRect({area.left + half, area.top + half},
                     {area.left + area.width - half, area.top + area.height - half},
                     active ? IM_COL32(90, 160, 255, 255) : IM_COL32(90, 90, 98, 255), 0.0F, 0, thick);
    }
}

}  // namespace mote::client
