// SPDX-License-Identifier: GPL-3.0-or-later
//
// Volumes that other people's programs wrote, against what another reading of their bytes (NumPy, by the
// formats' definitions) gave: extremes, values here and there, and a sum in which every voxel has its weight.
#include <gmock/gmock.h>

#include <array>

#include "tests/support/must.h"
#include "tests/unit/volume/volume_files.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;

struct Known {
    const char* file;
    const char* format;
    std::array<std::uint32_t, 3> size;
    const char* type;
    double least, greatest;
    std::int64_t sum, weighted;  ///< weighted: by the voxel's index modulo 997
    float middle;                ///< at half of each dimension
    glm::dvec3 origin, spacing;
};

class RealVolumes : public testing::TestWithParam<Known> {};

TEST_P(RealVolumes, HaveTheirValues) {
    const Known& known = GetParam();
    const auto path = fs::path(MOTE_SHARED_DATA) / "volumes" / known.file;
    if (!fs::exists(path)) GTEST_SKIP() << "the real file is not here";
    proto::VolumeSourceOptions options;
    if (std::string_view(known.format) == "raw") {
        for (const auto n : known.size) options.add_dimensions(n);
    }
    const auto volume = must(readVolume(path, options));
    const auto& shape = volume.shape;
    EXPECT_EQ(volume.format, known.format);
    EXPECT_EQ((std::array{shape.nx, shape.ny, shape.nz}), known.size);
    EXPECT_EQ(name(shape.type), known.type);
    const auto [least, greatest] = std::minmax_element(volume.values.begin(), volume.values.end());
    EXPECT_EQ(*least, known.least);
    EXPECT_EQ(*greatest, known.greatest);
    std::int64_t sum = 0, weighted = 0;
    for (std::size_t i = 0; i < volume.values.size(); ++i) {
        const auto value = static_cast<std::int64_t>(volume.values[i]);
        sum += value;
        weighted += value * static_cast<std::int64_t>(i % 997);
    }
    EXPECT_EQ(sum, known.sum);
    EXPECT_EQ(weighted, known.weighted);
    const auto middle =
        shape.nx / 2 + std::size_t{shape.nx} * (shape.ny / 2 + std::size_t{shape.ny} * (shape.nz / 2));
    EXPECT_EQ(volume.values[middle], known.middle);
    EXPECT_EQ(worldOf(shape, 0, 0, 0), known.origin);
    // Decimal spacings are rounded once.
    EXPECT_LT(glm::length(worldOf(shape, 1, 1, 1) - known.origin - known.spacing), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(All, RealVolumes,
                         testing::Values(Known{"engine_256x256x128_uint8.raw.gz",
                                               "raw",
                                               {256, 256, 128},
                                               "u8",
                                               0,
                                               255,
                                               187475057,
                                               93394903725,
                                               133,
                                               {0, 0, 0},
                                               {1, 1, 1}},
                                         Known{"ct_chest_abdomen_512x512x134_int16.nrrd",
                                               "nrrd",
                                               {512, 512, 134},
                                               "i16",
                                               -1000,
                                               1988,
                                               -24950407038,
                                               -12424852564553,
                                               82,
                                               {0, 0, 0},
                                               {1.07421875, 1.07421875, 3.0}},
                                         Known{"frog_500x470x136_uint8.nrrd",
                                               "nrrd",
                                               {500, 470, 136},
                                               "u8",
                                               0,
                                               254,
                                               576245255,
                                               286963360693,
                                               31,
                                               {0, 0, 0},
                                               {1, 1, 1.5}},
                                         // Its origin is stored in single precision.
                                         Known{"torso_ct_122x101x112_3mm.nii.gz",
                                               "nifti",
                                               {122, 101, 112},
                                               "i32",
                                               -1207,
                                               3382,
                                               -496851173,
                                               -247279329021,
                                               164,
                                               {-177.95632934570312, 11.319000244140625, 94.3017578125},
                                               {3, 3, 3}}),
                         [](const auto& sample) {
                             const std::string name = sample.param.file;
                             return name.substr(0, name.find('_'));
                         });

}  // namespace
}  // namespace mote::test
