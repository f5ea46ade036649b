// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/load_density.h"

#include <fmt/format.h>

#include <utility>

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

}  // namespace mote::server
