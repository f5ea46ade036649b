// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "preprocess/image/image_job.h"
#include "preprocess/job_kinds.h"

namespace mote::prep {
namespace {

constexpr const char* imageExamples = R"(Examples:
  mote-prep image lighthouse.png --out plots/lighthouse.mote

FILE is PNG, JPEG, TIFF or OpenEXR, of 8 or 16 bits or floats, grey or in colour. What is kept is its linear
luminance (ITU-R BT.709), upright, and laid on white where it is transparent. Integers are taken as sRGB and floats as
linear, unless the file says something else.)";

void addImage(const cli::Command& program, CommandLine& line) {
    const auto command =
        program.subcommand("image", "Make an image dataset: a picture behind a view, or one to be stippled");
    const auto job = std::make_shared<AskedJob>();
    fieldOption(command, job->request, "image.input", "FILE").required();
    addDatasetOptions(command, line, job);
    command.footer(imageExamples);
}

Result<proto::Manifest> runImage(const Job& job) {
    return runImageJob(job.request, job.inputs.front(), job.output, job.resources, job.progress);
}

}  // namespace

const JobKind imageJob{proto::JobRequest::kImage, false, addImage, runImage};

}  // namespace mote::prep
