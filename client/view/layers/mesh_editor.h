// SPDX-License-Identifier: GPL-3.0-or-later
//
// MeshEditor: what the user sets of a mesh layer, as sliders hold it (MeshControls, a value that is free of
// any window), and its part of the panel.
#pragma once

#include <array>

#include "client/view/layers/layer_editor.h"
#include "client/view/slider_values.h"
#include "protocol/mote.pb.h"

namespace mote::client {

struct MeshControls {
    std::array<float, 3> color{};  ///< sRGB-encoded
    float opacity = 1.0F;
    bool wire = false;
    LightAngles angles;  ///< towards the light
    float ambient = 0.0F, diffuse = 0.0F, specular = 0.0F;
    bool shadow = false;

    MeshControls();

    /// Fills the fields above and leaves the others alone.
    void write(proto::MeshStyle& style) const;
    /// Takes a style that has been parsed without error.
    void read(const proto::MeshStyle& style);
};

class MeshEditor final : public LayerEditor {
  public:
    void read(const proto::Layer& layer) override { controls.read(layer.mesh()); }
    void write(proto::Layer& layer) const override { controls.write(*layer.mutable_mesh()); }
    void drawFacts(const LayerPanel& panel) override;
    void draw(const LayerPanel& panel) override;

    MeshControls controls;
};

}  // namespace mote::client
