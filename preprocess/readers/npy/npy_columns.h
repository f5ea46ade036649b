// SPDX-License-Identifier: GPL-3.0-or-later
//
// NpyColumns: what the arrays of a file mean for a run: which numbers are which column, how many steps and
// rows there are, and what stands beside them (mass, times, iterations). Which names and shapes are
// understood: docs/READERS.md. A value, made once a file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/npy/npy_array.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct NpyColumns {
    struct Item {
        FieldMeaning meaning;
        std::size_t array = 0;  ///< which of them
        NpyNumbers numbers;
        std::string name;  ///< as it is written, for messages
    };

    std::vector<NpyArray> arrays;
    std::vector<Item> items;
    std::uint64_t steps = 1, rows = 0;     ///< rows of each step
    std::vector<double> times;             ///< s, of each step; empty where the file does not say
    std::vector<std::int64_t> iterations;  ///< the same
    double mass = 0.0;                     ///< eV/c^2; 0: unknown
    bool unnamed = false;                  ///< columns by their order, not by name

    const Item* find(Column column) const;
    const Item* findRecord(std::string_view name) const;  ///< by recordOf(its name)

    /// `mass` goes before the file's. Errors: corrupt (arrays of different lengths, two of one meaning, a
    /// mass or an iteration that is none), unsupported (other shapes, more than 100 000 steps, types that are
    /// not read), invalidArgument (units that need a mass), those of NpyReader.
    static Result<NpyColumns> of(std::vector<NpyArray> arrays, double mass, const std::string& file);
};

}  // namespace mote::prep
