// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "protocol/base/json.h"

namespace mote {
namespace {

TEST(Dataset, EachKindHasItsLayer) {
    using testing::ElementsAre;
    EXPECT_THAT(layersThatDraw("particles"), ElementsAre(proto::Layer::kParticles, proto::Layer::kInk));
    EXPECT_THAT(layersThatDraw("hybrid"), ElementsAre(proto::Layer::kHybrid, proto::Layer::kInk));
    EXPECT_THAT(layersThatDraw("stipple"),
                ElementsAre(proto::Layer::kStipple, proto::Layer::kInk, proto::Layer::kMesh));
    EXPECT_THAT(layersThatDraw("mesh"), ElementsAre(proto::Layer::kMesh, proto::Layer::kInk));
    EXPECT_THAT(layersThatDraw("image"), ElementsAre(proto::Layer::kImage));
    EXPECT_TRUE(layersThatDraw("of a later version").empty());
}

TEST(Dataset, OnlyASeriesHasSteps) {
    proto::Manifest manifest;
    EXPECT_EQ(stepCount(manifest), 0);
    manifest.set_kind("particles");
    manifest.mutable_particles()->add_steps();
    manifest.mutable_hybrid()->add_steps();
    manifest.mutable_hybrid()->add_steps();
    EXPECT_EQ(stepCount(manifest), 1) << "what is not of the kind does not count";
    manifest.set_kind("hybrid");
    EXPECT_EQ(stepCount(manifest), 2);
    manifest.set_kind("stipple");
    EXPECT_EQ(stepCount(manifest), 0);
}

TEST(Dataset, ItsBoxIsThatOfItsKind) {
    proto::Manifest manifest;
    EXPECT_EQ(datasetBounds(manifest), plotBounds);
    auto& mesh = *manifest.mutable_mesh();
    for (const double least : {-1.0, -2.0, -3.0}) mesh.add_bounds_min(least);
    for (const double greatest : {4.0, 5.0, 6.0}) mesh.add_bounds_max(greatest);
    const Bounds box{{-1.0, -2.0, -3.0}, {4.0, 5.0, 6.0}};
    for (const char* kind : {"mesh", "stipple"}) {
        manifest.set_kind(kind);
        EXPECT_EQ(datasetBounds(manifest), box) << kind;
    }
    manifest.set_kind("particles");
    EXPECT_EQ(datasetBounds(manifest), plotBounds);
}

TEST(Dataset, PatientsStandAndAreSeenFromBefore) {
    const auto look = [](const char* json) {
        proto::Manifest manifest;
        EXPECT_TRUE(parseJson(json, manifest, "manifest").ok());
        return datasetOutlook(manifest);
    };
    const glm::dvec3 y(0.0, 1.0, 0.0), z(0.0, 0.0, 1.0);
    EXPECT_EQ(look(R"({"kind": "hybrid", "hybrid": {"space": "ras"}})"), (Outlook{y, z}));
    EXPECT_EQ(look(R"({"kind": "hybrid", "hybrid": {"space": "lps"}})"), (Outlook{-y, z}));
    // A CT that says no space lies as scanners write its slices; another volume has no front.
    EXPECT_EQ(look(R"({"kind": "hybrid", "hybrid": {"valueMin": -1000, "valueMax": 1988}})"),
              (Outlook{-y, z}));
    EXPECT_EQ(look(R"({"kind": "hybrid", "hybrid": {"valueMin": 0, "valueMax": 255}})"), std::nullopt);
    // A part of one without air is known by its histogram.
    proto::Manifest part;
    part.set_kind("hybrid");
    part.mutable_hybrid()->set_value_min(-200.0);
    part.mutable_hybrid()->set_value_max(1080.0);
    EXPECT_EQ(datasetOutlook(part), std::nullopt);
    auto& step = *part.mutable_hybrid()->add_steps();
    for (int bin = 0; bin < 256; ++bin) step.add_histogram(bin >= 46 && bin < 56 ? 100 : 1);  // 30 to 80 HU
    EXPECT_EQ(datasetOutlook(part), (Outlook{-y, z}));
    EXPECT_EQ(look(R"({"kind": "mesh"})"), std::nullopt);
    // What was said at its preparation goes before.
    EXPECT_EQ(look(R"({"kind": "hybrid", "hybrid": {"space": "ras"}, "up": "y", "front": "-x"})"),
              (Outlook{{-1.0, 0.0, 0.0}, y}));
    const auto upright = look(R"({"kind": "mesh", "up": "z"})").value();
    EXPECT_EQ(upright.up, z);
    EXPECT_TRUE(upright.back.y < 0.0 && std::abs(upright.back.y) > std::abs(upright.back.x));
    for (const char* name : {"", "-", "w", "xy", "--x"}) EXPECT_EQ(findDirection(name), std::nullopt) << name;
}

TEST(Dataset, AVolumesBoxHasItsSamplesAsCellCentres) {
    proto::Manifest manifest;
    manifest.set_kind("hybrid");
    EXPECT_EQ(datasetBounds(manifest), plotBounds) << "nobody has checked it";
    auto& hybrid = *manifest.mutable_hybrid();
    for (const std::uint32_t side : {4U, 2U, 1U}) hybrid.add_source_size(side);
    for (int i = 0; i < 16; ++i) hybrid.add_index_to_world(i % 5 == 0 ? 1.0 : 0.0);
    hybrid.set_index_to_world(3, 10.0);  // along x
    EXPECT_EQ(datasetBounds(manifest), (Bounds{{9.5, -0.5, -0.5}, {13.5, 1.5, 0.5}}));
}

}  // namespace
}  // namespace mote
