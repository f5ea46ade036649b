// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/plot_manifest.h"

#include <fmt/format.h>

#include "preprocess/portable_input.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// Inputs as seen from the folder that holds the dataset; nothing else that depends on where or how it was
/// made.
proto::JobRequest portableRequest(const proto::JobRequest& request, const std::vector<fs::path>& inputs,
                                  const fs::path& output) {
    proto::JobRequest portable = request;
    portable.clear_output();
    auto& job = *portable.mutable_particles();
    job.clear_inputs();
    for (const auto& input : inputs) job.add_inputs(portableInput(input, output));
    return portable;
}

}  // namespace

proto::Manifest describePlot(const PlotRequest& asked, const PlotAxes& axes,
                             const std::array<Range, 3>& bounds, const StepOptions& options) {
    proto::Manifest manifest;
    manifest.set_kind("particles");
    manifest.set_format(storage::formatVersion);
    manifest.set_writer("mote-prep " MOTE_VERSION);
    *manifest.mutable_request() = portableRequest(asked.request, asked.inputs, asked.output);
    manifest.set_title(asked.request.title());
    if (asked.request.title().empty() && !asked.inputs.empty()) {
        manifest.set_title(fmt::format("{}: {} {} {}", asked.inputs.front().filename().string(), axes[0].name,
                                       axes[1].name, axes[2].name));
    }
    auto& particles = *manifest.mutable_particles();
    for (std::size_t a = 0; a < 3; ++a) {
        auto& axis = *particles.add_axes();
        axis.set_name(std::string(axes[a].name));
        axis.set_unit(std::string(axes[a].unit));
        axis.set_min(bounds[a].min);
        axis.set_max(bounds[a].max);
    }
    particles.set_volume_level(options.volumeLevel);
    particles.set_leaf_capacity(options.octree.leafCapacity);
    particles.set_max_level(options.octree.maxLevel);
    return manifest;
}

}  // namespace mote::prep
