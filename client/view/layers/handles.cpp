// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/handles.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <utility>

#include "client/view/camera_control.h"
#include "client/view/view_model.h"
#include "protocol/scene/write_fields.h"

namespace mote::client {
namespace {

// Screen coordinates at the scale 1.
constexpr double handReach = 9.0, handleRadius = 6.0;
constexpr double arrowLength = 90.0, ringRadius = 62.0, squareOffset = 78.0, plateNormal = 70.0;
constexpr int ringPieces = 64;
constexpr double leastAngle = 0.1;  // sine of the one between a handle's way and the line of sight

constexpr std::array<ImU32, 3> axisColors{IM_COL32(235, 90, 80, 255), IM_COL32(110, 200, 90, 255),
                                          IM_COL32(90, 150, 255, 255)};
constexpr ImU32 cutColor = IM_COL32(255, 200, 90, 255), freeColor = IM_COL32(225, 225, 230, 255);

glm::dvec3 axisVector(int axis) {
    glm::dvec3 vector(0.0);
    vector[axis] = 1.0;
    return vector;
}

glm::dvec3 toWorld(const glm::dmat4& transform, const glm::dvec3& place) {
    return glm::dvec3(transform * glm::dvec4(place, 1.0));
}

glm::dvec3 unitNormal(const proto::ClipPlane& plane) {
    return glm::normalize(readVector(plane.normal()));
}

/// Where a plane is taken hold of: next to the middle.
glm::dvec3 middleOf(const proto::ClipPlane& plane, const Bounds& bounds) {
    const auto normal = readVector(plane.normal());
    const double squared = glm::dot(normal, normal);
    return bounds.center() + normal * ((plane.distance() - glm::dot(normal, bounds.center())) / squared);
}

/// A circle that is stretched along with all else, of so much at most.
glm::dvec3 onRing(const glm::dvec3& center, int axis, double radius, double angle,
                  const glm::dvec3& stretch) {
    const auto one = axisVector((axis + 1) % 3) * stretch, other = axisVector((axis + 2) % 3) * stretch;
    const double most = std::max(glm::length(one), glm::length(other));
    return center + radius / most * (std::cos(angle) * one + std::sin(angle) * other);
}

}  // namespace

/// The picture and the layer in it.
struct Handles::Picture {
    Camera camera;
    double width, height, scale;
    glm::dvec2 corner;   // its upper left one, on the screen
    Bounds bounds;       // layer space
    glm::dvec3 stretch;  // of the view, from where layers are placed to the world

    double aspect() const { return width / height; }
    /// Beyond all pictures what is not before the eye.
    glm::dvec2 at(const glm::dvec3& place) const {
        const auto seen = seenAt(camera, aspect(), place);
        return seen ? *seen * glm::dvec2(width, height) : glm::dvec2(std::numeric_limits<double>::infinity());
    }
    Sight under(glm::dvec2 mouse) const {
        return sightAt(camera, aspect(), mouse / glm::dvec2(width, height));
    }
    glm::dvec3 sight() const { return glm::normalize(camera.target - camera.eye); }
    /// World units that so many screen coordinates are at a place.
    double length(const glm::dvec3& place, double coordinates) const {
        const double depth = camera.perspective() ? glm::dot(place - camera.eye, sight()) : 1.0;
        return coordinates * scale * 2.0 * camera.halfHeight() * depth / height;
    }
    /// Whether a way is told from a point on the screen.
    bool shows(const glm::dvec3& place, const glm::dvec3& way) const {
        const glm::dvec3 line = camera.perspective() ? place - camera.eye : sight();
        return glm::length(glm::cross(glm::normalize(line), glm::normalize(way))) > leastAngle;
    }
    /// How far along the way from a place that point lies which is next to the line of sight, in ways.
    double along(const Handle& handle, glm::dvec2 mouse) const {
        const auto line = under(mouse);
        const glm::dvec3 apart = handle.place - line.from;
        const double across = glm::dot(handle.along, line.along);
        const double ways = glm::dot(handle.along, handle.along), sights = glm::dot(line.along, line.along);
        return (across * glm::dot(line.along, apart) - sights * glm::dot(handle.along, apart)) /
               (ways * sights - across * across);
    }
    /// Where the line of sight meets the plane through a place.
    glm::dvec3 on(const glm::dvec3& place, const glm::dvec3& normal, glm::dvec2 mouse) const {
        const auto line = under(mouse);
        return line.from + line.along * (glm::dot(normal, place - line.from) / glm::dot(normal, line.along));
    }
    double angle(const Handle& handle, glm::dvec2 mouse) const {
        const auto arm = (on(handle.place, handle.along, mouse) - handle.place) / stretch;
        return std::atan2(arm[(handle.index + 2) % 3], arm[(handle.index + 1) % 3]);
    }

