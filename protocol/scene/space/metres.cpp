// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/space/metres.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <utility>

#include "protocol/quantity/plot_axes.h"
#include "protocol/scene/space/length_unit.h"

namespace mote {
namespace {

/// The axis of the world along which an axis of a plot lies; below 0: it is no place.
int worldAxis(const proto::Axis& axis) {
    const auto& name = axis.name();
    return name.size() == 1 && name[0] >= 'x' && name[0] <= 'z' ? name[0] - 'x' : -1;
}

/// Why a plot has no place.
Error noPlace(const proto::ParticlesManifest& plot) {
    std::string names;
    for (const auto& axis : plot.axes()) names += (names.empty() ? "" : ", ") + axis.name();
    return invalid("",
                   fmt::format("is a plot along {}: only one along x, y and z has a place in metres", names));
}

Result<glm::dmat4> findPlace(const proto::ParticlesManifest& plot, std::uint32_t step) {
    if (plot.axes_size() < axesOfPlot) return noPlace(plot);
    glm::dmat4 place(0.0);
    place[3][3] = 1.0;
    int seen = 0;
    for (int i = 0; i < axesOfPlot; ++i) {
        const auto& axis = axisOf(plot, i, step);
        const int along = worldAxis(axis);
        const double metre = axis.unit().empty() ? 1.0 : metresOf(axis.unit()).value_or(0.0);
        if (along < 0 || !(metre > 0.0)) return noPlace(plot);
        place[i][along] = 0.5 * (axis.max() - axis.min()) * metre;
        place[3][along] = 0.5 * (axis.max() + axis.min()) * metre;
        if (!(place[i][along] > 0.0) || !std::isfinite(place[i][along] + std::abs(place[3][along])))
            return invalid("", fmt::format("has no bounds along {}", axis.name()));
        seen |= 1 << along;
    }
    return seen == 7 ? Result<glm::dmat4>(place) : noPlace(plot);
}

Result<glm::dmat4> findPlace(const proto::Manifest& manifest, std::uint32_t step) {
    if (manifest.has_particles()) return findPlace(manifest.particles(), step);
    if (!manifest.has_hybrid() && !manifest.has_mesh()) return glm::dmat4(1.0);
    const auto& unit = worldUnit(manifest);
    if (const auto metre = metresOf(unit)) return glm::scale(glm::dmat4(1.0), glm::dvec3(*metre));
    const auto said = unit.empty() ? std::string("does not say in which unit its lengths are")
                                   : fmt::format("has lengths in \"{}\", which is no known unit", unit);
    return invalid("", said + ": prepare it with --unit");
}

template <class Place>
Result<glm::dmat4> named(Place place, const std::string& name) {
    if (place.ok()) return place;
    return Error{place.error().code, "", fmt::format("\"{}\" {}", name, place.error().message)};
}

/// Each number on its way: of two places along the same axes a place along them.
glm::dmat4 between(const glm::dmat4& from, const glm::dmat4& to, double share) {
    return from * (1.0 - share) + to * share;
}

}  // namespace

Result<glm::dmat4> placeInMetres(const proto::Manifest& manifest, std::uint32_t step,
                                 const std::string& name) {
    return named(findPlace(manifest, step), name);
}

Result<glm::dmat4> plotInMetres(const proto::ParticlesManifest& plot, std::uint32_t step,
                                const std::string& name) {
    return named(findPlace(plot, step), name);
}

Result<glm::dmat4> DatasetPlace::of(std::uint32_t step, const std::string& name) const {
    if (!lacks.empty()) return invalid("", fmt::format("\"{}\" {}", name, lacks));
    return steps[step < steps.size() ? step : 0];
}

DatasetPlace datasetPlace(const proto::Manifest& manifest) {
    DatasetPlace place;
    place.steps.clear();
    const auto& plot = manifest.particles();
    const bool own = stepsBehindAxes(plot) || std::ranges::any_of(plot.steps(), [](const auto& step) {
                         return step.axes_size() == axesOfPlot;
                     });
    const auto count = own ? static_cast<std::uint32_t>(plot.steps_size()) : 1U;
    for (std::uint32_t step = 0; step < count; ++step) {
        const auto found = findPlace(manifest, step);
        if (!found.ok()) return {{glm::dmat4(1.0)}, found.error().message};
        place.steps.push_back(*found);
    }
    return place;
}

Result<glm::dmat4> layerToWorld(const Layer& layer, const Metres& metres, const PlaceOf& placeOf) {
    MOTE_ASSIGN_OR_RETURN(auto place, placeOf(layer.dataset, layer.step));
    if (layer.towards && layer.towards->step != layer.step) {
        MOTE_ASSIGN_OR_RETURN(const auto next, placeOf(layer.dataset, layer.towards->step));
        place = between(place, next, layer.towards->share);
    }
    return glm::scale(glm::dmat4(1.0), metres.stretch) * layer.transform * place;
}

Status placeLayers(View& view, const PlaceOf& placeOf) {
    if (!view.metres || view.metres->placed) return success();
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        auto& layer = view.layers[i];
        if (layer.onScreen()) continue;
        const auto whole = layerToWorld(layer, *view.metres, placeOf);
        if (!whole.ok())
            return Error{whole.error().code, fmt::format("layers[{}].dataset", i), whole.error().message};
        layer.transform = *whole;
    }
    view.metres->placed = true;
    return success();
}

}  // namespace mote
