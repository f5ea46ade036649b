// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "preprocess/job_kinds.h"
#include "preprocess/synth/beam_run.h"

namespace mote::prep {
namespace {

constexpr const char* synthExamples = R"(Example:
  mote-prep synth beam --particles 1000000 --steps 10 --seed 1 --out runSynth.h5)";

struct SynthArguments {
    std::uint64_t particles = 1000000;
    std::uint32_t steps = 10;
    std::uint64_t seed = 1;
    std::optional<double> mismatch;
    std::string out;
};

proto::JobRequest toSynthRequest(const SynthArguments& options) {
    proto::JobRequest request;
    request.set_output(options.out);
    auto& job = *request.mutable_synth_beam();
    job.set_particles(options.particles);
    job.set_steps(options.steps);
    job.set_seed(options.seed);
    if (options.mismatch) job.set_mismatch(*options.mismatch);
    return request;
}

void addSynth(const cli::Command& program, CommandLine& line) {
    const auto synth = program.subcommand("synth", "Make a synthetic run");
    synth.requireOneSubcommand();
    const auto command =
        synth.subcommand("beam", "A mismatched beam in a FODO channel, in which a halo forms");
    const auto options = std::make_shared<SynthArguments>();
    command.option("--particles", options->particles, "Macro-particles").showDefault();
    command.option("--steps", options->steps, "Steps to write").showDefault();
    command.option("--seed", options->seed, "The same seed gives the same bytes").showDefault();
    command.option("--mismatch", options->mismatch, "Initial envelope over the matched one; default 1.5");
    command.option("--out", options->out, "The openPMD file to make, which must not exist")
        .required()
        .valueName("FILE.h5");
    addOutputFlags(command, line);
    command.footer(synthExamples);
    command.callback([options, &line] {
        line.command = [options, &line] { return runAndPrint(line, toSynthRequest(*options), {}, {}); };
    });
}

Result<proto::Manifest> runSynth(const Job& job) {
    MOTE_RETURN_IF_ERROR(synthesizeBeam(job.request.synth_beam(), job.output, job.progress));
    return proto::Manifest();
}

}  // namespace

const JobKind synthJob{proto::JobRequest::kSynthBeam, false, addSynth, runSynth};

}  // namespace mote::prep
