// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/paths.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/scene/check.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

constexpr LengthField widthField{"paths.width", 0.1, 64.0};

}  // namespace

Result<Paths> parsePaths(const proto::Paths& message) {
    Paths paths;
    if (message.ids_size() > Paths::maxIds) {
        return Error{ErrorCode::invalidArgument, "ids",
                     fmt::format("there may be at most {}, not {}", Paths::maxIds, message.ids_size())};
    }
    paths.ids.assign(message.ids().begin(), message.ids().end());
    std::sort(paths.ids.begin(), paths.ids.end());
    paths.ids.erase(std::unique(paths.ids.begin(), paths.ids.end()), paths.ids.end());
    if (!message.color().empty()) {
        MOTE_ASSIGN_OR_RETURN(paths.color, checkColor(message.color(), glm::dvec3(0.0), "color"));
    }
    MOTE_ASSIGN_OR_RETURN(paths.width,
                          checkLength(message.has_width(), message.width(), paths.width, widthField));
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
    visitor.pixels(paths.width, other.width, widthField);
}

}  // namespace mote
