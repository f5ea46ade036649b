// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "preprocess/job_kinds.h"
#include "preprocess/synth/beam_run.h"
#include "preprocess/synth/shapes.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

/// What is made beside a run: no job of a server's.
struct AskedShape {
    std::uint32_t voxels = 128;
    std::uint64_t seed = 1;
    std::filesystem::path output;
};

/// A command that writes one file and says so.
void writeWhenChosen(const cli::Command& command, CommandLine& line, const std::shared_ptr<AskedShape>& asked,
                     const std::function<Status(const AskedShape&)>& write) {
    command.option("--out", asked->output, "The file to make, which must not exist").required();
    addOutputFlags(command, line);
    command.callback([&line, asked, write] {
        line.command = [&line, asked, write] {
            const auto written = write(*asked);
            if (!written.ok()) return fail(line, written.error());
            const std::string name = asked->output.string();
            if (line.json)
                fmt::print("{}\n", JsonObject().add("output", name).text());
            else if (!line.quiet)
                fmt::print("{}\n", toTerminalText(name));
            return 0;
        };
    });
}

void addShapes(const cli::Command& synth, CommandLine& line) {
    const auto asked = std::make_shared<AskedShape>();
    const auto phantom = synth.subcommand("phantom", "A trunk of bones, organs and air, as a CT sees it");
    phantom.option("--voxels", asked->voxels, "Along each axis")
        .range(int{leastVoxels}, int{mostVoxels})
        .showDefault();
    phantom.option("--seed", asked->seed, "The same seed gives the same bytes").showDefault();
    writeWhenChosen(phantom, line, asked, [](const AskedShape& shape) {
        return writePhantom(shape.voxels, shape.seed, shape.output);
    });
    phantom.footer("Example:\n  mote-prep synth phantom --voxels 128 --out ct.nrrd");
    const auto coil = synth.subcommand("coil", "Wire wound about a ring, as a mesh");
    writeWhenChosen(coil, line, std::make_shared<AskedShape>(),
                    [](const AskedShape& shape) { return writeCoil(shape.output); });
    coil.footer("Example:\n  mote-prep synth coil --out coil.obj");
}

constexpr const char* synthExamples = R"(Example:
  mote-prep synth beam --particles 1000000 --steps 10 --seed 1 --out run.h5)";

void addSynth(const cli::Command& program, CommandLine& line) {
    const auto synth = program.subcommand("synth", "Make a synthetic run");
    synth.requireOneSubcommand();
    const auto command =
        synth.subcommand("beam", "A mismatched beam in a FODO channel, in which a halo forms");
    const auto job = std::make_shared<AskedJob>();
    auto& beam = *job->request.mutable_synth_beam();
    for (const char* const name : {"particles", "steps", "seed", "mismatch"})
        fieldOption(command, beam, name).valueName("N");
    fieldOption(command, job->request, "output", "--out", "The openPMD file to make, which must not exist")
        .required()
        .valueName("FILE.h5");
    addOutputFlags(command, line);
    command.footer(synthExamples);
    runWhenChosen(command, line, job);
    addShapes(synth, line);
}

Result<proto::Manifest> runSynth(const Job& job) {
    MOTE_RETURN_IF_ERROR(synthesizeBeam(job.request.synth_beam(), job.output, job.progress));
    return proto::Manifest();
}

}  // namespace

const JobKind synthJob{proto::JobRequest::kSynthBeam, false, addSynth, runSynth};

}  // namespace mote::prep
