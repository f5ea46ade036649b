// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/openpmd_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "protocol/scene/system_error.h"
#include "storage/files/file_descriptor.h"

namespace mote::prep {
namespace {

bool setAttribute(hid_t object, const char* name, hid_t type, hid_t memoryType, hid_t space,
                  const void* value) {
    const H5Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    return attribute.ok() && H5Awrite(attribute.get(), memoryType, value) >= 0;
}

bool setScalar(hid_t object, const char* name, hid_t type, hid_t memoryType, const void* value) {
    const H5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    return space.ok() && setAttribute(object, name, type, memoryType, space.get(), value);
}

bool setArray(hid_t object, const char* name, hid_t type, hid_t memoryType, hsize_t size,
              const void* values) {
    const H5Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
    return space.ok() && setAttribute(object, name, type, memoryType, space.get(), values);
}

/// HDF5 writes the kernel's number into its message: "... errno = 28, error message = ...".
herr_t findNumber(unsigned, const H5E_error2_t* entry, void* number) {
    constexpr std::string_view mark = "errno = ";
    if (entry->desc == nullptr || *static_cast<int*>(number) != 0) return 0;
    if (const char* found = std::strstr(entry->desc, mark.data())) {
        *static_cast<int*>(number) = std::atoi(found + mark.size());
    }
    return 0;
}

constexpr std::array<const char*, 3> axisNames{"x", "y", "z"};
constexpr double electronvoltOverC = elementaryCharge / speedOfLight;                           // kg m/s
constexpr double protonMass = protonMassEv * elementaryCharge / (speedOfLight * speedOfLight);  // kg

/// What openPMD asks of a record: powers of m, kg, s, A, K, mol, cd; how values scale with a macro-particle's
/// weight.
struct RecordKind {
    const char* name;
    std::array<double, 7> dimension;
    std::uint32_t macroWeighted;
    double weightingPower;
};

constexpr RecordKind position{"position", {1, 0, 0, 0, 0, 0, 0}, 0, 0.0};
constexpr RecordKind positionOffset{"positionOffset", {1, 0, 0, 0, 0, 0, 0}, 0, 0.0};
constexpr RecordKind momentum{"momentum", {1, 1, -1, 0, 0, 0, 0}, 0, 1.0};
constexpr RecordKind mass{"mass", {0, 1, 0, 0, 0, 0, 0}, 0, 1.0};
constexpr RecordKind charge{"charge", {0, 0, 1, 1, 0, 0, 0}, 0, 1.0};
constexpr RecordKind weighting{"weighting", {0, 0, 0, 0, 0, 0, 0}, 1, 1.0};
constexpr RecordKind identity{"id", {0, 0, 0, 0, 0, 0, 0}, 0, 0.0};

bool describe(hid_t record, const RecordKind& kind) {
    return setDoubles(record, "unitDimension", kind.dimension) && setDouble(record, "timeOffset", 0.0) &&
           setUnsigned32(record, "macroWeighted", kind.macroWeighted) &&
           setDouble(record, "weightingPower", kind.weightingPower);
}

bool setConstant(hid_t component, double value, double unit, std::uint64_t rows) {
    return setDouble(component, "value", value) && setExtent(component, "shape", rows) &&
           setDouble(component, "unitSI", unit);
}

bool addConstantScalar(hid_t species, const RecordKind& kind, double value, std::uint64_t rows) {
    const H5Handle record = createGroup(species, kind.name);
    return record.ok() && describe(record.get(), kind) && setConstant(record.get(), value, 1.0, rows);
}

bool addVector(hid_t species, const RecordKind& kind, hid_t type, double unit, std::uint64_t rows) {
    const H5Handle record = createGroup(species, kind.name);
    if (!record.ok() || !describe(record.get(), kind)) return false;
    for (const char* axis : axisNames) {
        const H5Handle component = createColumn(record.get(), axis, type, rows);
        if (!component.ok() || !setDouble(component.get(), "unitSI", unit)) return false;
    }
    return true;
}

bool addOffset(hid_t species, std::uint64_t rows) {
    const H5Handle record = createGroup(species, positionOffset.name);
    if (!record.ok() || !describe(record.get(), positionOffset)) return false;
    for (const char* axis : axisNames) {
        const H5Handle component = createGroup(record.get(), axis);
        if (!component.ok() || !setConstant(component.get(), 0.0, 1.0, rows)) return false;
    }
    return true;
}

bool addIdentity(hid_t species, std::uint64_t rows) {
    const H5Handle column = createColumn(species, identity.name, H5T_STD_U64LE, rows);
    return column.ok() && describe(column.get(), identity) && setDouble(column.get(), "unitSI", 1.0);
}

bool addSpecies(hid_t file, const std::string& path, const ChannelPlan& plan, std::uint64_t particles) {
    const H5Handle species = createGroup(file, path);
    const double weight = plan.beam.particlesPerBunch / static_cast<double>(particles);
    return species.ok() && addVector(species.get(), position, H5T_IEEE_F32LE, 1.0, particles) &&
           addOffset(species.get(), particles) &&
           addVector(species.get(), momentum, H5T_IEEE_F64LE, electronvoltOverC, particles) &&
           addConstantScalar(species.get(), weighting, weight, particles) &&
           addConstantScalar(species.get(), mass, protonMass, particles) &&
           addConstantScalar(species.get(), charge, elementaryCharge, particles) &&
           addIdentity(species.get(), particles);
}

bool addIteration(hid_t file, const std::string& path, const ChannelPlan& plan, const PlanDump& dump) {
    const H5Handle group = createGroup(file, path);
    const double speed = plan.beam.beta * speedOfLight;
    const std::array<double, 3> core{dump.core.axes[0], dump.core.axes[1],
                                     dump.core.axes[2] / plan.beam.gamma};
    // "place" and "coreSemiAxes" are ours, in m; the rest is the standard's.
    return group.ok() && setDouble(group.get(), "time", dump.place / speed) &&
           setDouble(group.get(), "dt", plan.sliceLength / speed) &&
           setDouble(group.get(), "timeUnitSI", 1.0) && setDouble(group.get(), "place", dump.place) &&
           setDoubles(group.get(), "coreSemiAxes", core);
}

bool describeRun(hid_t file, const ChannelPlan& plan, std::uint64_t seed) {
    return setText(file, "openPMD", "1.1.0") && setUnsigned32(file, "openPMDextension", 0) &&
           setText(file, "basePath", "/data/%T/") && setText(file, "particlesPath", "particles/") &&
           setText(file, "iterationEncoding", "groupBased") &&
           setText(file, "iterationFormat", "/data/%T/") &&
           setText(file, "software", "mote-prep synth beam") &&
           setText(file, "softwareVersion", MOTE_VERSION) &&
           setText(
               file, "comment",
               "A mismatched 6D waterbag in a FODO channel, particle-core model. z is the distance from the "
               "synchronous particle; an iteration counts the slices of the channel.") &&
           setUnsigned64(file, "seed", seed) && setDoubles(file, "mismatch", plan.design.mismatch);
}

}  // namespace

H5Handle createFile(const std::string& path) {
    const H5Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    const H5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    if (!creation.ok() || !access.ok()) return {};
    H5Pset_obj_track_times(creation.get(), false);
    H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
    return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose};
}

