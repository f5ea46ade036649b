// SPDX-License-Identifier: GPL-3.0-or-later
//
// openPMD in ADIOS2's files, made here by ADIOS2 itself of the same run in HDF5: what is read of them, and
// the datasets that are prepared, have the same bytes.
#include <adios2.h>
#include <gmock/gmock.h>
#include <hdf5.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <random>

#include "tests/unit/readers/h5_test_file.h"
#include "tests/unit/readers/openpmd_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::HasSubstr;
using BpRun = SourceTest;

/// How a run is written.
struct BpForm {
    enum class Steps { together, each, variable };
    std::string engine = "BP5";
    Steps steps = Steps::together;
    std::size_t blocks = 1;
    std::string compressor = {};
    double share = 1.0;        ///< of each variable's values that is written
    std::string padding = {};  ///< of every name: "/" makes "//data//1"
};

/// Copies an openPMD file of HDF5 by ADIOS2's interface: each dataset is a variable, each attribute one.
class BpCopy {
  public:
    BpCopy(const std::filesystem::path& from, const std::filesystem::path& to, BpForm form)
        : form_(std::move(form)) {
        collect(from);
        auto io = adios_.DeclareIO("copy");
        io.SetEngine(form_.engine);
        io.SetParameter("StatsLevel", "0");
        auto engine = io.Open(to, adios2::Mode::Write);
        const bool bySteps = form_.steps != BpForm::Steps::together;
        for (const auto& [iteration, puts] : steps_) {
            if (bySteps || &puts == &steps_.begin()->second) engine.BeginStep();
            for (const auto& put : puts) put(io, engine);
            if (bySteps) {
                if (form_.steps == BpForm::Steps::variable)
                    io.DefineAttribute<std::uint64_t>("/data/snapshot", std::stoull(iteration), "", "/",
                                                      true);
                engine.EndStep();
            }
        }
        if (!bySteps) engine.EndStep();
        engine.Close();
    }

  private:
    using Put = std::function<void(adios2::IO&, adios2::Engine&)>;

