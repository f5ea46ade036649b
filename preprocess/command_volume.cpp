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

void addResultOptions(const cli::Command& command, proto::VolumeJob& job) {
    const auto field = [&](const char* name, const char* help) {
        return fieldOption(command, job, name, help);
    };
    field("low", "Samples of the low volume along its longest axis; default 128").valueName("N");
    field("error_grid", "Samples of the error grid along its longest axis; default: the source's")
        .valueName("N");
    const auto threshold =
        field("threshold", "Take errors above T of the range of values; default .02").valueName("T");
    field("max_points", "Take the M greatest errors").excludes(threshold).valueName("M");
    field("filter", "cubic (the default), box or under:P: never above by more than P").valueName("NAME");
    field("representation", "points, residual (the default) or both").valueName("NAME");
    field("point_bytes", "Bytes of a point: 5 (the default), 6 or 9").valueName("N");
    field("value_bits", "Bits of a sample of the low volume: 8 (the default for u8 and i8) or 16")
        .valueName("N");
}

void addVolume(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("volume", "Make a hybrid volume of a scalar volume");
    const auto job = std::make_shared<AskedJob>();
    auto& volume = *job->request.mutable_volume();
    fieldOption(command, volume, "inputs",
                "A volume, a file or a folder (DICOM, pictures); several: one a step of a time series, or "
                "the files of a DICOM series",
                "INPUT")
        .required();
    addVolumeOptions(command, *volume.mutable_source());
    addResultOptions(command, volume);
    addOutlookOptions(command, job->request);
    addDatasetOptions(command, line, job);
    command.footer(volumeExamples);
}

Result<proto::Manifest> runVolume(const Job& job) {
    MOTE_RETURN_IF_ERROR(checkVolumeJob(job.request.volume()), "volume");
    return runVolumeJob(job.request, job.inputs, job.output, job.resources, job.progress);
}

}  // namespace

const JobKind volumeJob{proto::JobRequest::kVolume, true, addVolume, runVolume};

}  // namespace mote::prep
