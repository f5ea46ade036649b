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

class Nifti : public testing::TestWithParam<int>, protected OneFile {
  protected:
    Nifti() : OneFile("a.nii") {}
    /// Of a header that `change` has changed, before 60 bytes.
    template <class Change>
    std::string error(Change change) {
        Header header(GetParam());
        change(header);
        return OneFile::error(header.bytes() + std::string(60, 'x'));
    }
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

// VTK image files: every encoding, type, byte order and width of sizes; which array is read and where it
// lies; files that contradict themselves.

std::string base64(const std::string& bytes) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        std::uint32_t bits = 0;
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
        for (std::size_t i = 0; i < 3; ++i) {
            bits = bits << 8 | (i < count ? static_cast<std::uint8_t>(bytes[at + i]) : 0u);
        }
        for (std::size_t i = 0; i < 4; ++i) text += i <= count ? digits[bits >> (18 - 6 * i) & 63] : '=';
    }
    return text;
}

/// How a file says one array of 3 x 4 x 5 points.
struct VtiForm {
    std::string type = "UInt8", format = "appended", encoding = "raw";
    bool big = false, wide = false, compressed = false;
    std::string extent = "0 2 0 3 0 4", image = "Origin=\"0 0 0\" Spacing=\"1 1 1\"";
    std::string data = "PointData", dataAttributes = "Scalars=\"s\"", arrayAttributes;
    std::uint64_t blockBytes = 7;  // which divides no number evenly

    std::string sizes(const std::vector<double>& numbers) const {
        return wide ? numberBytes<std::uint64_t>(numbers, big) : numberBytes<std::uint32_t>(numbers, big);
    }

    /// As in the file: sizes and values, compressed or not, in base64 or not.
    std::string wrapped(const std::string& bytes) const {
        const bool text = format == "binary" || encoding == "base64";
        if (!compressed) {
            const auto whole = sizes({static_cast<double>(bytes.size())}) + bytes;
            return text ? base64(whole) : whole;
        }
        std::vector<double> head = {0, static_cast<double>(blockBytes),
                                    static_cast<double>(bytes.size() % blockBytes)};
        std::string blocks;
        for (std::size_t at = 0; at < bytes.size(); at += blockBytes) {
            const auto block = zlibDeflated(bytes.substr(at, blockBytes));
            head.push_back(static_cast<double>(block.size()));
            head[0] += 1;
            blocks += block;
        }
        return text ? base64(sizes(head)) + base64(blocks) : sizes(head) + blocks;
    }

    std::string file(const std::string& content) const {
        const bool appended = format == "appended";
        return "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"" +
               std::string(big ? "BigEndian" : "LittleEndian") + "\" header_type=\"" +
               (wide ? "UInt64" : "UInt32") + "\"" +
               (compressed ? " compressor=\"vtkZLibDataCompressor\"" : "") + ">\n<ImageData WholeExtent=\"" +
               extent + "\" " + image + ">\n<Piece Extent=\"" + extent + "\">\n<" + data + " " +
               dataAttributes + ">\n<DataArray type=\"" + type + "\" Name=\"s\" format=\"" + format + "\" " +
               arrayAttributes +
               (appended ? " offset=\"0\"/>\n" : ">\n      " + content + "\n</DataArray>\n") + "</" + data +
               ">\n</Piece>\n</ImageData>\n" +
               (appended
                    ? "<AppendedData encoding=\"" + encoding + "\">\n   _" + content + "\n</AppendedData>\n"
                    : std::string()) +
               "</VTKFile>\n";
    }
};

class Vti : public testing::Test, protected OneFile {
  protected:
    Vti() : OneFile("a.vti") {}
    /// Of a file with 60 bytes in it.
    template <class Change>
    std::string errorOf(Change change) {
        VtiForm form;
        change(form);
        return error(form.file(form.wrapped(std::string(60, 'x'))));
    }
};

