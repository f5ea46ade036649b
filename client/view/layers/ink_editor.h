// SPDX-License-Identifier: GPL-3.0-or-later
//
// InkEditor: what the user sets of an ink layer, as sliders hold it (InkControls, a value that is free of any
// window), and its part of the panel.
#pragma once

#include <string>

#include "client/view/layers/layer_editor.h"
#include "client/view/slider_values.h"
#include "protocol/mote.pb.h"

namespace mote::client {

struct InkControls {
    std::string lines;        ///< a SilhouetteMode
    float importance = 0.0F;  ///< depth step above which a line is always drawn
    float lineWidth = 0.0F;   ///< pixels, and so are all lengths
    float crease = 0.0F;      ///< degrees
    bool omit = false;
    float hatch = 0.0F;  ///< strength
    float spacing = 0.0F;
    float hatchWidth = 0.0F;
    std::string segments;  ///< a Segmentation
    float solid = 0.0F;    ///< strength
    float complexity = 0.0F;
    float occlusion = 0.0F;
    float reading = 0.0F;
    float waver = 0.0F;
    bool taper = false;
    bool coherent = false;
    std::string show;    ///< an InkPicture; "drawing" for itself
    LightAngles angles;  ///< towards the light
    float ambient = 0.0F, diffuse = 0.0F;
    bool shadow = false;

    InkControls();

    /// Other lines; what is left to them follows.
    void setLines(const std::string& mode);

    /// Fills the fields above and leaves the others alone.
    void write(proto::InkStyle& style) const;
    /// Takes a style that has been parsed without error.
    void read(const proto::InkStyle& style);

  private:
    void writeSolid(proto::InkStyle& style) const;

    bool importanceByLines_ = true;  // the view leaves it to them
    bool ownSolid_ = false;          // the view says something of it
};

class InkEditor final : public LayerEditor {
  public:
    void read(const proto::Layer& layer) override { controls.read(layer.ink()); }
    void write(proto::Layer& layer) const override { controls.write(*layer.mutable_ink()); }
    void drawFacts(const LayerPanel& panel) override;
    void draw(const LayerPanel& panel) override;

    InkControls controls;
};

}  // namespace mote::client