    void collect(const std::filesystem::path& from) {
        const hid_t file = H5Fopen(from.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
        addGroup(file, "");
        H5Fclose(file);
        // What belongs to no iteration is written with the first.
        auto root = steps_.extract("");
        auto& first = steps_.begin()->second;
        first.insert(first.begin(), root.mapped().begin(), root.mapped().end());
    }

    /// Puts that belong to the iteration of a path, and the name there.
    std::vector<Put>& stepOf(std::string& path) {
        std::string iteration;
        if (path.starts_with("/data/")) {
            iteration = path.substr(6, path.find('/', 6) - 6);
            if (form_.steps == BpForm::Steps::variable) path = "/data" + path.substr(6 + iteration.size());
        }
        std::string padded;
        for (const char letter : path) padded += letter == '/' ? form_.padding + "/" : std::string(1, letter);
        path = padded;
        return steps_[iteration];
    }

    void addGroup(hid_t file, const std::string& path) {
        const hid_t group = H5Gopen2(file, path.empty() ? "/" : path.c_str(), H5P_DEFAULT);
        addAttributes(group, path);
        hsize_t count = 0;
        H5Gget_num_objs(group, &count);
        for (hsize_t i = 0; i < count; ++i) {
            std::array<char, 256> name{};
            H5Gget_objname_by_idx(group, i, name.data(), name.size());
            const auto child = path + "/" + name.data();
            if (H5Gget_objtype_by_idx(group, i) == H5G_GROUP)
                addGroup(file, child);
            else
                addDataset(file, child);
        }
        H5Gclose(group);
    }

    template <class T>
    void addValues(hid_t dataset, hid_t type, const adios2::Dims& extent, std::string path) {
        std::size_t size = 1;
        for (const auto length : extent) size *= length;
        std::vector<T> values(size);
        H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
        auto& puts = stepOf(path);
        puts.push_back([this, path, extent, values](adios2::IO& io, adios2::Engine& engine) {
            auto variable = io.InquireVariable<T>(path);
            if (!variable) {
                variable = io.DefineVariable<T>(path, extent, adios2::Dims(extent.size(), 0), extent);
                // ADIOS2 has no room for what becomes no smaller.
                if (!form_.compressor.empty() && values.size() > 1000 && !std::is_same_v<T, std::uint64_t>)
                    variable.AddOperation(form_.compressor, {});
            }
            variable.SetShape(extent);
            // Along the first dimension, a block after the other.
            const auto written = static_cast<std::size_t>(static_cast<double>(extent[0]) * form_.share);
            for (std::size_t block = 0; block < form_.blocks; ++block) {
                auto first = adios2::Dims(extent.size(), 0), count = extent;
                first[0] = written * block / form_.blocks;
                count[0] = written * (block + 1) / form_.blocks - first[0];
                if (count[0] == 0 && block > 0) continue;
                variable.SetSelection({first, count});
                engine.Put(variable, values.data() + first[0] * (extent[0] ? values.size() / extent[0] : 0),
                           adios2::Mode::Sync);
            }
        });
    }

    void addDataset(hid_t file, const std::string& path) {
        const hid_t dataset = H5Dopen2(file, path.c_str(), H5P_DEFAULT);
        const hid_t type = H5Dget_type(dataset), space = H5Dget_space(dataset);
        adios2::Dims extent(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
        std::vector<hsize_t> lengths(extent.size());
        H5Sget_simple_extent_dims(space, lengths.data(), nullptr);
        extent.assign(lengths.begin(), lengths.end());
        if (H5Tequal(type, H5T_NATIVE_DOUBLE) > 0) addValues<double>(dataset, type, extent, path);
        if (H5Tequal(type, H5T_NATIVE_FLOAT) > 0) addValues<float>(dataset, type, extent, path);
        if (H5Tequal(type, H5T_NATIVE_INT32) > 0) addValues<std::int32_t>(dataset, type, extent, path);
        if (H5Tequal(type, H5T_NATIVE_UINT64) > 0) addValues<std::uint64_t>(dataset, type, extent, path);
        addAttributes(dataset, path);
        H5Sclose(space);
        H5Tclose(type);
        H5Dclose(dataset);
    }

    void addAttributes(hid_t object, const std::string& path) {
        const int count = H5Aget_num_attrs(object);
        for (int i = 0; i < count; ++i) {
            const hid_t attribute = H5Aopen_idx(object, static_cast<unsigned>(i));
            std::array<char, 256> name{};
            H5Aget_name(attribute, name.size(), name.data());
            addAttribute(attribute, path + "/" + name.data());
            H5Aclose(attribute);
        }
    }

    void addAttribute(hid_t attribute, std::string path) {
        const hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
        const auto size = static_cast<std::size_t>(H5Sget_simple_extent_npoints(space));
        const bool variable = form_.steps == BpForm::Steps::variable;
        const auto plain = path;
        auto& puts = stepOf(path);
        if (H5Tget_class(type) == H5T_STRING) {
            const auto length = H5Tget_size(type);
            std::string bytes(length * size, '\0');
            H5Aread(attribute, type, bytes.data());
            std::vector<std::string> texts;
            for (std::size_t i = 0; i < size; ++i) {
                auto& text = texts.emplace_back(bytes, i * length, length);
                text.resize(text.find_last_not_of('\0') + 1);
            }
            if (variable && plain == "/basePath") texts = {"/data"};
            if (variable && plain == "/iterationEncoding") texts = {"variableBased"};
            puts.push_back([path, texts](adios2::IO& io, adios2::Engine&) {
                io.DefineAttribute(path, texts.data(), texts.size(), "", "/", path.starts_with("/data/"));
            });
        } else if (H5Tget_class(type) == H5T_FLOAT) {
            std::vector<double> values(size);
            H5Aread(attribute, H5T_NATIVE_DOUBLE, values.data());
            puts.push_back([path, values, variable](adios2::IO& io, adios2::Engine&) {
                io.DefineAttribute(path, values.data(), values.size(), "", "/", variable);
            });
        } else {
            std::vector<std::int64_t> values(size);
            H5Aread(attribute, H5T_NATIVE_INT64, values.data());
            puts.push_back([path, values, variable](adios2::IO& io, adios2::Engine&) {
                io.DefineAttribute(path, values.data(), values.size(), "", "/", variable);
            });
        }
        H5Sclose(space);
        H5Tclose(type);
    }

    BpForm form_;
    std::map<std::string, std::vector<Put>> steps_;  ///< by iteration; "" of none
    adios2::ADIOS adios_;
};

/// axisLabels z, y, x, an array of texts.
void writeLabels(H5TestFile& file, const std::string& mesh) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, 1);
    const hsize_t three = 3;
    const hid_t space = H5Screate_simple(1, &three, nullptr);
    const hid_t object = H5Oopen(file.id(), mesh.c_str(), H5P_DEFAULT);
    const hid_t attribute = H5Acreate2(object, "axisLabels", type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, "zyx");
    H5Aclose(attribute);
    H5Oclose(object);
    H5Sclose(space);
    H5Tclose(type);
}

