// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/stipple_style.h"

#include <utility>

#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/write_fields.h"

namespace mote {

Result<StippleStyle> parseStippleStyle(StippleStyle said, const glm::dvec3& background) {
    if (said.has_dot_pixels() && !said.has_least_dot_pixels()) said.set_least_dot_pixels(said.dot_pixels());
    MOTE_ASSIGN_OR_RETURN(auto style, resolved(std::move(said)));
    if (!style.source().empty() && !style.image().empty())
        return invalid("source", "is instead of an image, not beside it");
    if (style.color().empty())
        writeVector(glm::dvec3(isLight(background) ? 0.0 : 1.0), style.mutable_color());
    const bool darker = luminance(readColor(style.color())) < luminance(background);
    const bool dark = style.dense().empty() ? darker != style.invert() : denseInDark(style);
    style.set_dense(dark ? "dark" : "light");
    style.set_invert(dark != darker);  // for servers that know no other word for it
    return style;
}

}  // namespace mote
