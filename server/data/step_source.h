// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepSource: where the renderer gets a layer's data from. Asked by the thread that renders; must answer from
// what is known, without searching and without reading what is loaded whole.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "protocol/base/error.h"
#include "server/data/loadable.h"
#include "storage/blocks/block_budget.h"
#include "storage/catalogue.h"
#include "storage/numbers/run_steps.h"
#include "storage/particles/particle_step.h"

namespace mote::server {

/// Where questions for numbers get a run of particles from. Any number of threads.
class RunSource {
  public:
    virtual ~RunSource() = default;
    /// `dataset` as in the catalogue. The same run as long as the dataset is the same. Errors: notFound,
    /// invalidArgument (it is no particle plot).
    virtual Result<std::shared_ptr<const storage::RunSteps>> run(const std::string& dataset) = 0;
    /// What is drawn, as StepSource has it, where questions are of that. Errors: as there; unsupported by who
    /// has runs alone.
    virtual Result<storage::Catalogue::Entry> dataset(const std::string& name) {
        return Error{ErrorCode::unsupported, "dataset", "of " + name + " only the run is here"};
    }
    virtual Result<Resident> resident(const AnyLoadable& what) {
        return Error{ErrorCode::unsupported, "dataset", "of " + what.dataset.name + " only the run is here"};
    }
};

class StepSource {
  public:
    virtual ~StepSource() = default;
    /// `name` as in the catalogue. Errors: notFound.
    virtual Result<storage::Catalogue::Entry> dataset(const std::string& name) = 0;
    /// A step of particles, of which more may be in memory or less. Errors: notFound (the dataset, the step),
    /// corrupt, permissionDenied.
    virtual Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string& dataset,
                                                                      std::uint32_t index) = 0;
    /// What was asked for; without a value if it is not there yet: it is brought in meanwhile. Errors: of
    /// its files; resourceExhausted.
    virtual Result<Resident> resident(const AnyLoadable& what) = 0;
    /// The same; null if it is not there yet.
    template <class T>
    Result<std::shared_ptr<const T>> get(const Result<Loadable<T>>& what) {
        MOTE_RETURN_IF_ERROR(what);
        MOTE_ASSIGN_OR_RETURN(const auto found, resident(*what));
        return std::static_pointer_cast<const T>(found.value);
    }
    /// Whether the dataset's steps are asked for in an order.
    virtual bool played(const storage::Catalogue::Entry& dataset) {
        static_cast<void>(dataset);
        return false;
    }
    /// What the pictures of a step, one that step() gave, would use now: what is missing is brought in
    /// meanwhile, and later steps of a series that is played are readied as far. Returns at once. False if
    /// nothing more will come: all is there, or there is no room for the rest.
    virtual bool want(const storage::ParticleStep& step, const storage::StepNeed& need) {
        static_cast<void>(step);
        static_cast<void>(need);
        return false;
    }
    /// Before a picture's first step: what the one before it held may leave memory.
    virtual void beginPicture() {}
};

}  // namespace mote::server
