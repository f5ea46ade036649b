// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/layer_editor.h"

#include <gtest/gtest.h>

#include "protocol/scene/dataset.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

constexpr proto::Layer::KindCase kinds[] = {proto::Layer::kParticles, proto::Layer::kHybrid,
                                            proto::Layer::kStipple,   proto::Layer::kMesh,
                                            proto::Layer::kInk,       proto::Layer::kImage};

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

TEST(LayerEditor, ThereIsOneForEachKindOfDatasetThatALayerDraws) {
    for (const char* dataset : {"particles", "hybrid", "stipple", "mesh", "image"}) {
        for (const auto kind : layersThatDraw(dataset)) EXPECT_NE(makeLayerEditor(kind), nullptr) << dataset;
    }
    EXPECT_EQ(makeLayerEditor(proto::Layer::KIND_NOT_SET), nullptr);
}

}  // namespace
}  // namespace mote::client
