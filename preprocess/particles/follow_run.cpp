// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <signal.h>
#include <stdlib.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "preprocess/kept_notes.h"
#include "preprocess/parallel/communicator.h"
#include "preprocess/particles/live_dataset.h"
#include "preprocess/particles/particles_job.h"
#include "preprocess/particles/plot_axis.h"
#include "preprocess/particles/watched_files.h"
#include "preprocess/readers/format_detection.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/series_source.h"
#include "protocol/scene/step_range.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;
using File = WatchedFiles::File;
using Clock = WatchedFiles::Clock;

constexpr std::chrono::milliseconds betweenLooks{250}, atOnce{50};

/// Whether an error is of what a file holds now, and may be gone when it changes.
bool mayPass(const Error& error) {
    return error.code == ErrorCode::corrupt || error.code == ErrorCode::unsupported ||
           error.code == ErrorCode::notFound;
}

/// What is said while it is only looked which files there are.
class Unheard final : public Progress {
  public:
    explicit Unheard(const Progress& progress) : progress_(progress) {}
    void report(double, std::string_view) override {}
    void note(std::string_view) override {}
    bool cancelled() const override { return progress_.cancelled(); }

  private:
    const Progress& progress_;
};

class FollowedRun {
  public:
    FollowedRun(const proto::JobRequest& request, const std::vector<fs::path>& inputs, LiveDataset live,
                const JobResources& resources, Progress& progress)
        : job_(request.particles()),
          inputs_(inputs),
          live_(std::move(live)),
          resources_(resources),
          progress_(progress),
          files_(inputs),
          goesOn_(live_.steps() > 0) {}

    Result<proto::Manifest> run() {
        while (!progress_.cancelled() && !complete()) {
            const auto begun = Clock::now();
            MOTE_RETURN_IF_ERROR(files_.look());
            const auto batch = nextBatch();
            if (!batch.files.empty()) {
                const auto taken = take(batch);
                if (!taken.ok() && taken.error().code == ErrorCode::cancelled) break;
                MOTE_RETURN_IF_ERROR(taken);
            }
            if (batch.files.empty()) pause(Clock::now() - begun);
        }
        if (!live_.manifest()) return wasCancelled();
        MOTE_RETURN_IF_ERROR(live_.close());
        return *live_.manifest();
    }

  private:
    /// What was made of a file so far.
    struct Taken {
        std::size_t steps = 0;          ///< of the source, those that were not meant too
        std::uint64_t particles = 0;    ///< in them
        std::string stamp, tried = {};  ///< as it was then; as it could not be read
        bool noted = false;
    };
    /// Files to read as one run; of one that is written to all steps but the last.
    struct Batch {
        std::vector<File> files;
        bool withoutLast = false;
    };

    /// With the last step that is meant, where the request says one.
    bool complete() const {
        const auto last = lastStepMeant(job_.steps());
        return last && seen_ > *last;
    }

    /// Those that follow, all at first and then one by one. What is not whole yet keeps the later ones
    /// waiting; not for ever.
    Batch nextBatch() {
        Batch batch;
        const auto now = Clock::now();
        const auto& all = files_.files();
        for (std::size_t i = 0; i < all.size(); ++i) {
            const File& file = all[i];
            auto& known = taken_[file.file.path];
            if (known.stamp == file.stamp) continue;
            const bool failed = known.tried == file.stamp;
            if (file.state == WatchedFiles::State::complete && !failed) {
                batch.files.push_back(file);
                if (live_.manifest() && !goesOn_) break;
                continue;
            }
            const bool later = i + 1 < all.size();
            if (later && file.still(now) && file.state != WatchedFiles::State::open) continue;
            if (batch.files.empty() && file.state == WatchedFiles::State::open && !failed &&
                H5File::looksLikeHdf5(file.file.path)) {
                batch = {{file}, true};
            }
            break;
        }
        return batch;
    }