TEST_F(Vti, IsReadInEveryForm) {
    const std::vector<std::pair<std::string, std::string>> types = {
        {"UInt8", "u8"},   {"Int8", "i8"},   {"UInt16", "u16"},  {"Int16", "i16"},
        {"UInt32", "u32"}, {"Int32", "i32"}, {"Float32", "f32"}, {"Float64", "f64"}};
    const auto numbers = countedNumbers(60);
    for (const auto& [said, type] : types) {
        for (int bits = 0; bits < 24; ++bits) {
            VtiForm form;
            form.type = said;
            form.big = (bits & 1) != 0;
            form.wide = (bits & 2) != 0;
            form.compressed = (bits & 4) != 0;
            form.format = bits < 16 ? "appended" : "binary";
            form.encoding = bits < 8 ? "raw" : "base64";
            const auto volume = must(read(form.file(form.wrapped(numberBytes(type, numbers, form.big)))));
            EXPECT_EQ(volume.format, "vti");
            EXPECT_EQ(name(volume.shape.type), type);
            EXPECT_THAT(volume.values, ElementsAreArray(numbers)) << said << bits;
        }
    }
}

TEST_F(Vti, TextIsRead) {
    VtiForm form;
    form.type = "Int16";
    form.format = "ascii";
    form.extent = "0 1 0 1 0 1";
    const auto volume = must(read(form.file("-1 2 3\n 4 5\n6 7 8")));
    EXPECT_EQ(volume.shape.type, prep::ScalarType::i16);
    EXPECT_THAT(volume.values, ElementsAreArray({-1, 2, 3, 4, 5, 6, 7, 8}));
    EXPECT_THAT(error(form.file("1 2 3 4 5 6 7")), HasSubstr("and it holds less"));
    EXPECT_THAT(error(form.file("1 2 3 4 5 6 7 8 9")), HasSubstr("and it holds more"));
    EXPECT_THAT(error(form.file("1 2 3 4 5 6 7 &amp;")), HasSubstr("where a value should stand"));
}

TEST_F(Vti, GzippedFilesAndEarlierSlicesAreRead) {
    VtiForm form;
    form.compressed = true;
    const auto numbers = countedNumbers(60);
    const auto bytes = form.file(form.wrapped(numberBytes<std::uint8_t>(numbers)));
    EXPECT_THAT(read(gzipped(bytes))->values, ElementsAreArray(numbers));
    EXPECT_FALSE(read(bytes)->sequential);
    for (const auto* encoding : {"raw", "base64"}) {
        form.encoding = encoding;
        writeFile(folder_ / "b.vti", form.file(form.wrapped(numberBytes<std::uint8_t>(numbers))));
        EXPECT_THAT(readSlices(folder_ / "b.vti", {3, 0, 4, 2, 1, 1, 0}),
                    ElementsAreArray(slicesOf(numbers, 12, {3, 0, 4, 2, 1, 1, 0})));
    }
}

TEST_F(Vti, LiesWhereItsHeaderSays) {
    VtiForm form;
    form.extent = "10 12 0 3 -1 3";
    form.image = "Origin=\"1 2 3\" Spacing=\"2 1 0.5\" Direction=\"0 -1 0 1 0 0 0 0 1\"";
    const auto points = must(read(form.file(form.wrapped(std::string(60, 'x')))));
    EXPECT_EQ(worldOf(points.shape, 0, 0, 0), glm::dvec3(1, 22, 2.5));
    EXPECT_EQ(worldOf(points.shape, 1, 1, 1), glm::dvec3(0, 24, 3));
    form.data = "CellData";
    form.extent = "0 3 0 4 0 5";
    form.image = "Origin=\"1 2 3\" Spacing=\"2 1 0.5\"";
    const auto cells = must(read(form.file(form.wrapped(std::string(60, 'x')))));
    EXPECT_EQ(cells.shape.nz, 5u);
    EXPECT_EQ(worldOf(cells.shape, 0, 0, 0), glm::dvec3(2, 2.5, 3.25));
}

