// SPDX-License-Identifier: GPL-3.0-or-later
//
// Raw volumes: every type in both byte orders, bytes before the numbers, gzip, and options that contradict
// the file.
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <openvdb/openvdb.h>
#include <fstream>
#include <limits>

#include "preprocess/volume/volume_formats.h"
#include "tests/support/deflate.h"
#include "tests/support/must.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/quiet_progress.h"
#include "tests/unit/volume/volume_files.h"
#include "tests/unit/volume/volume_files.h"  // first: protobuf does not like OpenImageIO's words

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

TEST(RawVolume, ItsNameSaysWhatItHolds) {
    const TempDir folder;
    const auto numbers = countedNumbers(60);
    const auto read = [&](const char* file, const std::string& bytes) {
        writeFile(folder / file, bytes);
        return must(readVolume(folder / file));
    };
    const auto shorts = read("Head_3x4x5_uint16.raw", numberBytes<std::uint16_t>(numbers));
    EXPECT_EQ(shorts.format, "raw");
    EXPECT_EQ(name(shorts.shape.type), "u16");
    EXPECT_EQ(shorts.shape.nz, 5u);
    EXPECT_THAT(shorts.values, ElementsAreArray(numbers));
    EXPECT_THAT(read("a b_5X3x4_INT8.RAW.gz", gzipped(numberBytes<std::int8_t>(numbers))).values,
                ElementsAreArray(numbers));
    EXPECT_THAT(read("c-float64-60x1x1.bin", numberBytes<double>(numbers)).values, ElementsAreArray(numbers));
    EXPECT_THAT(read("d.float.4x3x5", numberBytes<float>(numbers)).values, ElementsAreArray(numbers));

    const auto error = [&](const char* file, const proto::VolumeSourceOptions& options = {}) {
        writeFile(folder / file, std::string(60, 'x'));
        return volumeError(folder / file, options);
    };
    EXPECT_EQ(error("3x4x6_uint8.raw"),
              "corrupt: 3x4x6_uint8.raw: its dimensions 3 x 4 x 6 of u8 are 72 bytes, and it holds 60");
    EXPECT_EQ(error("3x4x6_uint8.raw", rawOptions(3, 4, 5)), "") << "what somebody says goes first";
    for (const char* const open :
         {"3x4x5.raw", "a_uint8.raw", "3x4x5x1_uint8.raw", "3x4_uint8.raw", "3x4x_uint8", "3x4x5_uint9.raw",
          "3x4x-5_uint8.raw", "9999999999x1x1_uint8.raw"})
        EXPECT_THAT(error(open), HasSubstr("a raw one is read")) << open;
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

// Stacks of pictures: every type, files in natural order, folders and patterns, pages of one file, colour;
// and pictures that contradict each other or themselves.

namespace fs = std::filesystem;

/// How a picture is written.
struct StackForm {
    OIIO::TypeDesc type = OIIO::TypeDesc::UINT8;
    int width = 3, height = 4, channels = 1;
    int tile = 0;  ///< its side, 0: in rows
    bool append = false;
};

void writePicture(const fs::path& path, const std::vector<double>& numbers, const StackForm& form = {}) {
    OIIO::ImageSpec spec(form.width, form.height, form.channels, form.type);
    spec.tile_width = spec.tile_height = form.tile;
    const std::string bytes = form.type == OIIO::TypeDesc::UINT8    ? numberBytes<std::uint8_t>(numbers)
                              : form.type == OIIO::TypeDesc::UINT16 ? numberBytes<std::uint16_t>(numbers)
                              : form.type == OIIO::TypeDesc::INT16  ? numberBytes<std::int16_t>(numbers)
                              : form.type == OIIO::TypeDesc::UINT32 ? numberBytes<std::uint32_t>(numbers)
                              : form.type == OIIO::TypeDesc::INT32  ? numberBytes<std::int32_t>(numbers)
                              : form.type == OIIO::TypeDesc::FLOAT  ? numberBytes<float>(numbers)
                                                                    : numberBytes<double>(numbers);
    const auto output = OIIO::ImageOutput::create(path.string());
    ASSERT_TRUE(output && output->open(path.string(), spec)) << OIIO::geterror();
    ASSERT_TRUE(output->write_image(form.type, bytes.data())) << output->geterror();
    ASSERT_TRUE(output->close());
}

/// A TIFF file of several pages.
void writePages(const fs::path& path, const std::vector<std::vector<double>>& pages) {
    const std::vector<OIIO::ImageSpec> specs(pages.size(), OIIO::ImageSpec(3, 4, 1, OIIO::TypeDesc::UINT16));
    const auto output = OIIO::ImageOutput::create(path.string());
    ASSERT_TRUE(output && output->open(path.string(), static_cast<int>(specs.size()), specs.data()));
    for (std::size_t i = 0; i < pages.size(); ++i) {
        if (i > 0) {
            ASSERT_TRUE(output->open(path.string(), specs[i], OIIO::ImageOutput::AppendSubimage));
        }
        const auto bytes = numberBytes<std::uint16_t>(pages[i]);
        ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT16, bytes.data())) << output->geterror();
    }
    ASSERT_TRUE(output->close());
}

