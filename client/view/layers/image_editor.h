// SPDX-License-Identifier: GPL-3.0-or-later
//
// ImageEditor: an image layer, of which there is nothing to edit but what every layer has, and its part of
// the panel.
#pragma once

#include "client/view/layers/layer_editor.h"
#include "protocol/mote.pb.h"

namespace mote::client {

class ImageEditor final : public LayerEditor {
  public:
    void read(const proto::Layer& layer) override { style = layer.image(); }
    void write(proto::Layer& layer) const override { *layer.mutable_image() = style; }
    void drawFacts(const LayerPanel& panel) override;
    void draw(const LayerPanel& panel) override;

    proto::ImageStyle style;  ///< valid
};

}  // namespace mote::client
