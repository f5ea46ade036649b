// SPDX-License-Identifier: GPL-3.0-or-later
//
// KnownQuantity: what a particle has a number of by a name that all know: a coordinate of the run, or what is
// made from such. The one table of names, symbols, units, columns and formulas: plot axes, columns,
// selections, statistics, histograms, colours and labels come from it, a row is all that a new one takes.
// docs/NUMBERS.md has the definitions.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace mote {

/// What formulas need besides a particle's own columns.
struct BeamContext {
    double mass = 0.0;             ///< eV/c^2, of one real particle; 0: not known, or of photons
    double meanMomentum = 0.0;     ///< eV/c, weighted mean of |p| over the step's particles
    std::array<double, 7> mean{};  ///< the same of x y z t px py pz: where the bunch is; NaN: not known
    bool photons = false;          ///< they are without mass
};

struct KnownQuantity {
    using Columns = std::span<const std::span<const double>>;
    /// `columns` are those that the row names, all of `out`'s size and none of them it. Not finite where a
    /// particle has none.
    using Formula = void (*)(Columns columns, const BeamContext& context, std::span<double> out);
    enum class Need : std::uint8_t {
        nothing,
        mass,           ///< above 0; or, where particles differ in it, that of each behind the columns
        massOrPhotons,  ///< likewise
        meanMomentum,
        means,  ///< of the coordinates
    };

    std::string_view name;
    std::string_view symbol;  ///< a letter, and behind "_" its index: "p_x"
    std::string_view unit;    ///< "m", "s", "rad", "eV/c", "eV" or "1"; of the weight the run's own
    std::vector<std::string_view> columns;  ///< what it is made from; of a coordinate itself
    Formula formula = nullptr;              ///< null: a coordinate or the weight, as the run has it
    Need need = Need::nothing;

    bool derived() const { return formula != nullptr; }
};

/// Coordinates in the order of BeamContext::mean, the weight, then what is derived.
std::span<const KnownQuantity> knownQuantities();

/// Null where there is none of this name.
const KnownQuantity* findKnownQuantity(std::string_view name);

}  // namespace mote
