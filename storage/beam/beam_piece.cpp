// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/beam/beam_piece.h"

#include <algorithm>
#include <cmath>

namespace mote::storage {
namespace {

using Columns = std::array<const double*, BeamRows::coordinates>;

/// By coordinate.
constexpr std::size_t timeColumn = 3;
constexpr std::array<std::size_t, BeamRows::coordinates> inBeamPiece{
    BeamPiece::x, BeamPiece::y, BeamPiece::z, BeamPiece::t, BeamPiece::px, BeamPiece::py, BeamPiece::pz};
constexpr std::array<std::size_t, BeamRows::coordinates> inPlanePiece{0, 2, 4, timeColumn, 1, 3, 5};

/// Where the rows from `begin` on stand; `most` zeros for what is not known.
template <std::size_t most>
Columns columnsFrom(const BeamRows& rows, std::size_t begin) {
    static constexpr std::array<double, most> zeros{};
    Columns from;
    for (std::size_t c = 0; c < from.size(); ++c)
        from[c] = rows.coordinate[c].empty() ? zeros.data() : rows.coordinate[c].data() + begin;
    return from;
}

/// Takes the weights, and adds to `check` what is not 0 where one is no weight.
template <std::size_t most>
void loadWeights(const BeamRows& rows, std::size_t begin, std::size_t count,
                 std::array<double, most>& weights, std::array<double, most>& check) {
    if (rows.weight.empty()) return static_cast<void>(std::fill_n(weights.begin(), count, 1.0));
    const double* const from = rows.weight.data() + begin;
    for (std::size_t i = 0; i < count; ++i) {
        weights[i] = from[i];
        check[i] += from[i] * 0.0;
    }
    for (std::size_t i = 0; i < count; ++i) check[i] = from[i] < 0.0 ? 1.0 : check[i];
}

/// Keeps the rows of which `check` is 0, and fills up the last lanes.
template <class Piece>
void keepGood(Piece& piece, const typename Piece::Values& check, std::size_t count) {
    double bad = 0.0;
    for (std::size_t i = 0; i < count; ++i) bad = check[i] == 0.0 ? bad : 1.0;
    piece.count = count;
    if (bad != 0.0) {
        piece.count = 0;
        for (std::size_t i = 0; i < count; ++i) {
            if (check[i] != 0.0) continue;
            for (auto& value : piece.value) value[piece.count] = value[i];
            piece.weight[piece.count++] = piece.weight[i];
        }
    }
    piece.size = (piece.count + lanes - 1) / lanes * lanes;
    for (std::size_t i = piece.count; i < piece.size; ++i) {
        for (auto& value : piece.value) value[i] = value[0];
        piece.weight[i] = 0.0;
    }
}

/// What is 0 where both slopes are finite. Returns whether all are.
bool checkSlopes(const BeamPiece& piece, BeamPiece::Values& check) {
    const auto &xp = piece.value[BeamPiece::xp], &yp = piece.value[BeamPiece::yp];
    double bad = 0.0;
    for (std::size_t i = 0; i < piece.count; ++i) {
        check[i] = xp[i] * 0.0 + yp[i] * 0.0;
        bad = check[i] == 0.0 ? bad : 1.0;
    }
    return bad == 0.0;
}

}  // namespace

std::uint32_t knownCoordinates(const BeamRows& rows) {
    std::uint32_t known = 0;
    for (std::size_t c = 0; c < BeamRows::coordinates; ++c) {
        if (!rows.coordinate[c].empty()) known |= std::uint32_t{1} << c;
    }
    return known;
}

MOTE_ANY_VECTORS void loadPiece(const BeamRows& rows, std::size_t begin, std::size_t count, double mass,
                                BeamPiece& piece) {
    alignas(64) BeamPiece::Values check;  // 0 if all is finite
    const auto from = columnsFrom<BeamPiece::most>(rows, begin);
    auto& value = piece.value;
    // Row by row, so that all of one is in registers.
    for (std::size_t i = 0; i < count; ++i) {
        double bad = 0.0;
        for (std::size_t c = 0; c < from.size(); ++c) {
            value[inBeamPiece[c]][i] = from[c][i];
            bad += from[c][i] * 0.0;
        }
        const double px = from[4][i], py = from[5][i], pz = from[6][i];
        const double p = std::sqrt(px * px + py * py + pz * pz);
        value[BeamPiece::p][i] = p;
        // sqrt(p^2 + m^2) - m without the difference of two large numbers.
        value[BeamPiece::energy][i] = mass > 0.0 ? p * (p / (std::sqrt(p * p + mass * mass) + mass)) : 0.0;
        value[BeamPiece::xp][i] = px / pz;
        value[BeamPiece::yp][i] = py / pz;
        check[i] = bad + p * 0.0;
    }
    loadWeights(rows, begin, count, piece.weight, check);
    keepGood(piece, check, count);
    piece.slopes = checkSlopes(piece, check);
}

void keepSlopes(BeamPiece& piece) {
    alignas(64) BeamPiece::Values check;
    if (!checkSlopes(piece, check)) keepGood(piece, check, piece.count);
    piece.slopes = true;
}

MOTE_ANY_VECTORS void loadPiece(const BeamRows& rows, std::size_t begin, std::size_t count,
                                PlanePiece& piece) {
    alignas(64) PlanePiece::Values check;
    const auto from = columnsFrom<PlanePiece::most>(rows, begin);
    for (std::size_t i = 0; i < count; ++i) {
        double bad = 0.0;
        for (std::size_t c = 0; c < from.size(); ++c) {
            if (c != timeColumn) piece.value[inPlanePiece[c]][i] = from[c][i];
            bad += from[c][i] * 0.0;
        }
        const double px = from[4][i], py = from[5][i], pz = from[6][i];
        check[i] = bad + (px * px + py * py + pz * pz) * 0.0;  // as its root
    }
    loadWeights(rows, begin, count, piece.weight, check);
    keepGood(piece, check, count);
}

}  // namespace mote::storage
