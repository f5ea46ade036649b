// SPDX-License-Identifier: GPL-3.0-or-later
//
// InkEditor: an ink layer as the user edits it, and its part of the panel.
#pragma once

#include "client/view/layers/layer_editor.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/fields/resolve.h"

namespace mote::client {

class InkEditor final : public LayerEditor {
  public:
    InkEditor() { fillIn(style); }

    void read(const proto::Layer& layer) override { style = layer.ink(); }
    void write(proto::Layer& layer) const override { *layer.mutable_ink() = style; }
    void drawFacts(const LayerPanel& panel) override;
    void draw(const LayerPanel& panel) override;

    proto::InkStyle style;  ///< valid
};

}  // namespace mote::client
