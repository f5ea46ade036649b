// SPDX-License-Identifier: GPL-3.0-or-later
//
// Raw volumes: every type in both byte orders, bytes before the numbers, gzip, and options that contradict
// the file.
#include <gmock/gmock.h>

#include <limits>

#include "tests/support/deflate.h"
#include "tests/support/must.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/quiet_progress.h"
#include "tests/unit/volume/volume_files.h"

namespace mote::test {
namespace {

using testing::ElementsAreArray;
using testing::HasSubstr;

proto::VolumeSourceOptions rawOptions(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz,
                                      const std::string& type = "") {
    proto::VolumeSourceOptions options;
    for (const auto n : {nx, ny, nz}) options.add_dimensions(n);
    options.set_type(type);
    return options;
}

TEST(RawVolume, IsReadInEveryTypeAndByteOrder) {
    const TempDir folder;
    const auto numbers = countedNumbers(60);
    for (const auto& type : scalarTypes()) {
        for (const bool big : {false, true}) {
            writeFile(folder / "a.raw", "head" + numberBytes(type, numbers, big));
            auto options = rawOptions(3, 4, 5, type);
            options.set_big_endian(big);
            options.set_header_bytes(4);
            const auto volume = must(readVolume(folder / "a.raw", options));
            EXPECT_EQ(volume.format, "raw");
            EXPECT_EQ(name(volume.shape.type), type);
            EXPECT_FALSE(volume.sequential);
            EXPECT_THAT(volume.values, ElementsAreArray(numbers)) << type << big;
        }
    }
}

TEST(RawVolume, KeepsTheExtremesOfItsTypes) {
    const TempDir folder;
    writeFile(folder / "a.raw", numberBytes<std::int16_t>({-32768, 32767}));
    EXPECT_THAT(readVolume(folder / "a.raw", rawOptions(2, 1, 1, "i16"))->values,
                testing::ElementsAre(-32768.0F, 32767.0F));
    writeFile(folder / "a.raw", numberBytes<std::uint32_t>({4294967295.0, 16777217.0}));
    EXPECT_THAT(readVolume(folder / "a.raw", rawOptions(2, 1, 1, "u32"))->values,
                testing::ElementsAre(4294967296.0F, 16777216.0F));
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    writeFile(folder / "a.raw", numberBytes<double>({nan, -inf, 0.1}));
    EXPECT_THAT(readVolume(folder / "a.raw", rawOptions(3, 1, 1, "f64"))->values,
                testing::ElementsAre(testing::IsNan(), -inf, 0.1F));
}

TEST(RawVolume, MayBeGzippedAndIsReadInAnyOrder) {
    const TempDir folder;
    const auto numbers = countedNumbers(120);
    writeFile(folder / "a.raw.gz", gzipped("12345678" + numberBytes<std::uint8_t>(numbers)));
    auto options = rawOptions(4, 5, 6);
    options.set_header_bytes(8);
    QuietProgress progress;
    auto source = must(prep::openVolumeSource(options, folder / "a.raw.gz", progress));
    EXPECT_TRUE(source->sequential());
    std::vector<float> slab(40);
    for (const std::uint32_t z : {0u, 2u, 4u, 1u, 4u, 0u}) {
        ASSERT_TRUE(source->read(z, z + 2, slab).ok());
        EXPECT_THAT(slab, ElementsAreArray(numbers.data() + z * 20, 40)) << z;
    }
}

TEST(RawVolume, LiesWhereTheOptionsSay) {
    const TempDir folder;
    writeFile(folder / "a.raw", std::string(8, 'x'));
    auto options = rawOptions(2, 2, 2);
    for (const double spacing : {0.5, 1.0, 3.0}) options.add_spacing(spacing);
    for (const double origin : {10.0, 20.0, -30.0}) options.add_origin(origin);
    const auto volume = must(readVolume(folder / "a.raw", options));
    EXPECT_EQ(worldOf(volume.shape, 0, 0, 0), glm::dvec3(10, 20, -30));
    EXPECT_EQ(worldOf(volume.shape, 1, 1, 1), glm::dvec3(10.5, 21, -27));
}

TEST(RawVolume, ContradictionsAreRefused) {
    const TempDir folder;
    writeFile(folder / "a.raw", std::string(60, 'x'));
    writeFile(folder / "a.raw.gz", gzipped(std::string(60, 'x')));
    const auto error = [&](std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, const std::string& type = "",
                           const char* file = "a.raw") {
        return volumeError(folder / file, rawOptions(nx, ny, nz, type));
    };
    EXPECT_EQ(error(3, 4, 5), "");
    EXPECT_EQ(error(3, 4, 6), "corrupt: a.raw: its dimensions 3 x 4 x 6 of u8 are 72 bytes, and it holds 60");
    EXPECT_THAT(error(3, 4, 4), HasSubstr("48 bytes, and it holds 60"));
    EXPECT_EQ(error(3, 4, 5, "", "a.raw.gz"), "");
    EXPECT_THAT(error(3, 4, 6, "", "a.raw.gz"), HasSubstr("72 bytes, and it holds less"));
    EXPECT_THAT(error(3, 4, 4, "", "a.raw.gz"), HasSubstr("48 bytes, and it holds more"));
    EXPECT_THAT(error(0, 4, 5), HasSubstr("invalid_argument: dimensions: says 0 x 4 x 5: no voxels"));
    EXPECT_THAT(error(1000000, 1000000, 1000000), HasSubstr("at most 65536 are read along an axis"));
    EXPECT_THAT(error(3, 4, 5, "f24"), HasSubstr("invalid_argument: type: \"f24\" is none of u8"));
    EXPECT_THAT(error(3, 4, 5, "", "none.raw"), HasSubstr("not_found: none.raw"));
    EXPECT_THAT(volumeError(folder.path(), rawOptions(3, 4, 5)), HasSubstr("is not a regular file"));
}

// A file of 65536^3 values would be 256 TiB; what it declares is held against it before memory is taken.
TEST(RawVolume, BombsAreRefused) {
    const TempDir folder;
    writeFile(folder / "bomb.gz", gzipped(std::string(1 << 20, '\0')));
    EXPECT_THAT(volumeError(folder / "bomb.gz", rawOptions(65536, 65536, 65536)),
                HasSubstr("and it holds at most"));
    EXPECT_THAT(volumeError(folder / "bomb.gz", rawOptions(1, 1, 1)), HasSubstr("and it holds more"));
}

TEST(RawVolume, CutGzipIsRefused) {
    const TempDir folder;
    const auto whole = gzipped(numberBytes<std::uint8_t>(countedNumbers(120)));
    writeFile(folder / "a.gz", whole.substr(0, whole.size() - 12));
    EXPECT_EQ(volumeError(folder / "a.gz", rawOptions(4, 5, 6)), "corrupt: a.gz: its gzip data is cut short");
    std::string damaged = whole;
    damaged[whole.size() / 2] ^= 0x55;
    writeFile(folder / "a.gz", damaged);
    EXPECT_EQ(volumeError(folder / "a.gz", rawOptions(4, 5, 6)), "corrupt: a.gz: its gzip data is damaged");
}

TEST(RawVolume, WrongOptionsAreRefused) {
    const TempDir folder;
    writeFile(folder / "a.raw", std::string(8, 'x'));
    const auto error = [&](auto change) {
        auto options = rawOptions(2, 2, 2);
        change(options);
        return volumeError(folder / "a.raw", options);
    };
    EXPECT_THAT(error([](auto& options) { options.add_dimensions(2); }), HasSubstr("needs three"));
    EXPECT_THAT(error([](auto& options) { options.add_spacing(1); }), HasSubstr("spacing: needs three"));
    EXPECT_THAT(error([](auto& options) { options.add_origin(1); }), HasSubstr("origin: needs three"));
    EXPECT_THAT(error([](auto& options) {
                    for (int i = 0; i < 3; ++i) options.add_spacing(0);
                }),
                HasSubstr("spacing: is not over 0"));
    EXPECT_THAT(error([](auto& options) {
                    for (int i = 0; i < 3; ++i) options.add_origin(std::numeric_limits<double>::infinity());
                }),
                HasSubstr("is no place"));
    EXPECT_THAT(error([](auto& options) { options.set_format("tar"); }), HasSubstr("\"tar\" is none of"));
    EXPECT_THAT(error([](auto& options) { options.set_header_bytes(~std::uint64_t{0}); }),
                HasSubstr("and it holds 0"));
}

}  // namespace
}  // namespace mote::test
