// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/beam/beam_piece.h"

#include <algorithm>
#include <cmath>

namespace mote::storage {
namespace {

using Values = std::array<double, BeamPiece::most>;

constexpr std::size_t energyOfA = 7, momentumOfA = 8;
/// By coordinate, its place in system a.
constexpr std::array<std::size_t, BeamRows::coordinates> placeInA{0, 2, 4, 6, 1, 3, 5};

/// Keeps the rows of which `check` is 0, and makes the rest of the last lanes weightless.
template <std::size_t N>
void keepGood(BeamPiece::Rows<N>& rows, const Values& check, std::size_t count) {
    bool all = true;
    for (std::size_t i = 0; i < count; ++i) all &= check[i] == 0.0;
    rows.count = count;
    if (!all) {
        rows.count = 0;
        for (std::size_t i = 0; i < count; ++i) {
            if (check[i] != 0.0) continue;
            for (auto& value : rows.value) value[rows.count] = value[i];
            rows.weight[rows.count++] = rows.weight[i];
        }
    }
    rows.size = (rows.count + lanes - 1) / lanes * lanes;
    for (std::size_t i = rows.count; i < rows.size; ++i) {
        for (auto& value : rows.value) value[i] = value[0];
        rows.weight[i] = 0.0;
    }
}

MOTE_ANY_VECTORS void loadA(const BeamRows& rows, std::size_t begin, std::size_t count, double mass,
                            BeamPiece& piece) {
    static constexpr std::array<double, BeamPiece::most> zeros{};
    auto& a = piece.a;
    alignas(64) Values check;  // 0 if all is finite
    std::array<const double*, BeamRows::coordinates> from;
    for (std::size_t c = 0; c < from.size(); ++c)
        from[c] = rows.coordinate[c].empty() ? zeros.data() : rows.coordinate[c].data() + begin;
    // Row by row, so that all of one is in registers.
    for (std::size_t i = 0; i < count; ++i) {
        double bad = 0.0;
        for (std::size_t c = 0; c < from.size(); ++c) {
            const double value = from[c][i];
            a.value[placeInA[c]][i] = value;
            bad += value * 0.0;
        }
        const double px = from[4][i], py = from[5][i], pz = from[6][i];
        const double p = std::sqrt(px * px + py * py + pz * pz);
        a.value[momentumOfA][i] = p;
        // sqrt(p^2 + m^2) - m without the difference of two large numbers.
        a.value[energyOfA][i] = mass > 0.0 ? p * (p / (std::sqrt(p * p + mass * mass) + mass)) : 0.0;
        check[i] = bad + p * 0.0;
    }
    for (std::size_t i = 0; i < count; ++i) {
        const double w = rows.weight.empty() ? 1.0 : rows.weight[begin + i];
        a.weight[i] = w;
        check[i] += w >= 0.0 ? w * 0.0 : 1.0;
    }
    keepGood(a, check, count);
}

MOTE_ANY_VECTORS void loadB(BeamPiece& piece) {
    const auto& a = piece.a;
    auto& b = piece.b;
    Values check{};
    for (std::size_t i = 0; i < a.count; ++i) {
        const double xp = a.value[1][i] / a.value[5][i], yp = a.value[3][i] / a.value[5][i];
        b.value[0][i] = a.value[0][i];
        b.value[1][i] = xp;
        b.value[2][i] = a.value[2][i];
        b.value[3][i] = yp;
        b.value[4][i] = a.value[momentumOfA][i];
        b.weight[i] = a.weight[i];
        check[i] = xp * 0.0 + yp * 0.0;
    }
    keepGood(b, check, a.count);
}

}  // namespace

std::uint32_t knownCoordinates(const BeamRows& rows) {
    std::uint32_t known = 0;
    for (std::size_t c = 0; c < BeamRows::coordinates; ++c) {
        if (!rows.coordinate[c].empty()) known |= std::uint32_t{1} << c;
    }
    return known;
}

void forEachPiece(const BeamRows& rows, double mass, bool slopes,
                  const std::function<void(const BeamPiece&)>& use) {
    BeamPiece piece;  // memory of the stack: fresh pages for each block would cost as much as its sums
    for (std::size_t begin = 0; begin < rows.size; begin += BeamPiece::most) {
        loadA(rows, begin, std::min(BeamPiece::most, rows.size - begin), mass, piece);
        if (piece.a.count == 0) continue;
        if (slopes) loadB(piece);
        use(piece);
    }
}

}  // namespace mote::storage
