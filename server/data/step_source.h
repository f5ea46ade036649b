// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepSource: where the renderer gets a layer's data from. Asked by the thread that renders; must answer from
// what is known, without searching.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "server/render/layers/stipple/stipple_surface.h"
#include "server/render/plan/grid_field.h"
#include "storage/particles/particle_step.h"
#include "storage/particles/step_need.h"

namespace mote::server {

/// Where a dataset of another kind lies.
struct DatasetPlace {
    std::filesystem::path directory;
    std::shared_ptr<const proto::Manifest> manifest;  ///< another one for a later dataset of its name
};

class StepSource {
  public:
    virtual ~StepSource() = default;
    /// `dataset` as in the catalogue. Errors: notFound.
    virtual Result<DatasetPlace> place(const std::string& dataset) {
        return Error{ErrorCode::notFound, "dataset", "there is no dataset \"" + dataset + "\" here"};
    }
    /// `dataset` as in the catalogue. Errors: notFound (the dataset, the step), corrupt, permissionDenied.
    virtual Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string& dataset,
                                                                      std::uint32_t index) = 0;
    /// The surface that a stipple layer draws. Errors: notFound, corrupt, permissionDenied; unsupported
    /// where the dataset holds none.
    virtual Result<std::shared_ptr<const render::StippleSurface>> surface(const std::string& dataset) {
        return Error{ErrorCode::unsupported, "dataset", "\"" + dataset + "\" is no stippled surface"};
    }
    /// The step of a hybrid volume, with what the representation draws; null where that is not there yet: it
    /// is brought in meanwhile. Errors: notFound, corrupt, permissionDenied, resourceExhausted; unsupported
    /// where the dataset has no such representation.
    virtual Result<std::shared_ptr<const render::GridField>> hybrid(const std::string& dataset,
                                                                    std::uint32_t index,
                                                                    HybridRepresentation representation) {
        static_cast<void>(index);
        static_cast<void>(representation);
        return Error{ErrorCode::unsupported, "dataset", "\"" + dataset + "\" is no hybrid volume"};
    }
    /// Its coarse grid alone, for as long as the rest is not there; null where steps are played and
    /// no hand is `moving` the view: then each is worth waiting for. Errors: the same.
    virtual Result<std::shared_ptr<const render::GridField>> hybridVolume(const std::string& dataset,
                                                                          std::uint32_t index, bool moving) {
        static_cast<void>(moving);
        return hybrid(dataset, index, HybridRepresentation::volume);
    }
    /// What the pictures of a step, one that step() gave, would use now: what is missing is brought in
    /// meanwhile, and later steps of a series that is played are readied as far. Returns at once. False where
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
