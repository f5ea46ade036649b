// SPDX-License-Identifier: GPL-3.0-or-later
//
// Stacks of pictures: every type, files in natural order, folders and patterns, pages of one file, colour;
// and pictures that contradict each other or themselves.
#include "tests/unit/volume/volume_files.h"  // first: protobuf does not like OpenImageIO's words

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>

#include <fstream>

#include "preprocess/volume/volume_formats.h"
#include "tests/support/must.h"
#include "tests/support/temp_dir.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAreArray;
using testing::HasSubstr;

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

}  // namespace
}  // namespace mote::test
