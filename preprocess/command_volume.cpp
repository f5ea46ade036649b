// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <memory>

#include "preprocess/hybrid/volume_job.h"
#include "preprocess/hybrid/volume_plan.h"
#include "preprocess/job_kinds.h"

namespace mote::prep {
namespace {

constexpr const char* volumeExamples = R"(Examples:
  mote-prep volume chest.nrrd --out chest.mote
  mote-prep volume chest.nrrd --low 128 --threshold 0.01 --space lps --out chest.mote
  mote-prep volume scan/DICOM --series 3 --out head.mote
  mote-prep volume bubble-*.raw --dimensions 640 256 256 --type u8 --threshold 0.05 --out bubble.mote
  mote-prep volume engine.nrrd --max-points 1000000 --representation both --filter under:0.1 --out engine.mote

Thresholds and P are fractions of the range of values. Several inputs, and the volumes of one file, are the steps
of a time series. Patients lie right, anterior, superior (RAS) whatever the format; --space says otherwise.)";

/// Options as the command line gives them.
struct VolumeArguments : DatasetOptions {
    std::vector<std::string> inputs;
    std::string filter, representation;
    std::optional<std::uint32_t> low, errorGrid, pointBytes, valueBits;
    std::optional<double> threshold;
    std::optional<std::uint64_t> maxPoints;
    VolumeOptions source;
};

void complete(const VolumeArguments& options, proto::VolumeJob& job) {
    for (const auto& input : options.inputs) job.add_inputs(input);
    *job.mutable_source() = options.source.message();
    if (options.low) job.set_low(*options.low);
    if (options.errorGrid) job.set_error_grid(*options.errorGrid);
    if (options.threshold) job.set_threshold(*options.threshold);
    if (options.maxPoints) job.set_max_points(*options.maxPoints);
    job.set_filter(options.filter);
    job.set_representation(options.representation);
    if (options.pointBytes) job.set_point_bytes(*options.pointBytes);
    if (options.valueBits) job.set_value_bits(*options.valueBits);
}

void addResultOptions(const cli::Command& command, VolumeArguments& options) {
    command.option("--low", options.low, "Samples of the low volume along its longest axis; default 128")
        .valueName("N");
    command.option("--error-grid", options.errorGrid, "The same of the error grid; default: the source's")
        .valueName("N");
    const auto threshold = command
                               .option("--threshold", options.threshold,
                                       "Take errors above T of the range of values; default .02")
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

void addVolume(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("volume", "Make a hybrid volume of a scalar volume");
    const auto options = std::make_shared<VolumeArguments>();
    command
        .option("INPUT", options->inputs,
                "A volume, a file or a folder (DICOM, pictures); several: one a step of a time series, or "
                "the files of a DICOM series")
        .required();
    addVolumeOptions(command, options->source);
    addResultOptions(command, *options);
    addDatasetOptions(command, line, options,
                      [options](auto& request) { complete(*options, *request.mutable_volume()); });
    command.footer(volumeExamples);
}

Result<proto::Manifest> runVolume(const Job& job) {
    MOTE_RETURN_IF_ERROR(checkVolumeJob(job.request.volume()), "volume");
    return runVolumeJob(job.request, job.inputs, job.output, job.resources, job.progress);
}

}  // namespace

const JobKind volumeJob{proto::JobRequest::kVolume, true, addVolume, runVolume};

}  // namespace mote::prep
