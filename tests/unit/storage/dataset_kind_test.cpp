// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/dataset_kind.h"

#include <gmock/gmock.h>

#include "protocol/scene/dataset.h"
#include "storage/manifest.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::storage {
namespace {

using testing::HasSubstr;

TEST(DatasetKind, EachHasAFieldOfItsNameInTheManifest) {
    std::set<std::string_view> names;
    for (const auto* kind : datasetKinds) {
        names.insert(kind->name);
        const auto* field = proto::Manifest::descriptor()->FindFieldByName(std::string(kind->name));
        ASSERT_TRUE(field) << kind->name;
        proto::Manifest manifest;
        manifest.set_kind(std::string(kind->name));
        EXPECT_EQ(findKind(manifest), nullptr) << kind->name << " says nothing of itself";
        proto::Manifest::GetReflection()->MutableMessage(&manifest, field);
        EXPECT_EQ(findKind(manifest), kind) << kind->name;
        EXPECT_EQ(kind->check(manifest, {}).error().code, ErrorCode::corrupt) << kind->name << " is empty";
    }
    EXPECT_EQ(names.size(), datasetKinds.size());
}

TEST(DatasetKind, WhatALayerDrawsIsAKind) {
    std::set<proto::Layer::KindCase> drawn;
    for (const auto* kind : datasetKinds) {
        for (const auto layer : layersThatDraw(kind->name)) drawn.insert(layer);
    }
    const auto* layers = proto::Layer::descriptor()->FindOneofByName("kind");
    EXPECT_EQ(drawn.size(), static_cast<std::size_t>(layers->field_count())) << "a layer draws nothing";
}

TEST(DatasetKind, APlotDescribesAndSumsUpItself) {
    auto manifest = test::TinyDataset().manifest();
    manifest.mutable_request()->mutable_particles()->add_inputs("run.h5");
    const auto& kind = *findKind(manifest);
    EXPECT_EQ(kind.name, "particles");
    EXPECT_THAT(kind.describe(manifest),
                testing::AllOf(HasSubstr("input    run.h5\n"), HasSubstr("axis "), HasSubstr("300000")));
    const auto summary = kind.summarize(manifest);
    EXPECT_EQ(summary.text, "1 step, 300000 particles in leaves");
    EXPECT_EQ(summary.numbers[1].first, "particles");
    EXPECT_EQ(std::get<std::uint64_t>(summary.numbers[1].second), 300000U);
    *manifest.mutable_particles()->add_steps() = manifest.particles().steps(0);
    EXPECT_EQ(kind.summarize(manifest).text, "2 steps, 600000 particles in leaves");
}

TEST(DatasetKind, AHierarchyOnASurfaceTellsOfItsMeshToo) {
    proto::Manifest manifest;
    manifest.set_kind("stipple");
    auto& stipple = *manifest.mutable_stipple();
    stipple.set_domain(proto::StippleManifest::SURFACE);
    stipple.set_points(10);
    stipple.set_moves(25);
    manifest.mutable_request()->mutable_stipple()->set_mesh("teapot.obj");
    const FileNames files{"hierarchy.h5", "hierarchy.digest"};
    EXPECT_EQ(stippleKind.check(manifest, files).error().where, "mesh");
    manifest.mutable_mesh()->set_vertices(7);
    EXPECT_THAT(stippleKind.describe(manifest),
                testing::AllOf(testing::StartsWith("mesh     teapot.obj\ndomain   surface"),
                               HasSubstr("2.5 a point"), HasSubstr("surface  7 vertices")));
    const auto summary = stippleKind.summarize(manifest);
    EXPECT_EQ(summary.text, "10 points, 25 moves");
    EXPECT_EQ(summary.numbers.front().first, "vertices");
    EXPECT_EQ(summary.numbers.back().first, "locked");
}

}  // namespace
}  // namespace mote::storage
