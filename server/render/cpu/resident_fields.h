// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentFields: what the device keeps of fields of either kind of samples: packed volumes, and where fields
// are visible. It holds no data alive. Owned by the device, used on its thread; what it
// returns may be read by any number until the next picture.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <utility>

#include "server/render/cpu/composite/dark_cells.h"
#include "server/render/plan/field_blocks.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/seen_fields.h"
#include "server/render/plan/step_volume.h"
#include "storage/blocks/counted_cache.h"

namespace mote::render {

/// PackedVolume: the cells of a step's volume, packed so that a trilinear sample takes four reads of 8 bytes.
/// Immutable once made; safe on any number of threads.
///
/// It is padded by one cell on each side with its outermost values, so that interpolation within the box
/// needs no clamping: the padded cell p (0 to size + 1) has its centre at (p - 1/2) / size of the box. A word
/// is a cell: the upper half of its extinction's cube root as a float, and t in 65535ths; words lie side by
/// side along x.
class PackedVolume {
  public:
    static constexpr std::uint32_t fullT = 65535;

    /// Works in parallel.
    explicit PackedVolume(const StepVolume& grid);

    const glm::uvec3& size() const { return size_; }         ///< cells, without the padding
    std::uint32_t rowWords() const { return size_.x + 2; }   ///< along x
    std::uint32_t sheetRows() const { return size_.y + 2; }  ///< along y
    const std::uint32_t* words() const { return words_.get(); }
    /// The ranges of extinction. Works in parallel.
    BlockRanges ranges() const;

  private:
    std::size_t index(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
        return (std::size_t{z} * sheetRows() + y) * rowWords() + x;
    }
    BlockRanges::Range rangeOf(const glm::uvec3& block, std::uint32_t edge) const;

    glm::uvec3 size_;
    std::unique_ptr<std::uint32_t[]> words_;
};

/// What is drawn of a field; nothing is owned but what is counted (storage/blocks/counted_cache.h).
struct VisibleField {
    SeenField seen;
    const PackedVolume* volume = nullptr;  ///< of densities that are somewhere visible
    float strength = 1.0F;                 ///< times its extinction
    /// Where its bricks are asked cell by cell; null: they are not.
    std::shared_ptr<const DarkCells> dark = nullptr;
};

/// Whether rays go from cell to cell, for their kinks: at two samples a cell or more.
inline bool cellByCell(const FramePlan& plan) {
    return plan.samplesPerCell >= 2.0;
}

class ResidentFields {
  public:
    /// What is as large as a part of the fields counts to `budget` from now on, and may go for others; null,
    /// as at first: to none.
    void countTo(const std::shared_ptr<storage::BlockBudget>& budget) {
        dark_.countTo(budget);
        seen_.countTo(budget);
    }
    /// One a field of the plan. Works in parallel.
    std::vector<VisibleField> of(const FramePlan& plan);
    /// Gives up what belongs to data that nobody else holds any more.
    void dropExpired();

  private:
    struct Resident {
        std::weak_ptr<const StepVolume> grid;
        const StepVolume* key;
        PackedVolume volume;
    };

    /// What of a transfer function dark cells depend on.
    struct Extinction {
        Curve opacity;
        double opacityLength, fade;
        ValueRange span;

        bool operator==(const Extinction&) const = default;
    };
    const PackedVolume& resident(const std::shared_ptr<const StepVolume>& grid);
    /// `kept`: how many to keep, of the latest.
    std::shared_ptr<const DarkCells> dark(const FieldPlan& plan, const SeenField& seen, std::size_t kept);

    std::list<Resident> volumes_;
    storage::CountedCache<Extinction, DarkCells> dark_;
    SeenFields seen_;
};

}  // namespace mote::render
