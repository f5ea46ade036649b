// SPDX-License-Identifier: GPL-3.0-or-later
//
// The cpu device by all kinds of vectors that this processor has, and on any number of threads.
#include <gtest/gtest.h>

#include <string>

#include "server/render/cpu/cpu_device.h"
#include "tests/golden/comparison.h"
#include "tests/golden/device_pictures.h"
#include "tests/golden/golden_scenes.h"
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
        // Sums are rounded differently where there is no fused multiply-add, and a steep density is cut as
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

TEST(CpuVectors, TheNumberOfThreadsChangesNoByte) {
    const auto scene = makeScene("orthographicInside");
    CpuDevice one({.threads = 1}), three({.threads = 3});
    EXPECT_EQ(picture(one, scene, Quality::exact()), picture(three, scene, Quality::exact()));
    EXPECT_NE(one.name().find("1 thread)"), std::string::npos) << one.name();
    EXPECT_NE(three.name().find("3 threads)"), std::string::npos) << three.name();
}

}  // namespace
}  // namespace mote::test
