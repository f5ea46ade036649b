// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the manifest of a hybrid volume says before any of its steps is made. A pure function, but for the
// names of the file system.
#pragma once

#include <filesystem>
#include <vector>

#include "preprocess/hybrid/value_range.h"
#include "preprocess/hybrid/volume_plan.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

proto::Manifest describeVolume(const proto::JobRequest& request,
                               const std::vector<std::filesystem::path>& inputs,
                               const std::filesystem::path& output, const VolumeShape& shape,
                               const VolumePlan& plan, const ValueRange& range);

}  // namespace mote::prep