    void pause(Clock::duration look) {
        if (files_.files().empty() && !std::exchange(noted_, true)) {
            progress_.note(fmt::format("{}: no file is there yet; waiting for the first step",
                                       inputs_.empty() ? "" : inputs_.front().string()));
        }
        if (live_.manifest() && !goesOn_)
            progress_.report(1.0, fmt::format("{} steps; waiting for the next", live_.steps()));
        else
            progress_.report(0.0, "waiting for the first step");
        // A slow disk is not kept busy: a twentieth of the time at most.
        const auto until = Clock::now() + std::max<Clock::duration>(betweenLooks, 20 * look);
        while (!progress_.cancelled() && Clock::now() < until) std::this_thread::sleep_for(atOnce);
    }

    struct Opened {
        std::unique_ptr<ParticleSource> source;
        std::vector<fs::path> paths;
    };

    Result<Opened> open(const std::vector<File>& files, Progress& notes) {
        auto job = job_;
        if (!format_.empty()) job.set_format(format_);
        std::vector<InputFile> asked;
        asked.reserve(files.size());
        for (const auto& file : files) asked.push_back(file.file);
        Unheard unheard(progress_);
        MOTE_ASSIGN_OR_RETURN(auto found, detectFormat(job, asked, unheard));
        job.set_format(std::string(found.reader->name));
        Opened opened;
        opened.paths = std::move(found.paths);
        MOTE_ASSIGN_OR_RETURN(opened.source, openParticleSource(job, opened.paths, notes));
        return opened;
    }

    /// Of those that were read the ones that gave no step are not read again, so that nobody is told of them
    /// who may be whole in a moment.
    Result<Opened> openWhole(std::vector<File> files, Progress& notes) {
        Unheard unheard(progress_);
        if (files.size() == 1) return open(files, notes);
        MOTE_ASSIGN_OR_RETURN(const auto all, open(files, unheard));
        std::erase_if(files, [&](const File& file) { return stepsOf(*all.source, file) == 0; });
        return open(files, notes);
    }

    static std::size_t stepsOf(const ParticleSource& source, const File& file) {
        return static_cast<std::size_t>(
            std::ranges::count(source.steps(), file.file.path.filename().string(), &SourceStep::file));
    }

    /// Errors: those that no change of a file mends; cancelled.
    Status take(const Batch& batch) {
        KeptNotes notes(progress_, live_.notes());
        auto opened = openWhole(batch.files, notes);
        if (!opened.ok()) return cannotRead(batch, opened.error());
        const auto& source = *opened->source;
        if (format_.empty()) MOTE_RETURN_IF_ERROR(checkRequest(source));
        const auto next = newSteps(batch, source);
        const std::size_t count = source.steps().size() - (batch.withoutLast ? 1 : 0);
        if (!next.steps.empty()) {
            const auto whole = [&] {
                return batch.withoutLast || std::ranges::all_of(batch.files, [](const File& file) {
                           return stampOf(file.file.path) == file.stamp;
                       });
            };
            const auto added = live_.add(*opened->source, namedInputs(), next, whole, resources_, notes);
            if (!added.ok()) return cannotRead(batch, added.error());
            if (!*added) return success();  // it is looked at again
        }
        if (format_.empty()) format_ = source.format();
        goesOn_ = false;
        remember(batch, source, count);
        return success();
    }

    /// What no further step would mend.
    Status checkRequest(const ParticleSource& source) const {
        for (const auto& axis : job_.axes()) MOTE_RETURN_IF_ERROR(PlotAxis::make(axis, source));
        return success();
    }

    /// What the manifest says, as the request named them.
    const std::vector<fs::path>& namedInputs() const { return inputs_; }

    /// Those that are meant of the source's steps, but for what was taken of its file before.
    LiveDataset::Next newSteps(const Batch& batch, const ParticleSource& source) {
        const auto& steps = source.steps();
        const bool one = batch.files.size() == 1;
        const std::size_t before = one ? taken_[batch.files.front().file.path].steps : 0;
        const std::size_t end = steps.size() - (batch.withoutLast && !steps.empty() ? 1 : 0);
        LiveDataset::Next next;
        for (std::size_t i = before; i < end; ++i) {
            const bool there = goesOn_ && steps[i].iteration <= lastIteration();
            if (meansStep(job_.steps(), seen_ + i - before) && !there) next.steps.push_back(i);
        }
        if (!live_.manifest() || goesOn_ || before > 0 || next.steps.empty()) return next;
        const auto& first = steps[next.steps.front()];
        if (!fileNumber(batch.files.front().file.path) && first.iteration <= lastIteration()) {
            next.firstIteration = lastIteration() + 1;
        } else if (first.iteration < lastIteration()) {
            progress_.note(fmt::format("{}: step {} came when the dataset had come to {}, and is left out",
                                       first.file, first.iteration, lastIteration()));
            next.steps.clear();
        }
        return next;
    }

