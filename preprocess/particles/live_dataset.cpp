// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/live_dataset.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "preprocess/kept_notes.h"
#include "preprocess/new_dataset.h"
#include "preprocess/parallel/communicator.h"
#include "protocol/base/system_error.h"
#include "protocol/scene/step_range.h"
#include "storage/dataset_writer.h"
#include "storage/files/dataset_file.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

/// "FOLDER/NAME.mote.partial-PID", in which steps are made; it goes with its owner.
class StepsDraft {
  public:
    static Result<StepsDraft> create(const fs::path& place) {
        for (int attempt = 0; attempt < 100; ++attempt) {
            fs::path folder = place;
            folder += fmt::format(".partial-{}", ::getpid());
            if (attempt > 0) folder += fmt::format("-{}", attempt);
            if (::mkdir(folder.c_str(), 0777) == 0) return StepsDraft(std::move(folder), place.filename());
            if (errno != EEXIST) return systemError(errno, place.string(), "cannot be made");
        }
        return Error{ErrorCode::alreadyExists, place.string(), "too many unfinished copies lie beside it"};
    }
    StepsDraft(StepsDraft&& other) noexcept
        : folder_(std::exchange(other.folder_, {})), name_(std::move(other.name_)) {}
    StepsDraft& operator=(StepsDraft&&) = delete;
    ~StepsDraft() {
        std::error_code ignored;
        if (!folder_.empty()) fs::remove_all(folder_, ignored);
    }
    fs::path output() const { return folder_ / name_; }

  private:
    StepsDraft(fs::path folder, fs::path name) : folder_(std::move(folder)), name_(std::move(name)) {}

    fs::path folder_, name_;
};

/// What a manifest keeps of the request: that of the plot, however its steps came.
proto::JobRequest ofPlot(proto::JobRequest request) {
    auto& job = *request.mutable_particles();
    job.clear_follow();
    job.clear_append();
    job.clear_closes();
    return request;
}

/// What one plot's steps have in common, whichever files they are read from.
proto::ParticlesJob choicesOf(const proto::JobRequest& request) {
    auto job = ofPlot(request).particles();
    job.clear_inputs();
    job.clear_steps();
    job.clear_format();
    if (job.bounds_of() == "run") job.clear_bounds_of();
    return job;
}

/// Errors: invalidArgument, with the first field that differs.
Status checkSamePlot(const proto::JobRequest& request, const proto::Manifest& manifest,
                     const fs::path& place) {
    const auto asked = choicesOf(request);
    const auto had = choicesOf(manifest.request());
    const auto& type = *asked.GetDescriptor();
    for (int i = 0; i < type.field_count(); ++i) {
        proto::ParticlesJob left = asked, right = had;
        for (int j = 0; j < type.field_count(); ++j) {
            if (j == i) continue;
            left.GetReflection()->ClearField(&left, type.field(j));
            right.GetReflection()->ClearField(&right, type.field(j));
        }
        if (left.SerializeAsString() == right.SerializeAsString()) continue;
        return invalid(
            std::string(type.field(i)->json_name()),
            fmt::format("is not that by which the live dataset {} was begun", place.filename().string()));
    }
    return success();
}

Result<proto::Manifest> readLive(const proto::JobRequest& request, const fs::path& place) {
    MOTE_ASSIGN_OR_RETURN(auto manifest, storage::readManifest(place));
    if (!manifest.particles().live())
        return Error{ErrorCode::alreadyExists, place.string(),
                     "exists already and is not live: it gets no further steps"};
    MOTE_RETURN_IF_ERROR(checkSamePlot(request, manifest, place));
    return manifest;
}

bool isThere(const fs::path& place) {
    std::error_code code;
    return fs::exists(fs::symlink_status(place, code));
}

std::vector<std::string> notesOf(const std::optional<proto::Manifest>& manifest) {
    if (!manifest) return {};
    return {manifest->particles().notes().begin(), manifest->particles().notes().end()};
}

/// As they follow each other in time.
Status checkOrder(const ParticleSource& source, const std::vector<std::size_t>& steps,
                  const std::optional<proto::Manifest>& manifest) {
    if (!manifest) return success();
    const auto& there = manifest->particles().steps();
    const auto last = there[there.size() - 1].iteration();
    for (const auto step : steps) {
        const auto& next = source.steps()[step];
        if (next.iteration > last) continue;
        return Error{
            ErrorCode::alreadyExists, next.file,
            fmt::format("is iteration {}, and the live dataset has come to {}", next.iteration, last)};
    }
    return success();
}

