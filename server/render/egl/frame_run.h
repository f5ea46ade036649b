// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameRun: one plan being drawn: band by band of tile rows, and in each the passes of docs/RENDERING.md.
// Made for one picture by the device, on its thread, while its context is current.
#pragma once

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "server/render/egl/egl_device.h"
#include "server/render/egl/frame_block.h"
#include "server/render/egl/gl_objects.h"
#include "server/render/egl/resident_grids.h"
#include "server/render/egl/resident_steps.h"
#include "server/render/egl/shader_library.h"
#include "server/render/egl/table_entries.h"
#include "server/render/plan/pixel_colors.h"
#include "server/render/plan/screen_dots.h"
#include "server/render/plan/seen_fields.h"

namespace mote::render {

/// Bindings of shader storage; GL guarantees no more than eight. Blocks of points, bricks of volume and rays
/// by section are bound only for the dispatch that reads them, and share one.
enum Storage : GLuint {
    masks,
    offsets,
    cells,
    blocks,
    counters,
    volumeMasks,
    tiles,
    pixels,
    bricks = blocks,
    sections = blocks
};

/// Texture units of points' programs and of cells_allocate.
enum PointUnit : GLuint { pointUnit, selectedUnit, slabBitsUnit, allocateDotsUnit, weightUnitNumber };

/// Texture units of composite.comp: eight volumes or hybrid volumes' samples from 0, then these.
enum CompositeUnit : GLuint {
    tableUnit = 8,
    maskUnit,
    cellUnit,
    volumeMaskUnit,
    dotUnit,
    dotListUnit,
    gridBrickUnit,
    colorUnit
};

/// What shaders wrote before is seen by whatever reads it after.
inline void barrier() {
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                    GL_TEXTURE_FETCH_BARRIER_BIT);
}

