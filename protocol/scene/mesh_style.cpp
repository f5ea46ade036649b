// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/mesh_style.h"

#include "protocol/scene/check.h"

namespace mote {

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

}  // namespace mote