TEST_F(Vti, TheActiveOrTheNamedArrayIsRead) {
    const auto array = [](const std::string& name, const std::string& value, const std::string& more = "") {
        return "<DataArray type=\"UInt8\" Name=\"" + name + "\" format=\"ascii\" " + more + ">" + value +
               "</DataArray>";
    };
    const auto file = [](const std::string& points, const std::string& cells) {
        return "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"0 1 0 0 0 "
               "0\">"
               "<Piece Extent=\"0 1 0 0 0 0\">" +
               points + cells + "</Piece></ImageData></VTKFile>";
    };
    const auto cells = "<CellData>" + array("c", "9") + "</CellData>";
    const auto three =
        array("v", "1 2 3 4 5 6", "NumberOfComponents=\"3\"") + array("a", "1 2") + array("b", "3 4");
    const auto points = file("<PointData Scalars=\"b\">" + three + "</PointData>", cells);
    EXPECT_THAT(read(points)->values, ElementsAreArray({3, 4}));
    EXPECT_THAT(read(points, "a")->values, ElementsAreArray({1, 2}));
    EXPECT_THAT(read(points, "c")->values, ElementsAreArray({9}));
    EXPECT_THAT(error(points, "v"),
                HasSubstr("NumberOfComponents: is 3: ask for one as the field, v:0 to v:2, or for the length "
                          "of the vector, v:magnitude"));
    EXPECT_THAT(error(points, "v:3"), HasSubstr("NumberOfComponents: is 3"));
    EXPECT_THAT(read(points, "v:1")->values, ElementsAreArray({2, 5}));
    EXPECT_THAT(read(points, "v:magnitude")->values, ElementsAreArray({std::sqrt(14.0F), std::sqrt(77.0F)}));
    EXPECT_THAT(read(points, "a:0")->values, ElementsAreArray({1, 2}));
    const auto colon = file("<PointData>" + array("a:1", "5 6") + three + "</PointData>", "");
    EXPECT_THAT(read(colon, "a:1")->values, ElementsAreArray({5, 6}));
    EXPECT_THAT(error(points, "d"), HasSubstr("not_found: a.vti: has no array of the name \"d\""));
    EXPECT_THAT(read(file("<PointData>" + three + "</PointData>", cells))->values, ElementsAreArray({1, 2}));
    EXPECT_THAT(read(file("<PointData/>", cells))->values, ElementsAreArray({9}));
    EXPECT_THAT(error(file("<PointData/>", "")), HasSubstr("has no array with one value"));
}

TEST_F(Vti, ContradictionsAreRefused) {
    EXPECT_EQ(errorOf([](VtiForm&) {}), "");
    EXPECT_THAT(errorOf([](VtiForm& f) { f.extent = "0 2 0 3 0 5"; }),
                HasSubstr("its array says 60 bytes, and its extent needs 72"));
    EXPECT_THAT(errorOf([](VtiForm& f) { f.extent = "0 2 0 3 0"; }),
                HasSubstr("Piece: Extent: has 5 numbers"));
    EXPECT_THAT(errorOf([](VtiForm& f) { f.extent = "0 2 0 3 0 -2"; }),
                HasSubstr("Piece: Extent: says 0 to -2"));
    EXPECT_THAT(errorOf([](VtiForm& f) { f.extent = "0 2 0 3 0 0.5"; }), HasSubstr("Extent: says 0 to 0.5"));
    EXPECT_THAT(errorOf([](VtiForm& f) { f.extent = "0 999999 0 999999 0 999999"; }),
                HasSubstr("resource_exhausted: a.vti: Piece: Extent: says 1000000 x"));
    EXPECT_THAT(errorOf([](VtiForm& f) { f.image = "Spacing=\"1 0 1\""; }), HasSubstr("axis y lie 0 apart"));
    EXPECT_THAT(errorOf([](VtiForm& f) { f.image = "Spacing=\"1 nan 1\""; }), HasSubstr("Spacing: says nan"));
    EXPECT_THAT(errorOf([](VtiForm& f) { f.type = "String"; }), HasSubstr("\"String\" is no integer of 8"));
    EXPECT_THAT(errorOf([](VtiForm& f) { f.type = "String"; }), HasSubstr("DataArray: type"));
    EXPECT_THAT(
        errorOf([](VtiForm& f) { f.format = "binary", f.arrayAttributes = "NumberOfComponents=\"3\""; }),
        HasSubstr("has no array with one value"));
    VtiForm form;
    const auto whole = form.file(form.wrapped(std::string(60, 'x')));
    const auto replaced = [&](const std::string& from, const std::string& to) {
        std::string file = whole;
        return error(file.replace(file.find(from), from.size(), to));
    };
    EXPECT_THAT(replaced("offset=\"0\"", "offset=\"9999\""), HasSubstr("ends within its array's sizes"));
    EXPECT_THAT(replaced("offset=\"0\"", "offset=\"-1\""), HasSubstr("offset: says -1"));
    EXPECT_THAT(replaced("type=\"ImageData\"", "type=\"PolyData\""), HasSubstr("type: is not ImageData"));
    EXPECT_THAT(replaced("LittleEndian", "Middle"), HasSubstr("byte_order: is neither"));
    EXPECT_THAT(replaced("UInt32", "UInt128"), HasSubstr("header_type: is neither"));
    EXPECT_THAT(replaced("header_type", "compressor=\"vtkLZ4DataCompressor\" header_type"),
                HasSubstr("unsupported: a.vti: VTKFile: compressor"));
    EXPECT_THAT(replaced("_", " "), HasSubstr("is no XML"));
    EXPECT_THAT(replaced("   _", "    "), HasSubstr("AppendedData: does not begin with _"));
    EXPECT_THAT(replaced("<Piece", "<Piece Extent=\"0 0 0 0 0 0\"/><Piece"),
                HasSubstr("more than one piece"));
    EXPECT_THAT(replaced("<VTKFile", "<!DOCTYPE x [<!ENTITY a \"aaaa\">]><VTKFile"),
                HasSubstr("has a document type of its own"));
    EXPECT_THAT(error("<VTKFile type=\"" + std::string(3 << 20, 'x')), HasSubstr("is no XML"));
    EXPECT_THAT(error("<VTKFile/>"), HasSubstr("has no array"));
}