/// The most bytes, at most `wanted`, of a buffer of pairs of words that shaders write and read as texels.
inline std::uint64_t pairLimit(std::uint64_t wanted) {
    GLint64 block = 0;
    GLint64 texels = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
    glGetInteger64v(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    // GL guarantees at least this much of each.
    const auto most = std::min(std::max<GLint64>(block, 1 << 27), 8 * std::max<GLint64>(texels, 1 << 16));
    return std::min(wanted, static_cast<std::uint64_t>(most));
}

/// Work groups of `size` for so many invocations.
inline std::uint32_t groups(std::uint32_t invocations, std::uint32_t size) {
    return (invocations + size - 1) / size;
}

/// A transfer table, and as shaders read it.
struct DensityTable {
    TransferTable table;
    std::vector<TableEntry> entries;

    explicit DensityTable(const TransferFunction& transfer) : table(transfer), entries(tableEntries(table)) {}
};
using DensityTables = TransferTables<DensityTable>;

/// Buffers that frames use again.
struct FrameBuffers {
    GlBuffer masks, offsets, cells, counters, volumeMasks, tiles, pixels, uniforms, blocks;
    GlBuffer dots, dotLists, sections;
    GlBuffer grids, gridBricks, tables, colors;
    GlTexture noVolume;  ///< if a layer has none: a program is compiled for textures as they are
    GlTexture gridBricksTexture, tablesTexture;
    GlTexture masksTexture, cellsTexture, volumeMasksTexture, dotsTexture, dotListsTexture, colorsTexture;
};

/// Without anything in it but its count of points.
Picture newPicture(const FramePlan& plan, PixelFormat format);

class FrameRun {
  public:
    /// `colors`: of each of the plan's points.
    FrameRun(const FramePlan& plan, const FrameColors& colors, PixelFormat format, const EglOptions& options,
             ShaderLibrary& shaders, ResidentSteps& steps, ResidentGrids& residentGrids,
             DensityTables& tables, FrameBuffers& buffers, std::stop_token stop);

    /// Draws bands of a picture that newPicture() made, from tile row `next` on, which is left where it got.
    /// `patient`: at least one. Whether the picture is done. Throws DeviceError, storage::StorageError.
    bool draw(Picture& picture, std::uint32_t& next, bool patient);
    const StageTimes& times() const { return times_; }

  private:
    struct LayerWork {
        LayerSlot slot;
        ResidentStep* resident;
        BendBlock bends;
        PointNumbers numbers{};
        const GridVolume* volume = nullptr;  ///< null if none of it is visible
        std::optional<BendBlock> volumeBends = {};
        const DensityTable* table = nullptr;
        GlBuffer bricks;
        std::uint32_t brickCount = 0;

        bool weighted() const { return slot.points != nullptr && !slot.points->selection->weights.empty(); }
        bool drawsPoints() const {
            return slot.points != nullptr && slot.points->pointsDrawn > 0 && numbers.tau > 0.0F;
        }
    };
    struct GridWork {
        const FieldPlan* plan;
        const CorrectedField* samples;  ///< the plan's
        ResidentGrid* resident;
        const ClassifiedBricks* bricks;
        GlBuffer visible;  ///< bricks in which something is seen
        std::uint32_t visibleCount;
        std::uint32_t firstBrick;  ///< among those of all fields
    };
    struct Band {
        std::uint32_t firstRow, rows, tiles;  ///< tile rows; tiles of them
    };
    /// What cells_allocate.comp counts: cells that the band needs; tiles with points alone, without points
    /// and with volume or dots, with points and volume.
    struct Counts {
        std::uint32_t cells = 0;
        std::array<std::uint32_t, 3> tiles{};
    };
    /// The pixels whose first cell is one of these.
    struct Pass {
        std::uint32_t firstCell = 0, cells = 0;
    };
    /// How points.glsl learns which points are drawn.
    enum class Selection { whole, byLeaf, listed };
    class Stage;

    std::uint32_t rowsOfABand() const;
    bool prepare();
    bool prepareVolume(LayerWork& work);
    void gatherTables();
    bool prepareGrids();
    void gatherBricks();
    void prepareDots();
    void writeDots(const std::vector<ScreenDot>& dots);
    PlacedDots madeDots(const Band& band) const;
    void bindDots(const Band& band);
    void bindColors(const Band& band);
    bool drawBand(const Band& band, Picture& picture);
    void bindBand(const Band& band);
    /// If depth does not matter: see flat_.
    bool drawFlat(const Band& band);
    bool drawSlabs(const Band& band);
    void markVolumes();
    bool markPoints();
    Counts allocateCells(const Band& band);
    bool drawCells(const Band& band, const Counts& counts);
    bool addPoints(const Pass& pass);
    bool dispatchPoints(std::string_view name, std::size_t layer, const Pass& pass);
    void dispatchBlocks(const std::vector<std::uint32_t>& numbers);
    GLuint usePointsProgram(std::string_view name, std::size_t layer, Selection selection, const Pass& pass);
    void setPointUniforms(GLuint program, std::size_t layer, const Pass& pass) const;
    bool composite(GLuint program, std::uint32_t firstTile, std::uint32_t tileCount);
    void readBack(const Band& band, Picture& picture);
    /// That the shaders are compiled for: they know no picture without any. Fields of samples come last.
    std::size_t layerCount() const { return std::max<std::size_t>(layers_.size() + grids_.size(), 1); }
    GLuint compositeProgram(bool points, bool volume, const Pass& pass) const;
    GLuint allocateProgram() const;

    const FramePlan& plan_;
    const FrameColors& frameColors_;
    PixelFormat format_;
    const EglOptions& options_;
    ShaderLibrary& shaders_;
    ResidentSteps& steps_;
    ResidentGrids& residentGrids_;
    DensityTables& tables_;
    FrameBuffers& buffers_;
    std::stop_token stop_;
    Pacer pacer_;
    StageTimes times_;
    std::vector<LayerWork> layers_;
    std::vector<GridWork> grids_;
    std::vector<const PixelColors*> colors_;  ///< of those points that are coloured by pixel
    PlacedDots dots_;                         ///< of the plan; front to back if nothing else is made
    std::vector<std::shared_ptr<const FragmentMaker>> makers_;
    bool anyDots_ = false;  ///< or anything that makes some
    bool anyPoints_ = false;
    bool flat_ = false;    ///< points of one layer and nothing else
    std::uint32_t words_;  ///< of slab bits a pixel
    std::uint32_t tilesAcross_, tilesDown_;
};

/// Notes how long a stage took, if EglOptions::measure asks for it.
class FrameRun::Stage {
  public:
    Stage(const FrameRun& run, StageTimes::Duration& sum) : measure_(run.options_.measure), sum_(sum) {
        if (measure_) glFinish();
    }
    ~Stage() {
        if (!measure_) return;
        glFinish();
        sum_ += std::chrono::steady_clock::now() - start_;
    }
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;

  private:
    bool measure_;
    StageTimes::Duration& sum_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace mote::render
