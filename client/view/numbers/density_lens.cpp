// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/density_lens.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "client/shared/numbers.h"
#include "client/view/numbers/selection_edits.h"
#include "client/view/panel_widgets.h"
#include "client/view/view_model.h"

namespace mote::client {

proto::Query densitiesIn(const ViewModel& model, double aspect, const PictureRectangle& rectangle,
                         std::uint32_t bins) {
    proto::Query query;
    query.set_dataset(model.dataset());
    query.set_steps(fmt::format("{0}:{0}:1", model.step()));
    *query.mutable_select() =
        lassoOn(model.camera(aspect), aspect, model.layer(), model.layerToWorld(), rectangle.corners());
    auto& histogram = *query.mutable_histogram();
    histogram.set_unweighted(true);
    auto& axis = *histogram.add_axes();
    axis.set_column("leaf_density");
    axis.set_bins(bins);
    axis.add_range(0.0);
    axis.add_range(1.0);
    return query;
}

void DensityLens::turn(bool on) {
    on_ = on;
    dragging_ = false;
    if (on) return;
    rectangle_.reset();
    lit_.clear();
    failure_.clear();
    query_.drop();
}

bool DensityLens::takeMouse(const PictureArea& area) {
    const auto& io = ImGui::GetIO();
    const auto at = area.partAt(static_cast<double>(io.MousePos.x), static_cast<double>(io.MousePos.y));
    const bool inside = area.holds(static_cast<double>(io.MousePos.x), static_cast<double>(io.MousePos.y));
    if (!on_ || !ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
        dragging_ = false;
        return false;
    }
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !io.WantCaptureMouse && inside) {
        dragging_ = true;
        rectangle_ = PictureRectangle{at, at};
    }
    if (dragging_) rectangle_->to = glm::clamp(at, 0.0, 1.0);
    return dragging_;
}

void DensityLens::ask(const ViewModel& model, const PictureArea& area, std::uint32_t bins, bool moving) {
    const bool particles = model.kind() == proto::Layer::kParticles && bins > 0;
    const bool wide =
        rectangle_ && rectangle_->from.x != rectangle_->to.x && rectangle_->from.y != rectangle_->to.y;
    if (!on_ || !particles || !wide) return lit_.clear();
    if (moving) return;
    const auto query = densitiesIn(model, area.aspect(), *rectangle_, bins);
    query_.want(query, [this, asked = query.histogram()](const Result<QueryAnswer>& answer) {
        const auto histogram = answer.ok() ? histogramOf(*answer, asked) : answer.error();
        lit_.clear();
        failure_ = histogram.ok() ? std::string() : histogram.error().toString();
        if (!histogram.ok()) return;
        particles_ = histogram->particles;
        for (const double count : histogram->counts) lit_.push_back(static_cast<std::uint64_t>(count));
    });
}

void DensityLens::draw(const PictureArea& area) const {
    if (!on_) return;
    std::string said = "Densities: drag a rectangle (T or Esc ends)";
    if (rectangle_ && !lit_.empty())
        said += fmt::format("; {} in it", metric(static_cast<double>(particles_), "particles"));
    if (rectangle_ && !failure_.empty()) said += "\n" + failure_;
    drawSign(area, said);
    if (!rectangle_) return;
    const auto placeOf = [&](const glm::dvec2& part) {
        return ImVec2{area.left + static_cast<float>(part.x) * area.width,
                      area.top + static_cast<float>(part.y) * area.height};
    };
    const ImVec2 one = placeOf(rectangle_->from), other = placeOf(rectangle_->to);
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const ImVec2 least{std::min(one.x, other.x), std::min(one.y, other.y)},
        most{std::max(one.x, other.x), std::max(one.y, other.y)};
    draw.AddRect({least.x - 1.0F, least.y - 1.0F}, {most.x + 1.0F, most.y + 1.0F}, IM_COL32(0, 0, 0, 160));
    draw.AddRect(least, most, IM_COL32(255, 225, 130, 255), 0.0F, 0, std::max(area.scale, 1.0F));
}

}  // namespace mote::client
