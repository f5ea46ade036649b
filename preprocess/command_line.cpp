// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/command_line.h"

#include <fmt/format.h>

#include <chrono>

#include "preprocess/console_progress.h"
#include "preprocess/json_object.h"
#include "preprocess/parallel/mpi_communicator.h"

namespace mote::prep {
namespace {

struct Totals {
    std::uint64_t particles = 0, lost = 0, invalid = 0, outside = 0;
};

Totals totalsOf(const proto::ParticlesManifest& particles) {
    Totals totals;
    for (const auto& step : particles.steps()) {
        totals.particles += step.particles();
        totals.lost += step.lost();
        totals.invalid += step.invalid();
        totals.outside += step.outside();
    }
    return totals;
}

void addParticles(const proto::ParticlesManifest& particles, JsonObject& object) {
    const auto totals = totalsOf(particles);
    object.add("steps", particles.steps_size())
        .add("particles", totals.particles)
        .add("lost", totals.lost)
        .add("invalid", totals.invalid)
        .add("outside", totals.outside);
}

struct HybridTotals {
    std::uint64_t points = 0, residuals = 0;
};

HybridTotals totalsOf(const proto::HybridManifest& hybrid) {
    HybridTotals totals;
    for (const auto& step : hybrid.steps()) {
        totals.points += step.points();
        totals.residuals += step.residual_samples();
    }
    return totals;
}

void addHybrid(const proto::HybridManifest& hybrid, JsonObject& object) {
    const auto totals = totalsOf(hybrid);
    object.add("steps", hybrid.steps_size()).add("points", totals.points).add("residuals", totals.residuals);
}

void addStipple(const proto::StippleManifest& stipple, JsonObject& object) {
    object.add("points", stipple.points()).add("moves", stipple.moves()).add("locked", stipple.locked());
}

void printJson(const JobOutcome& outcome, double seconds) {
    JsonObject object;
    object.add("output", outcome.output.string()).add("seconds", seconds);
    if (outcome.manifest) {
        const auto& manifest = *outcome.manifest;
        object.add("kind", manifest.kind());
        if (manifest.has_particles()) addParticles(manifest.particles(), object);
        if (manifest.has_hybrid()) addHybrid(manifest.hybrid(), object);
        if (manifest.has_image()) {
            object.add("width", manifest.image().width()).add("height", manifest.image().height());
        }
        if (manifest.has_mesh()) {
            const auto& mesh = manifest.mesh();
            object.add("vertices", mesh.vertices())
                .add("triangles", mesh.triangles())
                .add("area", mesh.area());
        }
        if (manifest.has_stipple()) addStipple(manifest.stipple(), object);
    }
    fmt::print("{}\n", object.text());
}

/// What a dataset holds, "10 steps, 1000 particles in leaves, ".
std::string describe(const proto::Manifest& manifest) {
    if (manifest.has_stipple()) {
        return fmt::format("{} points, {} moves, ", manifest.stipple().points(), manifest.stipple().moves());
    }
    if (manifest.has_image()) {
        return fmt::format("an image of {} x {} pixels, ", manifest.image().width(),
                           manifest.image().height());
    }
    if (manifest.has_mesh()) {
        return fmt::format("{} vertices, {} triangles, ", manifest.mesh().vertices(),
                           manifest.mesh().triangles());
    }
    if (manifest.has_hybrid()) {
        const auto totals = totalsOf(manifest.hybrid());
        return fmt::format("{} step{}, {} points, {} residuals, ", manifest.hybrid().steps_size(),
                           manifest.hybrid().steps_size() == 1 ? "" : "s", totals.points, totals.residuals);
    }
    const auto& particles = manifest.particles();
    return fmt::format("{} step{}, {} particles in leaves, ", particles.steps_size(),
                       particles.steps_size() == 1 ? "" : "s", totalsOf(particles).particles);
}

void printText(const JobOutcome& outcome, double seconds) {
    fmt::print("{}: {}made in {:.1f} s\n", outcome.output.string(),
               outcome.manifest ? describe(*outcome.manifest) : "", seconds);
}

/// The processes of this job: those that a launcher of MPI started, else this one.
Result<std::unique_ptr<Communicator>> joinRanks(const CancelSignal& signal) {
    if (!startedByMpi()) return singleProcess();
    return joinMpi([&signal] { return signal.received() != 0; });
}

}  // namespace

void addOutputFlags(const cli::Command& command, CommandLine& line) {
    command.flag("--json", line.json, "Print one JSON object on stdout");
    command.flag("--quiet", line.quiet, "Print errors only");
}

void addResourceOptions(const cli::Command& command, ParticlesJobOptions& options) {
    command.option("--threads", options.threads, "Threads; as many as there are cores unless given")
        .range(1, 1024)
        .valueName("N");
    command
        .option("--memory", options.memory,
                "Memory that each process of the job may take, as 8G; three quarters of the machine's "
                "unless given. Beyond it, particles lie in a temporary file beside the output")
        .size(std::uint64_t{1} << 20, std::uint64_t{1} << 50)
        .valueName("BYTES");
}

void addDatasetOptions(const cli::Command& command, CommandLine& line,
                       const std::shared_ptr<DatasetOptions>& options,
                       std::function<void(proto::JobRequest&)> complete) {
    command.option("--out", options->out, "The dataset to make, which must not exist")
        .required()
        .valueName("DIR/NAME.mote");
    command.option("--title", options->title, "What viewers call it").valueName("TEXT");
    addResourceOptions(command, options->job);
    addOutputFlags(command, line);
    command.callback([options, &line, complete = std::move(complete)] {
        line.command = [options, &line, complete] {
            proto::JobRequest request;
            request.set_title(options->title);
            request.set_output(options->out);
            complete(request);
            return runAndPrint(line, request, {}, options->job);
        };
    });
}

int runAndPrint(const CommandLine& line, const proto::JobRequest& request, const storage::Roots& roots,
                const ParticlesJobOptions& options, int progressDescriptor) {
    const auto begin = std::chrono::steady_clock::now();
    auto ranks = joinRanks(line.signal);
    if (!ranks.ok()) return fail(line, ranks.error());
    const bool first = (*ranks)->first();
    auto outcome = [&] {
        ConsoleProgress progress(line.signal, {line.quiet || !first, first ? progressDescriptor : -1});
        auto together = options;
        together.ranks = ranks->get();
        return runJob(request, roots, together, progress);
    }();
    // What all ranks know, one says.
    if (!first) return outcome.ok() ? 0 : 1;
    if (!outcome.ok()) return fail(line, outcome.error());
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    if (line.json) {
        printJson(*outcome, seconds.count());
    } else if (!line.quiet) {
        printText(*outcome, seconds.count());
    }
    return 0;
}

int fail(const CommandLine& line, const Error& error) {
    if (error.code == ErrorCode::cancelled && line.signal.received() != 0) {
        fmt::print(stderr, "mote-prep: cancelled, nothing was made\n");
        return 128 + line.signal.received();
    }
    fmt::print(stderr, "mote-prep: {}\n", error.toString());
    return error.code == ErrorCode::invalidArgument ? 2 : 1;
}

}  // namespace mote::prep