std::vector<double> slice(const std::vector<double>& numbers, std::size_t z) {
    return slicesOf(numbers, 12, {static_cast<std::uint32_t>(z)});
}

TEST(PictureStack, IsReadInEveryType) {
    const std::vector<std::pair<OIIO::TypeDesc::BASETYPE, std::string>> types = {
        {OIIO::TypeDesc::UINT8, "u8"},   {OIIO::TypeDesc::UINT16, "u16"}, {OIIO::TypeDesc::INT16, "i16"},
        {OIIO::TypeDesc::UINT32, "u32"}, {OIIO::TypeDesc::INT32, "i32"},  {OIIO::TypeDesc::FLOAT, "f32"},
        {OIIO::TypeDesc::DOUBLE, "f64"}};
    const auto numbers = countedNumbers(36);
    for (const auto& [type, name] : types) {
        for (const std::string ending : {".tif", ".png"}) {
            if (ending == ".png" && name != "u8" && name != "u16") continue;
            const TempDir folder;
            StackForm form;
            form.type = type;
            for (std::size_t z = 0; z < 3; ++z) {
                writePicture(folder / ("s" + std::to_string(z) + ending), slice(numbers, z), form);
            }
            const auto volume = must(readVolume(folder.path()));
            EXPECT_EQ(volume.format, "pictures");
            EXPECT_EQ(prep::name(volume.shape.type), name);
            EXPECT_THAT(volume.values, ElementsAreArray(numbers)) << name << ending;
            EXPECT_TRUE(volume.notes.empty());
        }
    }
}

TEST(PictureStack, IsInNaturalOrderFromFoldersAndPatterns) {
    const TempDir folder;
    const auto numbers = countedNumbers(12 * 12);
    for (std::size_t z = 0; z < 12; ++z) {
        writePicture(folder / ("slice" + std::to_string(z + 1) + ".png"), slice(numbers, z));
    }
    writeFile(folder / "notes.txt", "no picture");
    writeFile(folder / ".hidden.png", "no picture");
    for (const auto& input : {folder.path(), folder / "slice*.png"}) {
        const auto volume = must(readVolume(input));
        EXPECT_EQ(volume.shape.nz, 12u);
        EXPECT_THAT(volume.values, ElementsAreArray(numbers)) << input;
    }
    EXPECT_EQ(readVolume(folder / "slice1?.png")->shape.nz, 3u);
    EXPECT_THAT(readSlices(folder.path(), {7, 2, 11}), ElementsAreArray(slicesOf(numbers, 12, {7, 2, 11})));
    EXPECT_THAT(volumeError(folder / "none*.png"), HasSubstr("not_found: none*.png: no file has a name"));
    EXPECT_THAT(volumeError(folder / "slice1.png"), HasSubstr("is a single picture; name the folder"));
    EXPECT_THAT(volumeError(folder / "no*.txt"), HasSubstr("is no PNG, JPEG, TIFF or OpenEXR picture"));
    const TempDir empty;
    EXPECT_THAT(volumeError(empty.path()),
                HasSubstr("is a folder without DICOM files, PNG or TIFF pictures"));
}

