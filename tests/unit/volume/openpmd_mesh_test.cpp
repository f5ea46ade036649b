// SPDX-License-Identifier: GPL-3.0-or-later
//
// Meshes of openPMD files, written by this test in every order of axes that there is and held to plain
// formulas; and what happens where a file is cut, altered or hostile.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <glm/matrix.hpp>
#include <map>
#include <numbers>

#include "preprocess/volume/openpmd_mesh.h"
#include "tests/support/must.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/h5_test_file.h"
#include "tests/unit/volume/volume_files.h"

namespace mote::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string meshes = "/data/7/fields";

/// Texts as the array that axisLabels is, of fixed or variable length.
void texts(const H5TestFile& file, const std::string& object, const char* name,
           const std::vector<std::string>& values, bool variable) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, variable ? H5T_VARIABLE : 8);
    const hsize_t size = values.size();
    const hid_t space = H5Screate_simple(1, &size, nullptr);
    const hid_t owner = H5Oopen(file.id(), object.c_str(), H5P_DEFAULT);
    const hid_t attribute = H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    std::vector<const char*> pointers;
    std::string fixed(8 * values.size(), '\0');
    for (std::size_t i = 0; i < values.size(); ++i) {
        pointers.push_back(values[i].c_str());
        values[i].copy(fixed.data() + 8 * i, 8);
    }
    if (variable)
        H5Awrite(attribute, type, pointers.data());
    else
        H5Awrite(attribute, type, fixed.data());
    for (const auto close : {H5Aclose(attribute), H5Oclose(owner), H5Sclose(space), H5Tclose(type)})
        EXPECT_GE(close, 0);
}

/// m in a unit of the volume's world; a cell is 1 to 1000 of them wide.
double unitOf(const prep::VolumeShape& shape) {
    const std::map<std::string, double> units{{"fm", 1e-15}, {"pm", 1e-12}, {"nm", 1e-9}, {"um", 1e-6},
                                              {"mm", 1e-3},  {"m", 1.0},    {"km", 1e3}};
    const double width = std::cbrt(std::abs(glm::determinant(glm::dmat3(shape.indexToWorld))));
    EXPECT_GE(width, 1.0 - 1e-6);
    EXPECT_LT(width, 1000.0);
    return units.at(shape.worldUnit);
}

/// How a dataset is stored.
enum class Storage { contiguous, chunked, gzipped };

hid_t creationOf(Storage storage, const std::vector<hsize_t>& chunk) {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    if (storage != Storage::contiguous) H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
    if (storage == Storage::gzipped) {
        H5Pset_shuffle(creation);
        H5Pset_deflate(creation, 4);
    }
    return creation;
}

class OpenpmdMesh : public testing::Test {
  protected:
    std::filesystem::path path() const { return folder_ / "run.h5"; }

    /// The root's and an iteration's own words.
    static void writeRoot(H5TestFile& file) {
        file.text("/", "openPMD", "1.1.0");
        file.text("/", "basePath", "/data/%T/");
        file.text("/", "meshesPath", "fields/");
        file.group("/data/7");
        file.attribute("/data/7", "time", 2.5);
        file.attribute("/data/7", "timeUnitSI", 1e-12);
    }

    proto::VolumeSourceOptions field(const std::string& name) const {
        proto::VolumeSourceOptions options;
        options.set_field(name);
        return options;
    }

    /// Opens a scalar mesh of which one thing was changed after it had been written well.
    std::string errorWith(const std::function<void(H5TestFile&)>& change, const std::string& name = "rho") {
        {
            H5TestFile file(path());
            writeRoot(file);
            std::vector<double> values(24, 1.0);
            values[3] = 2.0;
            const hid_t creation = creationOf(Storage::contiguous, {});
            file.write(meshes + "/rho", H5T_NATIVE_DOUBLE, values.data(), {2, 3, 4}, creation);
            H5Pclose(creation);
            change(file);
            const auto missing = [&](const char* attribute) {
                return H5Aexists_by_name(file.id(), (meshes + "/rho").c_str(), attribute, H5P_DEFAULT) == 0;
            };
            if (missing("axisLabels")) texts(file, meshes + "/rho", "axisLabels", {"z", "y", "x"}, false);
            if (missing("gridSpacing"))
                file.attribute(meshes + "/rho", "gridSpacing", std::vector<double>{1, 1, 1});
        }
        return volumeError(path(), field(name));
    }

    TempDir folder_;
};

