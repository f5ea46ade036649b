// SPDX-License-Identifier: GPL-3.0-or-later
//
// NIfTI volumes of both versions: types, byte orders, slope, sform and qform, files beside the header, and
// headers that contradict themselves or the file.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/support/deflate.h"
#include "tests/support/must.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/volume/volume_files.h"

namespace mote::test {
namespace {

using testing::ElementsAreArray;
using testing::HasSubstr;

/// A header of 3 x 4 x 5 voxels, by the offsets of nifti1.h and nifti2.h.
class Header {
  public:
    explicit Header(int version, bool bigEndian = false)
        : first_(version == 1), big_(bigEndian), bytes_(first_ ? 348 : 540, '\0') {
        put<std::int32_t>(0, first_ ? 348 : 540);
        magic(first_ ? "n+1" : "n+2");
        dim({3, 3, 4, 5});
        type(2);
        for (int i = 1; i < 4; ++i) pixdim(i, 1.0);
        offset(first_ ? 352 : 544);
    }

    void magic(const std::string& text) { bytes_.replace(first_ ? 344 : 4, 3, text); }
    void dim(const std::vector<double>& sizes) {
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            first_ ? put<std::int16_t>(40 + 2 * i, sizes[i]) : put<std::int64_t>(16 + 8 * i, sizes[i]);
        }
    }
    void type(double code) { put<std::int16_t>(first_ ? 70 : 12, code); }
    void offset(double bytes) { first_ ? put<float>(108, bytes) : put<std::int64_t>(168, bytes); }
    void pixdim(int i, double value) { real(first_ ? 76 : 104, i, value); }
    void slope(double slope, double intercept) {
        real(first_ ? 112 : 176, 0, slope);
        real(first_ ? 116 : 184, 0, intercept);
    }
    void unit(char code) { first_ ? put<char>(123, code) : put<std::int32_t>(500, code); }
    void qform(const std::vector<double>& quatern) {
        first_ ? put<std::int16_t>(252, 1) : put<std::int32_t>(344, 1);
        for (int i = 0; i < 6; ++i) real(first_ ? 256 : 352, i, quatern[static_cast<std::size_t>(i)]);
    }
    void sform(const std::vector<double>& rows) {
        first_ ? put<std::int16_t>(254, 2) : put<std::int32_t>(348, 2);
        for (int i = 0; i < 12; ++i) real(first_ ? 280 : 400, i, rows[static_cast<std::size_t>(i)]);
    }
    /// With an empty extension flag behind it.
    std::string bytes() const { return bytes_ + std::string(4, '\0'); }

  private:
    template <class Number>
    void put(std::size_t at, double value) {
        bytes_.replace(at, sizeof(Number), numberBytes<Number>({value}, big_));
    }
    void real(std::size_t at, int index, double value) {
        const auto i = static_cast<std::size_t>(index);
        first_ ? put<float>(at + 4 * i, value) : put<double>(at + 8 * i, value);
    }

    bool first_, big_;
    std::string bytes_;
};

class Nifti : public testing::TestWithParam<int> {
  protected:
    Result<WholeVolume> read(const std::string& bytes) {
        writeFile(folder_ / "a.nii", bytes);
        return readVolume(folder_ / "a.nii");
    }
    /// Of a header that `change` has changed, before 60 bytes.
    template <class Change>
    std::string error(Change change) {
        Header header(GetParam());
        change(header);
        writeFile(folder_ / "a.nii", header.bytes() + std::string(60, 'x'));
        return volumeError(folder_ / "a.nii");
    }

