// SPDX-License-Identifier: GPL-3.0-or-later
//
// ErrorPass: goes through the error grid in slabs of z and says where the low-resolution volume is wrong;
// with it, which errors count, and the residual bricks that they become. One owner; works on the caller's
// oneTBB threads. The same source gives the same numbers for any threads and slabs.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "preprocess/hybrid/low_volume.h"
#include "preprocess/hybrid/value_range.h"
#include "preprocess/hybrid/volume_plan.h"
#include "storage/hybrid/hybrid_limits.h"
#include "storage/hybrid/residual_encoder.h"

namespace mote::prep {

/// Which errors count: those above a threshold, or the M of greatest magnitude. The latter are
/// found without sorting, by two counts: of the upper bits of all magnitudes, then of the lower bits of those
/// that share the upper bits of the M-th (a radix selection). Values; counts have one thread at a time.
struct ErrorSelection {
    float threshold = 0.0F;  ///< errors of a greater magnitude count
    /// Only so many errors of the least magnitude that counts, `least`, count: the first in the order of the
    /// bricks.
    float least = 0.0F;
    std::uint64_t mostOfLeast = ~std::uint64_t{0};

    bool takes(float error) const { return std::abs(error) > threshold; }
};

class ErrorCount {
  public:
    static constexpr int lowerBits = 15;

    /// Counts upper bits.
    ErrorCount() : bins_(std::size_t{1} << (31 - lowerBits)) {}
    /// Counts lower bits of the magnitudes that have these upper bits.
    explicit ErrorCount(std::uint32_t upper)
        : lower_(true), upper_(upper), bins_(std::size_t{1} << lowerBits) {}

    /// A count of the same that has counted nothing.
    ErrorCount empty() const { return lower_ ? ErrorCount(upper_) : ErrorCount(); }

    /// Errors of zero do not count.
    void add(std::span<const float> errors);
    void add(std::span<const std::uint64_t> bins);
    std::span<const std::uint64_t> bins() const { return bins_; }

    /// Where the `most`-th greatest lies.
    struct Place {
        std::uint32_t bin = 0;
        std::uint64_t above = 0;  ///< in greater bins
        bool fewer = false;       ///< there are not more than `most`: all count
    };
    Place find(std::uint64_t most) const;

  private:
    bool lower_ = false;
    std::uint32_t upper_ = 0;
    std::vector<std::uint64_t> bins_;
};

/// Selects the `most` greatest: the least of them has the upper bits `upper`, `above` of them greater ones.
ErrorSelection selectGreatest(const ErrorCount& lower, std::uint32_t upper, std::uint64_t most,
                              std::uint64_t above);

/// Slices [z0, z1) of the error grid, x fastest. Good during a visit.
class ErrorSlab {
  public:
    std::uint32_t z0 = 0, z1 = 0;
    storage::GridSize grid{};
    std::vector<float> errors;  ///< source minus low-resolution volume, of all samples of the slab

    std::size_t slice() const { return std::size_t{grid[0]} * grid[1]; }
    const float* error(std::uint32_t z) const { return errors.data() + (z - z0) * slice(); }
    /// The source at slice z and its neighbours, the slice itself at the grid's ends.
    std::array<const float*, 3> values(std::uint32_t z) const {
        return {value(z > 0 ? z - 1 : z), value(z), value(z + 1 < grid[2] ? z + 1 : z)};
    }

  private:
    friend class ErrorPass;
    const float* value(std::uint32_t z) const { return values_[z - valuesBegin_]; }

    std::uint32_t valuesBegin_ = 0;
    std::vector<const float*> values_;  ///< of slices valuesBegin_ on
};

class ErrorPass {
  public:
    /// All must outlive this; `together` slices make a slab, a multiple of residualBrickSide.
    ErrorPass(VolumeSource& source, const VolumePlan& plan, const ValueRange& range, const LowVolume& low,
              std::uint32_t together);

    /// Visits slices [e0, e1) in ascending order. The source's values between samples are interpolated
    /// linearly. Errors: the source's, and the visit's.
    Status run(std::uint32_t e0, std::uint32_t e1,
               const std::function<Status(const ErrorSlab&)>& visit) const;

  private:
    Status cover(SlabWindow& window, const ErrorSlab& slab) const;
    void sampleSource(const SlabWindow& window, ErrorSlab& slab, std::vector<float>& sampled) const;
    void sampleSlice(const SlabWindow& window, std::uint32_t z, std::span<float> out) const;
    void subtractLow(std::uint32_t z, ErrorSlab& slab) const;

    VolumeSource& source_;
    const VolumePlan& plan_;
    const ValueRange& range_;
    const LowVolume& low_;
    std::uint32_t together_;
    bool same_;                                                      ///< the error grid is the source's
    std::array<std::vector<storage::Between>, 3> inSource_, inLow_;  ///< where each sample lies along x, y, z
};

/// The step for errors above `threshold`, in the source's unit: what is left of an error is half a step at
/// most, and that shall be no more than the threshold below which errors are left as they are. So it is the
/// greatest power of two up to twice the threshold (as a half, a multiple then has few bits, which compress
/// well), but no less than the source's own quantum: a power of two up to `valueStep` (VolumeShape); where
/// that is not known, 1 if all values are integers, else 2^-16 of their span; and 2^-19 of it in any case.
double residualStep(const ValueRange& range, double valueStep, double threshold);

/// The bricks of a slab that begins at a multiple of their side, and lies in one layer of OpenVDB's nodes,
/// put aside; in no order. Errors: as ScratchFile::append.
Result<std::vector<storage::ResidualPart>> residualParts(const ErrorSlab& slab,
                                                         const ErrorSelection& selection,
                                                         const storage::ResidualCoding& coding,
                                                         storage::ScratchFile& scratch);

}  // namespace mote::prep
