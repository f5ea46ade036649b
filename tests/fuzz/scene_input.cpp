// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "protocol/base/json.h"
#include "protocol/scene/dataset.h"
#include "protocol/scene/film/check_script.h"
#include "protocol/scene/film/film.h"
#include "protocol/scene/job_request.h"
#include "protocol/scene/selection.h"
#include "protocol/scene/view.h"
#include "protocol/scene/view_message.h"
#include "storage/dataset_kind.h"
#include "storage/manifest.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/require.h"

namespace mote::test {
namespace {

std::string takeView(const proto::View& message) {
    const auto view = parseView(message);
    if (!view) return view.error().toString();
    require(parseView(toProto(*view)).ok());
    return "";
}

std::string takeSelection(const proto::Selection& message) {
    const auto selection = parseSelection(message);
    if (!selection) return selection.error().toString();
    const auto again = parseSelection(toProto(*selection));
    require(again.ok() && valueCount(*again) == valueCount(*selection));
    return "";
}

std::string takeScript(const proto::Script& script) {
    if (const auto status = checkScript(script); !status) return status.error().toString();
    FilmDatasets datasets;
    for (const auto& name : datasetsOf(script)) datasets[name].steps = 4;
    const auto film = Film::create(script, datasets);
    if (!film) return film.error().toString();
    require(film->frameCount() >= 1 && film->frameCount() <= maxFrames);
    for (const std::size_t frame : {std::size_t{0}, film->frameCount() / 2, film->frameCount() - 1}) {
        require(parseView(film->frame(frame)).ok());
    }
    return "";
}

std::string takeJob(const proto::JobRequest& message) {
    const auto request = parseJobRequest(message);
    return request ? "" : request.error().toString();
}

std::string takeManifest(const proto::Manifest& manifest) {
    // Before it is checked, too.
    require(stepCount(manifest) >= 0);
    datasetBounds(manifest);
    if (const auto status = storage::checkManifest(manifest); !status) return status.error().toString();
    const auto& kind = *storage::findKind(manifest);
    require(!kind.describe(manifest).empty() && !kind.summarize(manifest).text.empty());
    return "";
}

template <class Message>
std::string takeJson(std::string_view text, std::string (*take)(const Message&)) {
    Message message;
    // As a file of it, and as one that may be no larger than it is.
    const MemoryFile file(text);
    if (!text.empty()) require(!readJsonFile(file.path(), message, text.size() - 1).ok());
    if (const auto status = readJsonFile(file.path(), message, text.size()); !status)
        return status.error().toString();
    Message again;
    require(parseJson(toJsonLine(message, true), again, "again").ok());
    require(toJsonLine(again) == toJsonLine(message));
    return take(message);
}

}  // namespace

std::string sceneInput(std::string_view input) {
    const auto [kind, text] = firstLine(input);
    if (kind == "view") return takeJson(text, takeView);
    if (kind == "script") return takeJson(text, takeScript);
    if (kind == "selection") return takeJson(text, takeSelection);
    if (kind == "job") return takeJson(text, takeJob);
    return takeJson(text, takeManifest);
}

}  // namespace mote::test
