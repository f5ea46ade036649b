// SPDX-License-Identifier: GPL-3.0-or-later
//
// The generator of views: legal ones that nobody chose, of generated data (view_data.h). Every field of the
// schema's View is left out, at its ends and between them; most views show something. The same number gives
// the same view on every machine. Pure functions.
#pragma once

#include <cstdint>

#include "protocol/mote.pb.h"

namespace mote::test {

struct ViewShape {
    std::uint64_t mostPixels = 768;  ///< of a picture
};

/// The view of a number in the series of a seed. It is valid, and ViewData has its data.
proto::View generatedView(std::uint64_t seed, std::uint64_t number, const ViewShape& shape = {});

}  // namespace mote::test
