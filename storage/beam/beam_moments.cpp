// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "storage/beam/beam_piece.h"
#include "storage/beam/moment_sums.h"

namespace mote::storage {
namespace {

using moments::join;
using moments::pairIndex;
using Values = BeamPiece::Values;

constexpr std::size_t variables = BeamPiece::variables;
/// Rows that are summed about one point; what they come to is joined with others'.
constexpr std::size_t rowsTogether = 4096;

template <std::size_t N>
using System = std::array<std::size_t, N>;  // the variables of a piece that it has
constexpr System<BeamMoments::sizeA> systemA{BeamPiece::x,  BeamPiece::px,     BeamPiece::y,
                                             BeamPiece::py, BeamPiece::z,      BeamPiece::pz,
                                             BeamPiece::t,  BeamPiece::energy, BeamPiece::p};
constexpr System<BeamMoments::sizeB> systemB{BeamPiece::x, BeamPiece::xp, BeamPiece::y, BeamPiece::yp,
                                             BeamPiece::p};

/// Sums over rows about `center`, by lane. They stay in a core's first cache with the piece that is added.
struct Running {
    std::array<double, variables> center{};
    bool centered = false;  ///< whether it is known
    std::size_t count = 0;
    bool slopes = false;  ///< whether they are summed
    double greatestWeight = 0.0;
    LaneVector weight{};
    std::array<LaneVector, variables> first{}, least{}, greatest{};
    std::array<std::array<LaneVector, variables>, variables> second{};  ///< of a and of b <= a
    std::array<std::array<LaneVector, 9>, 3> planes{};
};

using Deviations = std::array<Values, variables>;

/// The mean of a piece, whatever its weights.
void findCenter(const BeamPiece& piece, Running& sums) {
    for (std::size_t a = 0; a < variables; ++a) {
        const double from = piece.value[a][0];
        LaneVector sum{};
        for (std::size_t i = 0; i < piece.size; i += lanes) {
            LaneVector value;
            load(value, piece.value[a].data() + i);
            sum += value - from;  // nothing beyond the end
        }
        const double mean = from + sumOf(std::bit_cast<Lanes>(sum)) / static_cast<double>(piece.count);
        sums.center[a] = std::isfinite(mean) ? mean : from;
    }
}

/// The values of some variables become deviations, 0 beyond the last row.
template <std::size_t... a>
void deviate(BeamPiece& piece, Running& to) {
    std::array<LaneVector, sizeof...(a)> least{to.least[a]...}, greatest{to.greatest[a]...};
    const std::array center{to.center[a]...};
    for (std::size_t i = 0; i < piece.size; i += lanes) {
        std::size_t k = 0;
        const auto one = [&](double* at) {
            LaneVector value;
            load(value, at);
            least[k] = value < least[k] ? value : least[k];
            greatest[k] = value > greatest[k] ? value : greatest[k];
            value -= center[k++];
            std::memcpy(at, &value, sizeof value);
        };
        (one(piece.value[a].data() + i), ...);
    }
    for (std::size_t i = piece.count; i < piece.size; ++i) ((piece.value[a][i] = 0.0), ...);
    std::size_t k = 0;
    ((to.least[a] = least[k], to.greatest[a] = greatest[k], ++k), ...);
}

void deviateAll(BeamPiece& piece, Running& to) {
    using P = BeamPiece;
    if (to.count == 0) {
        for (std::size_t a = 0; a < variables; ++a) {
            load(to.least[a], piece.value[a].data());
            to.greatest[a] = to.least[a];
        }
    }
    deviate<P::x, P::px, P::y, P::py>(piece, to);
    deviate<P::z, P::pz, P::energy, P::p>(piece, to);
    deviate<P::t, P::xp, P::yp>(piece, to);
}

/// The deviations times the weights.
void weigh(const BeamPiece& piece, Running& to, Deviations& weighted) {
    LaneVector greatest = to.greatestWeight - LaneVector{};
    for (std::size_t i = 0; i < piece.size; i += lanes) {
        LaneVector weight;
        load(weight, piece.weight.data() + i);
        to.weight += weight;
        greatest = weight > greatest ? weight : greatest;
        for (std::size_t a = 0; a < variables; ++a) {
            LaneVector value;
            load(value, piece.value[a].data() + i);
            value *= weight;
            std::memcpy(weighted[a].data() + i, &value, sizeof value);
        }
    }
    to.greatestWeight = std::ranges::max(std::bit_cast<Lanes>(greatest));
}

/// The sums of variable `a`, and of its products with some. In one pass: a sum that waits for nothing but
/// itself leaves most of a core idle.
template <std::size_t a, std::size_t... b>
void addProducts(const BeamPiece& piece, const Deviations& weighted, Running& to) {
    std::array<LaneVector, sizeof...(b)> sums{to.second[a][b]...};
    LaneVector first = to.first[a];
    for (std::size_t i = 0; i < piece.size; i += lanes) {
        LaneVector mine, other;
        load(mine, weighted[a].data() + i);
        first += mine;
        std::size_t k = 0;
        ((load(other, piece.value[b].data() + i), sums[k++] += mine * other), ...);
    }
    std::size_t k = 0;
    ((to.second[a][b] = sums[k++]), ...);
    to.first[a] = first;
}

/// The third and fourth products of a coordinate and its momentum.
void addPlane(const BeamPiece& piece, const Deviations& weighted, std::size_t plane, Running& to) {
    const std::size_t q = 2 * plane, p = q + 1;
    auto sums = to.planes[plane];
    for (std::size_t i = 0; i < piece.size; i += lanes) {
        LaneVector qi, pi, wqq, wpp;
        load(qi, piece.value[q].data() + i);
        load(pi, piece.value[p].data() + i);
        load(wqq, weighted[q].data() + i);
        load(wpp, weighted[p].data() + i);
        wqq *= qi;
        wpp *= pi;
        const LaneVector qq = qi * qi, pp = pi * pi, qp = qi * pi;
        sums[0] += wqq * qi;
        sums[1] += wqq * pi;
        sums[2] += wpp * qi;
        sums[3] += wpp * pi;
        sums[4] += wqq * qq;
        sums[5] += wqq * qp;
        sums[6] += wqq * pp;
        sums[7] += wpp * qp;
        sums[8] += wpp * pp;
    }
    to.planes[plane] = sums;
}

void addAllProducts(const BeamPiece& of, bool timed, const Deviations& weighted, Running& to) {
    using P = BeamPiece;
    addProducts<P::x, P::x>(of, weighted, to);
    addProducts<P::px, P::x, P::px>(of, weighted, to);
    addProducts<P::y, P::x, P::px, P::y>(of, weighted, to);
    addProducts<P::py, P::x, P::px, P::y, P::py>(of, weighted, to);
    addProducts<P::z, P::x, P::px, P::y, P::py, P::z>(of, weighted, to);
    addProducts<P::pz, P::x, P::px, P::y, P::py, P::z, P::pz>(of, weighted, to);
    addProducts<P::energy, P::x, P::px, P::y, P::py, P::z, P::pz, P::energy>(of, weighted, to);
    addProducts<P::p, P::x, P::px, P::y, P::py, P::z, P::pz, P::energy, P::p>(of, weighted, to);
    if (timed)
        addProducts<P::t, P::x, P::px, P::y, P::py, P::z, P::pz, P::energy, P::p, P::t>(of, weighted, to);
    if (!to.slopes) return;
    addProducts<P::xp, P::x, P::y, P::p, P::xp>(of, weighted, to);
    addProducts<P::yp, P::x, P::y, P::p, P::xp, P::yp>(of, weighted, to);
}

/// `weighted` has room for deviations times weights; null: all weights are the same, and are counted later.
MOTE_ANY_VECTORS void addPiece(BeamPiece& piece, bool timed, Deviations* weighted, Running& to) {
    if (!to.centered) findCenter(piece, to);
    to.centered = true;
    deviateAll(piece, to);
    if (weighted != nullptr) weigh(piece, to, *weighted);
    const auto& times = weighted != nullptr ? *weighted : piece.value;
    addAllProducts(piece, timed, times, to);
    for (std::size_t plane = 0; plane < to.planes.size(); ++plane) addPlane(piece, times, plane, to);
    to.count += piece.count;
}

double sumOf(const LaneVector& of) {
    return storage::sumOf(std::bit_cast<Lanes>(of));
}

double productOf(const Running& sums, std::size_t a, std::size_t b) {
    return sumOf(sums.second[std::max(a, b)][std::min(a, b)]);
}

/// All weights are `one`, or were counted: then it is 1.
struct Weight {
    double sum = 0.0, one = 1.0;
};

template <std::size_t N>
void finish(const Running& sums, const System<N>& of, const Weight& weight, BeamMoments::Second<N>& out) {
    out.count = sums.count;
    out.weight = weight.sum * weight.one;
    std::array<double, N> rest{};
    for (std::size_t a = 0; a < N; ++a) {
        out.least[a] = std::ranges::min(std::bit_cast<Lanes>(sums.least[of[a]]));
        out.greatest[a] = std::ranges::max(std::bit_cast<Lanes>(sums.greatest[of[a]]));
        if (!(out.weight > 0.0)) continue;
        rest[a] = sumOf(sums.first[of[a]]);
        out.mean[a] = sums.center[of[a]] + rest[a] / weight.sum;
    }
    if (!(out.weight > 0.0)) return;
    for (std::size_t a = 0; a < N; ++a) {
        for (std::size_t b = a; b < N; ++b) {
            out.sum[pairIndex<N>(a, b)] =
                weight.one * (productOf(sums, of[a], of[b]) - rest[a] * (rest[b] / weight.sum));
        }
    }
}

void finishPlanes(const Running& sums, const Weight& weight, std::array<BeamMoments::Plane, 3>& out) {
    for (std::size_t plane = 0; plane < out.size(); ++plane) {
        const std::size_t q = 2 * plane, p = q + 1;
        BeamMoments::Plane about;
        for (std::size_t i = 0; i < 4; ++i) about.third[i] = sumOf(sums.planes[plane][i]);
        for (std::size_t i = 0; i < 5; ++i) about.fourth[i] = sumOf(sums.planes[plane][4 + i]);
        const moments::Lower lower{weight.sum,
                                   sumOf(sums.first[q]),
                                   sumOf(sums.first[p]),
                                   productOf(sums, q, q),
                                   productOf(sums, q, p),
                                   productOf(sums, p, p)};
        out[plane] = moments::shifted(about, lower, -lower.q / weight.sum, -lower.p / weight.sum);
        for (auto& value : out[plane].third) value *= weight.one;
        for (auto& value : out[plane].fourth) value *= weight.one;
    }
}

MOTE_ANY_VECTORS bool areSame(std::span<const double> weights) {
    double other = 0.0;
    for (const double weight : weights) other = weight == weights.front() ? other : 1.0;
    return other == 0.0;
}

/// Some rows of a block.
class RowSums {
  public:
    RowSums(const BeamRows& rows, std::size_t begin, std::size_t end, double mass)
        : rows_(rows),
          begin_(begin),
          end_(end),
          mass_(mass),
          same_(rows.weight.empty() || areSame(rows.weight.subspan(begin, end - begin))) {}

