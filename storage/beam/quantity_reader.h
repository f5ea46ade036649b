// SPDX-License-Identifier: GPL-3.0-or-later
//
// QuantityReader: quantities of a step's points as doubles, block by block, from the columns that lie
// beside the points. Immutable but for what each call is given; any number of threads, each with a Scratch of
// its own. The columns outlive it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/quantity/quantity.h"
#include "storage/particles/particle_columns.h"

namespace mote::storage {

/// What a step's columns are for quantities.
RunColumns runOf(const ParticleColumns& columns, const BeamContext& context);

class QuantityReader {
  public:
    /// A thread's memory.
    struct Scratch {
        std::vector<std::vector<double>> columns;  ///< by column that any quantity needs
        Quantity::Scratch quantity;
    };

    /// `names` are of columns, known quantities or expressions. Errors, at the name: as Quantity::make.
    static Result<QuantityReader> make(const ParticleColumns& columns, const BeamContext& context,
                                       std::span<const std::string> names);

    std::size_t size() const { return sources_.size(); }  ///< as many as names
    /// The unit of each name's quantity.
    const std::vector<std::string>& units() const { return units_; }

    /// Points [begin, begin + count): `out` has a span of `count` for each name. Throws StorageError.
    void read(std::uint64_t begin, std::size_t count, Scratch& scratch,
              std::span<const std::span<double>> out) const;

  private:
    struct Source {
        Quantity quantity;
        std::vector<std::size_t> columns;  ///< indices in needed_
    };
    QuantityReader(const ParticleColumns& columns, const BeamContext& context)
        : columns_(&columns), context_(context) {}

    const ParticleColumns* columns_;
    BeamContext context_;
    std::vector<std::size_t> needed_;  ///< columns of the step
    std::vector<Source> sources_;      ///< by name
    std::vector<std::string> units_;
};

}  // namespace mote::storage
