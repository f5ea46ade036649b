// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/load_hybrid.h"

#include <fmt/format.h>

#include <utility>

#include "server/render/layers/hybrid/hybrid_load.h"
#include "server/render/layers/ink/density_grid.h"
#include "storage/particles/particle_step.h"

namespace mote::server {

/// The step is mapped once more, and no longer than it takes: what is read of it is the kernel's to take
/// back.
Result<Loadable<render::GridField>> stepDensity(const storage::Catalogue::Entry& entry, std::uint32_t step) {
    if (entry.manifest->kind() != "particles") {
        return Error{
            ErrorCode::invalidArgument, "dataset",
            fmt::format("\"{}\" is of kind \"{}\", not particles", entry.name, entry.manifest->kind())};
    }
    const auto load = [entry](std::uint32_t index,
                              const AnyLoadable::Cancelled&) -> Result<Loadable<render::GridField>::Value> {
        MOTE_ASSIGN_OR_RETURN(const auto opened,
                              storage::ParticleStep::open(entry.directory, *entry.manifest, index));
        auto density = render::densityGrid(*opened);
        opened->check();
        return density;
    };
    Loadable<render::GridField> loadable(
        entry, [](std::uint32_t) { return render::densityGridBytes(); }, load);
    loadable.step = step;
    loadable.steps = entry.manifest->particles().steps_size();
    return loadable;
}

Result<Loadable<render::GridField>> hybridStep(const storage::Catalogue::Entry& entry, std::uint32_t step,
                                               HybridRepresentation representation) {
    if (entry.manifest->kind() != "hybrid") {
        return Error{
            ErrorCode::invalidArgument, "dataset",
            fmt::format("\"{}\" is of kind \"{}\", not a hybrid volume", entry.name, entry.manifest->kind())};
    }
    const auto parts = render::hybridParts(entry.manifest->hybrid(), representation);
    if (!parts.ok()) return parts.error();
    const auto expected = [manifest = entry.manifest, parts = *parts](std::uint32_t index) {
        return render::hybridBytes(manifest->hybrid(), index, parts) +
               render::hybridLoadingBytes(manifest->hybrid(), index, parts);
    };
    const auto load = [entry, parts = *parts](std::uint32_t index, const AnyLoadable::Cancelled& cancelled) {
        return render::loadHybrid(entry.directory, *entry.manifest, index, parts, cancelled);
    };
    Loadable<render::GridField> loadable(entry, expected, load);
    loadable.part = static_cast<int>(*parts);
    loadable.step = step;
    loadable.steps = entry.manifest->hybrid().steps_size();
    return loadable;
}

Result<Loadable<render::GridField>> hybridVolume(const storage::Catalogue::Entry& entry, std::uint32_t step) {
    auto volume = hybridStep(entry, step, HybridRepresentation::volume);
    if (volume.ok()) volume->steps = 1;
    return volume;
}

}  // namespace mote::server
