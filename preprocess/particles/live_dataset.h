// SPDX-License-Identifier: GPL-3.0-or-later
//
// LiveDataset: a dataset of particles that gets its steps one after another while the run is written
// (storage/grow_dataset.h): it is published with the first, and each further step is made beside it and put
// in. One owner, one thread; while it exists no other program adds to the dataset.
//
// appendSteps: a job whose inputs are the next steps of a live dataset, as a simulation sends them to a
// server, one job a step.
//
// followRun: the particles job on a run that is still written: it makes a live dataset of the steps that are
// there, and each further one becomes its next step as soon as its file is whole. It ends when it is
// cancelled, or with the last step that the request means. Called from one thread; in one process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/kept_notes.h"
#include "preprocess/particles/particles_job.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/grow_dataset.h"

namespace mote::prep {

class LiveDataset {
  public:
    /// `place` is "FOLDER/NAME.mote", where a live dataset of the request's plot lies, or nothing yet.
    /// Errors: invalidArgument (a name; a dataset of another plot), alreadyExists (one that is not live;
    /// another program adds to it), as storage::readManifest.
    static Result<LiveDataset> open(const proto::JobRequest& request, const std::filesystem::path& place);

    /// Of what is published; none: nothing is.
    const std::optional<proto::Manifest>& manifest() const { return manifest_; }
    std::size_t steps() const {
        return manifest_ ? static_cast<std::size_t>(manifest_->particles().steps_size()) : 0;
    }

    /// What was said of them so far.
    std::vector<std::string> notes() const;

    /// Which of the source's steps follow, and how they are numbered.
    struct Next {
        std::vector<std::size_t> steps;
        std::optional<std::int64_t> firstIteration = {};
        bool live = true;  ///< more may come
    };
    /// Makes them and, if `whole` says that their files are what they were, publishes them. False: it said
    /// they are not. Errors: as makeLiveSteps, DatasetWriter::publish, storage::growDataset; the dataset is
    /// what it was then.
    Result<bool> add(ParticleSource& source, const std::vector<std::filesystem::path>& inputs,
                     const Next& next, const std::function<bool()>& whole, const JobResources& resources,
                     KeptNotes& notes);
    /// No more steps come. Errors: as storage::growDataset.
    Status close();

  private:
    LiveDataset(proto::JobRequest request, std::filesystem::path place)
        : request_(std::move(request)), place_(std::move(place)) {}
    Status grow(const std::filesystem::path& draft);

    proto::JobRequest request_;
    std::filesystem::path place_;
    std::optional<proto::Manifest> manifest_;
    std::optional<storage::GrowthLock> lock_;  ///< from the first step on
};

/// Makes the next steps of the live dataset at the output's place, which they begin if nothing is there. A
/// server's job leaves them where its output is made, for whoever puts that in place; else they are put in.
/// Without inputs, the request ends a live dataset. Errors: as LiveDataset; alreadyExists (a step that does
/// not come after those that are there); unsupported (several processes).
Result<proto::Manifest> appendSteps(const proto::JobRequest& request,
                                    const std::vector<std::filesystem::path>& inputs,
                                    const std::filesystem::path& output, const JobResources& resources,
                                    Progress& progress);

/// `output` is the dataset's place: nothing is there, or a live dataset of this run, with which it goes on.
/// Returns the manifest in the end, of a dataset that is no more live; a file that cannot be read is noted,
/// and tried again when it changes. Errors: cancelled (before the first step); unsupported (several
/// processes); as LiveDataset and runParticlesJob: then the dataset is live still.
Result<proto::Manifest> followRun(const proto::JobRequest& request,
                                  const std::vector<std::filesystem::path>& inputs,
                                  const std::filesystem::path& output, const JobResources& resources,
                                  Progress& progress);

}  // namespace mote::prep
