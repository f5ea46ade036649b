// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <memory>

#include "preprocess/hybrid/volume_job.h"
#include "preprocess/hybrid/volume_plan.h"
#include "preprocess/job_kinds.h"

namespace mote::prep {
namespace {

constexpr const char* examples = R"(Examples:
  mote-prep volume chest.nrrd --low 128 --threshold 0.02 --out chest.mote
  mote-prep volume bubble-*.raw --dimensions 640 256 256 --type u8 --threshold 0.05 --out bubble.mote
  mote-prep volume engine.nrrd --max-points 1000000 --representation both --filter under:0.1 --out engine.mote

Thresholds and P are fractions of the range of values. Several inputs are the steps of a time series.)";

/// Options as the command line gives them.
struct Options : DatasetOptions {
    std::vector<std::string> inputs;
    std::string filter, representation;
    std::optional<std::uint32_t> low, errorGrid, pointBytes, valueBits;
    std::optional<double> threshold;
    std::optional<std::uint64_t> maxPoints;
    std::string format, type, field;
    std::vector<std::uint32_t> dimensions;
    std::vector<double> spacing, origin;
    bool bigEndian = false;
    std::uint64_t headerBytes = 0;
};

void setSource(const Options& options, proto::VolumeSourceOptions& source) {
    source.set_format(options.format == "auto" ? "" : options.format);
    source.mutable_dimensions()->Assign(options.dimensions.begin(), options.dimensions.end());
    source.set_type(options.type);
    source.set_big_endian(options.bigEndian);
    source.set_header_bytes(options.headerBytes);
    source.mutable_spacing()->Assign(options.spacing.begin(), options.spacing.end());
    source.mutable_origin()->Assign(options.origin.begin(), options.origin.end());
    source.set_field(options.field);
}

void complete(const Options& options, proto::VolumeJob& job) {
    for (const auto& input : options.inputs) job.add_inputs(input);
    setSource(options, *job.mutable_source());
    if (options.low) job.set_low(*options.low);
    if (options.errorGrid) job.set_error_grid(*options.errorGrid);
    if (options.threshold) job.set_threshold(*options.threshold);
    if (options.maxPoints) job.set_max_points(*options.maxPoints);
    job.set_filter(options.filter);
    job.set_representation(options.representation);
    if (options.pointBytes) job.set_point_bytes(*options.pointBytes);
    if (options.valueBits) job.set_value_bits(*options.valueBits);
}

void addSourceOptions(const cli::Command& command, Options& options) {
    command.option("INPUT", options.inputs, "A volume; several: one a step of a time series").required();
    command.option("--format", options.format, "The inputs' format; told by their content unless given")
        .valueName("NAME");
    command.option("--dimensions", options.dimensions, "Raw: voxels along x, y, z")
        .values(3)
        .valueName("NX NY NZ");
    command.option("--type", options.type, "Raw: u8 (the default), i8, u16, i16, u32, i32, f32 or f64")
        .valueName("TYPE");
    command.flag("--big-endian", options.bigEndian, "Raw: the most significant byte comes first");
    command.option("--header-bytes", options.headerBytes, "Raw: before the first value").valueName("N");
    command.option("--spacing", options.spacing, "Of voxels, instead of what the file says")
        .values(3)
        .valueName("SX SY SZ");
    command.option("--origin", options.origin, "World position of the first voxel's centre")
        .values(3)
        .valueName("X Y Z");
    command.option("--field", options.field, "VTI array or OpenVDB grid").valueName("NAME");
}

void addResultOptions(const cli::Command& command, Options& options) {
    command.option("--low", options.low, "Samples of the low volume along its longest axis; default 128")
        .valueName("N");
    command.option("--error-grid", options.errorGrid, "The same of the error grid; default: the source's")
        .valueName("N");
    const auto threshold =
        command.option("--threshold", options.threshold, "Take errors above T of the range of values")
            .valueName("T");
    command.option("--max-points", options.maxPoints, "Take the M greatest errors")
        .excludes(threshold)
        .valueName("M");
    command
        .option("--filter", options.filter, "cubic (the default), box or under:P: never above by more than P")
        .valueName("NAME");
    command.option("--representation", options.representation, "points, residual (the default) or both")
        .valueName("NAME");
    command.option("--point-bytes", options.pointBytes, "Of a point: 5 (the default), 6 or 9").valueName("N");
    command
        .option("--value-bits", options.valueBits,
                "Of a sample of the low volume: 8 (the default for u8 and i8) or 16")
        .valueName("N");
}

void addCommand(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("volume", "Make a hybrid volume of a scalar volume");
    const auto options = std::make_shared<Options>();
    addSourceOptions(command, *options);
    addResultOptions(command, *options);
    addDatasetOptions(command, line, options,
                      [options](auto& request) { complete(*options, *request.mutable_volume()); });
    command.footer(examples);
}

Result<proto::Manifest> run(const Job& job) {
    MOTE_RETURN_IF_ERROR(checkVolumeJob(job.request.volume()), "volume");
    return runVolumeJob(job.request, job.inputs, job.output, job.resources, job.progress);
}

}  // namespace

const JobKind volumeJob{proto::JobRequest::kVolume, true, addCommand, run};

}  // namespace mote::prep