/// Iterations 7 and 42 of 3,000 and 2,500 electrons, and ions beside them: floats and doubles, a constant
/// mass and charge, ids, weights, a record of another name, and a mesh.
void writeRun(const std::filesystem::path& path, const std::vector<int>& iterations, unsigned seed = 1) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    H5TestFile file(path);
    writeRoot(file, "/data/%T/", "particles/");
    file.text("/", "meshesPath", "meshes/");
    file.text("/", "iterationEncoding", "groupBased");
    for (const int iteration : iterations) {
        const auto data = "/data/" + std::to_string(iteration);
        const std::size_t rows = iteration == 7 ? 3000 : 2500;
        const auto draw = [&](double scale) {
            std::vector<double> values(rows);
            for (double& value : values) value = scale * std::round(64.0 * normal(random)) / 64.0;
            return values;
        };
        file.group(data);
        file.attribute(data, "time", iteration * 0.25);
        file.attribute(data, "timeUnitSI", 1e-15);
        for (const char* name : {"electrons", "ions"}) {
            const auto species = data + "/particles/" + name;
            for (const char* axis : {"x", "y", "z"}) {
                const auto place = draw(1e3);
                file.data(species + "/position/" + axis, std::vector<float>(place.begin(), place.end()));
                file.attribute(species + "/position/" + axis, "unitSI", 1e-6);
                file.constant(species + "/positionOffset/" + axis, 2.5, static_cast<std::int64_t>(rows),
                              1e-6);
                file.data(species + "/momentum/" + axis, draw(1e6));
                file.attribute(species + "/momentum/" + axis, "unitSI", electronvolt);
            }
            file.attribute(species + "/momentum", "unitDimension", std::vector<double>{1, 1, -1, 0, 0, 0, 0});
            file.data(species + "/weighting", draw(10.0));
            file.data(species + "/temper", draw(5.0));
            std::vector<std::uint64_t> ids(rows);
            for (auto& id : ids) id = random();
            file.data(species + "/id", ids);
            file.constant(species + "/mass", 9.1093837015e-31, static_cast<std::int64_t>(rows));
            file.constant(species + "/charge", -1.602176634e-19, static_cast<std::int64_t>(rows));
        }
        std::vector<double> field(4 * 5 * 6);
        for (double& value : field) value = normal(random);
        file.write(data + "/meshes/rho", H5T_NATIVE_DOUBLE, field.data(), {4, 5, 6}, H5P_DEFAULT);
        file.attribute(data + "/meshes/rho", "gridSpacing", std::vector<double>{1, 2, 3});
        file.attribute(data + "/meshes/rho", "gridGlobalOffset", std::vector<double>{0, 0, 0});
        file.attribute(data + "/meshes/rho", "gridUnitSI", 1e-6);
        file.attribute(data + "/meshes/rho", "unitSI", 2.0);
        file.attribute(data + "/meshes/rho", "position", std::vector<double>{0, 0, 0});
        file.text(data + "/meshes/rho", "geometry", "cartesian");
        writeLabels(file, data + "/meshes/rho");
        file.text(data + "/meshes/rho", "dataOrder", "C");
    }
}

