// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/impact/impact_check.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace mote::prep {
namespace {

constexpr std::uint64_t rowsToLookAt = 1000;
constexpr std::uint64_t fewRows = 20;  // of which nothing is said
constexpr double greatestPhase = 1e6;  // rad
// Charge states of one particle; a deck's mass and the file's may be rounded.
constexpr double leastChargeState = 0.1, greatestChargeState = 200.0;

// Columns of a file, from 0.
constexpr std::size_t checkedPx = 1, checkedPy = 3, phase = 4, energy = 5, chargeOverMass = 6, number = 8;

using Row = std::array<double, NumberTable::maxColumns>;

/// What a row holds that such a file cannot: the column, from 1, and what should stand there.
struct Fault {
    std::size_t column = 0;
    const char* should = "";
};

std::optional<Fault> faultOf(const Row& row, std::size_t columns, double mass) {
    if (std::abs(row[phase]) > greatestPhase) return Fault{phase, "a phase in rad"};
    if (columns <= number) return std::nullopt;
    const double state = std::abs(row[chargeOverMass] * mass);
    if (!(state >= leastChargeState && state <= greatestChargeState))
        return Fault{chargeOverMass, "the charge over the mass, one or a few over the mass in eV"};
    if (row[number] < 0.0 || row[number] != std::floor(row[number]))
        return Fault{number, "the number of the particle"};
    return std::nullopt;
}

Error refused(const std::string& where, std::string why) {
    return {ErrorCode::unsupported, where,
            "this is no particle file of IMPACT-Z: " + std::move(why) +
                "; say what the columns are with --map (x=1 [mm],px=2 [MeV/c])"};
}

}  // namespace

Status checkImpactZ(NumberTable& table, double mass, double gamma, Progress& progress) {
    const std::uint64_t rows = std::min(table.rows(), rowsToLookAt);
    if (rows == 0) return success();
    MOTE_RETURN_IF_ERROR(table.seek(0, progress));
    std::uint32_t all = 0;
    for (std::size_t i = 0; i < table.columns(); ++i) all |= 1u << i;
    std::uint64_t impossible = 0;
    Row row{};
    for (std::uint64_t i = 0; i < rows; ++i) {
        MOTE_RETURN_IF_ERROR(table.next(all, row));
        if (const auto fault = faultOf(row, table.columns(), mass)) {
            return refused(table.where() + ", column " + std::to_string(fault->column + 1),
                           "here should stand " + std::string(fault->should));
        }
        const double own = gamma - row[energy];
        const double whole = (own - 1.0) * (own + 1.0);
        if (gamma > 0.0 && !(whole >= row[checkedPx] * row[checkedPx] + row[checkedPy] * row[checkedPy]))
            ++impossible;
    }
    table.close();
    if (rows < fewRows || impossible <= rows / 2) return success();
    return refused(table.where(), "the energies of " + std::to_string(impossible) + " of its first " +
                                      std::to_string(rows) +
                                      " rows are less than their transverse momenta ask for");
}

}  // namespace mote::prep