    void line(const glm::dvec3& from, const glm::dvec3& to, ImU32 color, float width) const {
        const auto one = at(from), other = at(to);
        if (std::isfinite(one.x) && std::isfinite(other.x))
            ImGui::GetBackgroundDrawList()->AddLine(screenOf(one), screenOf(other), color, width * unit());
    }
    ImVec2 screenOf(glm::dvec2 place) const {
        const auto shifted = corner + place;
        return {static_cast<float>(shifted.x), static_cast<float>(shifted.y)};
    }
    float unit() const { return static_cast<float>(scale); }
    void dot(glm::dvec2 place, ImU32 color, bool square = false) const {
        if (!std::isfinite(place.x)) return;
        auto& draw = *ImGui::GetBackgroundDrawList();
        const auto radius = static_cast<float>(handleRadius) * unit();
        const ImVec2 middle = screenOf(place);
        if (!square) {
            draw.AddCircleFilled(middle, radius, color);
            return draw.AddCircle(middle, radius, IM_COL32(10, 10, 14, 255), 0, unit());
        }
        draw.AddRectFilled({middle.x - radius, middle.y - radius}, {middle.x + radius, middle.y + radius},
                           color);
    }
    void box(const glm::dmat4& transform, const Bounds& shown, ImU32 color) const {
        const auto corners = shown.corners();
        for (std::size_t i = 0; i < corners.size(); ++i) {
            for (const std::size_t other : {i | 1U, i | 2U, i | 4U})
                if (other != i)
                    line(toWorld(transform, corners[i]), toWorld(transform, corners[other]), color, 1.0F);
        }
    }
    /// What of a plane lies in the dataset's box.
    void plate(const glm::dmat4& transform, const proto::ClipPlane& plane) const {
        const auto corners = bounds.corners();
        const auto normal = readVector(plane.normal());
        std::vector<glm::dvec3> meets;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            for (const std::size_t other : {i | 1U, i | 2U, i | 4U}) {
                const double one = glm::dot(normal, corners[i]) - plane.distance();
                const double end = glm::dot(normal, corners[other]) - plane.distance();
                if (other != i && (one < 0.0) != (end < 0.0))
                    meets.push_back(glm::mix(corners[i], corners[other], one / (one - end)));
            }
        }
        if (meets.size() < 3) return;
        const auto middle = middleOf(plane, bounds);
        const glm::dvec3 across = glm::normalize(meets[0] - middle),
                         above = glm::cross(unitNormal(plane), across);
        std::ranges::sort(meets, {}, [&](const glm::dvec3& place) {
            return std::atan2(glm::dot(place - middle, above), glm::dot(place - middle, across));
        });
        std::vector<ImVec2> outline;
        for (const auto& place : meets) outline.push_back(screenOf(at(toWorld(transform, place))));
        if (!std::ranges::all_of(outline, [](const ImVec2& each) { return std::isfinite(each.x); })) return;
        auto& draw = *ImGui::GetBackgroundDrawList();
        const int count = static_cast<int>(outline.size());
        draw.AddConvexPolyFilled(outline.data(), count, IM_COL32(255, 200, 90, 34));
        draw.AddPolyline(outline.data(), count, cutColor, ImDrawFlags_Closed, 1.5F * unit());
    }
};

