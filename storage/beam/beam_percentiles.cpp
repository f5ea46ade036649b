// SPDX-License-Identifier: GPL-3.0-or-later
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "storage/beam/beam_piece.h"
#include "storage/beam/plane_actions.h"
#include "storage/numbers/range_kernel.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

using Percentiles = BeamPercentiles;

constexpr std::uint64_t binsOfWindow = 4096;
constexpr std::uint64_t mostNear = std::uint64_t{1} << 18;  // particles near a cut that are sorted
// Over the root of a sample's particles: the share that it has below a cut deviates by 0.3 and less.
constexpr double marginOfOne = 0.9;
constexpr std::size_t leastSample = std::size_t{1} << 10, mostSample = std::size_t{1} << 19;
constexpr std::size_t leastStride = 32;
constexpr double sharesOfGreatest = 2147483648.0;
constexpr std::uint64_t endOfActions = std::uint64_t{1} << 63;  // of the bits of what is not negative

std::uint64_t bitsOf(double action) {
    return std::bit_cast<std::uint64_t>(action);
}

void add(Percentiles::Inside& to, const Percentiles::Inside& from) {
    to.weight += from.weight;
    to.qq += from.qq;
    to.qp += from.qp;
    to.pp += from.pp;
}

bool before(const Percentiles::NearCut& a, const Percentiles::NearCut& b) {
    if (a.cut != b.cut) return a.cut < b.cut;
    if (a.action != b.action) return a.action < b.action;
    return a.block < b.block;
}

double emittance(const Percentiles::Inside& of) {
    return std::sqrt(std::max(of.qq * of.pp - of.qp * of.qp, 0.0)) / of.weight;
}

/// The share that each weight is, a whole number below 2^53.
MOTE_ANY_VECTORS void findShares(double shareOfWeight, const double* weights, std::size_t size, double* to) {
    constexpr double whole = 4503599627370496.0;  // 2^52: beside it there are no fractions
    for (std::size_t i = 0; i < size; ++i) {
        const double share = weights[i] * shareOfWeight + whole;
        to[i] = share - whole;
    }
}

/// Deviations from a plane's means, and actions.
struct Actions {
    alignas(64) std::array<double, PlanePiece::most> q, p, action;
};

MOTE_ANY_VECTORS void findActions(const PlaneFrame& of, const double* fromQ, const double* fromP,
                                  std::size_t size, Actions& to) {
    for (std::size_t i = 0; i < size; ++i) {
        const double q = fromQ[i] - of.q;
        const double p = fromP[i] - of.p;
        to.q[i] = q;
        to.p[i] = p;
        to.action[i] = actionOf(of, q, p);
    }
}

using CutsOfPlane = std::array<double, Percentiles::percents.size()>;

/// By cut of a plane, the sums over those whose action is less than `lowest`.
MOTE_ANY_VECTORS void sumBelow(const CutsOfPlane& lowest, const Actions& of, const double* weights,
                               std::size_t size, Percentiles::Inside* to) {
    std::array<std::array<LaneVector, 4>, std::tuple_size_v<CutsOfPlane>> inside{};
    for (std::size_t i = 0; i < size; i += lanes) {
        LaneVector weight, q, p, action;
        load(weight, weights + i);
        load(q, of.q.data() + i);
        load(p, of.p.data() + i);
        load(action, of.action.data() + i);
        const LaneVector weighted = weight * q, qq = weighted * q, qp = weighted * p, pp = weight * p * p;
#pragma GCC unroll 4
        for (std::size_t cut = 0; cut < inside.size(); ++cut) {
            const auto below = action < lowest[cut];
            inside[cut][0] += below ? weight : 0.0;
            inside[cut][1] += below ? qq : 0.0;
            inside[cut][2] += below ? qp : 0.0;
            inside[cut][3] += below ? pp : 0.0;
        }
    }
    for (std::size_t cut = 0; cut < inside.size(); ++cut) {
        const auto sum = [&](std::size_t i) { return sumOf(std::bit_cast<Lanes>(inside[cut][i])); };
        mote::storage::add(to[cut], {sum(0), sum(1), sum(2), sum(3)});
    }
}

