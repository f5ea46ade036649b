// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/clip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>
#include <string>

#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/write_fields.h"

namespace mote {

double HalfSpace::within(const glm::dvec3& place) const {
    return glm::dot(normal, place) - distance;
}

bool inAll(std::span<const HalfSpace> clips, const glm::dvec3& place) {
    return std::all_of(clips.begin(), clips.end(),
                       [&](const HalfSpace& side) { return side.within(place) >= 0.0; });
}

bool allCut(std::span<const HalfSpace> clips, const Bounds& box) {
    return std::any_of(clips.begin(), clips.end(), [&](const HalfSpace& side) {
        glm::dvec3 farthest;
        for (int axis = 0; axis < 3; ++axis)
            farthest[axis] = side.normal[axis] > 0.0 ? box.max[axis] : box.min[axis];
        return side.within(farthest) < 0.0;
    });
}

HalfSpaces inSpace(std::span<const HalfSpace> clips, const glm::dmat4& toSpace) {
    HalfSpaces made;
    for (const auto& side : clips) {
        made.push_back({glm::transpose(glm::dmat3(toSpace)) * side.normal,
                        side.distance - glm::dot(side.normal, glm::dvec3(toSpace[3]))});
    }
    return made;
}

void clipWay(std::span<const HalfSpace> clips, const glm::dvec3& origin, const glm::dvec3& direction,
             double& enter, double& leave) {
    for (const auto& side : clips) {
        const double height = side.within(origin);
        const double rise = glm::dot(side.normal, direction);
        if (rise > 0.0) enter = std::max(enter, -height / rise);
        if (rise < 0.0) leave = std::min(leave, -height / rise);
        if (rise == 0.0 && height < 0.0) leave = -std::numeric_limits<double>::infinity();
    }
}

Status checkPlanes(ClipPlanes& planes, std::string_view field) {
    if (planes.size() > mostClipPlanes)
        return invalid(std::string(field), fmt::format("a layer has at most {} clip planes, not {}",
                                                       mostClipPlanes, planes.size()));
    for (int i = 0; i < planes.size(); ++i) {
        auto& plane = planes[i];
        const glm::dvec3 normal = readVector(plane.normal());
        const double length = glm::length(normal);
        if (!(length > 1e-6))
            return invalid(fmt::format("{}[{}].normal", field, i), "a normal must not be zero");
        // One that is a unit vector but for roundings stays: what was checked is as it was, checked again.
        if (std::abs(length - 1.0) < 2e-15) continue;
        writeVector(normal / length, plane.mutable_normal());
        plane.set_distance(plane.distance() / length);
    }
    return success();
}

Status checkBox(const proto::ClipBox& box, std::string_view field) {
    for (int axis = 0; axis < 3; ++axis) {
        if (!(box.min(axis) < box.max(axis)))
            return invalid(fmt::format("{}.max[{}]", field, axis), "must lie above the box's min");
    }
    return success();
}

Result<proto::Clip> parseClip(proto::Clip message) {
    MOTE_ASSIGN_OR_RETURN(auto clip, resolved(std::move(message)));
    MOTE_RETURN_IF_ERROR(checkPlanes(*clip.mutable_planes(), "planes"));
    if (clip.has_box()) MOTE_RETURN_IF_ERROR(checkBox(clip.box(), "box"));
    return clip;
}

proto::Clip saidClip(const proto::Layer& layer) {
    proto::Clip clip = layer.clip();
    clip.mutable_planes()->MergeFrom(layer.clip_planes());
    if (layer.has_clip_box()) *clip.mutable_box() = layer.clip_box();
    return clip;
}

Result<proto::Clip> parseClipOf(const proto::Layer& layer) {
    if (auto own = parseClip(layer.clip()); !own.ok()) return own.error().within("clip");
    proto::Layer beside;
    *beside.mutable_clip_planes() = layer.clip_planes();
    if (layer.has_clip_box()) *beside.mutable_clip_box() = layer.clip_box();
    if (auto other = parseClip(saidClip(beside)); !other.ok()) {
        // Of a clip's "planes" and "box" these are the layer's "clipPlanes" and "clipBox".
        Error error = other.error();
        if (!error.where.empty()) error.where[0] = error.where[0] == 'p' ? 'P' : 'B';
        error.where.insert(0, "clip");
        return error;
    }
    if (layer.has_clip_box() && layer.clip().has_box())
        return invalid("clipBox", "a layer has one clip box, and its \"clip\" has it");
    auto clip = parseClip(saidClip(layer));
    return clip.ok() ? clip : Result<proto::Clip>(invalid("clipPlanes", clip.error().message));
}

HalfSpaces halfSpacesOf(const ClipPlanes& planes, const proto::ClipBox* box) {
    HalfSpaces clips;
    for (const auto& plane : planes) clips.push_back({readVector(plane.normal()), plane.distance()});
    for (int axis = 0; box != nullptr && axis < 3; ++axis) {
        glm::dvec3 normal(0.0);
        normal[axis] = 1.0;
        clips.push_back({normal, box->min(axis)});
        clips.push_back({-normal, -box->max(axis)});
    }
    return clips;
}

HalfSpaces halfSpacesOf(const proto::Clip& clip) {
    return halfSpacesOf(clip.planes(), clip.has_box() ? &clip.box() : nullptr);
}

}  // namespace mote
