// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is cut away of the chosen layer, and where it lies, by numbers.
#include <imgui.h>

#include <array>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "client/view/layers/handles.h"
#include "client/view/layers/layer_editor.h"
#include "client/view/panel_widgets.h"
#include "client/view/view_model.h"
#include "protocol/scene/write_fields.h"

namespace mote::client {
namespace {

/// A part that is folded at first, and whose handles are shown while it is not.
bool handleSection(const char* title, bool& open) {
    ImGui::SetNextItemOpen(open);
    open = ImGui::CollapsingHeader(title);
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip("while this is unfolded, handles in the picture do the same");
    return open;
}

void drawClipBox(proto::Clip& clip, const Bounds& bounds, PanelActions& actions) {
    bool there = clip.has_box();
    auto box = clipBoxOf(clip, bounds);
    checkbox(actions, "box", there);
    if (there != clip.has_box()) there ? setClipBox(clip, box) : clip.clear_box();
    if (!there) return;
    const auto before = box;
    constexpr std::array<const char*, 3> axes{"x", "y", "z"};
    for (int axis = 0; axis < 3; ++axis)
        rangeBox(actions, axes[static_cast<std::size_t>(axis)], box.min[axis], box.max[axis],
                 {bounds.min[axis], bounds.max[axis]}, 400.0);
    if (!(box == before)) setClipBox(clip, box);
}

/// False where it is to be removed.
bool drawClipPlane(proto::ClipPlane& plane, const Bounds& bounds, PanelActions& actions) {
    const auto normal = readVector(plane.normal());
    const double length = glm::length(normal);
    auto angles = LightAngles::of(normal);
    const auto before = angles;
    angleSliders(actions, "plane", angles);
    if (!(angles == before)) writeVector(angles.direction() * length, plane.mutable_normal());
    const double middle = glm::dot(readVector(plane.normal()), bounds.center()) / length;
    const double half = 0.5 * glm::length(bounds.size());
    double distance = plane.distance() / length;
    const double shown = distance;
    wideSlider(actions, "distance", distance, {middle - half, middle + half});
    if (distance != shown) plane.set_distance(distance * length);
    if (ImGui::Button("Other side")) {
        writeVector(-readVector(plane.normal()), plane.mutable_normal());
        plane.set_distance(-plane.distance());
    }
    ImGui::SameLine();
    return !ImGui::Button("Remove plane");
}

void drawClipPlanes(proto::Clip& clip, const Bounds& bounds, PanelActions& actions) {
    for (int i = 0; i < clip.planes_size(); ++i) {
        ImGui::PushID(i);
        const bool stays = drawClipPlane(*clip.mutable_planes(i), bounds, actions);
        ImGui::PopID();
        if (!stays) clip.mutable_planes()->DeleteSubrange(i--, 1);
    }
}

void takeEdit(const Status& status, PanelActions& actions) {
    status.ok() ? static_cast<void>(actions.viewChanged = true)
                : static_cast<void>(actions.refused = status.error().toString());
}

}  // namespace

void drawCutAway(ViewModel& model, Handles& handles, const LayerPanel& panel) {
    const auto bounds = model.layerBounds();
    if (!bounds || !handleSection("Cut away", handles.cuts)) return;
    auto clip = model.clip();
    const auto before = clip;
    drawClipBox(clip, *bounds, panel.actions);
    drawClipPlanes(clip, *bounds, panel.actions);
    if (clip.planes_size() < mostClipPlanes && ImGui::Button("Cut in front of the middle"))
        cutBeforeMiddle(clip, *bounds,
                        glm::dvec3(glm::inverse(model.layerToWorld()) * glm::dvec4(panel.eye, 1.0)));
    if (!(clip == before)) takeEdit(model.setClip(clip), panel.actions);
}

void drawPlacement(ViewModel& model, Handles& handles, const LayerPanel& panel) {
    if (!model.layerBounds() || !handleSection("Place", handles.places)) return;
    bool metres = model.inMetres();
    if (ImGui::Checkbox("all layers where they are, in metres", &metres))
        takeEdit(model.setInMetres(metres), panel.actions);
    auto transform = model.transform();
    const auto before = transform;
    glm::dvec3 shift(transform[3]);
    if (typeNumbers(metres ? "shift, m" : "shift", shift)) transform[3] = glm::dvec4(shift, 1.0);
    if (auto placement = Placement::of(transform)) {
        bool typed = typeNumbers("turn, deg", placement->turn);
        typed |= typeNumbers("stretch", placement->stretch);
        if (typed) transform = placement->transform();
    } else {
        dim("Its right angles are oblique in the picture: there is more to it than turning and stretching.");
    }
    ImGui::BeginDisabled(before == glm::dmat4(1.0));
    if (ImGui::Button("Back to its own place")) transform = glm::dmat4(1.0);
    ImGui::EndDisabled();
    if (transform != before) takeEdit(model.setTransform(transform), panel.actions);
}

}  // namespace mote::client
