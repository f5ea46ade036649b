// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/layer_editor.h"

#include <gtest/gtest.h>

#include "client/view/layers/layer_of_dataset.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

constexpr proto::Layer::KindCase kinds[] = {proto::Layer::kParticles, proto::Layer::kHybrid,
                                            proto::Layer::kStipple};

TEST(LayerEditor, WritesALayerOfItsKindThatTheServerReads) {
    for (const auto kind : kinds) {
        const auto editor = makeLayerEditor(kind);
        ASSERT_NE(editor, nullptr);
        proto::View view;
        view.set_width(64);
        view.set_height(64);
        auto& layer = *view.add_layers();
        layer.set_dataset("data/some");
        editor->write(layer);
        EXPECT_EQ(layer.kind_case(), kind);
        const auto parsed = parseView(view);
        EXPECT_TRUE(parsed.ok()) << parsed.error().toString();
        // What is written is read as it was.
        const auto other = makeLayerEditor(kind);
        other->read(layer);
        proto::Layer again = layer;
        other->write(again);
        EXPECT_EQ(again.SerializeAsString(), layer.SerializeAsString());
    }
}

TEST(LayerEditor, ThereIsOneForWhateverADatasetIsShownAs) {
    for (const char* dataset : {"particles", "hybrid", "stipple", "image", "", "of another version"}) {
        EXPECT_NE(makeLayerEditor(layerOfDataset(dataset)), nullptr) << dataset;
    }
    EXPECT_EQ(makeLayerEditor(proto::Layer::KIND_NOT_SET), nullptr);
}

TEST(LayerEditor, ADatasetIsShownAsWhatItIs) {
    EXPECT_EQ(layerOfDataset("particles"), proto::Layer::kParticles);
    EXPECT_EQ(layerOfDataset("hybrid"), proto::Layer::kHybrid);
    EXPECT_EQ(layerOfDataset("stipple"), proto::Layer::kStipple);
}

TEST(LayerEditor, StepsAndBoxAreThoseOfItsKindOfDataset) {
    proto::Manifest plot, surface;
    for (int i = 0; i < 3; ++i) plot.mutable_particles()->add_steps();
    for (const double low : {0.0, 1.0, 2.0}) surface.mutable_mesh()->add_bounds_min(low);
    for (const double high : {3.0, 4.0, 5.0}) surface.mutable_mesh()->add_bounds_max(high);
    const auto particles = makeLayerEditor(proto::Layer::kParticles);
    const auto stipple = makeLayerEditor(proto::Layer::kStipple);
    EXPECT_EQ(particles->steps(plot), 3);
    EXPECT_EQ(particles->bounds(plot), plotBounds);
    EXPECT_EQ(stipple->steps(surface), 0);
    EXPECT_EQ(stipple->bounds(surface), (Bounds{{0.0, 1.0, 2.0}, {3.0, 4.0, 5.0}}));
}

}  // namespace
}  // namespace mote::client
