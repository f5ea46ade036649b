// SPDX-License-Identifier: GPL-3.0-or-later
//
// Towards: another step of a layer's dataset, and how far on the way there the layer is (docs/PICTURE.md,
// "Between steps"). A value.
#pragma once

#include <cstdint>

namespace mote {

struct Towards {
    std::uint32_t step = 0;  ///< index into the dataset's steps
    double share = 0.0;      ///< of the way from the layer's step to this one, 0 to 1

    bool operator==(const Towards&) const = default;
};

}  // namespace mote
