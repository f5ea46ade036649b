// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/script.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

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

std::string knownDatasets(const proto::Catalogue& catalogue) {
    if (catalogue.datasets().empty()) return "the server has none";
    constexpr int shown = 8;
    std::string names;
    for (int i = 0; i < std::min(shown, catalogue.datasets_size()); ++i) {
        names += fmt::format("{}\"{}\"", i == 0 ? "" : ", ", catalogue.datasets(i).name());
    }
    const int more = catalogue.datasets_size() - shown;
    return "there are " + names + (more > 0 ? fmt::format(" and {} more", more) : std::string());
}

Status checkLayer(const proto::Layer& layer, const proto::Catalogue& catalogue) {
    const auto& entries = catalogue.datasets();
    const auto entry = std::find_if(entries.begin(), entries.end(),
                                    [&](const auto& each) { return each.name() == layer.dataset(); });
    if (entry == entries.end()) {
        return Error{
            ErrorCode::notFound, "dataset",
            fmt::format("there is no dataset \"{}\"; {}", layer.dataset(), knownDatasets(catalogue))};
    }
    const bool series = entry->steps() > 0;  // other kinds have no steps
    if (series ? layer.step() < entry->steps() : layer.step() == 0) return success();
    return Error{ErrorCode::invalidArgument, "step",
                 fmt::format("\"{}\" has {} steps, numbered from 0; there is no step {}", layer.dataset(),
                             entry->steps(), layer.step())};
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
    for (std::size_t i = 0; i < views.size(); ++i) {
        for (int j = 0; j < views[i].layers_size(); ++j) {
            MOTE_RETURN_IF_ERROR(checkLayer(views[i].layers(j), catalogue),
                                 fmt::format("views[{}].layers[{}]", i, j));
        }
    }
    return success();
}

}  // namespace mote::client
