// SPDX-License-Identifier: GPL-3.0-or-later
//
// The cpu device by all kinds of vectors that this processor has, and on any number of threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "server/render/cpu/cpu_device.h"
#include "server/render/cpu/flat_points.h"
#include "server/render/cpu/leaf_cells.h"
#include "server/render/cpu/value_sums.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/golden/comparison.h"
#include "tests/golden/device_pictures.h"
#include "tests/golden/golden_scenes.h"
#include "tests/golden/golden_strokes.h"
#include "tests/reference/reference_renderer.h"
#include "tests/support/only_vectors.h"

namespace mote::test {
namespace {

using render::CpuDevice;
using render::Quality;

void expectTheSameOfAllKinds(const std::string& name, const Quality& quality) {
    const auto scene = makeScene(name);
    CpuDevice widest;
    const auto expected = picture(widest, scene, quality);
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
        const OnlyVectors only(target);
        CpuDevice device;
        // Sums are rounded differently if there is no fused multiply-add, and a steep density is cut as
        // finely as the steepest of a vector's rays needs it: a step or two of 8 bits.
        const auto result = compare(picture(device, scene, quality), expected);
        EXPECT_GT(result.psnr, 58.0) << name << ' ' << device.name() << ' ' << result.toString();
        EXPECT_LE(result.worst, 3) << name << ' ' << device.name() << ' ' << result.toString();
    }
}

TEST(CpuVectors, AllKindsDrawTheSamePicture) {
    Quality moving;
    moving.samplesPerCell = 1.0;
    moving.slabs = 24;
    for (const char* name : {"oddSize", "orthographicInside"}) {
        expectTheSameOfAllKinds(name, Quality::exact());
        expectTheSameOfAllKinds(name, moving);
    }
}

// Among them the plain kind, whose reads of memory a sanitizer sees.
TEST(CpuVectors, AllKindsMixVolumesPointsAndDotsAlike) {
    expectTheSameOfAllKinds("dotPlane", Quality::exact());
}

// Cut once, what lies in a cell is 2 dB worse of sheets within it.
TEST(CpuVectors, AllKindsCutWhatIsThinWithinACellAgain) {
    auto scene = makeScene("hybridSheets");
    scene.view.width /= 2, scene.view.height /= 2;
    const auto expected = reference::encode(reference::render(scene, {512.0}));
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
        const OnlyVectors only(target);
        CpuDevice device;
        const auto result = compare(picture(device, scene, Quality::exact()), expected);
        EXPECT_GT(result.psnr, 70.5) << device.name() << ' ' << result.toString();
    }
}

// What rays meet is added in one order: half floats tell roundings that bytes hide.
TEST(CpuVectors, FusedVectorsOfAnyWidthDrawTheSameHybrids) {
    for (const char* name : {"hybridResidual", "hybridGaussians", "hybridWithBeam"}) {
        auto scene = makeScene(name);
        scene.view.width *= 4, scene.view.height *= 4;
        const auto plan = render::makeFramePlan(scene, Quality::exact());
        std::vector<std::uint8_t> first;
        for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
            if (target > HWY_AVX2) continue;
            const OnlyVectors only(target);
            CpuDevice device;
            const auto pixels =
                device.render(plan, render::PixelFormat::linearHalf, std::stop_token()).value().pixels;
            if (first.empty()) first = pixels;
            EXPECT_TRUE(pixels == first) << name << ' ' << device.name();
        }
    }
}

TEST(CpuVectors, TheNumberOfThreadsChangesNoByte) {
    const auto scene = makeScene("orthographicInside");
    CpuDevice one({.threads = 1}), three({.threads = 3});
    EXPECT_EQ(picture(one, scene, Quality::exact()), picture(three, scene, Quality::exact()));
    EXPECT_NE(one.name().find("1 thread)"), std::string::npos) << one.name();
    EXPECT_NE(three.name().find("3 threads)"), std::string::npos) << three.name();
}

// Pictures of the cpu device that give way wherever they can, before their first tile too.

using render::FramePlan;
using render::PixelFormat;

constexpr render::WorkInTurns::Duration none{0};