/// By cut of a plane, the shares of those whose action is less than `lowest`; at most 2^22 of them, so that
/// their sums are exact.
MOTE_ANY_VECTORS void sumSharesBelow(const CutsOfPlane& lowest, const Actions& of, const double* shares,
                                     std::size_t size, std::uint64_t* to) {
    std::array<LaneVector, std::tuple_size_v<CutsOfPlane>> below{};
    for (std::size_t i = 0; i < size; i += lanes) {
        LaneVector share, action;
        load(share, shares + i);
        load(action, of.action.data() + i);
        for (std::size_t cut = 0; cut < below.size(); ++cut) below[cut] += action < lowest[cut] ? share : 0.0;
    }
    for (std::size_t cut = 0; cut < below.size(); ++cut)
        to[cut] += static_cast<std::uint64_t>(sumOf(std::bit_cast<Lanes>(below[cut])));
}

}  // namespace

std::uint64_t BeamSample::strideOf(std::uint64_t particles) {
    return std::max<std::uint64_t>(leastStride, particles / mostSample);
}

void BeamSample::add(const BeamRows& rows) {
    const auto join = [&](std::vector<double>& to, std::span<const double> from) {
        if (!from.empty()) to.reserve(room_);
        to.insert(to.end(), from.begin(), from.end());
    };
    for (std::size_t c = 0; c < coordinate_.size(); ++c) join(coordinate_[c], rows.coordinate[c]);
    join(weight_, rows.weight);
    size_ += rows.size;
}

BeamRows BeamSample::rows() const {
    BeamRows rows;
    for (std::size_t c = 0; c < coordinate_.size(); ++c) rows.coordinate[c] = coordinate_[c];
    rows.weight = weight_;
    rows.size = size_;
    return rows;
}

/// Deviations, actions and weights of a plane's particles, some at a time.
struct BeamPercentiles::Piece : Actions {
    std::uint64_t block = 0;
    std::size_t size = 0;  ///< a multiple of `lanes`
    const double* weight = nullptr;
    alignas(64) std::array<double, PlanePiece::most> share;
};

void BeamPercentiles::Gathered::merge(const Gathered& other) {
    bins.resize(std::max(bins.size(), other.bins.size()));
    for (std::size_t i = 0; i < other.bins.size(); ++i) {
        bins[i].share += other.bins[i].share;
        bins[i].count += other.bins[i].count;
    }
    sums.insert(sums.end(), other.sums.begin(), other.sums.end());
    near.insert(near.end(), other.near.begin(), other.near.end());
    crowded = crowded || other.crowded;
}

BeamPercentiles::BeamPercentiles(const BeamMoments::Sums& total, std::span<const BeamSample> sample) {
    emittances_.fill(std::numeric_limits<double>::quiet_NaN());
    shareOfWeight_ = sharesOfGreatest / total.greatestWeight;
    if (!std::isfinite(shareOfWeight_) || !(total.a.weight > 0.0)) return;
    for (std::size_t plane = 0; plane < planes; ++plane) {
        frames_[plane] = planeFrame(total, plane);
        if (frames_[plane].defined) state_ = State::narrowing;
    }
    openWindows();
    std::size_t size = 0;
    for (const auto& part : sample) size += part.size();
    if (state_ != State::narrowing || size < leastSample) return;
    margin_ = marginOfOne / std::sqrt(static_cast<double>(size));
    // Else more would be near a cut than are sorted.
    if (2.0 * margin_ * static_cast<double>(total.a.count) < static_cast<double>(mostNear)) askSample(sample);
}

/// Finds windows in which all cuts lie, as far as a sample tells: in bins, and in bins of these.
void BeamPercentiles::askSample(std::span<const BeamSample> sample) {
    state_ = State::sampling;
    for (int pass = 0; pass < 2; ++pass) {
        Gathered gathered;
        for (const auto& part : sample) add(part.rows(), gathered);
        narrowBySample(gathered.bins);
    }
    bySample_ = true;
    state_ = State::gathering;
}

