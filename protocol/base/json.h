// SPDX-License-Identifier: GPL-3.0-or-later
//
// Messages as JSON text and files, by protobuf's own mapping. Unknown fields and wrong types are errors that
// name the field's path. Pure, but for the files.
#pragma once

#include <google/protobuf/message.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "protocol/base/error.h"

namespace mote {

/// Errors: invalidArgument with `source` (a file's name, say) and the path of the field.
Status parseJson(std::string_view text, google::protobuf::Message& message, std::string_view source);

/// Reads at most `limit` bytes. Errors: notFound, permissionDenied, resourceExhausted (too large), as
/// parseJson.
Status readJsonFile(const std::filesystem::path& path, google::protobuf::Message& message,
                    std::size_t limit = std::size_t{1} << 24);

/// Indented, with a final newline; numbers that are zero and empty fields left out.
std::string toJson(const google::protobuf::Message& message);

/// One line, without a newline; zero and empty fields kept where `complete`.
std::string toJsonLine(const google::protobuf::Message& message, bool complete = false);

}  // namespace mote