    BeamMoments::Sums find() const {
        BeamMoments::Sums out;
        const auto sums = sumAll(false);
        if (sums.count == 0) return out;
        out.greatestWeight = sums.greatestWeight;
        finish(sums, systemA, weightOf(sums), out.a);
        if (out.a.weight > 0.0) finishPlanes(sums, weightOf(sums), out.planes);
        if (rows_.coordinate.back().empty()) return out;
        if (sums.slopes) {
            finish(sums, systemB, weightOf(sums), out.b);
        } else {
            const auto some = sumAll(true);
            if (some.count > 0) finish(some, systemB, weightOf(some), out.b);
        }
        return out;
    }

  private:
    /// Of all rows, or of those alone whose slopes are finite.
    Running sumAll(bool slopesAlone) const {
        Running sums;
        add(slopesAlone, sums);
        if (!isFar(sums, weightOf(sums))) return sums;
        Running nearer;
        nearer.centered = true;
        for (std::size_t a = 0; a < variables; ++a)
            nearer.center[a] = sums.center[a] + sumOf(sums.first[a]) / weightOf(sums).sum;
        add(slopesAlone, nearer);
        return nearer;
    }

    void add(bool slopesAlone, Running& to) const {
        const bool timed = !rows_.coordinate[3].empty();
        to.slopes = !rows_.coordinate.back().empty();
        Deviations weighted;
        BeamPiece piece;
        for (std::size_t at = begin_; at < end_; at += BeamPiece::most) {
            loadPiece(rows_, at, std::min(BeamPiece::most, end_ - at), mass_, piece);
            if (slopesAlone) keepSlopes(piece);
            if (piece.count == 0) continue;
            to.slopes = to.slopes && piece.slopes;
            if (same_) to.greatestWeight = piece.weight[0];
            addPiece(piece, timed, same_ ? nullptr : &weighted, to);
        }
    }