void BeamPercentiles::openWindows() {
    for (std::size_t cut = 0; cut < cuts; ++cut) {
        constexpr double leastOfBins = 1.0 / 256.0;
        constexpr int shiftOfBins = 45;  // 128 bins an octave, 32 octaves
        windows_[cut] = {bitsOf(leastOfBins), shiftOfBins, 0, endOfActions, 0, cut - cut % percents.size()};
    }
}

void BeamPercentiles::add(const BeamRows& rows, Gathered& gathered) const {
    if (counting()) gathered.bins.resize(cuts * binsOfWindow);
    BlockSums sums;
    const auto firstNear = static_cast<std::ptrdiff_t>(gathered.near.size());
    Piece piece;
    PlanePiece from;
    piece.block = rows.block;
    piece.weight = from.weight.data();
    for (std::size_t begin = 0; begin < rows.size; begin += PlanePiece::most) {
        loadPiece(rows, begin, std::min(PlanePiece::most, rows.size - begin), from);
        piece.size = from.size;
        findShares(shareOfWeight_, piece.weight, piece.size, piece.share.data());
        for (std::size_t i = 0; bySample_ && i < piece.size; ++i)
            sums.allShares += static_cast<std::uint64_t>(piece.share[i]);
        for (std::size_t plane = 0; plane < planes; ++plane) {
            const auto& frame = frames_[plane];
            if (!frame.defined) continue;
            findActions(frame, from.value[2 * plane].data(), from.value[2 * plane + 1].data(), piece.size,
                        piece);
            if (counting()) {
                count(piece, plane, gathered);
            } else {
                gather(piece, plane, gathered, sums);
            }
        }
    }
    if (state_ != State::gathering) return;
    if (gathered.sums.empty() || gathered.sums.back().block != rows.block)
        gathered.sums.emplace_back().block = rows.block;
    auto& block = gathered.sums.back();
    block.allShares += sums.allShares;
    for (std::size_t cut = 0; cut < cuts; ++cut) {
        mote::storage::add(block.inside[cut], sums.inside[cut]);
        block.shares[cut] += sums.shares[cut];
    }
    if (gathered.crowded) return;
    // Particles of one action are one: however many there are, little is kept.
    const auto begin = gathered.near.begin() + firstNear;
    std::stable_sort(begin, gathered.near.end(), before);
    auto last = begin;
    for (auto next = begin; next != gathered.near.end(); ++next) {
        if (next == begin) continue;
        if (before(*last, *next)) {
            *++last = *next;
        } else {
            last->share += next->share;
            mote::storage::add(last->of, next->of);
        }
    }
    if (begin != gathered.near.end()) gathered.near.erase(last + 1, gathered.near.end());
}

void BeamPercentiles::count(const Piece& piece, std::size_t plane, Gathered& gathered) const {
    for (std::size_t cut = plane * percents.size(); cut < (plane + 1) * percents.size(); ++cut) {
        const auto& window = windows_[cut];
        if (window.bins != cut) continue;
        auto* const bins = gathered.bins.data() + cut * binsOfWindow;
        for (std::size_t i = 0; i < piece.size; ++i) {
            const auto bits = bitsOf(piece.action[i]);
            if (bits < window.lowest || bits >= window.end) continue;
            const auto bin = bits < window.first ? 0 : (bits - window.first) >> window.shift;
            auto& to = bins[std::min(bin, binsOfWindow - 1)];
            to.share += static_cast<std::uint64_t>(piece.share[i]);
            to.count += piece.weight[i] > 0.0 ? 1 : 0;
        }
    }
}