TEST(PictureStack, NumbersInNamesCount) {
    const std::vector<std::string> names = {"a", "a1", "a01b", "a2", "a10", "a010x", "b0", "b00"};
    for (std::size_t i = 0; i < names.size(); ++i) {
        for (std::size_t j = 0; j < names.size(); ++j) {
            EXPECT_EQ(prep::naturallyLess(names[i], names[j]), i < j) << names[i] << " " << names[j];
        }
    }
}

TEST(PictureStack, AMissingSliceIsSaid) {
    const TempDir folder;
    for (const char* name : {"cut_008.png", "cut_010.png", "cut_012.png", "cut_016.png"}) {
        writePicture(folder / name, countedNumbers(12));
    }
    EXPECT_THAT(volumeError(folder.path()), HasSubstr("corrupt: cut_016.png: follows cut_012.png, where the "
                                                      "others' numbers rise by 2: a slice is missing"));
    EXPECT_EQ(volumeError(folder / "cut_0?[028].png"), "");
    writePicture(folder / "overview.png",
                 countedNumbers(12));  // names that are no series are taken as they are
    EXPECT_EQ(volumeError(folder.path()), "");
}

TEST(PictureStack, PagesOfOneFileAreSlices) {
    const TempDir folder;
    const auto numbers = countedNumbers(60);
    writePages(folder / "a.tif", {slice(numbers, 0), slice(numbers, 1), slice(numbers, 2), slice(numbers, 3),
                                  slice(numbers, 4)});
    const auto volume = must(readVolume(folder / "a.tif"));
    EXPECT_EQ(volume.shape.nz, 5u);
    EXPECT_THAT(volume.values, ElementsAreArray(numbers));
    EXPECT_THAT(readSlices(folder / "a.tif", {3, 0, 4}), ElementsAreArray(slicesOf(numbers, 12, {3, 0, 4})));
}

TEST(PictureStack, TilesAndColoursAreRead) {
    const TempDir folder;
    const auto numbers = countedNumbers(2 * 40 * 20);
    StackForm form;
    form.type = OIIO::TypeDesc::UINT16;
    form.width = 40;
    form.height = 20;
    form.tile = 16;
    writePicture(folder / "1.tif", slicesOf(numbers, 800, {0}), form);
    writePicture(folder / "2.tif", slicesOf(numbers, 800, {1}), form);
    EXPECT_THAT(readVolume(folder.path())->values, ElementsAreArray(numbers));
    const TempDir colours;
    StackForm colour;
    colour.channels = 3;
    colour.width = colour.height = 1;
    writePicture(colours / "1.png", {255, 0, 0}, colour);
    writePicture(colours / "2.png", {50, 50, 50}, colour);
    const auto volume = must(readVolume(colours.path()));
    EXPECT_FLOAT_EQ(volume.values[0], 0.2126F * 255);
    EXPECT_FLOAT_EQ(volume.values[1], 50);
    ASSERT_EQ(volume.notes.size(), 1u);
    EXPECT_THAT(volume.notes[0], HasSubstr("their luminance is read"));
}

TEST(PictureStack, ContradictionsAreRefused) {
    const TempDir folder;
    const auto numbers = countedNumbers(12);
    writePicture(folder / "1.png", numbers);
    StackForm other;
    other.width = 4;
    other.height = 3;
    writePicture(folder / "2.png", numbers, other);
    EXPECT_THAT(volumeError(folder.path()), HasSubstr("corrupt: 2.png: is 4 x 3 with 1 channels of uint8"));
    other = {};
    other.type = OIIO::TypeDesc::UINT16;
    writePicture(folder / "2.png", numbers, other);
    EXPECT_THAT(volumeError(folder.path()),
                HasSubstr("with 1 channels of uint16; the first picture is 3 x 4"));
    writeFile(folder / "2.png", "");
    EXPECT_THAT(volumeError(folder.path()), HasSubstr("is empty"));
    writeFile(folder / "2.png", "\xff\xd8\xff\xe0 is a JPEG file by its first bytes \xff\xd9");
    EXPECT_THAT(volumeError(folder.path()), HasSubstr("2.png"));
}

