// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/beam.h"

#include <fmt/format.h>

#include "preprocess/synth/beam_run.h"
#include "preprocess/synth/channel_plan.h"
#include "protocol/scene/check.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t mostParticles = 100'000'000'000;
constexpr std::uint32_t mostSteps = 10'000;
constexpr double leastMismatch = 0.5, greatestMismatch = 2.5, defaultMismatch = 1.5;
/// Above this ratio of the core's axes the kick is off by more than 1e-4, and the model more than that.
constexpr double flattestSound = 6.0;

}  // namespace

Status synthesizeBeam(const proto::SynthBeamJob& job, const std::filesystem::path& output,
                      Progress& progress) {
    if (job.particles() < 1 || job.particles() > mostParticles) {
        return Error{ErrorCode::invalidArgument, "synthBeam.particles", "must be 1 to 100000000000"};
    }
    if (job.steps() < 1 || job.steps() > mostSteps) {
        return Error{ErrorCode::invalidArgument, "synthBeam.steps", "must be 1 to 10000"};
    }
    const auto mismatch = checkRange(job.has_mismatch() ? job.mismatch() : defaultMismatch, leastMismatch,
                                     greatestMismatch, "synthBeam.mismatch");
    if (!mismatch) return mismatch.error();

    progress.report(0.0, "integrating the beam's envelope");
    const auto plan = planChannel(mismatched({}, *mismatch), job.steps());
    if (!plan) return plan.error();
    if (plan->flattest > flattestSound) {
        progress.note(fmt::format(
            "with this mismatch the core's axes come to differ by a factor of {:.0f}: the beam is "
            "for looking, its physics is rough",
            plan->flattest));
    }
    return writeBeamRun(*plan, {job.particles(), job.seed()}, output, progress);
}

}  // namespace mote::prep