    TempDir folder_;
};

TEST_P(Nifti, IsReadInEveryTypeAndByteOrder) {
    const std::vector<std::pair<int, std::string>> types = {
        {2, "u8"}, {256, "i8"}, {512, "u16"}, {4, "i16"}, {768, "u32"}, {8, "i32"}, {16, "f32"}, {64, "f64"}};
    const auto numbers = countedNumbers(60);
    for (const auto& [code, type] : types) {
        for (const bool big : {false, true}) {
            Header header(GetParam(), big);
            header.type(code);
            const auto bytes = header.bytes() + numberBytes(type, numbers, big);
            for (const auto& file : {bytes, gzipped(bytes)}) {
                const auto volume = must(read(file));
                EXPECT_EQ(volume.format, "nifti");
                EXPECT_EQ(name(volume.shape.type), type);
                EXPECT_THAT(volume.values, ElementsAreArray(numbers)) << type << big;
            }
        }
    }
}

TEST_P(Nifti, SlopeAndInterceptAreApplied) {
    const auto first = [&](double slope, double intercept) {
        Header header(GetParam());
        header.slope(slope, intercept);
        const auto volume = read(header.bytes() + std::string(60, '\x04'));
        EXPECT_EQ(volume->shape.valueStep, slope == 2.5 ? 2.5 : 1.0);
        return volume->values.front();
    };
    EXPECT_EQ(first(2.5, -1024), -1014.0F);
    EXPECT_EQ(first(0, 7), 4.0F);  // no slope: neither
    EXPECT_EQ(first(std::nan(""), 7), 4.0F);
    EXPECT_EQ(first(1, std::numeric_limits<double>::infinity()), 4.0F);
}

TEST_P(Nifti, LiesWhereItsFormsSay) {
    const auto shapeOf = [&](const Header& header) {
        const auto volume = read(header.bytes() + std::string(60, 'x'));
        EXPECT_TRUE(volume.ok()) << (volume.ok() ? "" : volume.error().toString());
        return volume->shape;
    };
    Header header(GetParam());
    for (int i = 1; i < 4; ++i) header.pixdim(i, i);
    header.unit(2 + 8);  // mm and s
    EXPECT_EQ(worldOf(shapeOf(header), 1, 1, 1), glm::dvec3(1, 2, 3));
    EXPECT_EQ(shapeOf(header).worldUnit, "mm");
    // A quarter turn about z: a = d = sqrt(1/2). In single precision it is off by 1e-7.
    header.qform({0, 0, std::sqrt(0.5), 10, 20, 30});
    const auto near = [](glm::dvec3 a, glm::dvec3 b) { return glm::length(a - b) < 1e-5; };
    EXPECT_TRUE(near(worldOf(shapeOf(header), 1, 0, 0), {10, 21, 30}));
    EXPECT_TRUE(near(worldOf(shapeOf(header), 0, 1, 1), {8, 20, 33}));
    header.pixdim(0, -1);  // the third axis is turned round
    EXPECT_TRUE(near(worldOf(shapeOf(header), 0, 1, 1), {8, 20, 27}));
    header.qform({0, 0, 1, 10, 20, 30});  // a half turn: a = 0
    EXPECT_TRUE(near(worldOf(shapeOf(header), 1, 1, 0), {9, 18, 30}));
    header.sform({-2, 0, 0, 5, 0, 0, 3, 6, 0, 4, 0, 7});
    EXPECT_EQ(worldOf(shapeOf(header), 1, 1, 1), glm::dvec3(3, 9, 11));
}

TEST_P(Nifti, NumbersMayLieBesideTheHeader) {
    Header header(GetParam());
    header.magic(GetParam() == 1 ? "ni1" : "ni2");
    header.offset(0);
    const auto numbers = countedNumbers(60);
    writeFile(folder_ / "a.hdr", header.bytes());
    EXPECT_THAT(volumeError(folder_ / "a.hdr"), HasSubstr("not_found: a.hdr: has no .img file beside it"));
    writeFile(folder_ / "a.img.gz", gzipped(numberBytes<std::uint8_t>(numbers)));
    EXPECT_THAT(readVolume(folder_ / "a.hdr")->values, ElementsAreArray(numbers));
    writeFile(folder_ / "a.img", numberBytes<std::uint8_t>(numbers));
    EXPECT_THAT(readVolume(folder_ / "a.hdr")->values, ElementsAreArray(numbers));
}

TEST_P(Nifti, ContradictionsAreRefused) {
    EXPECT_EQ(error([](Header&) {}), "");
    EXPECT_THAT(error([](Header& h) { h.dim({3, 3, 4, 6}); }), HasSubstr("72 bytes, and it holds 60"));
    EXPECT_THAT(error([](Header& h) { h.dim({3, 3, 4, 0}); }), HasSubstr("dim: says 3 x 4 x 0"));
    EXPECT_THAT(error([](Header& h) { h.dim({3, 3, -4, 5}); }), HasSubstr("dim: says -4 voxels"));
    EXPECT_THAT(error([](Header& h) { h.dim({9, 3, 4, 5}); }), HasSubstr("dim: says 9 axes"));
    EXPECT_THAT(error([](Header& h) {
                    h.dim({4, 3, 4, 1, 5});
                }),
                HasSubstr("says 5 volumes: ask for one of"));
    EXPECT_THAT(error([](Header& h) {
                    h.dim({5, 3, 4, 1, 1, 5});
                }),
                HasSubstr("says 5 volumes: ask for one of"));
    EXPECT_THAT(error([](Header& h) { h.type(128); }), HasSubstr("unsupported: a.nii: datatype: 128 is no"));
    EXPECT_THAT(error([](Header& h) { h.offset(-1); }), HasSubstr("vox_offset: is -1"));
    EXPECT_THAT(error([](Header& h) { h.offset(1e9); }), HasSubstr("and it holds 0"));
    EXPECT_THAT(error([](Header& h) { h.sform(std::vector<double>(12, 1.0)); }),
                HasSubstr("srow: says axes"));
    EXPECT_THAT(error([](Header& h) { h.sform(std::vector<double>(12, std::nan(""))); }), HasSubstr("srow"));
    EXPECT_THAT(error([](Header& h) { h.qform(std::vector<double>(6, std::nan(""))); }),
                HasSubstr("quatern"));
    EXPECT_THAT(error([](Header& h) { h.magic("abc"); }),
                HasSubstr(GetParam() == 1 ? "unsupported: a.nii: is an Analyze 7.5 header"
                                          : "unsupported: a.nii: is no"));
    writeFile(folder_ / "a.nii", Header(GetParam()).bytes().substr(0, 300));
    EXPECT_THAT(volumeError(folder_ / "a.nii"),
                HasSubstr(GetParam() == 1 ? "unsupported: a.nii: is an Analyze 7.5 header"
                                          : "unsupported: a.nii: is no"));
    proto::VolumeSourceOptions options;
    options.set_format("nifti");
    EXPECT_THAT(volumeError(folder_ / "a.nii", options), HasSubstr("corrupt: a.nii: does not begin as"));
}

// NIfTI-2 says sizes of 64 bits.
TEST(NiftiBomb, IsRefused) {
    const TempDir folder;
    Header header(2);
    header.dim({3, 1e6, 1e6, 1e6});
    writeFile(folder / "a.nii", header.bytes() + std::string(60, 'x'));
    EXPECT_THAT(volumeError(folder / "a.nii"), HasSubstr("resource_exhausted: a.nii: dim: says 1000000 x"));
    header.dim({3, 65536, 65536, 65536});
    writeFile(folder / "a.nii", gzipped(header.bytes() + std::string(60, 'x')));
    EXPECT_THAT(volumeError(folder / "a.nii"), HasSubstr("and it holds at most"));
}

INSTANTIATE_TEST_SUITE_P(Versions, Nifti, testing::Values(1, 2));

}  // namespace
}  // namespace mote::test