void Handles::addCuts(const ViewModel& model, const Picture& picture, std::vector<Handle>& handles) const {
    const auto transform = model.layerToWorld();
    const glm::dmat3 turned(transform);
    const auto clip = model.clip();
    const auto box = clipBoxOf(clip, picture.bounds);
    picture.box(transform, box, clip.has_box() ? cutColor : IM_COL32(255, 200, 90, 90));
    for (int face = 0; face < 6; ++face) {
        auto place = box.center();
        place[face / 2] = (face % 2 == 1 ? box.max : box.min)[face / 2];
        place = toWorld(transform, place);
        const auto way = turned * axisVector(face / 2);
        if (!picture.shows(place, way)) continue;
        handles.push_back({Of::boxFace, face, place, way, picture.at(place)});
        picture.dot(handles.back().at, axisColors[static_cast<std::size_t>(face / 2)]);
    }
    for (int i = 0; i < clip.planes_size(); ++i) {
        const auto& plane = clip.planes(i);
        picture.plate(transform, plane);
        const auto place = toWorld(transform, middleOf(plane, picture.bounds));
        const auto way = turned * unitNormal(plane);
        const auto tip = place + glm::normalize(way) * picture.length(place, plateNormal);
        picture.line(place, tip, cutColor, 2.0F);
        handles.push_back({Of::planeTurn, i, tip, way, picture.at(tip)});
        picture.dot(handles.back().at, freeColor);
        if (!picture.shows(place, way)) continue;
        handles.push_back({Of::planeShift, i, place, way, picture.at(place)});
        picture.dot(handles.back().at, cutColor);
    }
}

void Handles::addPlaces(const ViewModel& model, const Picture& picture, std::vector<Handle>& handles) const {
    const auto transform = model.layerToWorld();
    const auto center = toWorld(transform, picture.bounds.center());
    picture.box(transform, picture.bounds, IM_COL32(225, 225, 230, 90));
    const auto mouse = ImGui::GetIO().MousePos;
    for (int axis = 0; axis < 3; ++axis) {
        const auto color = axisColors[static_cast<std::size_t>(axis)];
        const auto way = axisVector(axis);
        if (picture.shows(center, way)) {
            const auto tip = center + way * picture.length(center, arrowLength);
            picture.line(center, tip, color, 2.0F);
            handles.push_back({Of::shift, axis, center, way, picture.at(tip)});
            picture.dot(handles.back().at, color);
        }
        // A ring that is seen from its edge tells no angles.
        if (std::abs(glm::dot(way, picture.sight())) < 2.0 * leastAngle) continue;
        Handle ring{Of::turn, axis, center, way, glm::dvec2(std::numeric_limits<double>::infinity())};
        const auto place = [&](int i) {
            return onRing(center, axis, picture.length(center, ringRadius),
                          i * glm::two_pi<double>() / ringPieces, picture.stretch);
        };
        for (int i = 0; i < ringPieces; ++i) {
            picture.line(place(i), place(i + 1), color, 2.0F);
            const auto at = picture.at(place(i));
            if (glm::distance(at, {mouse.x, mouse.y}) < glm::distance(ring.at, {mouse.x, mouse.y}))
                ring.at = at;
        }
        handles.push_back(ring);
    }
    const auto middle = picture.at(center);
    handles.push_back({Of::shiftFreely, 0, center, picture.sight(), middle});
    picture.dot(middle, freeColor);
    const auto corner = middle + glm::dvec2(squareOffset, -squareOffset) * picture.scale;
    handles.push_back({Of::stretch, 0, center, picture.sight(), corner});
    picture.dot(corner, freeColor, true);
}

bool Handles::pullFace(ViewModel& model, double way) const {
    auto clip = held_->clip;
    const auto whole = *model.layerBounds();
    auto box = clipBoxOf(clip, whole);
    const int axis = held_->handle.index / 2;
    const double least = 1e-3 * (whole.max[axis] - whole.min[axis]);  // that is left
    if (held_->handle.index % 2 == 1) {
        const double end = std::max(box.max[axis], whole.max[axis]);
        box.max[axis] = std::max(std::min(box.max[axis] + way, end), box.min[axis] + least);
    } else {
        const double end = std::min(box.min[axis], whole.min[axis]);
        box.min[axis] = std::min(std::max(box.min[axis] + way, end), box.max[axis] - least);
    }
    setClipBox(clip, box);
    return model.setClip(clip).ok();
}

