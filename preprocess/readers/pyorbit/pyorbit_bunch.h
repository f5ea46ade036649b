// SPDX-License-Identifier: GPL-3.0-or-later
//
// PyorbitBunch: a bunch of PyORBIT in text, as Bunch.dumpBunch() writes it: what its lines with % say, and
// its rows. A value.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/table/held_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct PyorbitBunch {
    std::string name;                         ///< the file's
    double momentum = 0.0;                    ///< GeV/c, of the synchronous particle; 0: not said
    double energy = 0.0;                      ///< GeV, its kinetic energy; 0: not said
    double mass = 0.0;                        ///< GeV/c^2; 0: not said
    double charge = 0.0;                      ///< elementary charges; 0: not said
    double macroSize = 0.0;                   ///< real particles of each; 0: not said
    double time = 0.0;                        ///< s, of the synchronous particle
    std::vector<std::string> attributes;      ///< names of what stands behind the six coordinates
    std::vector<std::vector<double>> values;  ///< x px y py z dE, then what else rows have, by column

    /// Errors: those of LineReader, corrupt with line and column, resourceExhausted, cancelled.
    static Result<PyorbitBunch> read(const HeldFile& file);

    /// The column in which an attribute begins; nothing where it has none, or where the number of columns
    /// does not fit the attributes that are named.
    std::optional<std::size_t> find(std::string_view attribute) const;
};

}  // namespace mote::prep
