// SPDX-License-Identifier: GPL-3.0-or-later
//
// StippleEditor: a stipple layer as the user edits it, and its part of the panel.
#pragma once

#include "client/view/layers/layer_editor.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/fields/resolve.h"

namespace mote::client {

class StippleEditor final : public LayerEditor {
  public:
    StippleEditor() { fillIn(style); }

    void read(const proto::Layer& layer) override { style = layer.stipple(); }
    void write(proto::Layer& layer) const override { *layer.mutable_stipple() = style; }
    void drawFacts(const LayerPanel& panel) override;
    void draw(const LayerPanel& panel) override;

    proto::StippleStyle style;  ///< valid

  private:
    void drawImage(const LayerPanel& panel);
};

}  // namespace mote::client
