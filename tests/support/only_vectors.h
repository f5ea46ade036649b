// SPDX-License-Identifier: GPL-3.0-or-later
//
// OnlyVectors: lets the cpu device use one kind of vectors alone while it lives, of those that this processor
// has. One at a time, while no device draws.
#pragma once

#include <hwy/targets.h>

#include <cstdint>

namespace mote::test {

class OnlyVectors {
  public:
    /// `target`: one of hwy::SupportedAndGeneratedTargets().
    explicit OnlyVectors(std::int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
    ~OnlyVectors() {
        hwy::SetSupportedTargetsForTest(0);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
    OnlyVectors(const OnlyVectors&) = delete;
    OnlyVectors& operator=(const OnlyVectors&) = delete;
};

}  // namespace mote::test
