// SPDX-License-Identifier: GPL-3.0-or-later
//
// MetaImage volumes: types, byte orders and compression, data beside the header, where voxels lie, and
// headers that contradict themselves or the file.
#include <gmock/gmock.h>

#include "tests/support/deflate.h"
#include "tests/support/must.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/volume/volume_files.h"

namespace mote::test {
namespace {

using testing::ElementsAreArray;
using testing::HasSubstr;

const std::string sizes = "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\n";
const std::string bytes = "ElementType = MET_UCHAR\n";

class MetaImage : public testing::Test {
  protected:
    Result<WholeVolume> read(const std::string& file) {
        writeFile(folder_ / "a.mha", file);
        return readVolume(folder_ / "a.mha");
    }
    std::string error(const std::string& file) {
        writeFile(folder_ / "a.mha", file);
        return volumeError(folder_ / "a.mha");
    }
    /// A header of these lines before 60 bytes.
    std::string errorOf(const std::string& lines) {
        return error(lines + "ElementDataFile = LOCAL\n" + std::string(60, 'x'));
    }

    TempDir folder_;
};

TEST_F(MetaImage, IsReadInEveryTypeByteOrderAndCompression) {
    const std::vector<std::pair<std::string, std::string>> types = {
        {"MET_UCHAR", "u8"}, {"MET_CHAR", "i8"}, {"MET_USHORT", "u16"}, {"MET_SHORT", "i16"},
        {"MET_UINT", "u32"}, {"MET_INT", "i32"}, {"MET_FLOAT", "f32"},  {"MET_DOUBLE", "f64"}};
    const auto numbers = countedNumbers(60);
    for (const auto& [said, type] : types) {
        for (const bool big : {false, true}) {
            const auto header = sizes + "BinaryData = True\nElementType = " + said +
                                "\nBinaryDataByteOrderMSB = " + (big ? "True" : "False") +
                                "\nCompressedData = ";
            const auto data = numberBytes(type, numbers, big);
            const std::string local = "\nElementDataFile = LOCAL\n";
            for (const auto& file :
                 {header + "False" + local + data, header + "True" + local + zlibDeflated(data),
                  gzipped(header + "False" + local + data),
                  gzipped(header + "True" + local + zlibDeflated(data))}) {
                const auto volume = must(read(file));
                EXPECT_EQ(volume.format, "metaimage");
                EXPECT_EQ(name(volume.shape.type), type);
                EXPECT_THAT(volume.values, ElementsAreArray(numbers)) << said << big;
            }
        }
    }
}

TEST_F(MetaImage, TextIsRead) {
    const auto volume =
        must(read("NDims = 3\r\nDimSize = 2 2 2\r\nBinaryData = False\r\nElementType = MET_SHORT\r\n"
                  "ElementDataFile = LOCAL\r\n-1 2 3 4\r\n5 6 7 8\r\n"));
    EXPECT_EQ(volume.shape.type, prep::ScalarType::i16);
    EXPECT_THAT(volume.values, ElementsAreArray({-1, 2, 3, 4, 5, 6, 7, 8}));
}

TEST_F(MetaImage, LiesWhereItsHeaderSays) {
    const auto volume = must(read(sizes + bytes +
                                  "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 10 -20 30\n"
                                  "ElementSpacing = 2 3 0.5\nElementToIntensityFunctionSlope = 2\n"
                                  "ElementToIntensityFunctionOffset = -1000\nElementDataFile = LOCAL\n" +
                                  std::string(60, '\x05')));
    EXPECT_EQ(worldOf(volume.shape, 0, 0, 0), glm::dvec3(-10, 20, 30));
    EXPECT_EQ(worldOf(volume.shape, 1, 0, 0), glm::dvec3(-10, 18, 30));
    EXPECT_EQ(worldOf(volume.shape, 0, 1, 2), glm::dvec3(-7, 20, 31));
    EXPECT_EQ(volume.shape.worldUnit, "mm");
    EXPECT_EQ(volume.values.front(), -990.0F);
}

TEST_F(MetaImage, DataMayLieBesideTheHeader) {
    const auto numbers = countedNumbers(60);
    const auto data = numberBytes<std::uint8_t>(numbers);
    writeFile(folder_ / "a.raw", "header" + data);
    EXPECT_THAT(read(sizes + bytes + "HeaderSize = 6\nElementDataFile = a.raw\n")->values,
                ElementsAreArray(numbers));
    EXPECT_THAT(read(sizes + bytes + "HeaderSize = -1\nElementDataFile = a.raw\n")->values,
                ElementsAreArray(numbers));
    writeFile(folder_ / "a.zraw", zlibDeflated(data));
    EXPECT_THAT(read(sizes + bytes + "CompressedData = True\nElementDataFile = a.zraw\n")->values,
                ElementsAreArray(numbers));
    std::string list = "LIST\n";
    for (const int slice : {1, 2, 3, 4, 5}) {
        const auto part = "s0" + std::to_string(slice) + ".raw";
        writeFile(folder_ / part, data.substr(static_cast<std::size_t>(slice - 1) * 12, 12));
        list += part + "\n";
    }
    EXPECT_THAT(read(sizes + bytes + "ElementDataFile = s%02d.raw 1 5 1\n")->values,
                ElementsAreArray(numbers));
    EXPECT_THAT(read(sizes + bytes + "ElementDataFile = " + list)->values, ElementsAreArray(numbers));
    EXPECT_THAT(error(sizes + bytes + "ElementDataFile = /etc/passwd\n"), HasSubstr("permission_denied"));
    EXPECT_THAT(error(sizes + bytes + "HeaderSize = -1\nCompressedData = True\nElementDataFile = a.zraw\n"),
                HasSubstr("corrupt: a.zraw"));
}

TEST_F(MetaImage, ContradictionsAreRefused) {
    EXPECT_EQ(errorOf(sizes + bytes), "");
    EXPECT_THAT(errorOf("NDims = 3\nDimSize = 3 4 6\n" + bytes), HasSubstr("72 bytes, and it holds 60"));
    EXPECT_THAT(errorOf("NDims = 3\nDimSize = 3 4 0\n" + bytes), HasSubstr("DimSize: says 3 x 4 x 0"));
    EXPECT_THAT(errorOf("NDims = 3\nDimSize = 1000000 1000000 1000000\n" + bytes),
                HasSubstr("resource_exhausted: a.mha: DimSize"));
    EXPECT_THAT(errorOf("NDims = 4\nDimSize = 3 4 5\n" + bytes), HasSubstr("as many numbers as NDims"));
    EXPECT_THAT(errorOf("NDims = 2\nDimSize = 12 5\n" + bytes), HasSubstr("is not that of a volume"));
    EXPECT_THAT(errorOf("NDims = 4\nDimSize = 3 4 1 5\n" + bytes), HasSubstr("says 5 volumes"));
    EXPECT_THAT(errorOf(sizes + "ElementType = MET_STRING\n"), HasSubstr("\"MET_STRING\" is no"));
    EXPECT_THAT(errorOf(sizes + bytes + "ElementNumberOfChannels = 3\n"), HasSubstr("says 3 values"));
    EXPECT_THAT(errorOf(sizes + bytes + "ElementSpacing = 1 1\n"), HasSubstr("has 2 numbers in place of 3"));
    EXPECT_THAT(errorOf(sizes + bytes + "ElementSpacing = 1 0 1\n"), HasSubstr("axis y lie 0 apart"));
    EXPECT_THAT(errorOf(sizes + bytes + "Offset = 1 nan 1\n"), HasSubstr("Offset: says nan"));
    EXPECT_THAT(errorOf(sizes + bytes + "TransformMatrix = 1 0 0 1 0 0 0 0 1\n"), HasSubstr("in one plane"));
    EXPECT_THAT(errorOf(sizes + bytes + "ElementToIntensityFunctionSlope = x\n"), HasSubstr("is no number"));
    EXPECT_THAT(errorOf(sizes + bytes + "nonsense\n"), HasSubstr("which is no field"));
    EXPECT_THAT(error(sizes + bytes), HasSubstr("ElementDataFile: is missing"));
    const auto packed = sizes + bytes + "CompressedData = True\nElementDataFile = LOCAL\n";
    EXPECT_THAT(error(packed + zlibDeflated(std::string(60, 'x')).substr(0, 8)), HasSubstr("is cut short"));
    EXPECT_THAT(error(packed + zlibDeflated(std::string(72, 'x'))), HasSubstr("and it holds more"));
}

}  // namespace
}  // namespace mote::test