bool Handles::pullPlane(ViewModel& model, const Picture& picture, glm::dvec2 to) const {
    auto clip = held_->clip;
    auto& plane = *clip.mutable_planes(held_->handle.index);
    const double length = glm::length(readVector(plane.normal()));
    if (held_->handle.of == Of::planeShift) {
        const double way = picture.along(held_->handle, to) - picture.along(held_->handle, held_->from);
        plane.set_distance(plane.distance() + way * length);
        return model.setClip(clip).ok();
    }
    const auto& tip = held_->handle.place;
    const auto moved =
        tip + picture.on(tip, picture.sight(), to) - picture.on(tip, picture.sight(), held_->from);
    const auto middle = middleOf(plane, picture.bounds);
    const auto arm = toWorld(glm::inverse(held_->layerToWorld), moved) - middle;
    if (!(glm::length(arm) > 0.0)) return false;
    const auto normal = glm::normalize(arm) * length;
    writeVector(normal, plane.mutable_normal());
    plane.set_distance(glm::dot(normal, middle));
    return model.setClip(clip).ok();
}

/// Where a layer is that was pulled so far.
glm::dmat4 Handles::placed(const Picture& picture, glm::dvec2 to) const {
    const auto& handle = held_->handle;
    // The layer's own transform comes before the view's stretch.
    const auto about = [&](const glm::dmat4& change) {
        const auto place = handle.place / picture.stretch;
        return glm::translate(glm::dmat4(1.0), place) * change * glm::translate(glm::dmat4(1.0), -place) *
               held_->transform;
    };
    const auto shifted = [&](const glm::dvec3& way) {
        return glm::translate(glm::dmat4(1.0), way / picture.stretch) * held_->transform;
    };
    switch (handle.of) {
        case Of::shift:
            return shifted(handle.along * (picture.along(handle, to) - picture.along(handle, held_->from)));
        case Of::shiftFreely:
            return shifted(picture.on(handle.place, handle.along, to) -
                           picture.on(handle.place, handle.along, held_->from));
        case Of::turn: {
            constexpr double notch = glm::pi<double>() / 12.0;
            double angle = picture.angle(handle, to) - picture.angle(handle, held_->from);
            if (ImGui::GetIO().KeyShift) angle = std::round(angle / notch) * notch;
            return about(glm::rotate(glm::dmat4(1.0), angle, handle.along));
        }
        default: {
            const auto middle = picture.at(handle.place);
            const double before = glm::distance(held_->from, middle), now = glm::distance(to, middle);
            return about(glm::scale(glm::dmat4(1.0), glm::dvec3(std::max(now / before, 0.01))));
        }
    }
}

bool Handles::pull(ViewModel& model, const Picture& picture, glm::dvec2 to) const {
    const auto& handle = held_->handle;
    if (handle.of == Of::boxFace)
        return pullFace(model, picture.along(handle, to) - picture.along(handle, held_->from));
    if (handle.of == Of::planeShift || handle.of == Of::planeTurn) return pullPlane(model, picture, to);
    const auto there = placed(picture, to);
    return std::isfinite(there[3][0] + there[3][1] + there[3][2]) && model.setTransform(there).ok();
}

/// What a handle does, or has done.
std::string Handles::said(const ViewModel& model) const {
    const auto& handle = held_->handle;
    const auto clip = model.clip();
    if (handle.of == Of::boxFace) {
        const auto box = clipBoxOf(clip, *model.layerBounds());
        const auto axis = static_cast<std::size_t>(handle.index / 2);
        const auto& end = handle.index % 2 == 1 ? box.max : box.min;
        return fmt::format("{} {} {:.5g}", "xyz"[axis], handle.index % 2 == 1 ? "to" : "from",
                           end[handle.index / 2]);
    }
    if (handle.of == Of::planeShift || handle.of == Of::planeTurn) {
        const auto& plane = clip.planes(handle.index);
        const auto normal = unitNormal(plane);
        return fmt::format("{:.3g}, {:.3g}, {:.3g} from {:.5g} on", normal.x, normal.y, normal.z,
                           plane.distance() / glm::length(readVector(plane.normal())));
    }
    const auto placement = Placement::of(model.transform());
    if (!placement) return "oblique";
    const auto& shown = handle.of == Of::turn      ? placement->turn
                        : handle.of == Of::stretch ? placement->stretch
                                                   : placement->shift;
    const char* what = handle.of == Of::turn ? "turned" : handle.of == Of::stretch ? "stretched" : "shifted";
    const bool metres = model.inMetres() && &shown == &placement->shift;
    return fmt::format("{} {:.4g}, {:.4g}, {:.4g}{}", what, shown.x, shown.y, shown.z, metres ? " m" : "");
}

