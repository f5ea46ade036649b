// SPDX-License-Identifier: GPL-3.0-or-later
//
// OnlyVectors: lets the cpu device use one kind of vectors alone while it lives, of those that this processor
// has. One at a time, while no device draws.
#pragma once

#include <hwy/targets.h>

#include <cstdint>

#include "server/render/cpu/vectors.h"

namespace mote::test {

class OnlyVectors {
  public:
    /// `target`: one of hwy::SupportedAndGeneratedTargets().
    explicit OnlyVectors(std::int64_t target) { render::useVectors(target); }
    ~OnlyVectors() { render::useVectorsOfEnvironment(); }
    OnlyVectors(const OnlyVectors&) = delete;
    OnlyVectors& operator=(const OnlyVectors&) = delete;
};

}  // namespace mote::test