std::map<std::string, std::string> bytesOf(const std::filesystem::path& dataset) {
    std::map<std::string, std::string> bytes;
    for (const auto& entry : std::filesystem::directory_iterator(dataset)) {
        std::ifstream file(entry.path(), std::ios::binary);
        bytes[entry.path().filename()] = {std::istreambuf_iterator<char>(file), {}};
    }
    return bytes;
}

/// The dataset that mote-prep makes of what lies in a folder; what it says is kept in the folder.
std::map<std::string, std::string> prepared(const std::filesystem::path& folder,
                                            const std::string& arguments) {
    const auto out = folder / "out.mote";
    const auto command = "cd " + folder.string() + " && " MOTE_BIN "/mote-prep " + arguments + " --out " +
                         out.string() + " >said.txt 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << bytesOf(folder)["said.txt"];
    return bytesOf(out);
}

std::string nameOf(const BpForm& form) {
    const char* steps = form.steps == BpForm::Steps::together ? " together"
                        : form.steps == BpForm::Steps::each   ? " a step each"
                                                              : " variable based";
    return form.engine + steps + ", blocks " + std::to_string(form.blocks) + " " + form.compressor;
}

TEST_F(BpRun, preparesTheSameBytesAsHdf5) {
    const std::vector<std::string> commands{
        "particles run.h5 --species electrons --axes x,px,y",
        "volume run.h5 --field 42:rho",
    };
    std::filesystem::create_directory(folder / "h5");
    writeRun(folder / "h5" / "run.h5", {7, 42});
    std::vector<std::map<std::string, std::string>> wanted;
    for (const auto& command : commands) {
        wanted.push_back(prepared(folder / "h5", command));
        std::filesystem::remove_all(folder / "h5" / "out.mote");
        EXPECT_GT(wanted.back().size(), 2U);
    }
    int made = 0;
    for (const char* engine : {"BP4", "BP5"}) {
        for (const auto steps : {BpForm::Steps::together, BpForm::Steps::each, BpForm::Steps::variable}) {
            for (const auto& [blocks, compressor] :
                 {std::pair{1, ""}, std::pair{3, ""}, std::pair{4, "bzip2"}}) {
                const BpForm form{engine, steps, static_cast<std::size_t>(blocks), compressor, 1.0, ""};
                const auto place = folder / std::to_string(made++);
                std::filesystem::create_directory(place);
                BpCopy(folder / "h5" / "run.h5", place / "run.h5", form);
                for (std::size_t i = 0; i < commands.size(); ++i) {
                    EXPECT_TRUE(prepared(place, commands[i]) == wanted[i])
                        << nameOf(form) << ": " << commands[i];
                    std::filesystem::remove_all(place / "out.mote");
                }
            }
        }
    }
}

TEST_F(BpRun, ofAFileAStepIsOneSeries) {
    for (const char* side : {"h5", "bp"}) std::filesystem::create_directory(folder / side);
    for (const int iteration : {7, 42}) {
        const auto name = "run_" + std::to_string(iteration) + ".h5";
        writeRun(folder / "h5" / name, {iteration}, static_cast<unsigned>(iteration));
        BpCopy(folder / "h5" / name, folder / "bp" / name, {.engine = iteration == 7 ? "BP4" : "BP5"});
    }
    for (const char* inputs : {"run_%T.h5", "run_42.h5 run_7.h5", "."}) {
        const auto command = std::string("particles ") + inputs + " --species ions --axes z,pz,x";
        auto wanted = prepared(folder / "h5", command), got = prepared(folder / "bp", command);
        // Of ".", the title is the folder's name.
        for (auto* side : {&wanted, &got})
            std::erase_if(*side, [](const auto& file) { return file.first.starts_with("manifest"); });
        EXPECT_TRUE(wanted == got) << inputs;
        EXPECT_EQ(wanted.count("step-000001.h5"), 1U);
        for (const char* side : {"h5", "bp"}) std::filesystem::remove_all(folder / side / "out.mote");
    }
}

