// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentFields: what the device keeps of fields of either kind of samples: packed volumes, and where fields
// are visible. It holds no data alive. Owned by the device, used on its thread; what it
// returns may be read by any number until the next picture.
#pragma once

#include <cstdint>
#include <list>
#include <memory>

#include "server/render/plan/field_blocks.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/seen_fields.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// PackedVolume: a step's density volume as scaled log densities, packed so that a trilinear sample takes two
/// reads of 8 bytes. Immutable once made; safe on any number of threads.
///
/// The volume is padded by one cell on each side with its outermost values, so that interpolation within the
/// box needs no clamping: the padded cell p (0 to size + 1) has its centre at (p - 1/2) / size of the box.
/// A word holds two neighbours along y, the nearer one in the low half; words lie side by side along x, so
/// that 8 bytes from any word on are 2 x 2 cells.
class PackedVolume {
  public:
    static constexpr std::uint32_t mostCells = 512;  ///< a side: words are counted in 31 bits
    /// t = 1; 0 is t = -LogDensity::fade. A multiple of 9, so that t = 0, where extinction begins to fade, is
    /// a code of its own and an end of a cell of the transfer functions' tables.
    static constexpr std::uint16_t full = 32760;

    /// Works in parallel. Throws storage::StorageError where the volume is damaged or too large.
    explicit PackedVolume(const storage::ParticleStep& step);

    std::uint32_t size() const { return size_; }           ///< cells a side, without the padding
    std::uint32_t rowWords() const { return size_ + 2; }   ///< along x
    std::uint32_t sheetRows() const { return size_ + 1; }  ///< along y; the last cell is in the row before
    const std::uint32_t* words() const { return words_.get(); }
    /// The ranges of t. Works in parallel.
    BlockRanges ranges() const;
    /// A padded cell's code.
    std::uint16_t cell(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
        const std::uint32_t row = y < sheetRows() ? y : y - 1;
        const std::uint32_t word = words_[(std::size_t{z} * sheetRows() + row) * rowWords() + x];
        return static_cast<std::uint16_t>(y < sheetRows() ? word : word >> 16);
    }

  private:
    std::uint32_t size_;
    std::unique_ptr<std::uint32_t[]> words_;
};

/// What is drawn of a field; nothing is owned.
struct VisibleField {
    SeenField seen;
    const PackedVolume* volume = nullptr;  ///< of densities that are somewhere visible
};

class ResidentFields {
  public:
    /// One a field of the plan. Works in parallel. Throws storage::StorageError.
    std::vector<VisibleField> of(const FramePlan& plan);
    /// Gives up what belongs to data that nobody else holds any more.
    void dropExpired();

  private:
    struct Resident {
        std::weak_ptr<const storage::ParticleStep> step;
        const storage::ParticleStep* key;
        PackedVolume volume;
    };

    const PackedVolume& resident(const std::shared_ptr<const storage::ParticleStep>& step);

    std::list<Resident> volumes_;
    SeenFields seen_;
};

}  // namespace mote::render