TEST_F(Vti, DamagedDataAreRefused) {
    VtiForm form;
    form.format = "binary";
    const auto values = std::string(60, 'x');
    EXPECT_EQ(error(form.file(form.wrapped(values))), "");
    EXPECT_THAT(error(form.file(form.wrapped(values).substr(0, 40))), HasSubstr("and it holds less"));
    EXPECT_THAT(error(form.file(form.wrapped(values).substr(0, 41))),
                HasSubstr("in the middle of its base64"));
    EXPECT_THAT(error(form.file("!!!!" + form.wrapped(values))), HasSubstr("means nothing there"));
    form.compressed = true;
    form.format = "appended";
    const auto packed = form.wrapped(values);
    EXPECT_EQ(error(form.file(packed)), "");
    const auto head = [&](const std::vector<double>& sizes) {
        return error(form.file(form.sizes(sizes) + packed.substr(4 * sizes.size())));
    };
    EXPECT_THAT(head({9, 7, 5}), HasSubstr("9 blocks of 7 bytes, the last one of 5"));
    EXPECT_THAT(head({8, 7, 4}), HasSubstr("and its extent needs 60 bytes"));
    EXPECT_THAT(head({8, 0, 0}), HasSubstr("8 blocks of 0 bytes"));
    EXPECT_THAT(head({9, 7, 4, 4e9}), HasSubstr("compressed blocks do not fit into the file"));
    EXPECT_THAT(head({1, 61, 60, 0}), HasSubstr("60 bytes cannot come out of 0 compressed ones"));
    EXPECT_THAT(head({1, 60, 0, 15}), HasSubstr("zlib data is damaged"));
    form.blockBytes = 70;
    const auto longer = form.wrapped(values + "1234567890"), shorter = form.wrapped(values.substr(10));
    const auto single = form.sizes({1, 60, 0, static_cast<double>(longer.size() - 16)});
    EXPECT_THAT(error(form.file(single + longer.substr(16))), HasSubstr("a block holds more than it should"));
    const auto less = form.sizes({1, 60, 0, static_cast<double>(shorter.size() - 16)});
    EXPECT_THAT(error(form.file(less + shorter.substr(16))), HasSubstr("block 0 holds less than it should"));
    std::string damaged = packed;
    damaged[12 * 4 + 3] ^= 0x55;
    EXPECT_THAT(error(form.file(damaged)), HasSubstr("corrupt: a.vti"));
}

}  // namespace
}  // namespace mote::test