TEST_F(OpenpmdMesh, LiesInTheWorldWhateverTheOrderOfItsAxes) {
    Random random(1);
    for (int round = 0; round < 60; ++round) {
        std::vector<std::string> labels{"x", "y", "z"};
        for (std::size_t i = 2; i > 0; --i) std::swap(labels[i], labels[random.below(i + 1)]);
        if (random.chance(0.25)) labels.pop_back();
        const auto rank = labels.size();
        std::vector<hsize_t> extent, chunk;
        std::vector<double> spacing, offset, position;
        hsize_t all = 1;
        for (std::size_t i = 0; i < rank; ++i) {
            extent.push_back(1 + random.below(7));
            chunk.push_back(1 + random.below(4));
            spacing.push_back(random.magnitude(-3, 3));
            offset.push_back(random.between(-5.0, 5.0));
            position.push_back(random.oneOf({0.0, 0.5}));
            all *= extent.back();
        }
        std::vector<double> values(all);
        for (auto& value : values) value = random.between(-1.0, 1.0);
        const bool fortran = random.chance(0.3);
        const auto storage = random.oneOf({Storage::contiguous, Storage::chunked, Storage::gzipped});
        const double unit = random.magnitude(-20, 20);
        {
            H5TestFile file(path());
            writeRoot(file);
            const auto record = meshes + "/E", component = record + "/x";
            file.group(record);
            const hid_t creation = creationOf(storage, chunk);
            file.write(component, H5T_NATIVE_DOUBLE, values.data(), extent, creation);
            H5Pclose(creation);
            const auto ordered = [&](auto list) {
                if (fortran) std::reverse(list.begin(), list.end());
                return list;
            };
            texts(file, record, "axisLabels", ordered(labels), random.chance(0.5));
            file.text(record, "dataOrder", fortran ? "F" : "C");
            file.text(record, "geometry", "cartesian");
            file.attribute(record, "gridSpacing", ordered(spacing));
            file.attribute(record, "gridGlobalOffset", ordered(offset));
            file.attribute(record, "gridUnitSI", 1e-3);
            file.attribute(record, "unitDimension", std::vector<double>{1, 1, -3, -1, 0, 0, 0});
            file.attribute(component, "unitSI", unit);
            file.attribute(component, "position", ordered(position));
        }
        const auto read = must(readVolume(path(), field("E/x")));
        EXPECT_EQ(read.shape.valueUnit, "V/m");
        const double metre = unitOf(read.shape);
        ASSERT_EQ(read.values.size(), all);
        // Each voxel by its place in the world, and by its indices in the file.
        const std::array<std::uint32_t, 3> size{read.shape.nx, read.shape.ny, read.shape.nz};
        for (std::size_t i = 0; i < all; ++i) {
            const glm::dvec4 index(static_cast<double>(i % size[0]),
                                   static_cast<double>(i / size[0] % size[1]),
                                   static_cast<double>(i / size[0] / size[1]), 1.0);
            const glm::dvec3 place(read.shape.indexToWorld * index);
            std::size_t at = 0;
            for (std::size_t axis = 0; axis < rank; ++axis) {
                const double world = place[labels[axis][0] - 'x'];
                const double along = (world * metre / 1e-3 - offset[axis]) / spacing[axis] - position[axis];
                EXPECT_NEAR(along, std::round(along), 1e-9);
                at = at * extent[axis] + static_cast<std::size_t>(std::llround(along));
            }
            ASSERT_LT(at, all);
            EXPECT_EQ(read.values[i], static_cast<float>(values[at] * unit));
        }
    }
}

/// f(r, theta, z), with a first and a second mode.
double modesAt(double r, double theta, double z) {
    return 1.0 + z + r * r + r * (0.5 * std::cos(theta) - 0.25 * std::sin(theta)) +
           r * r * (z * std::cos(2.0 * theta) + 0.125 * std::sin(2.0 * theta));
}

constexpr double dr = 0.01, dz = 0.5;
constexpr std::size_t nr = 50, nz = 4;

