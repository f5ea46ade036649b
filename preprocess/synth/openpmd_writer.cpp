// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/openpmd_writer.h"

#include <fmt/format.h>

#include "preprocess/openpmd/records.h"

namespace mote::prep {
namespace {

constexpr double protonMass = protonMassEv * elementaryCharge / (speedOfLight * speedOfLight);  // kg

bool addVector(hid_t species, const RecordKind& kind, hid_t type, double unit, std::uint64_t rows) {
    const H5Handle record = createGroup(species, kind.name);
    if (!record.ok() || !describeRecord(record.get(), kind)) return false;
    for (const char* axis : axisNames) {
        const H5Handle component = createColumn(record.get(), axis, type, rows);
        if (!component.ok() || !setDouble(component.get(), "unitSI", unit)) return false;
    }
    return true;
}

bool addOffset(hid_t species, std::uint64_t rows) {
    const H5Handle record = createGroup(species, records::positionOffset.name);
    if (!record.ok() || !describeRecord(record.get(), records::positionOffset)) return false;
    for (const char* axis : axisNames) {
        const H5Handle component = createGroup(record.get(), axis);
        if (!component.ok() || !setConstant(component.get(), 0.0, 1.0, rows)) return false;
    }
    return true;
}

bool addSpecies(hid_t file, const std::string& path, const ChannelPlan& plan, std::uint64_t particles) {
    const H5Handle species = createGroup(file, path);
    const double weight = plan.beam.particlesPerBunch / static_cast<double>(particles);
    return species.ok() && addVector(species.get(), records::position, H5T_IEEE_F32LE, 1.0, particles) &&
           addOffset(species.get(), particles) &&
           addVector(species.get(), records::momentum, H5T_IEEE_F64LE, electronvoltOverC, particles) &&
           addConstantScalar(species.get(), records::weighting, weight, particles) &&
           addConstantScalar(species.get(), records::mass, protonMass, particles) &&
           addConstantScalar(species.get(), records::charge, elementaryCharge, particles) &&
           addScalar(species.get(), records::identity, H5T_STD_U64LE, 1.0, particles);
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
