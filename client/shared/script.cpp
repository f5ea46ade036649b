// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/script.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "protocol/scene/film/check_script.h"
#include "protocol/scene/json.h"

namespace mote::client {
namespace {

constexpr std::uintmax_t maxScriptBytes = std::uintmax_t{256} << 20;
constexpr std::uintmax_t usualScriptBytes = std::uintmax_t{1} << 20;

/// What to take memory for: the reader takes as much as it may.
std::size_t limitOf(const std::filesystem::path& path) {
    std::error_code code;
    const auto size = std::filesystem::file_size(path, code);
    if (code) return std::size_t{16} << 20;  // a pipe
    return static_cast<std::size_t>(std::clamp(size, usualScriptBytes, maxScriptBytes));
}

/// The parser's error on one line: its sentence, then the place in the text (a piece of it, and a line that
/// marks the column).
Error onOneLine(Error error) {
    std::istringstream lines(error.message);
    std::string sentence, piece;
    std::getline(lines, sentence);
    std::getline(lines, piece);
    error.message = piece.empty() ? sentence : fmt::format("{} Near: {}", sentence, piece);
    return error;
}

}  // namespace

Result<proto::Script> readScript(const std::filesystem::path& path) {
    proto::Script script;
    if (const auto read = readJsonFile(path, script, limitOf(path)); !read.ok())
        return onOneLine(read.error());
    if (const auto checked = checkScript(script); !checked.ok()) {
        const auto& error = checked.error();
        return Error{error.code, fmt::format("{}: {}", path.string(), error.where), error.message};
    }
    return script;
}

}  // namespace mote::client
