// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepSource: where the renderer gets a layer's data from. Asked by the thread that renders; must answer from
// what is known, without searching.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "protocol/scene/error.h"
#include "storage/particles/particle_step.h"

namespace mote::server {

class StepSource {
  public:
    virtual ~StepSource() = default;
    /// `dataset` as in the catalogue. Errors: notFound (the dataset, the step), corrupt, permissionDenied.
    virtual Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string& dataset,
                                                                      std::uint32_t index) = 0;
};

}  // namespace mote::server
