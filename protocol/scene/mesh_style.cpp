// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/mesh_style.h"

#include "protocol/scene/check.h"
#include "protocol/scene/style_kinds.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

constexpr LengthField wireField{"mesh.wire", 0.25, 64.0};

}  // namespace

Result<MeshStyle> parseMeshStyle(const proto::MeshStyle& message) {
    MeshStyle style;
    MOTE_ASSIGN_OR_RETURN(style.color, checkColor(message.color(), style.color, "color"));
    const double opacity = message.has_opacity() ? message.opacity() : style.opacity;
    MOTE_ASSIGN_OR_RETURN(style.opacity, checkRange(opacity, 0.0, 1.0, "opacity"));
    const auto light = parseLight(message.light());
    if (!light.ok()) return light.error().within("light");
    style.light = *light;
    style.wire = message.wire();
    return style;
}

void writeStyle(const MeshStyle& style, const glm::dvec3&, proto::Layer& layer) {
    auto& message = *layer.mutable_mesh();
    writeColor(style.color, message.mutable_color());
    message.set_opacity(style.opacity);
    *message.mutable_light() = toProto(style.light);
    message.set_wire(style.wire);
}

void visitFields(MeshStyle& style, const MeshStyle& other, FieldVisitor& visitor) {
    visitor.vector(style.color, other.color);
    visitor.number(style.opacity, other.opacity);
    visitor.light(style.light, other.light);
    visitor.word(style.wire == other.wire);
    visitor.pixels(style.wireWidth, other.wireWidth, wireField);
}

}  // namespace mote
