// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "preprocess/job_kinds.h"
#include "preprocess/synth/beam_run.h"

namespace mote::prep {
namespace {

constexpr const char* synthExamples = R"(Example:
  mote-prep synth beam --particles 1000000 --steps 10 --seed 1 --out runSynth.h5)";

void addSynth(const cli::Command& program, CommandLine& line) {
    const auto synth = program.subcommand("synth", "Make a synthetic run");
    synth.requireOneSubcommand();
    const auto command =
        synth.subcommand("beam", "A mismatched beam in a FODO channel, in which a halo forms");
    const auto job = std::make_shared<AskedJob>();
    auto& beam = *job->request.mutable_synth_beam();
    beam.set_particles(1000000);
    beam.set_steps(10);
    beam.set_seed(1);
    fieldOption(command, beam, "particles", "Macro-particles").showDefault(std::to_string(beam.particles()));
    fieldOption(command, beam, "steps", "Steps to write").showDefault(std::to_string(beam.steps()));
    fieldOption(command, beam, "seed", "The same seed gives the same bytes")
        .showDefault(std::to_string(beam.seed()));
    fieldOption(command, beam, "mismatch", "Initial envelope over the matched one; default 1.5");
    fieldOption(command, job->request, "output", "The openPMD file to make, which must not exist", "--out")
        .required()
        .valueName("FILE.h5");
    addOutputFlags(command, line);
    command.footer(synthExamples);
    runWhenChosen(command, line, job);
}

Result<proto::Manifest> runSynth(const Job& job) {
    MOTE_RETURN_IF_ERROR(synthesizeBeam(job.request.synth_beam(), job.output, job.progress));
    return proto::Manifest();
}

}  // namespace

const JobKind synthJob{proto::JobRequest::kSynthBeam, false, addSynth, runSynth};

}  // namespace mote::prep