TEST_F(BpRun, namesMayHaveEmptyParts) {
    writeRun(folder / "run.h5", {7});
    BpCopy(folder / "run.h5", folder / "run.bp", {.engine = "BP5", .padding = "/"});
    proto::ParticlesJob job;
    job.set_species("ions");
    MOTE_OPEN(wanted, {folder / "run.h5"}, progress, job);
    MOTE_OPEN(got, {folder / "run.bp"}, progress, job);
    EXPECT_EQ(column(*got, 0, Column::pz), column(*wanted, 0, Column::pz));
    EXPECT_EQ(record(*got, 0, "temper"), record(*wanted, 0, "temper"));
    EXPECT_EQ(got->mass(), wanted->mass());
}

TEST_F(BpRun, whatWasNotWrittenIsNoZero) {
    writeRun(folder / "run.h5", {7});
    for (const char* engine : {"BP4", "BP5"}) {
        BpCopy(folder / "run.h5", folder / "run.bp", {.engine = engine, .blocks = 2, .share = 0.75});
        proto::ParticlesJob job;
        job.set_species("ions");
        NoteKeeper notes;
        MOTE_OPEN(source, {folder / "run.bp"}, notes, job);
        EXPECT_TRUE(notes.noted("record 'position/x' is left out: declares 3000 values and holds 2250"));
        EXPECT_FALSE(source->has(Column::x)) << engine;
        std::filesystem::remove_all(folder / "run.bp");
    }
}

TEST_F(BpRun, withoutOpenpmdIsRefused) {
    {
        adios2::ADIOS adios;
        auto io = adios.DeclareIO("plain");
        io.SetEngine("BP5");
        auto engine = io.Open((folder / "plain.bp").string(), adios2::Mode::Write);
        engine.BeginStep();
        engine.Put(io.DefineVariable<int>("answer"), 42);
        engine.EndStep();
        engine.Close();
    }
    EXPECT_THAT(errorOf({folder / "plain.bp"}), HasSubstr("is an ADIOS2 file without openPMD's particles"));
    std::filesystem::create_directory(folder / "torn.bp");
    writeFile(folder / "torn.bp" / "data.0", "x");
    EXPECT_THAT(errorOf({folder / "torn.bp"}), HasSubstr("without its md.idx"));
}

/// What a file that is cut short or changed makes of a job ends it in a sentence, or is not seen; ADIOS2
/// itself may end the process, so each is a process of its own.
TEST_F(BpRun, thatIsDamagedEndsTheJobAlone) {
    writeRun(folder / "run.h5", {7});
    std::mt19937 random(11);
    for (const char* engine : {"BP4", "BP5"}) {
        BpCopy(folder / "run.h5", folder / "run.bp", {.engine = engine, .blocks = 2});
        for (const char* name : {"md.idx", "md.0", "data.0"}) {
            const auto bytes = bytesOf(folder / "run.bp")[name];
            for (int i = 0; i < 6; ++i) {
                auto changed = bytes;
                if (i == 0)
                    changed.resize(bytes.size() / 2);
                else if (i == 1)
                    changed.clear();
                else
                    for (int k = 0; k < 3; ++k)
                        changed[random() % changed.size()] = static_cast<char>(random());
                writeFile(folder / "run.bp" / name, changed);
                const auto out = folder / "out.mote";
                const auto command =
                    "cd " + folder.path().string() +
                    " && ulimit -c 0 && timeout 60 " MOTE_BIN
                    "/mote-prep particles run.bp --species ions --axes x,px,y --memory 512M --out " +
                    out.string() + " >said.txt 2>&1";
                const int status = std::system(command.c_str());
                if (i == 0 && std::string_view(name) == "data.0") {
                    EXPECT_EQ(WEXITSTATUS(status), 1) << engine << ": what is cut short ends in a sentence";
                }
                EXPECT_NE(WEXITSTATUS(status), 124) << engine << " " << name << " " << i << " does not end";
                EXPECT_EQ(status == 0, std::filesystem::exists(out)) << engine << " " << name << " " << i;
                std::filesystem::remove_all(out);
            }
            writeFile(folder / "run.bp" / name, bytes);
        }
        std::filesystem::remove_all(folder / "run.bp");
    }
}

}  // namespace
}  // namespace mote::test
