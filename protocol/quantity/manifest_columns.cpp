// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/quantity/manifest_columns.h"

namespace mote {

RunColumns columnsOf(const proto::ParticlesManifest& manifest) {
    RunColumns run{{}, manifest.mass(), manifest.species() == "photon", "dataset", ""};
    for (const auto& column : manifest.columns()) run.columns.push_back({column.name(), column.unit()});
    return run;
}

}  // namespace mote