void forgetUnwritten(hid_t file) {
    void* handle = nullptr;
    if (H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) < 0 || handle == nullptr) return;
    const storage::FileDescriptor memory(::memfd_create("discarded", MFD_CLOEXEC));
    if (memory.valid()) ::dup3(memory.get(), *static_cast<int*>(handle), O_CLOEXEC);
}

H5Handle createGroup(hid_t parent, const std::string& path) {
    const H5Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    const H5Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
    if (!links.ok() || !creation.ok()) return {};
    H5Pset_create_intermediate_group(links.get(), 1);
    H5Pset_obj_track_times(creation.get(), false);
    return {H5Gcreate2(parent, path.c_str(), links.get(), creation.get(), H5P_DEFAULT), H5Gclose};
}

H5Handle createColumn(hid_t parent, const char* name, hid_t type, std::uint64_t rows) {
    const hsize_t extent = rows;
    const H5Handle space(H5Screate_simple(1, &extent, nullptr), H5Sclose);
    const H5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    if (!space.ok() || !creation.ok()) return {};
    H5Pset_layout(creation.get(), H5D_CONTIGUOUS);
    H5Pset_alloc_time(creation.get(), H5D_ALLOC_TIME_EARLY);
    H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER);
    H5Pset_obj_track_times(creation.get(), false);
    return {H5Dcreate2(parent, name, type, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Dclose};
}

bool writeColumn(hid_t file, const std::string& path, hid_t type, std::uint64_t first, std::size_t rows,
                 const void* values) {
    const H5Handle dataset(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.ok()) return false;
    const hsize_t start = first, count = rows;
    const H5Handle inFile(H5Dget_space(dataset.get()), H5Sclose);
    const H5Handle inMemory(H5Screate_simple(1, &count, nullptr), H5Sclose);
    return inFile.ok() && inMemory.ok() &&
           H5Sselect_hyperslab(inFile.get(), H5S_SELECT_SET, &start, nullptr, &count, nullptr) >= 0 &&
           H5Dwrite(dataset.get(), type, inMemory.get(), inFile.get(), H5P_DEFAULT, values) >= 0;
}

bool setText(hid_t object, const char* name, std::string_view text) {
    const H5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    if (!type.ok() || H5Tset_size(type.get(), text.size() + 1) < 0) return false;
    return setScalar(object, name, type.get(), type.get(), std::string(text).c_str());
}