/// The same as thetaMode writes it, values in the middle of cells along r.
void writeModes(H5TestFile& file, bool rFirst, double imaginary) {
    std::vector<double> values;
    const auto part = [&](std::size_t index, double r, double z) {
        const std::array<double, 5> parts{1.0 + z + r * r, 0.5 * r, -0.25 * r * imaginary, r * r * z,
                                          0.125 * r * r * imaginary};
        return parts[index];
    };
    for (std::size_t index = 0; index < 5; ++index) {
        for (std::size_t a = 0; a < (rFirst ? nr : nz); ++a) {
            for (std::size_t b = 0; b < (rFirst ? nz : nr); ++b) {
                const auto i = static_cast<double>(rFirst ? a : b), k = static_cast<double>(rFirst ? b : a);
                values.push_back(part(index, (i + 0.5) * dr, 3.0 + k * dz));
            }
        }
    }
    const auto record = meshes + "/rho";
    const hid_t creation = creationOf(Storage::chunked, {1, 3, 3});
    file.write(record, H5T_NATIVE_DOUBLE, values.data(), {5, rFirst ? nr : nz, rFirst ? nz : nr}, creation);
    H5Pclose(creation);
    texts(file, record, "axisLabels",
          rFirst ? std::vector<std::string>{"r", "z"} : std::vector<std::string>{"z", "r"}, true);
    file.text(record, "geometry", "thetaMode");
    file.text(record, "geometryParameters", imaginary < 0.0 ? "m=2;imag=-" : "m=2;imag=+");
    const std::vector<double> spacing{dr, dz}, offset{0.0, 3.0}, position{0.5, 0.0};
    const auto ordered = [&](std::vector<double> list) {
        if (!rFirst) std::swap(list[0], list[1]);
        return list;
    };
    file.attribute(record, "gridSpacing", ordered(spacing));
    file.attribute(record, "gridGlobalOffset", ordered(offset));
    file.attribute(record, "position", ordered(position));
}

class ThetaModes : public OpenpmdMesh, public testing::WithParamInterface<bool> {};
INSTANTIATE_TEST_SUITE_P(AxesOfTheFile, ThetaModes, testing::Bool());

TEST_P(ThetaModes, AddUpOnAGridAndInAPlane) {
    for (const double imaginary : {1.0, -1.0}) {
        {
            H5TestFile file(path());
            writeRoot(file);
            writeModes(file, GetParam(), imaginary);
        }
        for (const std::string name : {"rho", "rho@0", "rho@30", "rho@-100"}) {
            const auto read = must(readVolume(path(), field(name)));
            const bool plane = name != "rho";
            EXPECT_EQ(read.shape.nx, 2 * nr);
            EXPECT_EQ(read.shape.ny, plane ? 1U : 2 * nr);
            std::size_t inside = 0;
            for (std::size_t i = 0; i < read.values.size(); ++i) {
                const auto x = i % read.shape.nx, y = i / read.shape.nx % read.shape.ny,
                           z = i / read.shape.voxelsOfSlice();
                const auto place =
                    unitOf(read.shape) * glm::dvec3(read.shape.indexToWorld *
                                                    glm::dvec4(static_cast<double>(x), static_cast<double>(y),
                                                               static_cast<double>(z), 1.0));
                const double radius = std::hypot(place.x, place.y);
                if (radius > (nr - 0.5) * dr) continue;  // the last value is held, and then there is nothing
                ++inside;
                const double angle = std::atan2(place.y, place.x);
                // Linear in r between values of r^2: an eighth of the second derivative, 2 (1 + z + 1/8),
                // times dr^2; and rounding to float.
                const double tolerance = dr * dr / 4.0 * (place.z + 2.0) + 1e-6 * place.z;
                EXPECT_NEAR(read.values[i], modesAt(radius, angle, place.z), tolerance)
                    << name << ", voxel " << i;
                if (plane) {
                    const double along = std::stod(name.substr(4)) * std::numbers::pi / 180.0;
                    EXPECT_NEAR(place.x * std::sin(along) - place.y * std::cos(along), 0.0, 1e-12);
                }
            }
            EXPECT_GT(inside, read.values.size() / 2);
        }
    }
}

