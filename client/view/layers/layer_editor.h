// SPDX-License-Identifier: GPL-3.0-or-later
//
// LayerEditor: what the user edits of a layer: read out of a view, written into one, drawn as a part of the
// panel. Each kind of layer has one, in a pair of files of its own; layer_editor.cpp has the table of them.
// Owned by the view model; main thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>

#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"

namespace mote::client {

struct PanelActions;
struct ServerState;

/// What an editor is drawn with, and what it may change beside its layer.
struct LayerPanel {
    const ServerState& server;
    std::uint32_t step;                ///< of the shown dataset
    glm::dvec3 eye;                    ///< of the camera, world
    float scale;                       ///< pixels to a screen coordinate
    std::array<float, 3>& background;  ///< of the view, sRGB-encoded
    PanelActions& actions;
};

class LayerEditor {
  public:
    virtual ~LayerEditor() = default;

    /// Takes the style of a layer that has been parsed without error; without one every default.
    virtual void read(const proto::Layer& layer) = 0;
    /// Makes it a layer of this kind with what is edited here, and leaves the rest of its style alone.
    virtual void write(proto::Layer& layer) const = 0;
    /// Another dataset is shown, which this kind of layer draws.
    virtual void setDataset(const proto::Manifest& /*manifest*/) {}

    /// What the shown dataset holds, in a few faint lines. Within the panel's window; not before a dataset is
    /// shown.
    virtual void drawFacts(const LayerPanel& panel) = 0;
    /// The controls, likewise, also before a dataset is shown.
    virtual void draw(const LayerPanel& panel) = 0;
};

/// The editor of a kind of layer, every control at its default; null where the viewer has none.
std::unique_ptr<LayerEditor> makeLayerEditor(proto::Layer::KindCase kind);

}  // namespace mote::client
