// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/highlight.h"

#include <algorithm>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/particles_style.h"
#include "protocol/scene/write_fields.h"

namespace mote {

Result<Highlight> parseHighlight(const proto::Highlight& message, const NamedSelectionMessages& named) {
    Highlight highlight;
    if (!message.has_selection())
        return Error{ErrorCode::invalidArgument, "selection", "what is to be highlighted is missing"};
    auto selection = parseSelection(message.selection(), named);
    MOTE_RETURN_IF_ERROR(selection, "selection");
    highlight.selection = *std::move(selection);
    MOTE_RETURN_IF_ERROR(checkOwnFields(message));
    highlight.color = colorOf(message, message.kColorFieldNumber).value();
    if (message.has_size_pixels()) highlight.pointSize = message.size_pixels();
    highlight.opacity =
        std::min(numberOf(message, message.kOpacityFieldNumber), ParticlesStyle::opacityLimit);
    return highlight;
}

proto::Highlight toProto(const Highlight& highlight) {
    proto::Highlight message;
    *message.mutable_selection() = toProto(highlight.selection);
    writeColor(highlight.color, message.mutable_color());
    if (highlight.pointSize) message.set_size_pixels(*highlight.pointSize);
    message.set_opacity(highlight.opacity);
    return message;
}

void visitFields(Highlight& highlight, const Highlight& other, FieldVisitor& visitor) {
    visitor.word(highlight.selection == other.selection);
    visitor.vector(highlight.color, other.color);
    visitor.number(highlight.opacity, other.opacity);
    visitor.word(highlight.pointSize.has_value() == other.pointSize.has_value());
    if (highlight.pointSize && other.pointSize)
        visitor.pixels(*highlight.pointSize, *other.pointSize, lengthField("highlight.sizePixels"));
}

}  // namespace mote
