// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentGrids: what a device keeps of fields of samples in its memory, those given up first that were
// drawn longest ago. It holds no step alive. Owned by the device; used while its context is current.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <list>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "server/render/egl/gl_objects.h"
#include "server/render/egl/table_entries.h"
#include "server/render/plan/grid_field.h"
#include "server/render/plan/seen_fields.h"

namespace mote::render {

/// The samples of a field in the device's memory: those of its coarse grid and of the bricks in which that is
/// corrected, four texels of 16 bytes for sixteen cells along x.
class StepGrid {
  public:
    static constexpr std::uint32_t brickEdge = GridBricks::edge;  ///< cells of the grid

    /// `corrected`: with the step's bricks, which must be there. Empty if the frame is given up meanwhile.
    /// Throws DeviceError, also if the device cannot hold it.
    /// `slopes`: its samples', null if nobody asks for them.
    static std::optional<StepGrid> load(const GridField& step, bool corrected, const GridSlopes* slopes,
                                        const Pacer& pacer);

    /// The coarse grid, x fastest, then brick after brick, as shaders/grid.glsl reads them.
    GLuint samples() const { return samplesTexture_.get(); }
    /// Samples along the axes of the grid that is cut into bricks: the error grid, or the coarse grid.
    const glm::uvec3& grid() const { return grid_; }
    /// The texel where their slopes begin, a byte each in the same order; 0 without.
    std::uint32_t firstSlope() const { return firstSlope_; }
    std::size_t bytes() const { return samples_.bytes(); }

  private:
    StepGrid(const GridField& step, const GridBricks* bricks);
    bool upload(const GridField& step, const GridBricks* bricks, const GridSlopes* slopes,
                const Pacer& pacer);

    GlBuffer samples_;
    GlTexture samplesTexture_;
    glm::uvec3 grid_;
    std::uint32_t firstSlope_ = 0;
};

/// What a transfer function makes of the bricks of a field, as shaders/grid.glsl reads it: where something is
/// seen, how far it is to there, how long a segment of a ray may be. Made in main memory.
struct ClassifiedBricks {
    ClassifiedBricks() = default;
    ClassifiedBricks(const CorrectedField& samples, const SeenField& seen);

    /// One word a brick, x fastest, as grid.glsl says.
    std::vector<std::uint32_t> words;
    /// Bricks in which something is seen, x | y << 10 | z << 20.
    std::vector<std::uint32_t> visible;
    std::vector<TableEntry> table;
};

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
    /// As SeenFields, of what it makes in main memory.
    void countTo(std::shared_ptr<storage::BlockBudget> budget) { seen_.countTo(std::move(budget)); }

    /// What the plan draws, ready but for light; empty if the frame is given up meanwhile. It stays valid
    /// for the next 15 calls, until dropExpired(). Throws DeviceError.
    std::optional<GridParts> of(const FieldPlan& plan, const CorrectedField& samples, const Pacer& pacer);
    void dropExpired();

  private:
    ResidentGrid* find(const CorrectedField& samples, const GridSlopes* slopes, const Pacer& pacer);

    static constexpr std::size_t keptClassified = 16;  ///< more than a picture has layers

    std::uint64_t budget_;
    SeenFields seen_;                // tables, and where the fields are seen
    std::list<ResidentGrid> grids_;  // drawn last first
};

}  // namespace mote::render
