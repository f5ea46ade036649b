// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/between_steps.h"

#include <map>
#include <optional>
#include <utility>

namespace mote::reference {

Picture renderBetween(const View& view, const SceneOf& sceneOf, const MovedPlace& moved) {
    constexpr int places = 1000;
    // By the steps of the layers.
    std::map<std::vector<std::uint32_t>, int> counts;
    for (int i = 0; i < places; ++i) {
        std::vector<std::uint32_t> steps;
        for (const auto& layer : view.layers) {
            const bool next = layer.towards && (i + 0.5) / places < layer.towards->share;
            steps.push_back(next ? layer.towards->step : layer.step);
        }
        ++counts[steps];
    }
    std::optional<Picture> mean;
    for (const auto& [steps, count] : counts) {
        View shown = view;
        std::vector<Layer> ways = view.layers;
        for (std::size_t i = 0; i < steps.size(); ++i) {
            shown.layers[i].step = steps[i];
            shown.layers[i].towards.reset();
            if (steps[i] == view.layers[i].step) continue;
            ways[i].step = steps[i];
            ways[i].towards = {view.layers[i].step, 1.0 - view.layers[i].towards->share};
        }
        Options options;
        if (moved) {
            options.placeOf = [&](std::uint32_t layer, std::uint64_t point, const glm::dvec3& place) {
                return ways[layer].towards ? moved(ways[layer], point, place) : place;
            };
        }
        auto picture = render(sceneOf(shown), options);
        for (auto& pixel : picture.linear) pixel *= static_cast<double>(count) / places;
        if (!mean) {
            mean = std::move(picture);
            continue;
        }
        for (std::size_t i = 0; i < picture.linear.size(); ++i) {
            mean->linear[i] += picture.linear[i];
            mean->ambiguous[i] |= picture.ambiguous[i];
        }
    }
    return *std::move(mean);
}

}  // namespace mote::reference
