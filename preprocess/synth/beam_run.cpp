// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/beam_run.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "preprocess/draft_file.h"
#include "preprocess/synth/openpmd_writer.h"
#include "preprocess/synth/tracker.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"

namespace mote::prep {
namespace {

/// Rows of one task: some milliseconds of work, so that a cancelled job stops at once.
constexpr std::size_t taskRows = 4096;

/// Carries one chunk of particles through the channel and writes it into every step.
class ChunkRunner {
  public:
    ChunkRunner(const ChannelPlan& plan, const BeamRun& run, OpenPmdWriter& writer, Progress& progress)
        : plan_(plan),
          run_(run),
          writer_(writer),
          progress_(progress),
          particles_(std::min<std::uint64_t>(run.chunkRows, run.particles)),
          columns_(particles_.size()) {}

    Status carry(std::uint64_t first, std::size_t rows) {
        for (std::size_t step = 0; step < plan_.dumps.size(); ++step) {
            if (!advance(first, rows, step)) {
                return Error{ErrorCode::cancelled, "", "the job was cancelled"};
            }
            MOTE_RETURN_IF_ERROR(writer_.write(step, first, rows, columns_));
            report(first, rows, step);
        }
        return success();
    }

  private:
    /// Advances from the dump before (or from nothing) to dump `step`, and into the file's units; false when
    /// cancelled.
    bool advance(std::uint64_t first, std::size_t rows, std::size_t step) {
        std::atomic<bool> stopped = false;
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, (rows + taskRows - 1) / taskRows, 1),
                          [&](const tbb::blocked_range<std::size_t>& tasks) {
                              for (std::size_t task = tasks.begin(); task != tasks.end(); ++task) {
                                  if (stopped || progress_.cancelled()) return stopped.store(true);
                                  const std::size_t begin = task * taskRows;
                                  advanceRows(first, begin, std::min(begin + taskRows, rows), step);
                              }
                          });
        return !stopped;
    }

    void advanceRows(std::uint64_t first, std::size_t begin, std::size_t end, std::size_t step) {
        if (step == 0) startParticles(plan_, run_.seed, first, particles_, begin, end);
        trackParticles(plan_.dumps[step], particles_, begin, end);
        fillColumns(plan_, particles_, first, begin, end, columns_);
    }

    void report(std::uint64_t first, std::size_t rows, std::size_t step) const {
        // A step costs its slices, and about 20 more for writing it.
        const auto cost = [&](std::size_t s) {
            return static_cast<double>(plan_.dumps[s].slice) + 20.0 * static_cast<double>(s + 1);
        };
        const double within = cost(step) / cost(plan_.dumps.size() - 1) * static_cast<double>(rows);
        progress_.report((static_cast<double>(first) + within) / static_cast<double>(run_.particles),
                         fmt::format("particles up to {} of {}: step {} of {}", first + rows, run_.particles,
                                     step + 1, plan_.dumps.size()));
    }

    const ChannelPlan& plan_;
    const BeamRun& run_;
    OpenPmdWriter& writer_;
    Progress& progress_;
    ParticleArrays particles_;
    BeamColumns columns_;
};

/// Above this ratio of the core's axes the kick is off by more than 1e-4, and the model more than that.
constexpr double flattestSound = 6.0;

}  // namespace

Status writeBeamRun(const ChannelPlan& plan, const BeamRun& run, const std::filesystem::path& output,
                    Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto draft, DraftFile::create(output));
    MOTE_ASSIGN_OR_RETURN(auto writer, OpenPmdWriter::create(draft.path()));
    MOTE_RETURN_IF_ERROR(draft.reserve(OpenPmdWriter::fileBytes(plan, run.particles)));
    MOTE_RETURN_IF_ERROR(writer.layOut(plan, run.particles, run.seed));
    ChunkRunner runner(plan, run, writer, progress);
    for (std::uint64_t first = 0; first < run.particles; first += run.chunkRows) {
        MOTE_RETURN_IF_ERROR(
            runner.carry(first, std::min<std::uint64_t>(run.chunkRows, run.particles - first)));
    }
    MOTE_RETURN_IF_ERROR(writer.close());
    return draft.publish();
}

Status synthesizeBeam(const proto::SynthBeamJob& job, const std::filesystem::path& output,
                      Progress& progress) {
    MOTE_RETURN_IF_ERROR(checkOwnFields(job), "synthBeam");
    const double mismatch = numberOf(job, proto::SynthBeamJob::kMismatchFieldNumber);

    progress.report(0.0, "integrating the beam's envelope");
    MOTE_ASSIGN_OR_RETURN(const auto plan, planChannel(mismatched({}, mismatch), job.steps()));
    if (plan.flattest > flattestSound) {
        progress.note(fmt::format(
            "with this mismatch the core's axes come to differ by a factor of {:.0f}: the beam is "
            "for looking, its physics is rough",
            plan.flattest));
    }
    return writeBeamRun(plan, {job.particles(), job.seed()}, output, progress);
}

}  // namespace mote::prep
