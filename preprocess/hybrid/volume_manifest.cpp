// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/volume_manifest.h"

#include <fmt/format.h>

#include "preprocess/portable_input.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// Inputs as seen from the folder that holds the dataset; nothing else of where it was made.
proto::JobRequest portableRequest(const proto::JobRequest& request, const std::vector<fs::path>& inputs,
                                  const fs::path& output) {
    proto::JobRequest portable = request;
    portable.clear_output();
    portable.mutable_volume()->clear_inputs();
    for (const auto& input : inputs) portable.mutable_volume()->add_inputs(portableInput(input, output));
    return portable;
}

}  // namespace

proto::Manifest describeVolume(const proto::JobRequest& request, const std::vector<fs::path>& inputs,
                               const fs::path& output, const VolumeShape& shape, const VolumePlan& plan,
                               const ValueRange& range) {
    proto::Manifest manifest;
    manifest.set_kind("hybrid");
    manifest.set_format(storage::formatVersion);
    manifest.set_writer("mote-prep " MOTE_VERSION);
    manifest.set_title(request.title().empty() ? inputs.front().filename().string() : request.title());
    *manifest.mutable_request() = portableRequest(request, inputs, output);
    auto& hybrid = *manifest.mutable_hybrid();
    hybrid.mutable_source_size()->Assign(plan.source.begin(), plan.source.end());
    hybrid.mutable_low_size()->Assign(plan.low.begin(), plan.low.end());
    hybrid.mutable_error_size()->Assign(plan.error.begin(), plan.error.end());
    for (int i = 0; i < 16; ++i) hybrid.add_index_to_world(plan.indexToWorld[i % 4][i / 4]);
    hybrid.set_value_min(range.min);
    hybrid.set_value_max(range.max);
    hybrid.set_scalar_type(std::string(name(shape.type)));
    hybrid.set_value_unit(shape.valueUnit);
    hybrid.set_world_unit(shape.worldUnit);
    hybrid.set_filter(request.volume().filter().empty() ? "cubic" : request.volume().filter());
    hybrid.set_value_bits(plan.valueBits);
    hybrid.set_point_bytes(plan.pointBytes);
    hybrid.set_residual(plan.residual);
    return manifest;
}

}  // namespace mote::prep