class CpuTurns : public testing::Test {
  protected:
    CpuTurns() { others_.request_stop(); }

    render::Picture drawnAtOnce(const FramePlan& plan) {
        return device_.render(plan, PixelFormat::srgb8, std::stop_token()).value();
    }
    /// Others' pictures, which use the same lists and steps, are drawn at every seventh turn.
    render::Picture drawnInTurns(const FramePlan& plan, const FramePlan& other) {
        const auto expected = drawnAtOnce(other).pixels;
        const auto begun = device_.begin(plan, PixelFormat::srgb8, std::stop_token());
        for (turns_ = 1; !begun->advance(others_.get_token()); ++turns_) {
            if (turns_ % 7 != 3) continue;
            EXPECT_TRUE(drawnAtOnce(other).pixels == expected);
            device_.trim();
        }
        return begun->take();
    }
    void expectTheSame(const FramePlan& plan, const FramePlan& other) {
        const auto expected = drawnAtOnce(plan);
        const auto drawn = drawnInTurns(plan, other);
        EXPECT_TRUE(drawn.pixels == expected.pixels) << turns_ << " turns";
        EXPECT_EQ(drawn.pointsDrawn, expected.pointsDrawn);
    }

    std::stop_source others_;
    render::CpuDevice device_{{.threads = 2, .leastTurn = none}};
    const FramePlan small_ = render::makeFramePlan(makeScene("oddSize"), Quality::exact());
    int turns_ = 0;
};

/// By a value that grows with a point's place in the file.
void colorByValue(FramePlan& plan, bool nearest) {
    for (auto& points : plan.points) {
        auto values = std::make_shared<render::PointValues>();
        for (std::uint64_t i = 0; i < points.step->pointCount(); ++i)
            values->codes.push_back(static_cast<render::ValueCode>(i % 60000));
        values->complete = true;
        points.colors = render::PointColors{std::move(values), ColorMap::find("magma").value(), nearest};
    }
}

/// As if some of a layer's leaves were all.
render::PointsPlan withLeaves(const render::PointsPlan& points, std::span<const std::size_t> leaves) {
    auto part = points;
    auto selection = std::make_shared<render::PointSelection>(*points.selection);
    std::fill(selection->drawn.begin(), selection->drawn.end(), 0);
    for (const std::size_t leaf : leaves) selection->drawn[leaf] = points.selection->drawn[leaf];
    part.selection = std::move(selection);
    return part;
}

// A leaf is passed over if it lies behind all that its pixels have: that changes no value.
TEST(CpuVectors, NearestValuesAreTheLeastOfEachLeafAlone) {
    for (const char* name : {"haloOnly", "orthographicInside", "twoLayers"}) {
        SCOPED_TRACE(name);
        auto scene = makeScene(name);
        scene.view.width = 12;
        scene.view.height = 9;
        auto plan = render::makeFramePlan(scene, Quality::exact());
        colorByValue(plan, true);
        for (auto& points : plan.points) {
            points.look.size = 1.0;           // discs are looked at one by one
            std::vector<std::size_t> leaves;  // some, from all of the file
            const std::size_t count = points.selection->drawn.size(), step = count / 500 + 1;
            for (std::size_t i = 0; i < count; i += step) {
                if (points.drawn(i) > 0) leaves.push_back(i);
            }
            ASSERT_GT(leaves.size(), 30U);
            render::ResidentLeaves resident;
            const auto cells = resident.of(points.step).upTo(*points.step, points.selection->drawn.size());
            const auto sums = [&](std::span<const std::size_t> some) {
                return render::valueSums(plan, withLeaves(points, some), cells, std::stop_token()).value();
            };
            auto alone = sums({leaves.data(), 1});
            for (std::size_t i = 1; i < leaves.size(); ++i) alone.add(sums({leaves.data() + i, 1}));
            EXPECT_EQ(sums(leaves).words, alone.words);
        }
    }
}