void BeamPercentiles::gather(const Piece& piece, std::size_t plane, Gathered& gathered,
                             BlockSums& sums) const {
    const std::size_t firstCut = plane * percents.size();
    CutsOfPlane lowest;
    for (std::size_t i = 0; i < lowest.size(); ++i)
        lowest[i] = std::bit_cast<double>(windows_[firstCut + i].lowest);
    sumBelow(lowest, piece, piece.weight, piece.size, sums.inside.data() + firstCut);
    if (bySample_)
        sumSharesBelow(lowest, piece, piece.share.data(), piece.size, sums.shares.data() + firstCut);
    // A sample that was no help must not fill the memory. All that threads have is held to half of this, so
    // that what comes of it does not depend on how many there are.
    if (bySample_ && gathered.near.size() > 2 * cuts * mostNear) {
        gathered.near = {};
        gathered.crowded = true;
    }
    if (gathered.crowded) return;
    std::array<std::uint64_t, PlanePiece::most / 64> within;
    const auto actions = std::span<const double>(piece.action).first(piece.size);
    for (std::size_t cut = firstCut; cut < firstCut + percents.size(); ++cut) {
        const auto& window = windows_[cut];
        const double end = window.end < endOfActions ? std::bit_cast<double>(window.end)
                                                     : std::numeric_limits<double>::quiet_NaN();
        findWithin(actions, lowest[cut - firstCut], end, within);
        forEachChosen(std::span(within).first(wordCount(piece.size)), [&](std::size_t i) {
            const auto bits = bitsOf(piece.action[i]);
            const double w = piece.weight[i];
            if (bits < window.lowest || bits >= window.end || !(w > 0.0)) return;
            const double q = piece.q[i], p = piece.p[i];
            gathered.near.push_back({piece.action[i],
                                     piece.block,
                                     cut,
                                     static_cast<std::uint64_t>(piece.share[i]),
                                     {w, w * q * q, w * q * p, w * p * p}});
        });
    }
}

void BeamPercentiles::finishPass(Gathered gathered) {
    gathered.bins.resize(counting() ? cuts * binsOfWindow : 0);
    if (state_ == State::narrowing) {
        narrow(gathered.bins);
    } else if (state_ == State::gathering && bySample_ && !sampleWasRight(gathered)) {
        bySample_ = false;
        allShares_ = 0;
        openWindows();
        state_ = State::narrowing;
    } else if (state_ == State::gathering) {
        finish(gathered);
    }
}

/// In the first pass all windows hold all: then the shares of all are known.
std::span<const Percentiles::Bin> BeamPercentiles::binsOf(const Window& window,
                                                          const std::vector<Bin>& bins) {
    const auto of = std::span(bins).subspan(window.bins * binsOfWindow, binsOfWindow);
    if (allShares_ == 0) {
        for (const auto& bin : of) allShares_ += bin.share;
    }
    return of;
}

/// To the bins between which a cut lies, as far as a sample tells, and `margin_` beside it.
void BeamPercentiles::narrowBySample(const std::vector<Bin>& bins) {
    auto next = windows_;
    for (std::size_t cut = 0; cut < cuts; ++cut) {
        if (!frames_[cut / percents.size()].defined) continue;
        const auto& window = windows_[cut];
        const auto of = binsOf(window, bins);
        const double all = static_cast<double>(allShares_), share = percents[cut % percents.size()] / 100.0;
        std::uint64_t below = window.below, first = 0;
        const auto reached = [&](std::uint64_t bin, double wanted) {
            return static_cast<double>(below + of[bin].share) >= wanted * all;
        };
        while (first + 1 < binsOfWindow && !reached(first, share - margin_)) below += of[first++].share;
        auto& narrowed = next[cut];
        narrowed.below = below;
        std::uint64_t last = first;
        while (last + 1 < binsOfWindow && !reached(last, share + margin_)) below += of[last++].share;
        if (first > 0) narrowed.lowest = window.first + (first << window.shift);
        if (last + 1 < binsOfWindow)
            narrowed.end = std::min(window.end, window.first + ((last + 1) << window.shift));
        narrowed.first = narrowed.lowest;
        narrowed.shift = 0;
        while (((narrowed.end - 1 - narrowed.lowest) >> narrowed.shift) >= binsOfWindow) ++narrowed.shift;
        narrowed.bins = cut;
    }
    windows_ = next;
}