bool setDouble(hid_t object, const char* name, double value) {
    return setScalar(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

bool setDoubles(hid_t object, const char* name, std::span<const double> values) {
    return setArray(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.size(), values.data());
}

bool setUnsigned32(hid_t object, const char* name, std::uint32_t value) {
    return setScalar(object, name, H5T_STD_U32LE, H5T_NATIVE_UINT32, &value);
}

bool setUnsigned64(hid_t object, const char* name, std::uint64_t value) {
    return setScalar(object, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, &value);
}

bool setExtent(hid_t object, const char* name, std::uint64_t value) {
    return setArray(object, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, 1, &value);
}

H5Errors::H5Errors() {
    // HDF5 1.10 cannot close a file whose flush has failed, and crashes on what is left of it when it tidies
    // up at the end of the process. We close all that we open: nothing is left to tidy. In time only as
    // HDF5's very first call.
    H5dont_atexit();
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, keep, this);
}

H5Errors::~H5Errors() {
    H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

herr_t H5Errors::keep(hid_t stack, void* self) {
    // Now, not later: closing what the failed call left open clears the stack.
    H5Ewalk2(stack, H5E_WALK_UPWARD, findNumber, &static_cast<H5Errors*>(self)->number_);
    return 0;
}

Error H5Errors::failure(const std::string& where) const {
    if (number_ != 0) return systemError(number_, where, "cannot be written");
    return {ErrorCode::internal, where, "HDF5 cannot write the file"};
}

BeamColumns::BeamColumns(std::size_t rows) : id(rows) {
    for (auto& column : position) column.resize(rows);
    for (auto& column : momentum) column.resize(rows);
}

void fillColumns(const ChannelPlan& plan, const ParticleArrays& particles, std::uint64_t first,
                 std::size_t begin, std::size_t end, BeamColumns& columns) {
    const double momentum = plan.beam.momentum;
    // zeta = gamma z, and zeta' = delta / gamma (docs/SYNTH.md).
    const std::array<double, 3> length{1.0, 1.0, 1.0 / plan.beam.gamma};
    const std::array<double, 3> scale{momentum, momentum, momentum * plan.beam.gamma};
    const std::array<double, 3> offset{0.0, 0.0, momentum};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t row = begin; row < end; ++row) {
            columns.position[axis][row] = static_cast<float>(length[axis] * particles.position[axis][row]);
            columns.momentum[axis][row] = offset[axis] + scale[axis] * particles.slope[axis][row];
        }
    }
    for (std::size_t row = begin; row < end; ++row) columns.id[row] = first + row;
}

OpenPmdWriter::OpenPmdWriter(const std::string& path)
    : name_(path), errors_(std::make_unique<H5Errors>()), file_(createFile(path)) {}

OpenPmdWriter::~OpenPmdWriter() {
    if (file_.ok()) forgetUnwritten(file_.get());
}

std::uint64_t OpenPmdWriter::fileBytes(const ChannelPlan& plan, std::uint64_t particles) {
    constexpr std::uint64_t perParticle = 3 * sizeof(float) + 3 * sizeof(double) + sizeof(std::uint64_t);
    constexpr std::uint64_t perStep = 16'896, root = 6'144;  // measured, rounded up
    return root + plan.dumps.size() * (perStep + perParticle * particles);
}

Result<OpenPmdWriter> OpenPmdWriter::create(const std::filesystem::path& path) {
    OpenPmdWriter writer(path.string());
    if (!writer.file_.ok()) return writer.errors_->failure(writer.name_);
    return writer;
}

Status OpenPmdWriter::layOut(const ChannelPlan& plan, std::uint64_t particles, std::uint64_t seed) {
    const hid_t file = file_.get();
    if (!describeRun(file, plan, seed)) return errors_->failure(name_);
    for (const PlanDump& dump : plan.dumps) {
        const std::string iteration = fmt::format("/data/{}", dump.slice);
        const std::string& species = species_.emplace_back(iteration + "/particles/beam");
        if (!addIteration(file, iteration, plan, dump) || !addSpecies(file, species, plan, particles)) {
            return errors_->failure(name_);
        }
    }
    return success();
}

Status OpenPmdWriter::write(std::size_t step, std::uint64_t first, std::size_t rows,
                            const BeamColumns& columns) {
    const hid_t file = file_.get();
    const std::string& species = species_[step];
    bool ok = true;
    for (std::size_t axis = 0; ok && axis < 3; ++axis) {
        ok = writeColumn(file, species + "/position/" + axisNames[axis], H5T_NATIVE_FLOAT, first, rows,
                         columns.position[axis].data()) &&
             writeColumn(file, species + "/momentum/" + axisNames[axis], H5T_NATIVE_DOUBLE, first, rows,
                         columns.momentum[axis].data());
    }
    ok = ok && writeColumn(file, species + "/id", H5T_NATIVE_UINT64, first, rows, columns.id.data());
    if (!ok) return errors_->failure(name_);
    return success();
}

Status OpenPmdWriter::close() {
    if (H5Fflush(file_.get(), H5F_SCOPE_GLOBAL) < 0) return errors_->failure(name_);
    file_ = {};
    return success();
}

}  // namespace mote::prep
