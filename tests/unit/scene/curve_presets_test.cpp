// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/curve_presets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace mote {
namespace {

/// A dark ground with an object in it: most values in the first bins, some around the bin 160.
std::vector<std::uint64_t> objectOnGround() {
    std::vector<std::uint64_t> bins(256, 0);
    for (std::size_t i = 0; i < 8; ++i) bins[i] = 100000;
    for (std::size_t i = 140; i < 180; ++i) bins[i] = 1000;
    return bins;
}

void expectOrdered(const CurvePreset& preset) {
    ASSERT_FALSE(preset.knots.empty()) << preset.name;
    for (std::size_t i = 0; i < preset.knots.size(); ++i) {
        EXPECT_GE(preset.knots[i].y, 0.0) << preset.name;
        EXPECT_LE(preset.knots[i].y, 1.0) << preset.name;
        EXPECT_GE(preset.knots[i].x, preset.knots[i > 0 ? i - 1 : 0].x) << preset.name;
    }
    EXPECT_TRUE(preset.colors.empty() || preset.colors.size() == preset.knots.size()) << preset.name;
}

/// Linear between knots, level beyond them.
double opacity(const CurvePreset& preset, double value) {
    if (value <= preset.knots.front().x) return preset.knots.front().y;
    for (std::size_t i = 1; i < preset.knots.size(); ++i) {
        const auto &a = preset.knots[i - 1], &b = preset.knots[i];
        if (value < b.x) return a.y + (b.y - a.y) * (value - a.x) / (b.x - a.x);
    }
    return preset.knots.back().y;
}

const CurvePreset& named(std::span<const CurvePreset> presets, std::string_view name) {
    return *std::find_if(presets.begin(), presets.end(), [&](auto& each) { return each.name == name; });
}

TEST(CurvePresets, TomographyShowsWhatItsNameSays) {
    const auto presets = tomographyPresets();
    for (const auto& preset : presets) {
        expectOrdered(preset);
        EXPECT_EQ(opacity(preset, -1000.0), 0.0) << preset.name << " lets the eye through air";
    }
    const double lung = -750.0, fat = -100.0, muscle = 50.0, contrast = 350.0, bone = 1200.0;
    EXPECT_EQ(opacity(named(presets, "bones"), muscle), 0.0);
    EXPECT_GT(opacity(named(presets, "bones"), bone), 0.7);
    EXPECT_EQ(opacity(named(presets, "vessels"), muscle), 0.0);
    EXPECT_GT(opacity(named(presets, "vessels"), contrast), opacity(named(presets, "bones"), contrast));
    EXPECT_EQ(opacity(named(presets, "soft tissue"), fat), 0.0);
    EXPECT_GT(opacity(named(presets, "soft tissue"), muscle), 0.0);
    EXPECT_GT(opacity(named(presets, "skin"), fat), 0.3);
    EXPECT_GT(opacity(named(presets, "lungs"), lung), 0.0);
    EXPECT_EQ(opacity(named(presets, "lungs"), muscle), 0.0);
}

TEST(CurvePresets, HounsfieldUnitsAreKnownByTheirNameOrTheirRange) {
    EXPECT_TRUE(inHounsfieldUnits("HU", {0.0, 255.0}));
    EXPECT_FALSE(inHounsfieldUnits("K", {-1024.0, 3071.0}));
    EXPECT_TRUE(inHounsfieldUnits("", {-1024.0, 3071.0}));
    EXPECT_TRUE(inHounsfieldUnits("", {-1000.0, 1500.0}));
    EXPECT_FALSE(inHounsfieldUnits("", {0.0, 255.0}));
    EXPECT_FALSE(inHounsfieldUnits("", {-32768.0, 32767.0}));
}

/// Of -1000 to 1560 HU in 256 bins: air, muscles, and bones that become fewer by e every `fall` HU.
std::vector<std::uint64_t> bodyWithBones(double fall) {
    std::vector<std::uint64_t> bins(256, 0);
    for (std::size_t i = 0; i < 10; ++i) bins[i] = 1000000;
    for (std::size_t i = 102; i < 110; ++i) bins[i] = 200000;  // to 100
    for (std::size_t i = 110; i < bins.size(); ++i)
        bins[i] =
            static_cast<std::uint64_t>(6000.0 * std::exp(-(static_cast<double>(i) - 110.0) * 10.0 / fall));
    return bins;
}

/// Values around middles, each with its share and its spread, in 256 bins over a range.
struct Hump {
    double middle, share, spread;
};
std::vector<std::uint64_t> humps(const ValueRange& values, const std::vector<Hump>& all) {
    std::vector<std::uint64_t> bins(256, 0);
    for (std::size_t i = 0; i < bins.size(); ++i) {
        const double at = values.low + (static_cast<double>(i) + 0.5) / 256.0 * (values.high - values.low);
        for (const auto& [middle, share, spread] : all)
            bins[i] += static_cast<std::uint64_t>(
                1e6 * share * std::exp(-0.5 * (at - middle) * (at - middle) / (spread * spread)));
    }
    return bins;
}

constexpr Hump fatOfPatient{-95.0, 0.4, 25.0}, muscles{55.0, 0.5, 25.0}, bonesOfPatient{450.0, 0.05, 250.0};

TEST(CurvePresets, APartOfAPatientWithoutAirIsKnownByItsTissue) {
    for (const ValueRange& values : {ValueRange{-150.0, 1270.0}, ValueRange{-438.0, 1288.0}}) {
        const auto part = humps(values, {fatOfPatient, muscles, bonesOfPatient});
        EXPECT_TRUE(inHounsfieldUnits("", values, part));
        EXPECT_FALSE(inHounsfieldUnits("K", values, part));
        EXPECT_FALSE(inHounsfieldUnits("", values));
        EXPECT_EQ(presetsOf("", values, part).front().name, "bones");
    }
    const ValueRange values{-438.0, 1288.0};
    const auto noise = humps(values, {{0.0, 0.5, 60.0}});
    EXPECT_FALSE(inHounsfieldUnits("", values, noise)) << "most is water";
    EXPECT_FALSE(inHounsfieldUnits("", values, humps(values, {muscles, {600.0, 0.5, 200.0}})))
        << "most is no tissue";
    EXPECT_FALSE(inHounsfieldUnits("", values, humps(values, {muscles, {-300.0, 0.1, 30.0}})))
        << "more is lighter than denser";
    EXPECT_FALSE(inHounsfieldUnits("", {-438.0, 290.0}, humps({-438.0, 290.0}, {muscles})));
    EXPECT_FALSE(inHounsfieldUnits("", {-438.0, 30000.0}, humps({-438.0, 30000.0}, {muscles})))
        << "bins are too wide to tell";
}

TEST(CurvePresets, APatientIsShownByWhatThereIs) {
    const ValueRange values{-1000.0, 1560.0};
    const Hump air{-1000.0, 1.0, 20.0}, lung{-800.0, 0.9, 80.0};
    const auto best = [&](const std::vector<Hump>& all) {
        return presetsOf("HU", values, humps(values, all)).front().name;
    };
    EXPECT_EQ(best({air, fatOfPatient, muscles, bonesOfPatient}), "bones");
    EXPECT_EQ(best({air, fatOfPatient, muscles}), "soft tissue");
    EXPECT_EQ(best({air, muscles, {1000.0, 1e-5, 20.0}}), "soft tissue") << "a few specks";
    EXPECT_EQ(best({lung, {50.0, 0.1, 25.0}}), "lungs");
    EXPECT_EQ(presetsOf("HU", values, {}).front().name, "bones");
    EXPECT_EQ(presetsOf("HU", values, humps(values, {muscles})).size(),
              presetsOf("HU", values, bodyWithBones(170.0)).size());
}

TEST(CurvePresets, BonesBeginWhereNothingElseIs) {
    const ValueRange values{-1000.0, 1560.0};
    for (const double fall : {120.0, 170.0, 300.0})
        EXPECT_EQ(boneThreshold(bodyWithBones(fall), values), 150.0) << fall;
    auto withBlood = bodyWithBones(170.0);
    for (std::size_t i = 119; i < 127; ++i) withBlood[i] += 4000;  // 190 to 270, of a contrast agent
    EXPECT_EQ(boneThreshold(withBlood, values), 270.0);
    auto withOrgans = bodyWithBones(170.0);
    for (std::size_t i = 110; i < 118; ++i) withOrgans[i] += 20000;  // to 180
    EXPECT_EQ(boneThreshold(withOrgans, values), 180.0);
    auto dense = bodyWithBones(170.0);
    for (std::size_t i = 124; i < 129; ++i) dense[i] += 4000;  // 240 to 290
    EXPECT_EQ(boneThreshold(dense, values), 290.0);

    const auto bones = presetsOf("HU", values, bodyWithBones(170.0)).front();
    expectOrdered(bones);
    EXPECT_EQ(opacity(bones, 149.0), 0.0);
    EXPECT_GT(opacity(bones, 151.0), 0.4);
}

TEST(CurvePresets, WhereBonesAreNotToldTheyBeginAsEver) {
    const ValueRange values{-1000.0, 1560.0};
    EXPECT_EQ(boneThreshold({}, values), 290.0);
    EXPECT_EQ(boneThreshold(std::vector<std::uint64_t>(256, 0), values), 290.0);
    EXPECT_EQ(boneThreshold(std::vector<std::uint64_t>(256, 9), values), 290.0) << "does not fall";
    EXPECT_EQ(boneThreshold(std::vector<std::uint64_t>{1000, 1}, values), 290.0) << "too coarse";
    auto few = bodyWithBones(170.0);
    for (auto& count : few) count /= 1000;
    EXPECT_EQ(boneThreshold(few, values), 290.0);
    EXPECT_EQ(presetsOf("HU", values, {}).front().knots.front().x, 290.0);
}

TEST(CurvePresets, HistogramPresetsLeaveTheGroundOut) {
    const auto presets = histogramPresets(objectOnGround(), {-1.0, 1.0});
    const auto valueOf = [](double bin) { return -1.0 + bin / 128.0; };
    for (const auto& preset : presets) expectOrdered(preset);
    for (const char* name : {"object", "denser parts", "densest", "layers"}) {
        const auto& preset = named(presets, name);
        EXPECT_EQ(opacity(preset, valueOf(8.0)), 0.0) << name;
        double most = 0.0;
        for (double bin = 140.0; bin <= 180.0; bin += 0.25)
            most = std::max(most, opacity(preset, valueOf(bin)));
        EXPECT_GT(most, 0.0) << name;
    }
    EXPECT_GT(opacity(named(presets, "object"), valueOf(160.0)),
              opacity(named(presets, "densest"), valueOf(160.0)));
    EXPECT_GT(opacity(named(presets, "everything"), valueOf(9.0)), 0.0);
}

TEST(CurvePresets, HistogramPresetsOfOddHistogramsAreCurvesToo) {
    EXPECT_TRUE(histogramPresets({}, {0.0, 1.0}).empty());
    for (const std::size_t only : {0U, 100U, 255U}) {  // a constant volume
        std::vector<std::uint64_t> bins(256, 0);
        for (const auto& preset : histogramPresets(bins, {0.0, 1.0})) expectOrdered(preset);
        bins[only] = 7;
        for (const auto& preset : histogramPresets(bins, {0.0, 1.0})) expectOrdered(preset);
    }
}

}  // namespace
}  // namespace mote
