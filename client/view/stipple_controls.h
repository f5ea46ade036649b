// SPDX-License-Identifier: GPL-3.0-or-later
//
// StippleControls: what the user sets of a stipple layer, as sliders hold it. A value, free of any window.
#pragma once

#include <array>
#include <string>

#include "client/view/light_angles.h"
#include "protocol/mote.pb.h"

namespace mote::client {

struct StippleControls {
    float spacing = 5.0F;          ///< pixels
    float dotSize = 2.0F;          ///< pixels
    bool ownColor = false;         ///< otherwise the opposite of the background
    std::array<float, 3> color{};  ///< sRGB-encoded
    LightAngles angles;            ///< towards the light
    float ambient = 0.15F;         ///< the rest is diffuse
    bool shadow = false;
    float jitter = 0.5F;
    bool soft = false;
    bool seeThrough = false;
    bool invert = false;
    float gamma = 1.0F;
    std::string image;  ///< a dataset of the catalogue, or empty

    StippleControls();

    /// Fills the fields above and leaves the others alone.
    void write(proto::StippleStyle& style) const;
    /// Takes a style that has been parsed without error.
    void read(const proto::StippleStyle& style);

    bool operator==(const StippleControls&) const = default;
};

}  // namespace mote::client
