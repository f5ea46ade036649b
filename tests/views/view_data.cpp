// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/view_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <vector>

#include "protocol/scene/plot_density.h"
#include "protocol/scene/view_message.h"
#include "protocol/scene/view_parts.h"
#include "server/render/layers/ink/density_grid.h"
#include "server/render/layers/mesh/cut_mesh.h"
#include "tests/reference/generated_image.h"
#include "tests/support/generated_mesh.h"
#include "tests/views/dot_data.h"
#include "tests/views/hybrid_data.h"
#include "tests/views/number_data.h"
#include "tests/views/particle_data.h"

namespace mote::test {
namespace {

constexpr std::string_view root = "views/";

std::span<const std::string_view> formsOf(DataKind kind) {
    if (kind == DataKind::particles) return particleForms();
    if (kind == DataKind::mesh) return meshForms();
    if (kind == DataKind::image) return imageForms();
    return kind == DataKind::hybrid ? hybridForms() : dotForms();
}

Error missing(const std::string& name) {
    return {ErrorCode::notFound, "dataset", "no generated dataset is called \"" + name + '"'};
}

/// Kinds of data that a layer draws; the first that has a dataset of its name.
std::vector<DataKind> kindsOf(const Layer& layer) {
    if (layer.particles() != nullptr) return {DataKind::particles};
    if (layer.mesh() != nullptr) return {DataKind::mesh};
    if (layer.image() != nullptr) return {DataKind::image};
    if (layer.ink() != nullptr) return {DataKind::mesh, DataKind::hybrid, DataKind::particles};
    return {layer.hybrid() != nullptr ? DataKind::hybrid : DataKind::dots};
}

Result<DatasetName> datasetOf(const Layer& layer) {
    for (const auto kind : kindsOf(layer)) {
        auto found = ViewData::find(layer.dataset, kind);
        if (found.ok()) return found;
    }
    return missing(layer.dataset);
}

Status checkRepresentation(HybridRepresentation asked, const render::GridField& step) {
    using enum HybridRepresentation;
    const bool any = asked == best || asked == volume;
    if (any || asked == step.parts) return success();
    return Error{ErrorCode::unsupported, "representation", "the dataset has none"};
}

}  // namespace

std::string DatasetName::toString() const {
    return fmt::format("{}{}-{}", root, form, number);
}

DatasetName ViewData::any(Random& random, DataKind kind) {
    const auto forms = formsOf(kind);
    const std::string form(forms[random.below(forms.size())]);
    return {kind, form, static_cast<std::uint32_t>(random.below(numbers))};
}

Result<DatasetName> ViewData::find(const std::string& name, DataKind kind) {
    const std::size_t dash = name.rfind('-');
    if (!name.starts_with(root) || dash == std::string::npos || dash < root.size()) return missing(name);
    DatasetName found{kind, name.substr(root.size(), dash - root.size()), 0};
    const char* const end = name.data() + name.size();
    const auto [last, error] = std::from_chars(name.data() + dash + 1, end, found.number);
    const auto forms = formsOf(kind);
    const bool known = std::find(forms.begin(), forms.end(), found.form) != forms.end();
    if (error != std::errc() || last != end || found.number >= numbers || !known) return missing(name);
    return found;
}

DatasetTraits ViewData::traits(const DatasetName& name) {
    if (name.kind == DataKind::mesh) return {meshOf(name.form, name.number, 0)->bounds()};
    if (name.kind != DataKind::hybrid) return {plotBounds};
    const HybridShape shape = hybridShape(name.form, name.number);
    return {Bounds{glm::dvec3(0.0), glm::dvec3(1.0)}.transformed(shape.boxToLayer), shape.range, shape.parts};
}

std::shared_ptr<const MemoryStep> ViewData::particles(const DatasetName& name, std::uint32_t step) {
    auto& kept = particles_[name.toString() + fmt::format("/{}", step)];
    if (!kept) kept = particleStep(name.form, name.number, step);
    return kept;
}

const MemoryRun& ViewData::run(const DatasetName& name) {
    auto& kept = runs_[name.toString()];
    if (!kept) {
        std::vector<MemoryRun::Step> all;
        for (std::uint32_t step = 0; step < steps; ++step) all.push_back(withNumbers(particles(name, step)));
        kept = std::make_shared<const MemoryRun>(std::move(all), BeamContext{});
    }
    return *kept;
}

std::shared_ptr<const render::GridField> ViewData::hybrid(const DatasetName& name, std::uint32_t step) {
    auto& kept = hybrids_[name.toString() + fmt::format("/{}", step)];
    if (!kept) kept = hybridStep(name.form, name.number, step);
    return kept;
}

std::shared_ptr<const render::MeshSurface> ViewData::mesh(const DatasetName& name, std::uint32_t step) {
    auto& kept = meshes_[name.toString() + fmt::format("/{}", step)];
    if (!kept) kept = meshOf(name.form, name.number, step);
    return kept;
}

namespace {

/// Of the last layer, whose ink is of what is left.
void cutMesh(const HalfSpaces& clips, render::Scene& scene) {
    if (clips.empty()) return;
    auto& surface = scene.layers.back().mesh;
    auto mesh = render::cutMesh(surface->mesh(), clips);
    if (mesh.triangles.empty()) scene.view.layers[scene.layers.size() - 1].opacity = 0.0;
    surface = std::make_shared<const render::MeshSurface>(std::move(mesh), surface->bounds());
}

}  // namespace

Status ViewData::add(const Layer& layer, render::Scene& scene, render::Dots& dots) {
    const auto name = datasetOf(layer);
    MOTE_RETURN_IF_ERROR(name);
    if (layer.step >= steps)
        return Error{ErrorCode::notFound, "step", fmt::format("there are {} steps", steps)};
    auto& data = scene.layers.emplace_back();
    const bool inked = layer.ink() != nullptr;
    if (name->kind == DataKind::particles && inked) {
        data.density = render::densityGrid(*particles(*name, layer.step));
    } else if (name->kind == DataKind::particles) {
        data.step = particles(*name, layer.step);
        MOTE_RETURN_IF_ERROR(addNumbers(layer, run(*name), data));
    }
    if (name->kind == DataKind::dots) addDots(name->form, name->number, layer, scene.view, dots);
    if (name->kind == DataKind::image) data.image = imageOf(name->form, name->number);
    if (name->kind == DataKind::mesh) data.mesh = mesh(*name, layer.step);
    if (name->kind == DataKind::mesh && inked) cutMesh(layer.clips(), scene);
    if (name->kind != DataKind::hybrid) return success();
    data.hybrid = hybrid(*name, layer.step);
    return inked ? success()
                 : checkRepresentation(hybridStyleOf(*layer.hybrid()).representation, *data.hybrid);
}

namespace {

/// What a view leaves to the plot is that of a plot of as many, or of so many that there is a volume.
PlotDensity plotOf(const storage::ParticleStep& step) {
    const std::uint64_t points = step.pointCount();
    const double weight = points > 0 ? step.nodes().density[0] / static_cast<double>(points) : 0.0;
    return {step.logDensity(), points % 2 == 0 ? points : points + 1'000'000, weight};
}

/// Steps of so few points hardly have a volume by their plot, and points in its colours: some datasets have
/// these anyway, of half of the map.
void resolve(const storage::ParticleStep& step, const DatasetName& name, ParticlesStyle& style) {
    resolveByPlot(style, plotOf(step));
    if (style.colorByPlot && name.number % 3 != 0)
        style.pointShade = PointShade{{0.1, 0.9}, {name.number % 3 == 1 ? 0.0 : 1.0, 0.5}};
}

}  // namespace

Result<render::Scene> ViewData::scene(const proto::View& message) {
    auto view = parseView(message);
    MOTE_RETURN_IF_ERROR(view);
    view = viewAt(*std::move(view), nearestPlace);
    render::Scene scene{lengthsInPixels(*view), {}};
    auto dots = std::make_shared<render::Dots>();
    for (std::size_t i = 0; i < view->layers.size(); ++i) {
        const auto added = add(view->layers[i], scene, *dots);
        if (!added.ok()) return added.error().within(fmt::format("layers[{}]", i));
        auto& data = scene.layers[i];
        const auto* const said = scene.view.layers[i].particles();
        if (said == nullptr || data.step == nullptr) continue;
        data.particles = particlesStyleOf(*said, scene.view.height);
        resolve(*data.step, *datasetOf(view->layers[i]), *data.particles);
    }
    if (!dots->empty()) scene.dots = std::move(dots);
    return scene;
}

}  // namespace mote::test
