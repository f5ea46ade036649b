// SPDX-License-Identifier: GPL-3.0-or-later
//
// NRRD volumes: types, encodings and byte orders, data beside the header, where voxels lie, and headers that
// contradict themselves or the file.
#include <gmock/gmock.h>

#include "tests/support/deflate.h"
#include "tests/support/must.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/volume/volume_files.h"

namespace mote::test {
namespace {

using testing::ElementsAreArray;
using testing::HasSubstr;

const std::string plain = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 4 5\nencoding: raw\n";
const std::string packed = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 4 5\nencoding: gzip\n";

class Nrrd : public testing::Test, protected OneFile {
  protected:
    Nrrd() : OneFile("a.nrrd") {}
    /// A header of these lines before 60 bytes.
    std::string errorOf(const std::string& lines) {
        return error("NRRD0004\n" + lines + "\n\n" + numberBytes<std::uint8_t>(countedNumbers(60)));
    }
};

TEST_F(Nrrd, IsReadInEveryTypeEncodingAndByteOrder) {
    const std::vector<std::pair<std::string, std::string>> types = {
        {"uint8_t", "u8"}, {"signed char", "i8"}, {"unsigned short", "u16"}, {"short", "i16"},
        {"uint", "u32"},   {"int32", "i32"},      {"float", "f32"},          {"double", "f64"}};
    const auto numbers = countedNumbers(60);
    for (const auto& [said, type] : types) {
        for (const bool big : {false, true}) {
            const auto header =
                "NRRD0001\r\n# a comment\r\nType: " + said +
                "\r\ndimension: 3\r\nkey:=value\r\nsizes: 3 4 5\r\nendian: " + (big ? "big" : "little") +
                "\r\nencoding: ";
            const auto data = numberBytes(type, numbers, big);
            for (const auto& bytes : {header + "raw\r\n\r\n" + data, header + "gzip\r\n\r\n" + gzipped(data),
                                      gzipped(header + "raw\r\n\r\n" + data)}) {
                const auto volume = must(read(bytes));
                EXPECT_EQ(volume.format, "nrrd");
                EXPECT_EQ(name(volume.shape.type), type);
                EXPECT_THAT(volume.values, ElementsAreArray(numbers)) << said << big;
            }
        }
    }
}

TEST_F(Nrrd, TextIsRead) {
    const auto volume = must(
        read("NRRD0005\ntype: short\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n-1 2\n3,4 5\n6 7 8\n"));
    EXPECT_EQ(volume.shape.type, prep::ScalarType::i16);
    EXPECT_THAT(volume.values, ElementsAreArray({-1, 2, 3, 4, 5, 6, 7, 8}));
    const auto head = std::string("NRRD0005\ntype: short\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n");
    EXPECT_THAT(error(head + "1 2 3 4 5 6 7 x"), HasSubstr("has \"x\" where a value should stand"));
    EXPECT_THAT(error(head + "1 2 3 4 5 6 7"), HasSubstr("and it holds"));
    EXPECT_THAT(error(head + "1 2 3 4 5 6 7 8 9"), HasSubstr("and it holds more"));
    EXPECT_THAT(error(head + std::string(1000, '1')), HasSubstr("where a value should stand"));
}

TEST_F(Nrrd, LiesWhereItsDirectionsSay) {
    const auto volume =
        must(read(plain +
                  "space: left-posterior-superior\nspace directions: (0,2,0) (-1,0,0) (0,0.5,3)\n"
                  "space origin: (10,-20,30)\nspace units: \"mm\" \"mm\" \"mm\"\n"
                  "sample units: \"HU\"\n\n" +
                  std::string(60, 'x')));
    // Of a patient, and so in right, anterior, superior.
    EXPECT_EQ(worldOf(volume.shape, 0, 0, 0), glm::dvec3(-10, 20, 30));
    EXPECT_EQ(worldOf(volume.shape, 1, 2, 3), glm::dvec3(-8, 16.5, 39));
    EXPECT_EQ(volume.shape.space, "left-posterior-superior");
    EXPECT_EQ(volume.shape.worldSpace, "ras");
    EXPECT_EQ(volume.shape.worldUnit, "mm");
    EXPECT_EQ(volume.shape.valueUnit, "HU");
}

TEST_F(Nrrd, LiesWhereItsSpacingsSay) {
    const auto data = "\n" + std::string(60, 'x');
    auto volume = read(plain + "spacings: 0.5 nan 2\n" + data);
    ASSERT_TRUE(volume.ok()) << volume.error().toString();
    EXPECT_EQ(worldOf(volume->shape, 1, 1, 1), glm::dvec3(0.5, 1, 2));
    volume = read(plain + "spacings: 2 2 2\naxis mins: 1 2 3\ncenterings: node cell node\n" + data);
    ASSERT_TRUE(volume.ok()) << volume.error().toString();
    EXPECT_EQ(worldOf(volume->shape, 0, 0, 0), glm::dvec3(1, 3, 3));
    EXPECT_EQ(worldOf(read(plain + data)->shape, 1, 1, 1), glm::dvec3(1, 1, 1));
}

TEST_F(Nrrd, AxesOfOneValueAreNoAxes) {
    const auto rest = std::string("encoding: raw\n") + "\n" + std::string(60, 'x');
    const auto first =
        must(read("NRRD0004\ntype: uchar\ndimension: 4\nsizes: 1 3 4 5\n"
                  "space directions: none (1,0,0) (0,1,0) (0,0,2)\n" +
                  rest));
    EXPECT_EQ(first.shape.nx, 3u);
    EXPECT_EQ(worldOf(first.shape, 1, 1, 1), glm::dvec3(1, 1, 2));
    const auto last = must(read("NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 4 5 1\n" + rest));
    EXPECT_EQ(last.shape.nz, 5u);
}

TEST_F(Nrrd, DataMayLieBesideTheHeader) {
    const auto numbers = countedNumbers(60);
    std::filesystem::create_directory(folder_ / "data");
    writeFile(folder_ / "data/a.raw", numberBytes<std::uint8_t>(numbers));
    EXPECT_THAT(read(plain + "data file: data/a.raw\n")->values, ElementsAreArray(numbers));
    writeFile(folder_ / "data/a.raw", "one\ntwo\n!!" + numberBytes<std::uint8_t>(numbers));
    EXPECT_THAT(read(plain + "line skip: 2\nbyteskip: 2\ndatafile: ./data/a.raw\n")->values,
                ElementsAreArray(numbers));
    EXPECT_THAT(read(plain + "byte skip: -1\ndata file: data/a.raw\n")->values, ElementsAreArray(numbers));
    EXPECT_THAT(error(plain + "line skip: 5\ndata file: data/a.raw\n"), HasSubstr("line skip: is more"));
    writeFile(folder_ / "data/a.raw.gz", gzipped(numberBytes<std::uint8_t>(numbers)));
    EXPECT_THAT(read(packed + "data file: data/a.raw.gz\n")->values, ElementsAreArray(numbers));
    writeFile(folder_ / "data/a.raw.gz", "one\n" + gzipped(numberBytes<std::uint8_t>(numbers)));
    EXPECT_THAT(read(packed + "line skip: 1\ndata file: data/a.raw.gz\n")->values, ElementsAreArray(numbers));
    EXPECT_THAT(error(plain + "data file: none.raw\n"), HasSubstr("not_found: a.nrrd: data file none.raw"));
}

TEST_F(Nrrd, DataMayLieInSeveralFiles) {
    const auto numbers = countedNumbers(60);
    const auto bytes = numberBytes<std::uint8_t>(numbers);
    for (const int slice : {0, 1, 2, 3, 4}) {
        const auto part = bytes.substr(static_cast<std::size_t>(slice) * 12, 12);
        writeFile(folder_ / ("s" + std::to_string(3 * slice + 7) + ".raw"), "head" + part);
        writeFile(folder_ / ("z" + std::to_string(slice) + ".gz"), gzipped(part));
    }
    const auto numbered = plain + "byte skip: 4\ndata file: s%d.raw 7 19 3 2\n";
    const auto volume = must(read(numbered));
    EXPECT_THAT(volume.values, ElementsAreArray(numbers));
    const auto list = plain + "data file: LIST 2\nz0.gz\nz1.gz\nz2.gz\nz3.gz\nz4.gz\n";
    EXPECT_THAT(read(list)->values, ElementsAreArray(numbers));
    EXPECT_THAT(error(plain + "data file: LIST\n"), HasSubstr("data file: lists no data file"));
    EXPECT_THAT(error(plain + "data file: LIST\nz0.gz\nz1.gz\n../z2\n"), HasSubstr("permission_denied"));
    EXPECT_THAT(error(plain + "data file: LIST\nz0.gz\nz1.gz\nz2.gz\n"), HasSubstr("and it holds less"));
    writeFile(folder_ / "z4.gz", gzipped("0123456789ABC"));
    EXPECT_THAT(error(list), HasSubstr("is 12 bytes, and it holds more"));
    writeFile(folder_ / "z4.gz", gzipped("0123456789"));
    EXPECT_THAT(error(list), HasSubstr("is 12 bytes, and it holds less"));
    EXPECT_THAT(error(plain + "data file: s%d.raw 7 13 3\n"), HasSubstr("is 20 bytes, and it holds 16"));
    EXPECT_THAT(error(plain + "data file: s%d.raw 7 28 3\n"), HasSubstr("cannot hold 60 bytes evenly"));
    EXPECT_THAT(error(plain + "data file: s%d.raw 7 22 3\n"), HasSubstr("is 10 bytes, and it holds 16"));
    EXPECT_THAT(error(plain + "data file: s%s.raw 7 19 3\n"), HasSubstr("is no pattern of data files"));
    EXPECT_THAT(error(plain + "data file: s%d.raw 7 1e9 1\n"), HasSubstr("more than 65536 data files"));
    EXPECT_THAT(error(plain + "data file: s%d.raw 7 1 1\n"), HasSubstr("is no pattern of data files"));
}

TEST_F(Nrrd, VectorsAreRefused) {
    const auto rest = std::string("encoding: raw\n") + "\n" + std::string(60, 'x');
    EXPECT_THAT(
        error("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 4 5\nkinds: RGB-color domain domain\n" + rest),
        HasSubstr("unsupported: a.nrrd: sizes: says 2 axes of space"));
    EXPECT_THAT(error("NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 1 4 5\nspacings: nan 1 1 1\n" + rest),
                HasSubstr("says 3 values for each voxel"));
}

TEST_F(Nrrd, DataOfOtherFoldersAreNotRead) {
    const TempDir other;
    writeFile(other / "secret.raw", std::string(60, 'x'));
    std::filesystem::create_symlink(other / "secret.raw", folder_ / "link.raw");
    for (const auto& name : {(other / "secret.raw").string(), std::string("link.raw"),
                             "../" + other.path().filename().string() + "/secret.raw"}) {
        EXPECT_THAT(error(plain + "data file: " + name + "\n"), HasSubstr("permission_denied: a.nrrd: names"))
            << name;
    }
}

TEST_F(Nrrd, ContradictionsAreRefused) {
    const std::string type = "type: uchar\n", dimension = "dimension: 3\n", sizes = "sizes: 3 4 5\n",
                      raw = "encoding: raw";
    EXPECT_EQ(errorOf(type + dimension + sizes + raw), "");
    EXPECT_THAT(errorOf(type + dimension + "sizes: 3 4 6\n" + raw), HasSubstr("72 bytes, and it holds 60"));
    EXPECT_THAT(errorOf(type + dimension + "sizes: 3 4 0\n" + raw),
                HasSubstr("corrupt: a.nrrd: sizes: says 3 x 4 x 0: no voxels"));
    EXPECT_THAT(errorOf(type + dimension + "sizes: 1000000 1000000 1000000\n" + raw),
                HasSubstr("resource_exhausted: a.nrrd: sizes: says 1000000 x"));
    EXPECT_THAT(errorOf(type + dimension + "sizes: 3 -4 5\n" + raw), HasSubstr("says -4, which is no count"));
    EXPECT_THAT(errorOf(type + dimension + "sizes: 3 4\n" + raw), HasSubstr("not as many as dimension"));
    EXPECT_THAT(errorOf(type + "dimension: 2\nsizes: 12 5\n" + raw), HasSubstr("says 2 axes"));
    EXPECT_THAT(errorOf(type + dimension + raw), HasSubstr("sizes: are not as many"));
    EXPECT_THAT(errorOf(dimension + sizes + raw), HasSubstr("unsupported: a.nrrd: type: \"\" is no"));
    EXPECT_THAT(errorOf("type: block\n" + dimension + sizes + raw), HasSubstr("\"block\" is no integer"));
    EXPECT_THAT(errorOf(type + dimension + sizes + "encoding: lzma"), HasSubstr("\"lzma\" is none of"));
    EXPECT_THAT(errorOf("type: short\n" + dimension + sizes + raw), HasSubstr("endian: \"\" is neither"));
    EXPECT_THAT(errorOf(type + type + dimension + sizes + raw), HasSubstr("type: stands there twice"));
    EXPECT_THAT(errorOf(type + dimension + sizes + raw + "\nnonsense"), HasSubstr("which is no field"));
    EXPECT_THAT(errorOf(type + dimension + sizes + raw + "\nspacings: 1 0 1"),
                HasSubstr("axis y lie 0 apart"));
    EXPECT_THAT(errorOf(type + dimension + sizes + raw + "\nspacings: 1 inf 1"), HasSubstr("lie inf apart"));
    EXPECT_THAT(errorOf(type + dimension + sizes + raw + "\nspacings: 1 1"),
                HasSubstr("are not one an axis"));
    const auto directions = type + dimension + sizes + raw + "\nspace directions: ";
    EXPECT_THAT(errorOf(directions + "(1,0,0) (2,0,0) (0,0,1)"), HasSubstr("lie in one plane"));
    EXPECT_THAT(errorOf(directions + "(1,0,0) (0,1,0)"), HasSubstr("three numbers in brackets"));
    EXPECT_THAT(errorOf(directions + "(1,0,0) (0,1,0) (0,0,x)"), HasSubstr("something else than numbers"));
    EXPECT_THAT(errorOf(directions + "(1,0,0) (0,1,0) none"),
                HasSubstr("says 5 values between the axes of space"));
    EXPECT_THAT(errorOf("type: \xff\x01 y\n" + dimension + sizes + raw), HasSubstr("\"?? y\" is no integer"));
    EXPECT_THAT(error("NRRD0004\n" + std::string(2 << 20, 'x')), HasSubstr("header: has no end"));
}

// As bgzip and pigz -i write them.
TEST_F(Nrrd, GzipMayHaveSeveralMembers) {
    const auto head = std::string("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 4 5\nencoding: gzip\n\n");
    const auto numbers = countedNumbers(60);
    const auto bytes = numberBytes<std::uint8_t>(numbers);
    EXPECT_THAT(read(head + gzipped(bytes.substr(0, 25)) + gzipped(bytes.substr(25)))->values,
                ElementsAreArray(numbers));
    EXPECT_THAT(error(head + gzipped(bytes) + gzipped("a whole slice")), HasSubstr("and it holds more"));
    const auto longer = must(read(head + gzipped(bytes) + gzipped("x")));
    EXPECT_THAT(longer.notes, testing::ElementsAre("a.nrrd: a byte behind its last value was left out"));
}

TEST_F(Nrrd, CutDataAreRefused) {
    const auto head = std::string("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 4 5\nencoding: gzip\n\n");
    const auto data = gzipped(numberBytes<std::uint8_t>(countedNumbers(60)));
    EXPECT_EQ(error(head + data), "");
    EXPECT_THAT(error(head + data.substr(0, 20)), HasSubstr("corrupt: a.nrrd: its gzip data is cut short"));
    EXPECT_THAT(error(head), HasSubstr("and it holds at most 0"));
    EXPECT_THAT(error(head + "not gzip at all, but long enough to be"), HasSubstr("is damaged"));
}

// MetaImage volumes: types, byte orders and compression, data beside the header, where voxels lie, and
// headers that contradict themselves or the file.

const std::string sizes = "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\n";
const std::string bytes = "ElementType = MET_UCHAR\n";

class MetaImage : public testing::Test, protected OneFile {
  protected:
    MetaImage() : OneFile("a.mha") {}
    /// A header of these lines before 60 bytes.
    std::string errorOf(const std::string& lines) {
        return error(lines + "ElementDataFile = LOCAL\n" + std::string(60, 'x'));
    }
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