TEST_F(OpenpmdMesh, HasEachIterationAsAStepWithItsTime) {
    {
        H5TestFile file(path());
        writeRoot(file);
        for (const int iteration : {30, 4, 100}) {
            const auto group = "/data/" + std::to_string(iteration);
            file.group(group);
            file.attribute(group, "time", 0.5 * iteration);
            const std::vector<float> values{0.0F, 1.0F, 2.0F, static_cast<float>(iteration)};
            file.group(group + "/fields");
            const hid_t creation = creationOf(Storage::contiguous, {});
            file.write(group + "/fields/phi", H5T_NATIVE_FLOAT, values.data(), {2, 2}, creation);
            H5Pclose(creation);
            texts(file, group + "/fields/phi", "axisLabels", {"z", "x"}, false);
            file.attribute(group + "/fields/phi", "gridSpacing", std::vector<double>{1, 2});
        }
    }
    H5TestFile other(folder_ / "other.h5");
    writeRoot(other);
    const auto steps = must(prep::volumeSteps(field("phi"), {path(), folder_ / "no.nrrd"}));
    std::vector<std::string> fields;
    for (const auto& step : steps) fields.push_back(step.options.field());
    EXPECT_THAT(fields, ElementsAre("4:phi", "7:phi", "30:phi", "100:phi", "phi"));
    const auto last = must(prep::openOpenpmdMesh(path(), "100:phi"));
    EXPECT_EQ(last->time(), 50.0);
    EXPECT_THAT(volumeError(path(), field("phi")), HasSubstr("several iterations"));
    EXPECT_THAT(volumeError(path(), field("5:phi")),
                HasSubstr("has no iteration 5; there are 4, 7, 30, 100"));
    EXPECT_THAT(volumeError(path(), field("7:phi")), HasSubstr("holds no meshes"));
}

TEST_F(OpenpmdMesh, SaysWhichFieldsThereAre) {
    EXPECT_EQ(errorWith([](H5TestFile&) {}), "");
    EXPECT_EQ(errorWith([](H5TestFile&) {}, ""), "") << "the only one";
    EXPECT_THAT(errorWith([](H5TestFile&) {}, "E/x"), HasSubstr("holds no field \"E/x\"; there is rho"));
    EXPECT_THAT(errorWith([](H5TestFile& file) { file.data(meshes + "/B/x", std::vector<double>{1.0}); }, ""),
                HasSubstr("name one with --field; there are B/x, rho"));
    for (const char* name : {"a:rho", "rho@", "rho@x", "/x", "E/", "E/x/y", "-1:rho", "rho@inf"})
        EXPECT_THAT(errorWith([](H5TestFile&) {}, name), HasSubstr("invalid_argument: field")) << name;
    EXPECT_THAT(errorWith([](H5TestFile&) {}, "rho@30"), HasSubstr("thetaMode"));
    EXPECT_THAT(errorWith([](H5TestFile& file) { file.constant(meshes + "/n", 1.0, 8); }, "n"),
                HasSubstr("unsupported"));
}

TEST_F(OpenpmdMesh, RefusesWhatItsAttributesCannotMean) {
    const auto with = [&](auto... arguments) {
        return errorWith([&](H5TestFile& file) { file.attribute(meshes + "/rho", arguments...); });
    };
    EXPECT_THAT(with("gridSpacing", std::vector<double>{1, 1}),
                HasSubstr("has 2 numbers where the mesh has 3 axes"));
    EXPECT_THAT(with("gridSpacing", std::vector<double>{1, 0, 1}), HasSubstr("gridSpacing"));
    EXPECT_THAT(with("gridSpacing", std::vector<double>{1, std::nan(""), 1}), HasSubstr("is not finite"));
    EXPECT_THAT(with("gridSpacing", std::vector<double>{1e300, 1, 1}), HasSubstr("corrupt"));
    EXPECT_THAT(with("gridGlobalOffset", std::vector<double>{1, 1, INFINITY}), HasSubstr("is not finite"));
    EXPECT_THAT(with("position", std::vector<double>{0}), HasSubstr("position"));
    EXPECT_THAT(with("unitSI", std::nan("")), HasSubstr("unitSI"));
    const auto labelled = [&](const std::vector<std::string>& labels) {
        return errorWith([&](H5TestFile& file) { texts(file, meshes + "/rho", "axisLabels", labels, true); });
    };
    EXPECT_THAT(labelled({"x", "y"}), HasSubstr("names 2 axes of a mesh of 3"));
    EXPECT_THAT(labelled({"x", "y", "x"}), HasSubstr("has an axis \"x\""));
    EXPECT_THAT(labelled({"x", "y", "w"}), HasSubstr("has an axis \"w\""));
    const auto geometry = [&](const std::string& name) {
        return errorWith([&](H5TestFile& file) { file.text(meshes + "/rho", "geometry", name); });
    };
    EXPECT_THAT(geometry("spherical"), HasSubstr("cartesian and thetaMode are read"));
    EXPECT_THAT(geometry("thetaMode"), HasSubstr("2 parts of modes"));
}