bool Handles::draw(ViewModel& model, const PictureArea& area, bool& changed) {
    const auto bounds = model.layerBounds();
    if (!bounds || model.layers().empty() || (!cuts && !places)) {
        held_.reset();
        return false;
    }
    const auto& io = ImGui::GetIO();
    // Within the picture, as all that follows but what is drawn.
    const glm::dvec2 mouse(io.MousePos.x - area.left, io.MousePos.y - area.top);
    const double width = area.width, height = area.height;
    const Picture picture{model.camera(width / height), width,   height,         area.scale,
                          {area.left, area.top},        *bounds, model.stretch()};
    // Let go, it is where the mouse was last.
    if (held_ && mouse != held_->from) changed |= pull(model, picture, mouse);
    std::vector<Handle> handles;
    if (cuts) addCuts(model, picture, handles);
    if (places) addPlaces(model, picture, handles);
    if (held_) {
        ImGui::SetTooltip("%s", said(model).c_str());
        if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) held_.reset();
        return true;
    }
    const auto away = [&](const Handle& handle) { return glm::distance(handle.at, mouse); };
    const auto nearest = std::ranges::min_element(handles, {}, away);
    if (io.WantCaptureMouse || nearest == handles.end() || !(away(*nearest) < handReach * area.scale))
        return false;
    ImGui::GetBackgroundDrawList()->AddCircle(picture.screenOf(nearest->at),
                                              static_cast<float>(handleRadius + 3.0) * area.scale,
                                              IM_COL32_WHITE, 0, 2.0F * area.scale);
    if (!ImGui::IsMouseClicked(ImGuiMouseButton_Left)) return false;
    held_ = Held{*nearest, mouse, model.clip(), model.transform(), model.layerToWorld()};
    return true;
}

bool cutBeforeMiddle(proto::Clip& clip, const Bounds& bounds, const glm::dvec3& eye) {
    const glm::dvec3 away = bounds.center() - eye;
    if (clip.planes_size() >= mostClipPlanes || !(glm::length(away) > 0.0)) return false;
    const auto normal = glm::normalize(away);
    auto& plane = *clip.add_planes();
    writeVector(normal, plane.mutable_normal());
    plane.set_distance(glm::dot(normal, bounds.center()));
    return true;
}

Bounds clipBoxOf(const proto::Clip& clip, const Bounds& bounds) {
    if (clip.has_box()) return {readVector(clip.box().min()), readVector(clip.box().max())};
    const glm::dvec3 least = 1e-6 * (glm::abs(bounds.min) + 1.0);  // a box holds something
    return {bounds.min, glm::max(bounds.max, bounds.min + least)};
}

void setClipBox(proto::Clip& clip, const Bounds& box) {
    writeVector(box.min, clip.mutable_box()->mutable_min());
    writeVector(box.max, clip.mutable_box()->mutable_max());
}

std::optional<Placement> Placement::of(const glm::dmat4& transform) {
    glm::dmat3 turned(transform);
    Placement placement{glm::dvec3(transform[3])};
    for (int i = 0; i < 3; ++i) placement.stretch[i] = glm::length(turned[i]);
    if (glm::determinant(turned) < 0.0) placement.stretch.x = -placement.stretch.x;
    for (int i = 0; i < 3; ++i) turned[i] /= placement.stretch[i];
    for (int i = 0; i < 3; ++i) {
        if (std::abs(glm::dot(turned[i], turned[(i + 1) % 3])) > 1e-9) return std::nullopt;
    }
    const double y = std::asin(std::clamp(0.0 - turned[0][2], -1.0, 1.0));
    const bool upright = std::abs(turned[0][2]) < 1.0 - 1e-12;
    placement.turn = glm::degrees(upright ? glm::dvec3(std::atan2(turned[1][2], turned[2][2]), y,
                                                       std::atan2(turned[0][1], turned[0][0]))
                                          : glm::dvec3(std::atan2(-turned[2][1], turned[1][1]), y, 0.0));
    return placement;
}

glm::dmat4 Placement::transform() const {
    auto transform = glm::translate(glm::dmat4(1.0), shift);
    for (const int axis : {2, 1, 0})
        transform = glm::rotate(transform, glm::radians(turn[axis]), axisVector(axis));
    return glm::scale(transform, stretch);
}

}  // namespace mote::client
