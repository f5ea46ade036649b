// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/paths.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/write_fields.h"

namespace mote {

Result<Paths> parsePaths(const proto::Paths& message) {
    Paths paths;
    if (message.ids_size() > Paths::maxIds) {
        return Error{ErrorCode::invalidArgument, "ids",
                     fmt::format("there may be at most {}, not {}", Paths::maxIds, message.ids_size())};
    }
    paths.ids.assign(message.ids().begin(), message.ids().end());
    std::sort(paths.ids.begin(), paths.ids.end());
    paths.ids.erase(std::unique(paths.ids.begin(), paths.ids.end()), paths.ids.end());
    MOTE_RETURN_IF_ERROR(checkOwnFields(message));
    paths.color = colorOf(message, message.kColorFieldNumber);
    paths.width = lengthOf(message, message.kWidthFieldNumber);
    return paths;
}

proto::Paths toProto(const Paths& paths) {
    proto::Paths message;
    message.mutable_ids()->Add(paths.ids.begin(), paths.ids.end());
    if (paths.color) writeColor(*paths.color, message.mutable_color());
    if (paths.width.said()) message.set_width(paths.width);
    return message;
}

void visitFields(Paths& paths, const Paths& other, FieldVisitor& visitor) {
    visitor.word(paths.ids == other.ids && paths.color.has_value() == other.color.has_value());
    if (paths.color && other.color) visitor.vector(*paths.color, *other.color);
    visitor.pixels(paths.width, other.width, lengthField("paths.width"));
}

}  // namespace mote
