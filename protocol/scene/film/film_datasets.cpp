// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/film_datasets.h"

#include <fmt/format.h>

#include <optional>
#include <vector>

#include "protocol/scene/view_message.h"

namespace mote {
namespace {

std::string namesOf(const FilmDatasets& datasets) {
    if (datasets.empty()) return "the server has none";
    constexpr std::size_t shown = 8;
    std::string names;
    std::size_t count = 0;
    for (const auto& [name, dataset] : datasets) {
        if (count == shown) break;
        names += fmt::format("{}\"{}\"", count++ == 0 ? "" : ", ", name);
    }
    const auto more = datasets.size() - count;
    return "there are " + names + (more > 0 ? fmt::format(" and {} more", more) : std::string());
}

Status checkKnown(const std::string& name, const FilmDatasets& datasets, std::string_view field) {
    if (datasets.contains(name)) return success();
    return Error{ErrorCode::notFound, std::string(field),
                 fmt::format("there is no dataset \"{}\"; {}", name, namesOf(datasets))};
}

Status checkLayer(const proto::Layer& layer, const FilmDatasets& datasets) {
    MOTE_RETURN_IF_ERROR(checkKnown(layer.dataset(), datasets, "dataset"));
    const auto& image = layer.stipple().image();
    if (!image.empty()) MOTE_RETURN_IF_ERROR(checkKnown(image, datasets, "stipple.image"));
    const auto& known = datasets.at(layer.dataset());
    MOTE_RETURN_IF_ERROR(checkStep(layer.dataset(), known, layer.step(), "step"));
    if (!layer.has_towards()) return success();
    return checkStep(layer.dataset(), known, layer.towards().step(), "towards.step");
}

}  // namespace

Status checkStep(const std::string& dataset, const FilmDataset& known, std::uint32_t step,
                 std::string_view field) {
    const bool series = known.steps > 0;  // other kinds have no steps
    if (series ? step < static_cast<std::uint32_t>(known.steps) : step == 0) return success();
    return Error{
        ErrorCode::invalidArgument, std::string(field),
        fmt::format("\"{}\" has {} steps, numbered from 0; there is no step {}", dataset, known.steps, step)};
}

Status checkDatasets(const proto::View& view, const FilmDatasets& datasets) {
    for (int i = 0; i < view.layers_size(); ++i) {
        MOTE_RETURN_IF_ERROR(checkLayer(view.layers(i), datasets), fmt::format("layers[{}]", i));
    }
    return success();
}

Status placeAmong(View& view, const FilmDatasets& datasets) {
    return placeLayers(view, [&](const std::string& name, std::uint32_t step) -> Result<glm::dmat4> {
        const auto found = datasets.find(name);
        return found != datasets.end() ? found->second.place.of(step, name) : glm::dmat4(1.0);
    });
}

Status fitToDatasets(View& view, const FilmDatasets& datasets) {
    if (!view.cameraFitted) return success();
    View placed = view;
    MOTE_RETURN_IF_ERROR(placeAmong(placed, datasets));
    std::vector<std::optional<LayerBox>> boxes;
    for (const auto& layer : view.layers) {
        const auto found = datasets.find(layer.dataset);
        boxes.emplace_back();
        if (found != datasets.end()) boxes.back() = LayerBox{found->second.bounds, found->second.outlook};
    }
    fitLayers(placed, boxes);
    view.camera = placed.camera;
    return success();
}

}  // namespace mote
