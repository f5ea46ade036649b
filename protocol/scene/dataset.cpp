// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/dataset.h"

#include "protocol/scene/curve_presets.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <string>

namespace mote {
namespace {

int noSteps(const proto::Manifest&) {
    return 0;
}

int particleSteps(const proto::Manifest& manifest) {
    return manifest.particles().steps_size();
}

int hybridSteps(const proto::Manifest& manifest) {
    return manifest.hybrid().steps_size();
}

Bounds plotBox(const proto::Manifest&) {
    return plotBounds;
}

Bounds hybridBox(const proto::Manifest& manifest) {
    return volumeBounds(manifest.hybrid());
}

/// A mesh has one, and a stipple hierarchy on one; a plane has none.
Bounds meshBox(const proto::Manifest& manifest) {
    const auto& mesh = manifest.mesh();
    if (mesh.bounds_min_size() != 3 || mesh.bounds_max_size() != 3) return plotBounds;
    return {{mesh.bounds_min(0), mesh.bounds_min(1), mesh.bounds_min(2)},
            {mesh.bounds_max(0), mesh.bounds_max(1), mesh.bounds_max(2)}};
}

struct Kind {
    std::string_view name;
    std::span<const proto::Layer::KindCase> layers;
    int (*steps)(const proto::Manifest&);
    Bounds (*bounds)(const proto::Manifest&);
};

constexpr std::array particleLayers{proto::Layer::kParticles, proto::Layer::kInk};
constexpr std::array hybridLayers{proto::Layer::kHybrid, proto::Layer::kInk};
constexpr std::array stippleLayers{proto::Layer::kStipple, proto::Layer::kInk, proto::Layer::kMesh};
constexpr std::array meshLayers{proto::Layer::kMesh, proto::Layer::kInk};
constexpr std::array imageLayers{proto::Layer::kImage};
constexpr std::span<const proto::Layer::KindCase> noLayers;

constexpr std::array datasetKinds{
    Kind{"particles", particleLayers, particleSteps, plotBox},
    Kind{"hybrid", hybridLayers, hybridSteps, hybridBox},
    Kind{"stipple", stippleLayers, noSteps, meshBox},
    Kind{"mesh", meshLayers, noSteps, meshBox},
    Kind{"image", imageLayers, noSteps, plotBox},
};

/// One that is not in the table is drawn by no layer.
Kind findKind(std::string_view name) {
    const auto* const found = std::ranges::find(datasetKinds, name, &Kind::name);
    return found != datasetKinds.end() ? *found : Kind{name, noLayers, noSteps, plotBox};
}

}  // namespace

std::span<const proto::Layer::KindCase> layersThatDraw(std::string_view datasetKind) {
    return findKind(datasetKind).layers;
}

int stepCount(const proto::Manifest& manifest) {
    return findKind(manifest.kind()).steps(manifest);
}

std::optional<proto::View> firstView(const std::string& name, std::string_view datasetKind, int steps,
                                     std::uint32_t width, std::uint32_t height) {
    const auto kinds = layersThatDraw(datasetKind);
    if (kinds.empty()) return std::nullopt;
    proto::View view;
    view.set_width(width);
    view.set_height(height);
    auto& layer = *view.add_layers();
    layer.set_dataset(name);
    layer.set_step(static_cast<std::uint32_t>(steps) / 2);
    layer.GetReflection()->MutableMessage(&layer,
                                          proto::Layer::descriptor()->FindFieldByNumber(kinds.front()));
    return view;
}

Bounds datasetBounds(const proto::Manifest& manifest) {
    return findKind(manifest.kind()).bounds(manifest);
}

std::optional<glm::dvec3> findDirection(std::string_view name) {
    const bool back = name.starts_with('-');
    if (back) name.remove_prefix(1);
    if (name.size() != 1 || name[0] < 'x' || name[0] > 'z') return std::nullopt;
    glm::dvec3 direction(0.0);
    direction[name[0] - 'x'] = back ? -1.0 : 1.0;
    return direction;
}

bool takenForPatient(const proto::Manifest& manifest) {
    const auto& hybrid = manifest.hybrid();
    std::span<const std::uint64_t> histogram;
    if (!hybrid.steps().empty()) {
        const auto& bins = hybrid.steps(0).histogram();
        histogram = {bins.data(), static_cast<std::size_t>(bins.size())};
    }
    return manifest.kind() == "hybrid" && hybrid.space().empty() && manifest.up().empty() &&
           inHounsfieldUnits(hybrid.value_unit(), {hybrid.value_min(), hybrid.value_max()}, histogram);
}

/// Patients stand, and are seen from before.
std::optional<Outlook> datasetOutlook(const proto::Manifest& manifest) {
    const std::string space = takenForPatient(manifest) ? "lps" : manifest.hybrid().space();
    const bool patient = manifest.up().empty() && (space == "ras" || space == "lps");
    const auto up = findDirection(patient ? "z" : manifest.up());
    if (!up) return std::nullopt;
    const auto front = findDirection(!patient ? manifest.front() : space == "ras" ? "y" : "-y");
    if (front && glm::dot(*front, *up) == 0.0) return Outlook{*front, *up};
    // The front of what has its upper side along z is where CAD programs have it.
    const glm::dvec3 usual = up->z != 0.0 ? glm::dvec3(0.0, -1.0, 0.0) : glm::dvec3(0.0, 0.0, 1.0);
    const Outlook look;
    return Outlook{look.back.x * glm::cross(*up, usual) + look.back.y * *up + look.back.z * usual, *up};
}

Bounds volumeBounds(const proto::HybridManifest& hybrid) {
    if (hybrid.index_to_world_size() != 16 || hybrid.source_size_size() != 3) return plotBounds;
    glm::dmat4 toWorld(1.0);
    for (int i = 0; i < 16; ++i) toWorld[i % 4][i / 4] = hybrid.index_to_world(i);  // glm keeps columns
    const glm::dvec3 size(hybrid.source_size(0), hybrid.source_size(1), hybrid.source_size(2));
    return Bounds{glm::dvec3(-0.5), size - 0.5}.transformed(toWorld);  // samples are cells' centres
}

}  // namespace mote
