// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
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

using Half [[gnu::vector_size(sizeof(Lanes) / 2)]] = double;

/// The lanes in a core's registers: in one vector, or in two halves. Where no vector is as long as the lanes,
/// g++ 12 takes each such vector apart through memory.
template <class Part>
struct Held {
    static constexpr std::size_t parts = sizeof(Lanes) / sizeof(Part);
    std::array<Part, parts> part;

    static Held from(const double* values) {
        Held held;
        std::memcpy(held.part.data(), values, sizeof held);
        return held;
    }
    static Held from(const Lanes& values) { return from(values.data()); }
    void putTo(double* values) const { std::memcpy(values, part.data(), sizeof part); }
    void putTo(Lanes& values) const { putTo(values.data()); }

    void operator+=(const Held& other) {
        for (std::size_t i = 0; i < parts; ++i) part[i] += other.part[i];
    }
    Held operator*(const Held& other) const {
        Held product;
        for (std::size_t i = 0; i < parts; ++i) product.part[i] = part[i] * other.part[i];
        return product;
    }
    Held operator-(double other) const {
        Held rest;
        for (std::size_t i = 0; i < parts; ++i) rest.part[i] = part[i] - other;
        return rest;
    }
    void takeLess(const Held& other) {
        for (std::size_t i = 0; i < parts; ++i) part[i] = other.part[i] < part[i] ? other.part[i] : part[i];
    }
    void takeGreater(const Held& other) {
        for (std::size_t i = 0; i < parts; ++i) part[i] = other.part[i] > part[i] ? other.part[i] : part[i];
    }
};

/// Sums over rows about `center`, by lane. They stay in a core's first cache with the piece that is added.
struct Running {
    std::array<double, variables> center{};
    bool centered = false;  ///< whether it is known
    std::size_t count = 0;
    bool slopes = false;  ///< whether they are summed
    double greatestWeight = 0.0;
    alignas(64) Lanes weight{};
    std::array<Lanes, variables> first{}, least{}, greatest{};
    std::array<std::array<Lanes, variables>, variables> second{};  ///< of a and of b <= a
    std::array<std::array<Lanes, 9>, 3> planes{};
};

using Deviations = std::array<Values, variables>;

/// The mean of a piece, whatever its weights.
template <class Vector>
void findCenter(const BeamPiece& piece, Running& sums) {
    for (std::size_t a = 0; a < variables; ++a) {
        const double from = piece.value[a][0];
        Vector sum{};
        for (std::size_t i = 0; i < piece.size; i += lanes)
            sum += Vector::from(piece.value[a].data() + i) - from;  // nothing beyond the end
        const double mean = from + sumOf(std::bit_cast<Lanes>(sum)) / static_cast<double>(piece.count);
        sums.center[a] = std::isfinite(mean) ? mean : from;
    }
}

/// The values of some variables become deviations, 0 beyond the last row.
template <class Vector, std::size_t... a>
void deviate(BeamPiece& piece, Running& to) {
    std::array least{Vector::from(to.least[a])...}, greatest{Vector::from(to.greatest[a])...};
    const std::array center{to.center[a]...};
    for (std::size_t i = 0; i < piece.size; i += lanes) {
        std::size_t k = 0;
        const auto one = [&](double* at) {
            const auto value = Vector::from(at);
            least[k].takeLess(value);
            greatest[k].takeGreater(value);
            (value - center[k++]).putTo(at);
        };
        (one(piece.value[a].data() + i), ...);
    }
    for (std::size_t i = piece.count; i < piece.size; ++i) ((piece.value[a][i] = 0.0), ...);
    std::size_t k = 0;
    ((least[k].putTo(to.least[a]), greatest[k].putTo(to.greatest[a]), ++k), ...);
}

template <class Vector>
void deviateAll(BeamPiece& piece, Running& to) {
    using P = BeamPiece;
    if (to.count == 0) {
        for (std::size_t a = 0; a < variables; ++a) {
            std::copy_n(piece.value[a].begin(), lanes, to.least[a].begin());
            to.greatest[a] = to.least[a];
        }
    }
    deviate<Vector, P::x, P::px, P::y, P::py>(piece, to);
    deviate<Vector, P::z, P::pz, P::energy, P::p>(piece, to);
    deviate<Vector, P::t, P::xp, P::yp>(piece, to);
}

/// The deviations times the weights.
template <class Vector>
void weigh(const BeamPiece& piece, Running& to, Deviations& weighted) {
    Vector greatest{}, sum = Vector::from(to.weight);
    for (std::size_t i = 0; i < piece.size; i += lanes) {
        const auto weight = Vector::from(piece.weight.data() + i);
        sum += weight;
        greatest.takeGreater(weight);
        for (std::size_t a = 0; a < variables; ++a)
            (Vector::from(piece.value[a].data() + i) * weight).putTo(weighted[a].data() + i);
    }
    sum.putTo(to.weight);
    to.greatestWeight = std::max(to.greatestWeight, std::ranges::max(std::bit_cast<Lanes>(greatest)));
}