std::string bigEndianWord(std::uint32_t value) {
    return numberBytes<std::uint32_t>({static_cast<double>(value)}, true);
}

/// A PNG's first chunk says how large it is; the checksum of each chunk is not right, but none comes so far.
TEST(PictureStack, BombsAndCutPicturesAreRefused) {
    const TempDir folder;
    const auto numbers = countedNumbers(12);
    writePicture(folder / "1.tif", numbers);
    writePicture(folder / "2.tif", numbers);
    EXPECT_EQ(volumeError(folder.path()), "");
    const auto bytes = [](double width, double height) {
        // Little-endian TIFF: one strip without compression, which is not there.
        std::string tiff("II*\0\x08\0\0\0\x08\0", 10);
        const auto tag = [&](int number, int type, double value) {
            tiff += numberBytes<std::uint16_t>({static_cast<double>(number), static_cast<double>(type)}) +
                    numberBytes<std::uint32_t>({1, value});
        };
        tag(256, 4, width), tag(257, 4, height), tag(258, 3, 8), tag(259, 3, 1), tag(262, 3, 1),
            tag(273, 4, 8);
        tag(278, 4, height), tag(279, 4, width * height);
        return tiff + std::string(4, '\0');
    };
    writeFile(folder / "1.tif", bytes(30000, 30000));
    EXPECT_THAT(volumeError(folder.path()), HasSubstr("1.tif"));
    writeFile(folder / "1.tif", bytes(70000, 2));
    EXPECT_THAT(volumeError(folder.path()), HasSubstr("1.tif"));
    writeFile(folder / "1.tif", bytes(3, 4));
    EXPECT_THAT(volumeError(folder.path()), testing::AnyOf("", HasSubstr("1.tif")));
    const TempDir pngs;
    writePicture(pngs / "1.png", numbers);
    writePicture(pngs / "2.png", numbers);
    std::string png(fs::file_size(pngs / "2.png"), '\0');
    std::ifstream(pngs / "2.png", std::ios::binary)
        .read(png.data(), static_cast<std::streamsize>(png.size()));
    writeFile(pngs / "2.png", png.substr(0, png.size() - 20));
    EXPECT_THAT(volumeError(pngs.path()), HasSubstr("corrupt: 2.png: cannot be read"));
    png.replace(16, 8, bigEndianWord(60000) + bigEndianWord(60000));
    writeFile(pngs / "2.png", png);
    EXPECT_THAT(volumeError(pngs.path()), HasSubstr("2.png"));
}

// OpenVDB volumes: the grids that can be read, where their voxels lie, and files without one.

namespace fs = std::filesystem;

class Vdb : public testing::Test {
  protected:
    static void SetUpTestSuite() { openvdb::initialize(); }

    /// By OpenVDB's own table of kinds: Grid::create would have all of its code compiled here, minutes of it.
    template <class Grid>
    static typename Grid::Ptr empty() {
        return openvdb::StaticPtrCast<Grid>(openvdb::GridBase::createGrid(Grid::gridType()));
    }

    /// Voxels 0, 1, 2, ... of a box from (-2, 3, 5) on, 0 of them not active.
    template <class Grid>
    typename Grid::Ptr counted(int nx, int ny, int nz, const std::string& name) {
        auto grid = empty<Grid>();
        grid->setName(name);
        for (int i = 0; i < nx * ny * nz; ++i) {
            grid->tree().setValue({i % nx - 2, i / nx % ny + 3, i / (nx * ny) + 5},
                                  static_cast<typename Grid::ValueType>(i));
        }
        return grid;
    }

    fs::path write(const openvdb::GridCPtrVec& grids, bool statistics = true) {
        openvdb::io::File file((folder_ / "a.vdb").string());
        file.setGridStatsMetadataEnabled(statistics);
        file.write(grids);
        file.close();
        return folder_ / "a.vdb";
    }

