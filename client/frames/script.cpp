// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/script.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "protocol/scene/film/film_datasets.h"
#include "protocol/scene/json.h"
#include "protocol/scene/view.h"

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

Error inScript(const std::filesystem::path& path, const Error& error) {
    return {error.code, fmt::format("{}: {}", path.string(), error.where), error.message};
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

Result<std::vector<proto::View>> readScript(const std::filesystem::path& path) {
    proto::Script script;
    if (const auto read = readJsonFile(path, script, limitOf(path)); !read.ok())
        return onOneLine(read.error());
    if (script.keyframes_size() + script.moves_size() > 0) {
        return Error{ErrorCode::unsupported, path.string() + ": keyframes",
                     "keyframes are not in this version; write one view a frame"};
    }
    if (script.views_size() == 0) {
        return Error{ErrorCode::invalidArgument, path.string() + ": views",
                     "a script needs at least one view"};
    }
    if (script.views_size() > maxViews) {
        return Error{ErrorCode::resourceExhausted, path.string() + ": views",
                     fmt::format("a script has at most {} views, not {}", maxViews, script.views_size())};
    }
    for (int i = 0; i < script.views_size(); ++i) {
        const auto view = parseView(script.views(i));
        if (!view.ok()) return inScript(path, view.error().within(fmt::format("views[{}]", i)));
    }
    return std::vector<proto::View>(script.views().begin(), script.views().end());
}

Status checkDatasets(const std::vector<proto::View>& views, const proto::Catalogue& catalogue) {
    FilmDatasets datasets;
    for (const auto& entry : catalogue.datasets())
        datasets[entry.name()].steps = static_cast<int>(entry.steps());
    for (std::size_t i = 0; i < views.size(); ++i)
        MOTE_RETURN_IF_ERROR(mote::checkDatasets(views[i], datasets), fmt::format("views[{}]", i));
    return success();
}

}  // namespace mote::client