/// The same with no more steps to come, as files of a folder of its own.
Status writeClosed(proto::Manifest manifest, const fs::path& output) {
    manifest.mutable_particles()->set_live(false);
    MOTE_ASSIGN_OR_RETURN(auto writer, storage::DatasetWriter::create(output));
    return writer.publish(std::move(manifest));
}

}  // namespace

Result<LiveDataset> LiveDataset::open(const proto::JobRequest& request, const fs::path& place) {
    LiveDataset live(ofPlot(request), place);
    if (!isThere(place)) {
        MOTE_RETURN_IF_ERROR(storage::DatasetWriter::choose(place));
        return live;
    }
    MOTE_RETURN_IF_ERROR(readLive(request, place));
    MOTE_ASSIGN_OR_RETURN(auto lock, storage::GrowthLock::take(place));
    MOTE_ASSIGN_OR_RETURN(live.manifest_, readLive(request, place));  // as nobody else changes it
    live.lock_.emplace(std::move(lock));
    return live;
}

std::vector<std::string> LiveDataset::notes() const {
    return notesOf(manifest_);
}

Status LiveDataset::grow(const fs::path& draft) {
    if (lock_) return storage::growDataset(draft, *lock_);
    MOTE_RETURN_IF_ERROR(storage::publishByRename(draft, place_));
    MOTE_ASSIGN_OR_RETURN(auto lock, storage::GrowthLock::take(place_));
    lock_.emplace(std::move(lock));
    return success();
}

Result<bool> LiveDataset::add(ParticleSource& source, const std::vector<fs::path>& inputs, const Next& next,
                              const std::function<bool()>& whole, const JobResources& resources,
                              KeptNotes& notes) {
    MOTE_ASSIGN_OR_RETURN(const auto draft, StepsDraft::create(place_));
    LiveSteps live;
    live.base = manifest_;
    live.place = place_;
    live.steps = next.steps;
    live.firstIteration = next.firstIteration;
    live.live = next.live;
    MOTE_ASSIGN_OR_RETURN(auto made,
                          makeLiveSteps(request_, source, inputs, draft.output(), live, resources, notes));
    if (!whole()) return false;
    MOTE_RETURN_IF_ERROR(grow(draft.output()));
    manifest_ = std::move(made);
    return true;
}

Status LiveDataset::close() {
    if (!manifest_ || !manifest_->particles().live()) return success();
    MOTE_ASSIGN_OR_RETURN(const auto draft, StepsDraft::create(place_));
    MOTE_RETURN_IF_ERROR(writeClosed(*manifest_, draft.output()));
    MOTE_RETURN_IF_ERROR(grow(draft.output()));
    manifest_->mutable_particles()->set_live(false);
    return success();
}

Result<proto::Manifest> appendSteps(const proto::JobRequest& request, const std::vector<fs::path>& inputs,
                                    const fs::path& output, const JobResources& resources,
                                    Progress& progress) {
    const auto& job = request.particles();
    if (resources.ranks != nullptr && resources.ranks->size() > 1)
        return unsupported("append", "steps are added by one process, not under MPI");
    const auto place = finalPlace(output);
    std::optional<proto::Manifest> base;
    if (isThere(place)) {
        MOTE_ASSIGN_OR_RETURN(base, readLive(request, place));
    }
    std::optional<StepsDraft> draft;
    if (place == output) {
        MOTE_ASSIGN_OR_RETURN(auto own, StepsDraft::create(place));
        draft.emplace(std::move(own));
    }
    const auto made = draft ? draft->output() : output;
    Result<proto::Manifest> manifest = invalid("inputs", "name no file, and there is no live dataset to end");
    if (inputs.empty() && base) {
        MOTE_RETURN_IF_ERROR(writeClosed(*base, made));
        base->mutable_particles()->set_live(false);
        manifest = *base;
    } else if (!inputs.empty()) {
        KeptNotes notes(progress, notesOf(base));
        MOTE_ASSIGN_OR_RETURN(const auto source, openRun(job, inputs, notes));
        LiveSteps live;
        MOTE_ASSIGN_OR_RETURN(live.steps, selectSteps(job.steps(), source->steps().size()));
        MOTE_RETURN_IF_ERROR(checkOrder(*source, *live.steps, base));
        live.base = base;
        live.place = place;
        live.live = !job.closes();
        manifest = makeLiveSteps(ofPlot(request), *source, inputs, made, live, resources, notes);
    }
    if (!manifest.ok() || !draft) return manifest;
    if (!base) {
        MOTE_RETURN_IF_ERROR(storage::publishByRename(made, place));
    } else {
        MOTE_ASSIGN_OR_RETURN(const auto lock, storage::GrowthLock::take(place));
        MOTE_RETURN_IF_ERROR(storage::growDataset(made, lock));
    }
    return manifest;
}

}  // namespace mote::prep