/// Whether each cut lies in its window, of which is then known what lies below it.
bool BeamPercentiles::sampleWasRight(const Gathered& gathered) {
    if (gathered.crowded || gathered.near.size() > cuts * mostNear) return false;
    std::array<std::uint64_t, cuts> below{}, near{};
    std::uint64_t all = 0;
    for (const auto& block : gathered.sums) {
        all += block.allShares;
        for (std::size_t cut = 0; cut < cuts; ++cut) below[cut] += block.shares[cut];
    }
    for (const auto& one : gathered.near) near[one.cut] += one.share;
    for (std::size_t cut = 0; cut < cuts; ++cut) {
        if (!frames_[cut / percents.size()].defined) continue;
        const auto percent = percents[cut % percents.size()];
        // Nothing is below a window from 0 on; else it must not reach so far.
        if (windows_[cut].lowest > 0 && reachesPercent(below[cut], percent, all)) return false;
        if (!reachesPercent(below[cut] + near[cut], percent, all)) return false;
        windows_[cut].below = below[cut];
    }
    allShares_ = all;
    return true;
}

void BeamPercentiles::narrow(const std::vector<Bin>& bins) {
    bool enough = true;
    auto next = windows_;
    for (std::size_t cut = 0; cut < cuts; ++cut) {
        if (!frames_[cut / percents.size()].defined) continue;
        const auto& window = windows_[cut];
        const auto of = binsOf(window, bins);
        std::uint64_t below = window.below;
        std::uint64_t bin = 0;
        while (bin + 1 < binsOfWindow &&
               !reachesPercent(below + of[bin].share, percents[cut % percents.size()], allShares_)) {
            below += of[bin++].share;
        }
        auto& narrowed = next[cut];
        if (bin > 0) narrowed.lowest = window.first + (bin << window.shift);
        if (bin + 1 < binsOfWindow) {
            narrowed.end = std::min(window.end, window.first + ((bin + 1) << window.shift));
        }
        narrowed.below = below;
        narrowed.first = narrowed.lowest;
        narrowed.shift = 0;
        while (((narrowed.end - 1 - narrowed.lowest) >> narrowed.shift) >= binsOfWindow) ++narrowed.shift;
        narrowed.bins = cut;
        enough = enough && (of[bin].count <= mostNear || narrowed.end - narrowed.lowest <= 1);
    }
    windows_ = next;
    if (enough) state_ = State::gathering;
}

void BeamPercentiles::finish(const std::array<double, cuts>& emittances) {
    emittances_ = emittances;
    state_ = State::done;
}

void BeamPercentiles::finish(Gathered& gathered) {
    std::ranges::sort(gathered.sums, {}, &BlockSums::block);
    std::array<std::vector<NearCut>, cuts> nearOf;
    std::array<std::size_t, cuts> counts{};
    for (const auto& one : gathered.near) ++counts[one.cut];
    for (std::size_t cut = 0; cut < cuts; ++cut) nearOf[cut].reserve(counts[cut]);
    for (const auto& one : gathered.near) nearOf[one.cut].push_back(one);
    gathered.near = {};
    // Of a block that came in parts, in their order.
    oneapi::tbb::parallel_for(std::size_t{0}, cuts,
                              [&](std::size_t cut) { std::ranges::stable_sort(nearOf[cut], before); });
    for (std::size_t cut = 0; cut < cuts; ++cut) {
        if (!frames_[cut / percents.size()].defined) continue;
        Inside inside;
        for (const auto& block : gathered.sums) mote::storage::add(inside, block.inside[cut]);
        std::uint64_t shares = windows_[cut].below;
        double action = -1.0;
        for (const auto& near : nearOf[cut]) {
            const bool reached = reachesPercent(shares, percents[cut % percents.size()], allShares_);
            if (reached && near.action != action) break;
            action = near.action;
            shares += near.share;
            mote::storage::add(inside, near.of);
        }
        emittances_[cut] = emittance(inside);
    }
    state_ = State::done;
}

}  // namespace mote::storage