    std::int64_t lastIteration() const {
        const auto& steps = live_.manifest()->particles().steps();
        return steps[steps.size() - 1].iteration();
    }

    void remember(const Batch& batch, const ParticleSource& source, std::size_t count) {
        const bool one = batch.files.size() == 1;
        for (const auto& file : batch.files) {
            auto& known = taken_[file.file.path];
            const std::size_t steps = one ? count : stepsOf(source, file);
            (steps == 0 ? known.tried : known.stamp) = file.stamp;
            if (batch.withoutLast) known.tried = std::exchange(known.stamp, {});
            seen_ += steps - std::min(known.steps, steps);
            noteChange(file, source, known);
            known.steps = std::max(known.steps, steps);
            known.particles = particlesOf(source, file, known.steps);
        }
    }

    static std::uint64_t particlesOf(const ParticleSource& source, const File& file, std::size_t most) {
        std::uint64_t particles = 0;
        for (const auto& step : source.steps()) {
            if (step.file != file.file.path.filename().string() || most == 0) continue;
            particles += step.particles;
            --most;
        }
        return particles;
    }

    /// A step that is there never changes: its file should not either.
    void noteChange(const File& file, const ParticleSource& source, Taken& known) {
        if (known.steps == 0 || particlesOf(source, file, known.steps) == known.particles) return;
        progress_.note(fmt::format("{} was written to after its step was taken, which stays as it is",
                                   file.file.path.filename().string()));
    }

    Status cannotRead(const Batch& batch, const Error& error) {
        if (!mayPass(error)) return error;
        for (const auto& file : batch.files) {
            auto& known = taken_[file.file.path];
            known.tried = file.stamp;
            // Of what is written to, an error is nothing to tell of.
            if (batch.withoutLast || std::exchange(known.noted, true)) continue;
            progress_.note(fmt::format("{} (tried again when it changes)", error.toString()));
        }
        return success();
    }

    const proto::ParticlesJob job_;
    const std::vector<fs::path> inputs_;
    LiveDataset live_;
    const JobResources resources_;
    Progress& progress_;
    WatchedFiles files_;
    std::map<fs::path, Taken> taken_;
    std::string format_;    ///< of the first files; empty: none was read yet
    std::size_t seen_ = 0;  ///< steps of the run so far, those that were not meant too
    bool noted_ = false;    ///< that there is no file yet
    bool goesOn_ = false;   ///< with a dataset that was there: its own steps come first
};

}  // namespace

Result<proto::Manifest> followRun(const proto::JobRequest& request, const std::vector<fs::path>& inputs,
                                  const fs::path& output, const JobResources& resources, Progress& progress) {
    if (resources.ranks != nullptr && resources.ranks->size() > 1)
        return unsupported("follow", "a run is followed by one process, not under MPI");
    MOTE_RETURN_IF_ERROR(checkParticlesJob(request.particles()));
    for (const auto& input : inputs) {
        std::error_code code;
        if (fs::exists(input / storage::manifestName, code))
            return invalid("inputs",
                           fmt::format("{} is a dataset; the files of a run are followed", input.string()));
    }
    // No lock of ours keeps the run's writer from its file, and none of his us: HDF5 reads this as it begins.
    ::setenv("HDF5_USE_FILE_LOCKING", "FALSE", 1);
    ::signal(SIGIO, SIG_IGN);  // somebody waits for a lease (watched_files.cpp), which is given back anyway
    MOTE_ASSIGN_OR_RETURN(auto live, LiveDataset::open(request, output));
    return FollowedRun(request, inputs, std::move(live), resources, progress).run();
}

}  // namespace mote::prep
