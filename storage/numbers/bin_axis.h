// SPDX-License-Identifier: GPL-3.0-or-later
//
// BinAxis: in which of some bins each point's quantity lies. Immutable; any number of threads, each with
// a Scratch of its own.
//
// Edge i of n even bins over [low, high] is low + i * ((high - low) / n) in doubles, the last one high
// itself. A value belongs to bin i where edge i <= value < edge i + 1, and to the last one where it is high:
// the bins of numpy.histogram and histogram2d. What lies beyond, and what is not a number, belongs to none.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "storage/beam/quantity_reader.h"
#include "storage/numbers/bin_kernel.h"
#include "storage/numbers/point_mask.h"
#include "storage/numbers/run_steps.h"

namespace mote::storage {

class BinAxis {
  public:
    /// A thread's memory.
    struct Scratch {
        QuantityReader::Scratch reader;
        std::vector<double> values;
    };

    /// Finite, low < high; 1 bin at least. The step's columns outlive it. Errors: notFound at the column's
    /// name.
    static Result<BinAxis> make(const StepNumbers& step, const std::string& column, std::uint32_t bins,
                                double low, double high);
    /// Bins of any edges, two at least, that do not descend: where several are alike, the last of their bins
    /// has what lies there. Errors likewise.
    static Result<BinAxis> make(const StepNumbers& step, const std::string& column,
                                std::vector<double> edges);

    std::uint32_t bins() const { return static_cast<std::uint32_t>(edges_.size()) - 1; }
    const std::vector<double>& edges() const { return edges_; }

    /// The bin of each point of a block, bins() where it has none. Throws StorageError.
    void find(PointRange block, Scratch& scratch, std::span<std::uint32_t> out) const;

  private:
    BinAxis(const ParticleColumns& columns, QuantityReader reader, std::vector<double> edges)
        : columns_(&columns), reader_(std::move(reader)), edges_(std::move(edges)) {}

    const ParticleColumns* columns_;
    QuantityReader reader_;
    std::vector<double> edges_;
    bool even_ = true;
    std::optional<std::size_t> column_;  // that is binned as it is stored, in floats
    FloatBins floats_;                   // of it
};

/// A range that bins can be in: what it is where low < high; else a half to both sides of the one value, or
/// more where a half is nothing beside it; [0, 1] where there is no value, low > high.
std::pair<double, double> widened(double low, double high);
/// The edges of even bins.
std::vector<double> evenEdges(std::uint32_t bins, double low, double high);
/// The edges of slices of equal weight over [low, high], the chosen points' own range (null: of all): edge i
/// of n is the least value at which the weight of it and all below is more than i/n of all, weights counted
/// in whole 2^31sts of the greatest; where nothing weighs anything, even edges. Any number of threads gives
/// the same. Nothing where `cancelled` said to stop. Throws StorageError.
std::optional<std::vector<double>> edgesOfEqualWeight(const StepNumbers& step, const QuantityReader& reader,
                                                      const PointMask* chosen, std::uint32_t slices,
                                                      double low, double high,
                                                      const std::function<bool()>& cancelled);
/// The bin of a value among even ones; the number of bins where it has none.
std::uint32_t binOf(std::span<const double> edges, double value);

}  // namespace mote::storage