    Weight weightOf(const Running& sums) const {
        return same_ ? Weight{static_cast<double>(sums.count), sums.greatestWeight}
                     : Weight{sumOf(sums.weight), 1.0};
    }

    /// Whether any mean is so many sigma from the point that the sums are about: they would lose digits.
    static bool isFar(const Running& sums, const Weight& weight) {
        constexpr double most = 4.0;
        constexpr double share = most * most / (1.0 + most * most);
        // Sums of slopes that are not all finite are no numbers, and so not far.
        for (std::size_t a = 0; a < variables && weight.sum > 0.0; ++a) {
            const double rest = sumOf(sums.first[a]);
            if (rest * rest > share * weight.sum * productOf(sums, a, a)) return true;
        }
        return false;
    }

    const BeamRows& rows_;
    const std::size_t begin_, end_;
    const double mass_;
    const bool same_;  ///< all weights
};

}  // namespace

void BeamMoments::add(const BeamRows& rows) {
    if (blocks_.empty() || blocks_.back().block != rows.block) blocks_.emplace_back().block = rows.block;
    for (std::size_t begin = 0; begin < rows.size; begin += rowsTogether) {
        const auto end = std::min(rows.size, begin + rowsTogether);
        auto some = RowSums(rows, begin, end, mass_).find();
        some.particles = end - begin;
        some.known = knownCoordinates(rows);
        join(blocks_.back(), some);
    }
}

BeamMoments::Sums BeamMoments::total() const {
    auto blocks = blocks_;
    std::ranges::sort(blocks, {}, &Sums::block);
    Sums total;
    for (const auto& block : blocks) join(total, block);
    return total;
}

}  // namespace mote::storage
