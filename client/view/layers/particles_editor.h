// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParticlesEditor: what the user sets of a particle plot, as sliders hold it (ParticlesControls, a value that
// is free of any window), and its part of the panel.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "client/view/layers/layer_editor.h"
#include "client/view/layers/transfer_functions.h"
#include "client/view/replot.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/curve_presets.h"
#include "protocol/scene/plot_density.h"
#include "protocol/scene/transfer_function.h"

namespace mote::client {

struct ParticlesControls {
    TransferFunctions functions;
    std::string colorMap;
    float pointOpacity = 0.0F;
    float pointSize = 0.0F;             ///< pixels
    std::array<float, 3> pointColor{};  ///< sRGB-encoded
    /// The two densities that curves and colours are told between, in the units of colour bars; null: the
    /// plot's.
    std::optional<Interval> densities;

    ParticlesControls();

    /// Another plot: curves that nobody has chosen are its own.
    void setDataset(const proto::ParticlesManifest& manifest);

    /// Fills the fields above and leaves the others alone.
    void write(proto::ParticlesStyle& style) const;
    /// Takes a style that has been parsed without error.
    void read(const proto::ParticlesStyle& style);
    /// Takes the curves of a preset; null: the plot's own.
    void take(const DensityPreset* preset);
    /// The least and the greatest density of the plot, in the units of colour bars; null before one is shown.
    std::optional<Interval> densitiesOfPlot() const;
    /// What the volume is drawn with; its colours are the plot's where the curves are.
    TransferFunction drawn() const;

  private:
    ParticlesStyle styleOfPlot() const;
    bool opacityChosen() const;
    bool sizeChosen() const;
    bool colorChosen() const;

    bool ownOpacity_ = false, ownSize_ = false, ownColor_ = false;  // from a saved view
    float plotOpacity_ = 0.0F, plotSize_ = 0.0F;  // what sliders show where the plot says how points look
    std::array<float, 3> plotColor_{};
    std::optional<PlotDensity> plot_;
};

class ParticlesEditor final : public LayerEditor {
  public:
    void read(const proto::Layer& layer) override { controls.read(layer.particles()); }
    void write(proto::Layer& layer) const override { controls.write(*layer.mutable_particles()); }
    void setDataset(const proto::Manifest& manifest) override { controls.setDataset(manifest.particles()); }
    void drawFacts(const LayerPanel& panel) override;
    void draw(const LayerPanel& panel) override;

    ParticlesControls controls;

  private:
    void drawAxisLists(const AxisNames& shown, const proto::Description& dataset, PanelActions& actions);

    AxisNames axes_;             // chosen in the lists
    std::string axesOfDataset_;  // the dataset that axes_ was last taken from
};

}  // namespace mote::client
