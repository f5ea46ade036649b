// SPDX-License-Identifier: GPL-3.0-or-later
//
// MeshEditor: a mesh layer as the user edits it, and its part of the panel.
#pragma once

#include "client/view/layers/layer_editor.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/fields/resolve.h"

namespace mote::client {

class MeshEditor final : public LayerEditor {
  public:
    MeshEditor() { fillIn(style); }

    void read(const proto::Layer& layer) override { style = layer.mesh(); }
    void write(proto::Layer& layer) const override { *layer.mutable_mesh() = style; }
    void drawFacts(const LayerPanel& panel) override;
    void draw(const LayerPanel& panel) override;

    proto::MeshStyle style;  ///< valid
};

}  // namespace mote::client