    static proto::VolumeSourceOptions named(const std::string& field) {
        proto::VolumeSourceOptions options;
        options.set_field(field);
        return options;
    }

    TempDir folder_;
};

TEST_F(Vdb, GridsOfEachTypeAreRead) {
    const auto numbers = countedNumbers(60);
    const auto path =
        write({counted<openvdb::FloatGrid>(3, 4, 5, "f"), counted<openvdb::DoubleGrid>(3, 4, 5, "d"),
               counted<openvdb::Int32Grid>(3, 4, 5, "i")});
    for (const auto& [field, type] : std::vector<std::pair<std::string, std::string>>{
             {"", "f32"}, {"f", "f32"}, {"d", "f64"}, {"i", "i32"}}) {
        const auto volume = must(readVolume(path, named(field)));
        EXPECT_EQ(volume.format, "vdb");
        EXPECT_EQ(name(volume.shape.type), type);
        EXPECT_THAT(volume.values, ElementsAreArray(numbers));
    }
}

TEST_F(Vdb, SparseGridsHaveTheirBackground) {
    auto grid = empty<openvdb::FloatGrid>();
    grid->tree().root().setBackground(-1.0F, false);
    grid->tree().setValue({0, 0, 0}, 5.0F);
    grid->tree().setValue({40, 20, 30}, 7.0F);
    grid->tree().fill(openvdb::CoordBBox({8, 8, 8}, {15, 15, 15}), 3.0F);  // a tile, or a leaf
    const auto volume = must(readVolume(write({grid})));
    ASSERT_EQ(volume.shape.voxels(), 41u * 21 * 31);
    const auto at = [&](std::size_t x, std::size_t y, std::size_t z) {
        return volume.values[x + 41 * (y + 21 * z)];
    };
    EXPECT_EQ(at(0, 0, 0), 5.0F);
    EXPECT_EQ(at(40, 20, 30), 7.0F);
    EXPECT_EQ(at(1, 0, 0), -1.0F);
    EXPECT_EQ(at(15, 8, 12), 3.0F);
    EXPECT_EQ(at(16, 8, 12), -1.0F);
    EXPECT_EQ(std::count(volume.values.begin(), volume.values.end(), 3.0F), 512);
}

// A grid of more than 256 MiB of voxels comes in several windows of slices, in any order.
TEST_F(Vdb, LongGridsAreReadInWindows) {
    auto grid = empty<openvdb::FloatGrid>();
    for (const int z : {0, 16383, 16384, 20000, 39999}) {
        grid->tree().setValue({0, 0, z}, 1.0F);
        grid->tree().setValue({63, 63, z}, static_cast<float>(z));
    }
    const auto path = write({grid});
    const std::vector<std::uint32_t> slices = {20000, 0, 16384, 39999, 16383, 5, 20000};
    const auto values = readSlices(path, slices);
    ASSERT_EQ(values.size(), 64u * 64 * slices.size());
    for (std::size_t i = 0; i < slices.size(); ++i) {
        EXPECT_EQ(values[4096 * i], slices[i] == 5 ? 0.0F : 1.0F);
        EXPECT_EQ(values[4096 * i + 4095], slices[i] == 5 ? 0.0F : static_cast<float>(slices[i]));
    }
    QuietProgress progress;
    auto source = prep::openVolumeSource({}, path, progress);
    ASSERT_TRUE(source.ok());
    std::vector<float> across(4096u * 20);
    ASSERT_TRUE((*source)->read(16374, 16394, across).ok());
    EXPECT_EQ(across[4096 * 9 + 4095], 16383.0F);
    EXPECT_EQ(across[4096 * 10 + 4095], 16384.0F);
    EXPECT_EQ(std::count(across.begin(), across.end(), 0.0F), 4096 * 20 - 4);
}

