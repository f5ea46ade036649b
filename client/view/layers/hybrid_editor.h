// SPDX-License-Identifier: GPL-3.0-or-later
//
// HybridEditor: what the user sets of a hybrid volume, as sliders hold it (HybridControls, a value that is
// free of any window), and its part of the panel.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "client/view/knot_curve.h"
#include "client/view/layers/layer_editor.h"
#include "client/view/slider_values.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"
#include "protocol/scene/curve_presets.h"

namespace mote::client {

struct HybridControls {
    KnotCurve curve;  ///< opacity over values in the source's own unit
    std::string colorMap;
    bool ownMap = false;         ///< somebody chose the map; otherwise the curve has what of it can be read
    bool ownColorRange = false;  ///< otherwise the map goes from the curve's first knot to its last
    std::array<double, 2> colorRange{};  ///< ascending, in the source's unit
    proto::HybridStyle rest;             ///< what the other members are not about

    HybridControls();

    /// Another dataset: its range of values and, where the curve is that of values of another kind, a curve
    /// that suits it. The first one after a style was read brings what that leaves out, and nothing else.
    void setDataset(const proto::HybridManifest& manifest);
    /// Curves for the values of the dataset; its first step stands for all.
    static std::vector<CurvePreset> presets(const proto::HybridManifest& manifest);
    /// Linear RGB.
    glm::dvec3 color(double value) const;

    /// The colour map stays where it was when the curve had this extent.
    void keepColors(const Interval& extent);

    /// Fills the fields above and leaves the others alone.
    void write(proto::HybridStyle& style) const;
    /// Takes a style that has been parsed without error.
    void read(const proto::HybridStyle& style);

  private:
    /// Where the colour map begins and ends over a curve's extent.
    Interval mapOver(const Interval& extent) const;
    void takeUnsaid(const proto::HybridManifest& manifest);

    bool ownCurve_ = false;      // from a saved view, not one that suits some dataset
    std::string valuesUnit_;     // of the dataset for which the curve is
    Interval values_{0.0, 0.0};  // likewise; empty before the first dataset
    double highest_ = 0.0;       // of greatest values, that has a colour of its own
};
class HybridEditor final : public LayerEditor {
  public:
    void read(const proto::Layer& layer) override { controls.read(layer.hybrid()); }
    void write(proto::Layer& layer) const override { controls.write(*layer.mutable_hybrid()); }
    void setDataset(const proto::Manifest& manifest) override { controls.setDataset(manifest.hybrid()); }
    void drawFacts(const LayerPanel& panel) override;
    void draw(const LayerPanel& panel) override;

    HybridControls controls;
};

}  // namespace mote::client
