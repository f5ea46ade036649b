// SPDX-License-Identifier: GPL-3.0-or-later
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
    const auto field = [&](const char* name) { return fieldOption(command, job, name); };
    field("low").valueName("N");
    field("error_grid").valueName("N");
    const auto threshold = field("threshold").valueName("T");
    field("max_points").excludes(threshold).valueName("M");
    field("filter").valueName("NAME");
    field("representation").valueName("NAME");
    field("point_bytes").valueName("N");
    field("value_bits").valueName("N");
}

void addVolume(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("volume", "Make a hybrid volume of a scalar volume");
    const auto job = std::make_shared<AskedJob>();
    auto& volume = *job->request.mutable_volume();
    fieldOption(command, volume, "inputs", "INPUT").required();
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