// As many points as a pixel needs to hide all that is behind them are counted while the nearest are looked
// for, also those that lie behind.
TEST(CpuVectors, WhoLooksForTheNearestCountsThePoints) {
    for (const char* name : {"haloOnly", "orthographicInside", "twoLayers"}) {
        for (const double opacity : {0.05, 0.99}) {
            SCOPED_TRACE(name);
            auto scene = makeScene(name);
            scene.view.width = 61;
            scene.view.height = 43;
            auto plan = render::makeFramePlan(scene, Quality::exact());
            colorByValue(plan, true);
            for (auto& points : plan.points) {
                points.look.size = 1.0;
                points.look.light = 0.0;
                points.look.opacity = 1e-6;  // no pixel is full
                render::ResidentLeaves resident;
                const auto cells =
                    resident.of(points.step).upTo(*points.step, points.selection->drawn.size());
                render::FlatPoints flat;
                ASSERT_TRUE(flat.draw(plan, points, cells, nullptr, PixelFormat::srgb8, {}));
                points.look.opacity = opacity;
                const render::FullCount full = render::fullOfAnyColor(points.look);
                const auto sums = render::valueSums(plan, points, cells, std::stop_token(), true).value();
                EXPECT_EQ(sums.counted, flat.pointsDrawn());
                for (std::size_t i = 0; i < flat.counts().size(); ++i)
                    EXPECT_EQ(std::min<std::uint64_t>(sums.words[2 * i + 1], full),
                              std::min(flat.counts()[i], full))
                        << i;
            }
        }
    }
}

TEST_F(CpuTurns, EveryKindOfPictureComesToTheSameBytes) {
    Quality moving;  // points that are streamed, or of a preview
    moving.pointFraction = 0.5;
    for (const char* name : {"twoLayers", "discs", "haloOnly", "dotPlane", "dotsAlone", "onePixel"}) {
        SCOPED_TRACE(name);
        auto scene = makeScene(name);
        for (const auto& quality : {Quality::exact(), moving}) {
            auto plan = render::makeFramePlan(scene, quality);
            expectTheSame(plan, small_);
            expectTheSame(plan, plan);
            EXPECT_GT(turns_, 3);
        }
    }
}

TEST_F(CpuTurns, PointsThatAreColoredByTheirValueToo) {
    for (const char* name : {"haloOnly", "twoLayers", "discs"}) {
        for (const bool nearest : {false, true}) {
            SCOPED_TRACE(name);
            auto plan = render::makeFramePlan(makeScene(name), Quality::exact());
            colorByValue(plan, nearest);
            expectTheSame(plan, small_);
            EXPECT_GT(turns_, 5);
        }
    }
}

TEST_F(CpuTurns, AndStrokes) {
    auto plan = render::makeFramePlan(makeScene("unlinked"), Quality::exact());
    addStrokes(plan, strokesFor(plan, 11), 0.0, 100.0);
    expectTheSame(plan, small_);
    EXPECT_GT(turns_, 9);
}

TEST_F(CpuTurns, WhatIsGivenUpAnywhereLeavesNoTrace) {
    const auto plan = render::makeFramePlan(makeScene("dotPlane"), Quality::exact());
    const auto expected = drawnAtOnce(plan);
    drawnInTurns(plan, small_);
    for (int turns = 0, all = turns_; turns < all; turns += 1 + all / 12) {
        const auto begun = device_.begin(plan, PixelFormat::srgb8, std::stop_token());
        for (int i = 0; i < turns; ++i) begun->advance(others_.get_token());
        begun->giveUp();
        EXPECT_TRUE(drawnAtOnce(plan).pixels == expected.pixels) << "given up after " << turns << " turns";
    }
}

TEST_F(CpuTurns, WhatWaitsMayOutliveItsDevice) {
    const auto plan = render::makeFramePlan(makeScene("dotPlane"), Quality::exact());
    std::unique_ptr<render::UnfinishedPicture> left;
    {
        render::CpuDevice device({.threads = 2, .leastTurn = none});
        left = device.begin(plan, PixelFormat::srgb8, std::stop_token());
        EXPECT_FALSE(left->advance(others_.get_token()));
        EXPECT_FALSE(left->advance(others_.get_token()));
    }
    left.reset();
}

}  // namespace
}  // namespace mote::test
