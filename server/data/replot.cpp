// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/replot.h"

namespace mote::server {

std::optional<proto::JobRequest> replotOf(const proto::JobRequest& request,
                                          const std::filesystem::path& folder, const storage::Roots& roots) {
    if (!request.has_particles() || request.particles().inputs().empty()) return std::nullopt;
    proto::JobRequest replot = request;
    replot.clear_output();
    for (auto& input : *replot.mutable_particles()->mutable_inputs()) {
        const auto name = roots.nameOf((folder / input).lexically_normal());
        if (!name || !roots.resolveExisting(*name).ok()) return std::nullopt;
        input = *name;
    }
    return replot;
}

}  // namespace mote::server
