// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/json.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <cerrno>
#include <cstring>
#include <fstream>

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
    return text;
}

}  // namespace

Status parseJson(std::string_view text, google::protobuf::Message& message, std::string_view source) {
    const auto status =
        json::JsonStringToMessage({text.data(), text.size()}, &message, json::JsonParseOptions{});
    if (status.ok()) return success();
    return Error{ErrorCode::invalidArgument, std::string(source),
                 std::string(status.message().data(), status.message().size())};
}

Status readJsonFile(const std::filesystem::path& path, google::protobuf::Message& message,
                    std::size_t limit) {
    std::error_code code;
    if (std::filesystem::is_directory(path, code)) {
        return Error{ErrorCode::invalidArgument, path.string(), "is a directory, not a JSON file"};
    }
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        const auto kind = errno == EACCES ? ErrorCode::permissionDenied : ErrorCode::notFound;
        return Error{kind, path.string(), fmt::format("cannot be opened: {}", std::strerror(errno))};
    }
    std::string text(limit + 1, '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
    if (text.size() > limit) {
        return Error{ErrorCode::resourceExhausted, path.string(),
                     fmt::format("is larger than the {} bytes that a file of its kind may have", limit)};
    }
    return parseJson(text, message, path.string());
}

std::string toJson(const google::protobuf::Message& message) {
    return print(message, true, false);
}

std::string toJsonLine(const google::protobuf::Message& message, bool complete) {
    return print(message, false, complete);
}

}  // namespace mote
