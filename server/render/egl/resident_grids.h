// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentGrids: what a device keeps of fields of samples in its memory, those given up first that were
// drawn longest ago. It holds no step alive. Owned by the device; used while its context is current.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>

#include "server/render/egl/classified_bricks.h"
#include "server/render/egl/step_grid.h"
#include "server/render/plan/grid_sights.h"

namespace mote::render {

/// A field, and what pictures drew of it.
struct ResidentGrid {
    std::weak_ptr<const GridField> grid;
    const GridField* key;
    bool corrected;  ///< with bricks
    StepGrid samples;
    struct Classified {
        TransferFunction transfer;
        bool mixed;
        ClassifiedBricks bricks;
    };
    std::list<Classified> classified = {};  ///< used last first

    std::size_t bytes() const { return samples.bytes(); }
};

/// What a layer draws: two may draw the same field.
struct GridParts {
    ResidentGrid* resident;
    const ClassifiedBricks* bricks;
};

class ResidentGrids {
  public:
    explicit ResidentGrids(std::uint64_t budget) : budget_(budget) {}

    /// What the plan draws, ready but for light; empty where the frame is given up meanwhile. It stays valid
    /// for the next 15 calls, until dropExpired(). Throws DeviceError.
    std::optional<GridParts> of(const FieldPlan& plan, const CorrectedField& samples, const Pacer& pacer);
    void dropExpired();

  private:
    ResidentGrid* find(const CorrectedField& samples, const Pacer& pacer);

    static constexpr std::size_t keptClassified = 16;  ///< more than a picture has layers

    std::uint64_t budget_;
    GridSights sights_;              // tables, and where the fields are seen
    std::list<ResidentGrid> grids_;  // drawn last first
};

}  // namespace mote::render
