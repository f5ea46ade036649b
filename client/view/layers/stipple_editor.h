// SPDX-License-Identifier: GPL-3.0-or-later
//
// StippleEditor: what the user sets of a stipple layer, as sliders hold it (StippleControls, a value that is
// free of any window), and its part of the panel.
#pragma once

#include <array>
#include <string>

#include "client/view/layers/layer_editor.h"
#include "client/view/slider_values.h"
#include "protocol/mote.pb.h"

namespace mote::client {

struct StippleControls {
    float spacing = 5.0F;          ///< pixels
    float dotSize = 2.0F;          ///< pixels
    bool ownColor = false;         ///< otherwise the opposite of the background
    std::array<float, 3> color{};  ///< sRGB-encoded
    LightAngles angles;            ///< towards the light
    float ambient = 0.0F, diffuse = 0.0F;
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
};

class StippleEditor final : public LayerEditor {
  public:
    void read(const proto::Layer& layer) override { controls.read(layer.stipple()); }
    void write(proto::Layer& layer) const override { controls.write(*layer.mutable_stipple()); }
    void drawFacts(const LayerPanel& panel) override;
    void draw(const LayerPanel& panel) override;

    StippleControls controls;
};

}  // namespace mote::client
