// SPDX-License-Identifier: GPL-3.0-or-later
//
// Clips: what is cut away of a layer, of whatever kind (docs/PICTURE.md, "Clipping"): its message, whose
// normals are made unit vectors, and the half-spaces in all of which lies what stays. Values and pure
// functions.
#pragma once

#include <google/protobuf/message.h>

#include <concepts>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"

/// Messages as values: equal where they say the same.
namespace mote::proto {

template <std::derived_from<google::protobuf::Message> Message>
bool operator==(const Message& a, const Message& b) {
    return a.SerializeAsString() == b.SerializeAsString();
}

}  // namespace mote::proto

namespace mote {

/// What lies where dot(normal, place) >= distance.
struct HalfSpace {
    glm::dvec3 normal;  ///< unit, of layer space; in another space of any length
    double distance;    ///< layer units

    /// How far within it a place lies; below 0: it is cut away.
    double within(const glm::dvec3& place) const;
    bool operator==(const HalfSpace&) const = default;
};
using HalfSpaces = std::vector<HalfSpace>;

/// What stays, in all of them.
bool inAll(std::span<const HalfSpace> clips, const glm::dvec3& place);
/// Whether nothing of a box stays, as one of them says.
bool allCut(std::span<const HalfSpace> clips, const Bounds& box);

/// The same half-spaces in a space from which `toSpace` leads into theirs.
HalfSpaces inSpace(std::span<const HalfSpace> clips, const glm::dmat4& toSpace);

/// Shortens the part of origin + at * direction from `enter` to `leave` to what stays; `enter` is greater
/// where nothing does.
void clipWay(std::span<const HalfSpace> clips, const glm::dvec3& origin, const glm::dvec3& direction,
             double& enter, double& leave);

constexpr int mostClipPlanes = 6;

using ClipPlanes = google::protobuf::RepeatedPtrField<proto::ClipPlane>;

/// Makes unit normals. Errors: too many, a normal of length 0.
Status checkPlanes(ClipPlanes& planes, std::string_view field);
/// Errors: one without extent.
Status checkBox(const proto::ClipBox& box, std::string_view field);

/// Its fields checked, and filled in. Errors: as above, a number out of range.
Result<proto::Clip> parseClip(proto::Clip message);

/// What a layer says of its clip, in `clip` and beside it (clipPlanes, clipBox); unchecked.
proto::Clip saidClip(const proto::Layer& layer);
/// The same, as parseClip. Errors name the layer's field: as above, two boxes, too many planes in all.
Result<proto::Clip> parseClipOf(const proto::Layer& layer);

/// Of checked ones.
HalfSpaces halfSpacesOf(const ClipPlanes& planes, const proto::ClipBox* box);
HalfSpaces halfSpacesOf(const proto::Clip& clip);

}  // namespace mote
