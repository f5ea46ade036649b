// SPDX-License-Identifier: GPL-3.0-or-later
//
// BinAxis: in which of some even bins each point's quantity lies. Immutable; any number of threads, each with
// a Scratch of its own.
//
// Edge i of n bins over [low, high] is low + i * ((high - low) / n) in doubles, the last one high itself. A
// value belongs to bin i where edge i <= value < edge i + 1, and to the last one where it is high: the bins
// of numpy.histogram and histogram2d. What lies beyond, and what is not a number, belongs to none.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "protocol/scene/error.h"
#include "storage/beam/quantity_reader.h"
#include "storage/numbers/bin_kernel.h"
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
    std::optional<std::size_t> column_;  // that is binned as it is stored, in floats
    FloatBins floats_;                   // of it
};

/// A range that bins can be in: what it is where low < high; else a half to both sides of the one value, or
/// more where a half is nothing beside it; [0, 1] where there is no value, low > high.
std::pair<double, double> widened(double low, double high);
/// The edges of even bins.
std::vector<double> evenEdges(std::uint32_t bins, double low, double high);
/// The bin of a value; the number of bins where it has none.
std::uint32_t binOf(std::span<const double> edges, double value);

}  // namespace mote::storage
