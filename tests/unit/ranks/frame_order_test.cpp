// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/frame_order.h"

#include <gtest/gtest.h>

namespace mote::render {
namespace {

/// No field as it is by default.
HybridStyle unlikeTheDefault() {
    HybridStyle style;
    style.representation = HybridRepresentation::points;
    style.opacity = Curve::create({{-400.0, 0.0}, {1300.0, 0.9}}, -1000.0, 3000.0).value();
    style.colors = {glm::dvec3(0.1, 0.2, 0.3), glm::dvec3(0.9, 0.8, 0.7)};
    style.colorMap = ColorMap::find("viridis").value();
    style.colorRange = ValueRange{-300.0, 1200.0};
    style.pointShape = PointShape::disc;
    style.pointOpacity = 0.7;
    style.light = {.direction = glm::dvec3(0.0, 0.6, 0.8), .fixed = true, .ambient = 0.3, .diffuse = 0.5};
    style.light.specular = 0.2;
    style.clipPlanes = {{glm::dvec3(1.0, 0.0, 0.0), 20.0}, {glm::dvec3(0.0, 0.0, -1.0), -3.0}};
    style.clipBox = Bounds{glm::dvec3(-1.0), glm::dvec3(2.0)};
    return style;
}

TEST(FrameOrder, EveryFieldOfAHybridLayerArrives) {
    glm::dmat4 layerToWorld(1.0);
    layerToWorld[3] = glm::dvec4(5.0, 6.0, 7.0, 1.0);
    FrameOrder order;
    order.plan.width = 64;
    order.plan.height = 48;
    order.hybrids = {{{"data/ct.mote/step-000000.h5", "digest"}, unlikeTheDefault(), layerToWorld},
                     {{"data/b.mote/step-000003.h5", "other"}, {}, glm::dmat4(1.0)}};
    const auto arrived = unpackOrder(packOrder(order));
    ASSERT_EQ(arrived.hybrids.size(), order.hybrids.size());
    for (std::size_t i = 0; i < order.hybrids.size(); ++i) {
        EXPECT_EQ(arrived.hybrids[i].step, order.hybrids[i].step);
        EXPECT_EQ(arrived.hybrids[i].style, order.hybrids[i].style);
        EXPECT_EQ(arrived.hybrids[i].layerToWorld, order.hybrids[i].layerToWorld);
    }
}

}  // namespace
}  // namespace mote::render