TEST_F(OpenpmdMesh, BelievesNoSizeThatTheFileDoesNotBearOut) {
    const auto sized = [&](const std::vector<hsize_t>& extent, const std::vector<hsize_t>& chunk) {
        return errorWith(
            [&](H5TestFile& file) {
                const hid_t creation =
                    creationOf(chunk.empty() ? Storage::contiguous : Storage::chunked, chunk);
                file.empty(meshes + "/big", extent, creation);
                H5Pclose(creation);
                texts(file, meshes + "/big", "axisLabels", {"z", "y", "x"}, false);
                file.attribute(meshes + "/big", "gridSpacing", std::vector<double>{1, 1, 1});
            },
            "big");
    };
    EXPECT_THAT(sized({60000, 60000, 60000}, {}), HasSubstr("declares"));
    EXPECT_THAT(sized({60000, 60000, 60000}, {10, 10, 10}), HasSubstr("declares"));
    EXPECT_THAT(sized({1ULL << 30, 1ULL << 16, 1ULL << 10}, {64, 64, 64}), HasSubstr("declares"));
    EXPECT_THAT(sized({600, 600, 1100}, {1 << 9, 1 << 9, 1 << 10}), HasSubstr("chunks of"));
    EXPECT_THAT(sized({0, 4, 4}, {1, 4, 4}), HasSubstr("no voxels"));
    EXPECT_THAT(
        errorWith([](H5TestFile& file) { file.data(meshes + "/line", std::vector<double>(9, 1.0)); }, "line"),
        HasSubstr("has 1 dimensions"));
}

TEST_F(OpenpmdMesh, SurvivesFilesThatAreCutAndAltered) {
    {
        H5TestFile file(path());
        writeRoot(file);
        std::vector<double> values(5 * 6 * 7);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i);
        const hid_t creation = creationOf(Storage::gzipped, {2, 3, 4});
        file.write(meshes + "/rho", H5T_NATIVE_DOUBLE, values.data(), {5, 6, 7}, creation);
        H5Pclose(creation);
        texts(file, meshes + "/rho", "axisLabels", {"x", "y", "z"}, true);
        file.attribute(meshes + "/rho", "gridSpacing", std::vector<double>{1, 1, 1});
    }
    std::ifstream stream(path(), std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    ASSERT_EQ(volumeError(path(), field("rho")), "");
    Random random(9);
    for (int i = 0; i < 400; ++i) {
        auto bytes = whole;
        if (i % 4 == 0) bytes.resize(random.below(bytes.size()));
        for (auto left = random.below(4); left > 0 && !bytes.empty(); --left)
            bytes[random.below(bytes.size())] ^= static_cast<char>(1U << random.below(8));
        writeFile(path(), bytes);
        // Read, or told in a sentence: the place where a bit fell decides. Nothing else may happen.
        const auto said = volumeError(path(), field("rho"));
        EXPECT_EQ(said.find('\n'), std::string::npos);
    }
}

// Volumes that other people's programs wrote, against what another reading of their bytes (NumPy, by the
// formats' definitions) gave: extremes, values here and there, and a sum in which every voxel has its weight.

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

// clang-format off
const Known knownVolumes[] = {
    {"engine_256x256x128_uint8.raw.gz", "raw", {256, 256, 128}, "u8", 0, 255, 187475057, 93394903725, 133,
     {0, 0, 0}, {1, 1, 1}},
    {"ct_chest_abdomen_512x512x134_int16.nrrd", "nrrd", {512, 512, 134}, "i16", -1000, 1988, -24950407038,
     -12424852564553, 82, {0, 0, 0}, {1.07421875, 1.07421875, 3.0}},
    {"frog_500x470x136_uint8.nrrd", "nrrd", {500, 470, 136}, "u8", 0, 254, 576245255, 286963360693, 31,
     {0, 0, 0}, {1, 1, 1.5}},
    // Its origin is stored in single precision.
    {"torso_ct_122x101x112_3mm.nii.gz", "nifti", {122, 101, 112}, "i32", -1207, 3382, -496851173, -247279329021, 164,
     {-177.95632934570312, 11.319000244140625, 94.3017578125}, {3, 3, 3}}};
// clang-format on

INSTANTIATE_TEST_SUITE_P(All, RealVolumes, testing::ValuesIn(knownVolumes), [](const auto& sample) {
    const std::string name = sample.param.file;
    return name.substr(0, name.find('_'));
});

}  // namespace
}  // namespace mote::test
