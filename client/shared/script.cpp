// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/script.h"

#include <fmt/format.h>
#include <algorithm>
#include <sstream>
#include <string_view>

#include "protocol/base/json.h"
#include "protocol/base/text_file.h"
#include "protocol/scene/dataset.h"
#include "protocol/scene/film/check_script.h"
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

/// The name that comes before a colon at `place`, a quotation mark; empty if none does. `place` moves to
/// the mark that ends it.
std::string_view keyAt(std::string_view text, std::size_t& place) {
    const std::size_t begin = place + 1;
    const char mark = text[place];
    for (++place; place < text.size() && text[place] != mark; ++place) place += text[place] == '\\' ? 1 : 0;
    if (place >= text.size()) return {};
    const auto next = text.find_first_not_of(" \t\r\n", place + 1);
    return next != text.npos && text[next] == ':' ? text.substr(begin, place - begin) : std::string_view();
}

bool hasField(const google::protobuf::Descriptor& message, std::string_view name) {
    for (int i = 0; i < message.field_count(); ++i) {
        if (message.field(i)->json_name() == name || message.field(i)->name() == name) return true;
    }
    return false;
}

/// Which of the two a text is, its first field says that only one of them has.
bool isView(std::string_view text) {
    int depth = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        depth += c == '{' || c == '[' ? 1 : c == '}' || c == ']' ? -1 : 0;
        if (c != '"' && c != '\'') continue;
        const auto key = keyAt(text, i);
        if (depth != 1 || key.empty()) continue;
        if (hasField(*proto::Script::descriptor(), key)) return false;
        if (hasField(*proto::View::descriptor(), key)) return true;
    }
    return false;
}

Status inFile(const std::filesystem::path& path, const Status& status) {
    if (status.ok()) return status;
    const auto& error = status.error();
    return Error{error.code, fmt::format("{}: {}", path.string(), error.where), error.message};
}

Status parse(const std::string& text, google::protobuf::Message& message, const std::filesystem::path& path) {
    const auto read = parseJson(text, message, path.string());
    return read.ok() ? read : onOneLine(read.error());
}

Result<proto::Script> scriptOf(const std::string& text, const std::filesystem::path& path) {
    proto::Script script;
    MOTE_RETURN_IF_ERROR(parse(text, script, path));
    MOTE_RETURN_IF_ERROR(inFile(path, checkScript(script)));
    return script;
}

/// What a picture in a window is not of a script.
std::string noteOf(const proto::Script& script, const std::filesystem::path& path) {
    if (script.keyframes_size() > 0) {
        return fmt::format(
            "{} is a film of {} keyframes, of which the first is shown here: mote-view --film opens it to be "
            "edited, mote-frames draws it",
            path.string(), script.keyframes_size());
    }
    if (script.moves_size() > 0) {
        return fmt::format(
            "{} is a film of {} {}, of which the view at its beginning is shown here: mote-frames draws it",
            path.string(), script.moves_size(), script.moves_size() == 1 ? "move" : "moves");
    }
    if (script.views_size() < 2) return "";
    return fmt::format("{} has {} views, of which the first is shown here: mote-frames draws all",
                       path.string(), script.views_size());
}

}  // namespace

Result<proto::Script> readScript(const std::filesystem::path& path, std::uint32_t width,
                                 std::uint32_t height) {
    MOTE_ASSIGN_OR_RETURN(const auto text, readTextFile(path, limitOf(path)));
    if (!isView(text)) return scriptOf(text, path);
    proto::Script script;
    auto& view = *script.add_views();
    MOTE_RETURN_IF_ERROR(parse(text, view, path));
    if (view.width() == 0) view.set_width(width);
    if (view.height() == 0) view.set_height(height);
    const auto parsed = parseView(view);
    if (!parsed.ok()) return inFile(path, parsed.error()).error();
    return script;
}

Result<SavedView> readSavedView(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto text, readTextFile(path, limitOf(path)));
    SavedView saved;
    if (isView(text)) {
        MOTE_RETURN_IF_ERROR(parse(text, saved.view, path));
        return saved;
    }
    MOTE_ASSIGN_OR_RETURN(const auto script, scriptOf(text, path));
    saved.view = script.keyframes_size() > 0 ? script.keyframes(0).view()
                 : script.moves_size() > 0   ? script.view()
                                             : script.views(0);
    saved.note = noteOf(script, path);
    return saved;
}

FilmDatasets knownDatasets(const proto::Catalogue& catalogue) {
    FilmDatasets datasets;
    for (const auto& entry : catalogue.datasets())
        datasets[entry.name()] = {plotBounds, static_cast<int>(entry.steps())};
    return datasets;
}

FilmDataset knownDataset(const proto::Manifest& manifest) {
    return {datasetBounds(manifest), stepCount(manifest), datasetOutlook(manifest), datasetPlace(manifest)};
}

}  // namespace mote::client