TEST_F(Vdb, LiesWhereItsTransformSays) {
    auto grid = counted<openvdb::FloatGrid>(2, 2, 2, "f");
    const openvdb::Mat4d map(0.0, 2.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 10.0, 20.0, 30.0,
                             1.0);  // of row vectors
    grid->setTransform(openvdb::math::Transform::createLinearTransform(map));
    const auto volume = must(readVolume(write({grid})));
    const auto expected = [&](int x, int y, int z) {
        const openvdb::Vec3d at = grid->indexToWorld(openvdb::Coord(x - 2, y + 3, z + 5));
        return glm::dvec3(at[0], at[1], at[2]);
    };
    EXPECT_EQ(worldOf(volume.shape, 0, 0, 0), expected(0, 0, 0));
    EXPECT_EQ(worldOf(volume.shape, 1, 0, 1), expected(1, 0, 1));
    EXPECT_EQ(worldOf(volume.shape, 0, 1, 0), expected(0, 1, 0));
    EXPECT_THAT(volume.values, ElementsAreArray(countedNumbers(8)));
}

TEST_F(Vdb, FilesWithoutAGridToReadAreRefused) {
    EXPECT_THAT(volumeError(write({})), HasSubstr("not_found: a.vdb: holds no grid"));
    auto vectors = empty<openvdb::Vec3SGrid>();
    vectors->setName("v");
    EXPECT_THAT(volumeError(write({vectors})),
                HasSubstr("unsupported: a.vdb: grid \"v\": holds values of type vec3s; only float"));
    const auto both = write({vectors, counted<openvdb::FloatGrid>(2, 2, 2, "f")});
    EXPECT_EQ(volumeError(both), "");
    EXPECT_THAT(volumeError(both, named("v")), HasSubstr("holds values of type vec3s"));
    EXPECT_THAT(volumeError(both, named("x")), HasSubstr("holds no grid of the name \"x\""));
    EXPECT_THAT(volumeError(write({empty<openvdb::FloatGrid>()})), HasSubstr("no voxels"));
    EXPECT_THAT(volumeError(write({counted<openvdb::FloatGrid>(2, 2, 2, "f")}, false)),
                HasSubstr("does not say which box"));
    auto wide = empty<openvdb::FloatGrid>();
    wide->tree().setValue({0, 0, 0}, 1.0F);
    wide->tree().setValue({1000000, 1000000, 1000000}, 1.0F);
    EXPECT_THAT(volumeError(write({wide})),
                HasSubstr("resource_exhausted: a.vdb: grid \"\": says 1000001 x"));
    auto frustum = counted<openvdb::FloatGrid>(2, 2, 2, "f");
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd({-10, -10, -10}, {10, 10, 10}), 0.5, 1.0));
    EXPECT_THAT(volumeError(write({frustum})), HasSubstr("has a transform that is not linear"));
}

/// OpenVDB takes memory for any length that a file says.
TEST_F(Vdb, LengthsThatAFileCannotHaveAreRefused) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "the sanitizers end a program that gets no memory";
#endif
    const auto path = write({counted<openvdb::FloatGrid>(2, 2, 2, "f")});
    // Behind the header (57 bytes), no metadata and the count of grids: the first grid's name.
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(65);
    file.write("\xff\xff\xff\x7f", 4);
    file.close();
    EXPECT_THAT(volumeError(path), HasSubstr("resource_exhausted: a.vdb: asks for more memory"));
    write({counted<openvdb::FloatGrid>(2, 2, 2, "f")});
    EXPECT_EQ(volumeError(path), "");
}

TEST_F(Vdb, CutFilesAreRefused) {
    const auto path = write({counted<openvdb::FloatGrid>(20, 20, 20, "f")});
    const auto size = fs::file_size(path);
    for (const auto left : {std::uintmax_t{9}, std::uintmax_t{100}, size / 2, size - 10}) {
        fs::resize_file(path, left);
        EXPECT_THAT(volumeError(path), HasSubstr("corrupt: a.vdb: ")) << left;
        write({counted<openvdb::FloatGrid>(20, 20, 20, "f")});
    }
}

}  // namespace
}  // namespace mote::test
