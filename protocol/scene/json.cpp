// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/json.h"
#include "protocol/scene/empty_lists.h"
#include "protocol/scene/mote_check.h"
#include "protocol/scene/text_file.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

namespace mote {
namespace {

namespace json = google::protobuf::util;

std::string print(const google::protobuf::Message& message, bool indented, bool complete) {
    json::JsonPrintOptions options;
    options.add_whitespace = indented;
    options.always_print_primitive_fields = complete;
    std::string text;
    const auto status = json::MessageToJsonString(message, &text, options);
    MOTE_CHECK(status.ok());
    return complete && !indented ? withoutEmptyLists(std::move(text), message) : text;
}

/// A field's path as it is written in JSON: fov_y_degrees is fovYDegrees there.
std::string jsonPath(std::string_view path) {
    std::string result;
    bool raise = false;
    for (const char c : path) {
        if (c != '_') result += raise && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
        raise = c == '_';
    }
    return result;
}

/// Protobuf says "(views[0]) widht: Cannot find field." and "(views[0].width): invalid value ..."; people
/// look for "views[0].widht" and "views[0].width".
std::string withPath(std::string_view text) {
    const auto end = text.find(')');
    if (text.empty() || text.front() != '(' || end == std::string_view::npos) return std::string(text);
    const std::string path = jsonPath(text.substr(1, end - 1));
    const auto rest = text.substr(end + 1);
    return rest.starts_with(' ') ? fmt::format("{}.{}", path, rest.substr(1))
                                 : fmt::format("{}{}", path, rest);
}

}  // namespace

Status parseJson(std::string_view text, google::protobuf::Message& message, std::string_view source) {
    const auto status =
        json::JsonStringToMessage({text.data(), text.size()}, &message, json::JsonParseOptions{});
    if (!status.ok())
        return Error{ErrorCode::invalidArgument, std::string(source),
                     withPath({status.message().data(), status.message().size()})};
    MOTE_RETURN_IF_ERROR(tellEmptyLists(text, message), source);
    return success();
}

Status readJsonFile(const std::filesystem::path& path, google::protobuf::Message& message,
                    std::size_t limit) {
    MOTE_ASSIGN_OR_RETURN(const auto text, readTextFile(path, limit));
    return parseJson(text, message, path.string());
}

std::string toJson(const google::protobuf::Message& message) {
    return print(message, true, false);
}

std::string toJsonLine(const google::protobuf::Message& message, bool complete) {
    return print(message, false, complete);
}

}  // namespace mote
