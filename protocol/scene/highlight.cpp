// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/highlight.h"

#include <algorithm>

#include "protocol/scene/check.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

constexpr LengthField highlightSize{"highlight.sizePixels", 0.1, 64.0};

}  // namespace

Result<Highlight> parseHighlight(const proto::Highlight& message, const NamedSelectionMessages& named) {
    Highlight highlight;
    if (!message.has_selection())
        return Error{ErrorCode::invalidArgument, "selection", "what is to be highlighted is missing"};
    auto selection = parseSelection(message.selection(), named);
    MOTE_RETURN_IF_ERROR(selection, "selection");
    highlight.selection = *std::move(selection);
    MOTE_ASSIGN_OR_RETURN(highlight.color, checkColor(message.color(), highlight.color, "color"));
    if (message.has_size_pixels()) {
        MOTE_ASSIGN_OR_RETURN(highlight.pointSize, checkRange(message.size_pixels(), highlightSize.least,
                                                              highlightSize.greatest, highlightSize.name()));
    }
    const double opacity = message.has_opacity() ? message.opacity() : highlight.opacity;
    MOTE_ASSIGN_OR_RETURN(const double checked, checkRange(opacity, 0.0, 1.0, "opacity"));
    highlight.opacity = std::min(checked, ParticlesStyle::opacityLimit);
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
        visitor.pixels(*highlight.pointSize, *other.pointSize, highlightSize);
}

}  // namespace mote