/// The sums of variable `a`, and of its products with some. In one pass: a sum that waits for nothing but
/// itself leaves most of a core idle.
template <class Vector, std::size_t a, std::size_t... b>
void addProducts(const BeamPiece& piece, const Deviations& weighted, Running& to) {
    std::array sums{Vector::from(to.second[a][b])...};
    auto first = Vector::from(to.first[a]);
    for (std::size_t i = 0; i < piece.size; i += lanes) {
        const auto mine = Vector::from(weighted[a].data() + i);
        first += mine;
        std::size_t k = 0;
        ((sums[k++] += mine * Vector::from(piece.value[b].data() + i)), ...);
    }
    std::size_t k = 0;
    (sums[k++].putTo(to.second[a][b]), ...);
    first.putTo(to.first[a]);
}

/// The third and fourth products of a coordinate and its momentum.
template <class Vector>
void addPlane(const BeamPiece& piece, const Deviations& weighted, std::size_t plane, Running& to) {
    const std::size_t q = 2 * plane, p = q + 1;
    std::array<Vector, 9> sums;
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = Vector::from(to.planes[plane][i]);
    for (std::size_t i = 0; i < piece.size; i += lanes) {
        const auto qi = Vector::from(piece.value[q].data() + i), pi = Vector::from(piece.value[p].data() + i);
        const auto wqq = Vector::from(weighted[q].data() + i) * qi,
                   wpp = Vector::from(weighted[p].data() + i) * pi;
        const auto qq = qi * qi, pp = pi * pi, qp = qi * pi;
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
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i].putTo(to.planes[plane][i]);
}

template <class Vector>
void addAllProducts(const BeamPiece& of, bool timed, const Deviations& weighted, Running& to) {
    using P = BeamPiece;
    addProducts<Vector, P::x, P::x>(of, weighted, to);
    addProducts<Vector, P::px, P::x, P::px>(of, weighted, to);
    addProducts<Vector, P::y, P::x, P::px, P::y>(of, weighted, to);
    addProducts<Vector, P::py, P::x, P::px, P::y, P::py>(of, weighted, to);
    addProducts<Vector, P::z, P::x, P::px, P::y, P::py, P::z>(of, weighted, to);
    addProducts<Vector, P::pz, P::x, P::px, P::y, P::py, P::z, P::pz>(of, weighted, to);
    addProducts<Vector, P::energy, P::x, P::px, P::y, P::py, P::z, P::pz, P::energy>(of, weighted, to);
    addProducts<Vector, P::p, P::x, P::px, P::y, P::py, P::z, P::pz, P::energy, P::p>(of, weighted, to);
    if (timed)
        addProducts<Vector, P::t, P::x, P::px, P::y, P::py, P::z, P::pz, P::energy, P::p, P::t>(of, weighted,
                                                                                                to);
    if (!to.slopes) return;
    addProducts<Vector, P::xp, P::x, P::y, P::p, P::xp>(of, weighted, to);
    addProducts<Vector, P::yp, P::x, P::y, P::p, P::xp, P::yp>(of, weighted, to);
}

/// `weighted` has room for deviations times weights; null: all weights are the same, and are counted later.
template <class Vector>
void addHeld(BeamPiece& piece, bool timed, Deviations* weighted, Running& to) {
    if (!to.centered) findCenter<Vector>(piece, to);
    to.centered = true;
    deviateAll<Vector>(piece, to);
    if (weighted != nullptr) weigh<Vector>(piece, to, *weighted);
    const auto& times = weighted != nullptr ? *weighted : piece.value;
    addAllProducts<Vector>(piece, timed, times, to);
    for (std::size_t plane = 0; plane < to.planes.size(); ++plane) addPlane<Vector>(piece, times, plane, to);
    to.count += piece.count;
}

#ifdef MOTE_WIDEST_VECTORS
MOTE_WIDEST_VECTORS void addWhole(BeamPiece& piece, bool timed, Deviations* weighted, Running& to) {
    addHeld<Held<LaneVector>>(piece, timed, weighted, to);
}
#endif
MOTE_ANY_VECTORS void addHalves(BeamPiece& piece, bool timed, Deviations* weighted, Running& to) {
    addHeld<Held<Half>>(piece, timed, weighted, to);
}

void addPiece(BeamPiece& piece, bool timed, Deviations* weighted, Running& to) {
#ifdef MOTE_WIDEST_VECTORS
    if (hasWidestVectors()) return addWhole(piece, timed, weighted, to);
#endif
    addHalves(piece, timed, weighted, to);
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
        out.oneWeight = same_;
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

std::uint64_t BeamMoments::add(const BeamRows& rows) {
    std::uint64_t taken = 0;
    if (blocks_.empty() || blocks_.back().block != rows.block) blocks_.emplace_back().block = rows.block;
    for (std::size_t begin = 0; begin < rows.size; begin += rowsTogether) {
        const auto end = std::min(rows.size, begin + rowsTogether);
        auto some = RowSums(rows, begin, end, mass_).find();
        some.particles = end - begin;
        some.known = knownCoordinates(rows);
        taken += some.a.count;
        join(blocks_.back(), some);
    }
    return taken;
}

BeamMoments::Sums BeamMoments::total() const {
    auto blocks = blocks_;
    std::ranges::sort(blocks, {}, &Sums::block);
    Sums total;
    for (const auto& block : blocks) join(total, block);
    return total;
}

}  // namespace mote::storage
