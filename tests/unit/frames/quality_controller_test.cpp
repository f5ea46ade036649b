// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/quality_controller.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace mote::server {
namespace {

using render::Quality;

/// A device whose pictures cost what the model does not know: a constant, a cost a point, one a pixel and
/// slab.
struct SimulatedDevice {
    double constantMs, perPoint, perPixelSlab, perSample;

    double render(QualityController& controller, const ViewLoad& load, const Quality& quality) const {
        const double pixels = load.pixels * quality.resolutionScale * quality.resolutionScale;
        const double points = load.points * quality.pointFraction;
        const double ms = constantMs + perPoint * points + perPixelSlab * pixels * quality.slabs +
                          perSample * pixels * quality.samplesPerCell;
        controller.learn(pixels, points, quality, ms);
        return ms;
    }
};

constexpr ViewLoad hd{1280.0 * 720.0, 10e6};

TEST(QualityController, CheapPicturesAreSoonExact) {
    const SimulatedDevice gpu{0.5, 1e-7, 5e-9, 1e-7};
    QualityController controller(30.0);
    for (int i = 0; i < 6; ++i) gpu.render(controller, hd, controller.quick(hd));
    EXPECT_EQ(controller.quick(hd), Quality::exact());
    EXPECT_FALSE(controller.worthIntermediate(hd));
}

/// From a first guess that may be far off, within a few pictures the time is near the budget: never twice it,
/// and not less than half of it unless everything is drawn.
TEST(QualityController, QuickPicturesSettleNearTheBudget) {
    const SimulatedDevice devices[] = {
        {1.0, 25e-6, 1e-7, 4e-6},   // a software rasteriser
        {2.0, 100e-6, 1e-7, 2e-6},  // points are dear
        {1.0, 5e-6, 6e-7, 3e-6},    // pixels are dear
        {0.3, 1e-6, 1e-8, 2e-7},
    };
    for (const auto& device : devices) {
        QualityController controller(30.0);
        double ms = 0.0;
        Quality quality;
        for (int i = 0; i < 12; ++i) {
            quality = controller.quick(hd);
            ms = device.render(controller, hd, quality);
        }
        EXPECT_LT(ms, 60.0);
        EXPECT_TRUE(quality.pointFraction == 1.0 || ms > 15.0) << ms;
    }
}

TEST(QualityController, FollowsAViewThatBecomesDearer) {
    const SimulatedDevice device{1.0, 25e-6, 1e-7, 4e-6};
    QualityController controller(30.0);
    const ViewLoad light{1280.0 * 720.0, 0.2e6};
    for (int i = 0; i < 10; ++i) device.render(controller, light, controller.quick(light));
    double ms = 0.0;
    for (int i = 0; i < 6; ++i) ms = device.render(controller, hd, controller.quick(hd));
    EXPECT_LT(ms, 60.0);
}

/// The first picture of a step carries its upload.
TEST(QualityController, OneSlowPictureIsForgiven) {
    const SimulatedDevice device{1.0, 5e-6, 1e-8, 1e-6};
    QualityController controller(30.0);
    for (int i = 0; i < 10; ++i) device.render(controller, hd, controller.quick(hd));
    const Quality before = controller.quick(hd);
    controller.learn(hd.pixels, hd.points * before.pointFraction, before, 2500.0);
    for (int i = 0; i < 8; ++i) device.render(controller, hd, controller.quick(hd));
    EXPECT_GT(controller.quick(hd).pointFraction, 0.6 * before.pointFraction);
    EXPECT_EQ(controller.quick(hd).resolutionScale, before.resolutionScale);
}

TEST(QualityController, ScaleDoesNotFlicker) {
    const SimulatedDevice device{1.0, 5e-6, 6e-7, 3e-6};
    QualityController controller(30.0);
    int changes = 0;
    double scale = 1.0;
    for (int i = 0; i < 100; ++i) {
        const Quality quality = controller.quick(hd);
        if (i > 5 && quality.resolutionScale != scale) ++changes;
        scale = quality.resolutionScale;
        device.render(controller, hd, quality);
    }
    EXPECT_EQ(changes, 0);
}

/// What takes the processors beside a hand (the browser that shows its pictures) is there only while it
/// moves, and comes and goes: neither the rest before it nor a moment's peace brings pictures that take too
/// long.
TEST(QualityController, ABusyMachineDoesNotMakeTheResolutionFlicker) {
    const ViewLoad load{hd.pixels, 0.2e6};
    int runs = 0, late = 0;
    const auto orbit = [&](double perPoint, double perSlab, auto others) {
        QualityController controller(30.0);
        const auto device = [&](double busy) {
            return SimulatedDevice{1.0, perPoint * busy, perSlab * busy, 4.0 * perSlab * busy};
        };
        for (int i = 0; i < 4; ++i) device(1.0).render(controller, load, Quality::exact());
        int changes = 0;
        double scale = 1.0;
        for (int i = 0; i < 300; ++i) {
            const Quality quality = controller.quick(load);
            late += device(others(i)).render(controller, load, quality) > 45.0 ? 1 : 0;
            changes += quality.resolutionScale != scale ? 1 : 0;
            scale = quality.resolutionScale;
        }
        ++runs;
        return changes;
    };
    for (const double perSlab : {1e-7, 3e-7, 6e-7, 1.2e-6}) {
        for (const double perPoint : {5e-6, 50e-6}) {
            for (const double level : {1.0, 1.4, 1.8, 2.5}) {
                for (const double period : {0.11, 0.4, 0.9, 2.1}) {
                    const auto others = [&](int i) { return level * (1.0 + 0.5 * std::sin(period * i)); };
                    EXPECT_LE(orbit(perPoint, perSlab, others), 10)
                        << perSlab << ' ' << level << ' ' << period;
                }
            }
        }
    }
    EXPECT_LT(late, 2 * runs);
}

TEST(QualityController, AThirdOfTheResolutionWhereHalfTakesTooLong) {
    const SimulatedDevice device{1.0, 5e-6, 8e-6, 3e-6};  // half takes more than all of the time
    const ViewLoad volume{hd.pixels, 0.0};
    QualityController controller(30.0);
    for (int i = 0; i < 30; ++i) device.render(controller, volume, controller.quick(volume));
    EXPECT_EQ(controller.quick(volume).resolutionScale, 1.0 / 3.0);
}

/// Points of one pixel: 131,072 of them may grow, of more a fifth keeps its light in whole pixels.
TEST(QualityController, FewerPixelsWhereManyPointsWouldLoseLight) {
    for (const double perPoint : {5e-6, 12e-6, 25e-6, 60e-6, 100e-6}) {
        for (const double points : {0.5e6, 2e6, 10e6, 50e6}) {
            const SimulatedDevice device{1.0, perPoint, 1e-8, 1e-6};
            const ViewLoad load{hd.pixels, points};
            QualityController controller(30.0);
            int changes = 0;
            Quality quality;
            for (int i = 0; i < 60; ++i) {
                const double before = quality.resolutionScale;
                quality = controller.quick(load);
                if (i > 40 && quality.resolutionScale != before) ++changes;
                device.render(controller, load, quality);
            }
            const double share = quality.pointFraction, scale = quality.resolutionScale;
            EXPECT_EQ(changes, 0);
            EXPECT_TRUE(share * points <= 1 << 17 || share >= 0.199 * scale * scale || scale < 0.4)
                << perPoint << ' ' << points << ' ' << share << ' ' << scale;
            EXPECT_TRUE(share < 1.0 || scale == 1.0);
        }
    }
}

TEST(QualityController, ACalibratedDeviceIsTrustedFromTheFirstPicture) {
    const SimulatedDevice device{0.5, 4e-6, 1e-8, 1e-6};
    QualityController controller(30.0);
    controller.startFrom({4.0, 6.0});
    const Quality first = controller.quick(hd);
    const double ms = device.render(controller, hd, first);
    EXPECT_GT(ms, 8.0);
    EXPECT_LT(ms, 45.0);
    controller.startFrom({1000.0, 1000.0});  // too late: it has learned
    EXPECT_GE(controller.quick(hd).pointFraction, first.pointFraction);
}

/// Points must not come and go while a view turns, though times vary from picture to picture.
TEST(QualityController, TheShareOfPointsIsSteady) {
    QualityController controller(30.0);
    int changes = 0;
    double share = 0.0;
    for (int i = 0; i < 60; ++i) {
        const Quality quality = controller.quick(hd);
        if (i > 12 && quality.pointFraction != share) ++changes;
        share = quality.pointFraction;
        const double noise = 1.0 + 0.15 * std::sin(2.1 * i);
        controller.learn(hd.pixels, hd.points * share, quality,
                         noise * (1.0 + 8e-6 * hd.points * share + 1e-6 * hd.pixels));
        EXPECT_EQ(std::fmod(-2.0 * std::log2(share), 1.0), 0.0);
    }
    EXPECT_LE(changes, 1);
}

TEST(QualityController, AShareLittleAboveThePreviewIsThePreview) {
    QualityController controller(30.0);
    controller.startFrom({30.0, 1.0});
    ViewLoad load{1280.0 * 720.0, 20e6, 0.02};  // the first picture dares a fortieth of it
    EXPECT_EQ(controller.quick(load).pointFraction, 0.02);
    load.previewShare = 0.001;  // far below what fits
    EXPECT_GT(controller.quick(load).pointFraction, 0.01);
    load.previewShare = 0.2;  // any smaller share comes from it, too
    EXPECT_LT(controller.quick(load).pointFraction, 0.06);
}

TEST(QualityController, LongExactPicturesGetOneBetween) {
    const SimulatedDevice device{1.0, 25e-6, 1e-6, 4e-6};
    QualityController controller(30.0);
    const ViewLoad huge{1920.0 * 1080.0, 50e6};
    for (int i = 0; i < 8; ++i) device.render(controller, huge, controller.quick(huge));
    EXPECT_TRUE(controller.worthIntermediate(huge));
    const Quality between = controller.intermediate(huge);
    EXPECT_EQ(between.resolutionScale, 1.0);
    EXPECT_LT(controller.expectedMs(huge, between), controller.expectedMs(huge, Quality::exact()) / 2);
    EXPECT_GT(between.pointFraction, controller.quick(huge).pointFraction);
}

/// Whatever was measured (a sleeping machine, a clock that stood still), what comes out can be rendered.
TEST(QualityController, StrangeMeasurementsGiveValidQualities) {
    QualityController controller(30.0);
    for (const double ms : {0.0, 1e-9, 1e6, 0.0, 30.0, 1e9}) {
        for (const ViewLoad& load : {ViewLoad{1.0, 0.0}, ViewLoad{3.3e7, 1e9}, hd}) {
            controller.learn(load.pixels, load.points, Quality::exact(), ms);
            const Quality quality = controller.quick(load);
            EXPECT_TRUE(quality.pointFraction > 0.0 && quality.pointFraction <= 1.0);
            EXPECT_TRUE(quality.resolutionScale > 0.0 && quality.resolutionScale <= 1.0);
            EXPECT_TRUE(std::isfinite(controller.expectedMs(load, quality)));
        }
    }
}

}  // namespace
}  // namespace mote::server
