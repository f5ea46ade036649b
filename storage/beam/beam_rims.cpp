// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/beam/beam_rims.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "storage/beam/beam_piece.h"
#include "storage/beam/plane_actions.h"
#include "storage/numbers/range_kernel.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

using Outside = BeamRims::Outside;
using Place = BeamRims::Place;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr auto percentsOfPlane = BeamPercentiles::percents.size();
constexpr std::size_t leastSample = std::size_t{1} << 10;
constexpr std::size_t pieceRows = 512;
constexpr std::size_t roomOfPiece = 2 * pieceRows;
/// As many may lie in rims, of all, and as many in any case.
constexpr std::uint64_t shareWithin = 8, leastWithin = std::uint64_t{1} << 20;

// So many deviations of a sample's share below a cut, and of the actions by its ellipse, are thought of: some
// three times what is seen.
constexpr double marginOfShare = 3.0;
constexpr double marginOfActions = 1.5;
// Actions are told as exactly as this, whatever is rounded.
constexpr double roundedActions = 1e-6;

using Values = std::array<double, roomOfPiece>;

MOTE_ANY_VECTORS void findActions(const PlaneFrame& of, const double* q, const double* p, std::size_t size,
                                  double* to) {
    for (std::size_t i = 0; i < size; ++i) to[i] = actionOf(of, q[i] - of.q, p[i] - of.p);
}

using EndsOfPlane = std::array<double, percentsOfPlane>;

/// By cut of a plane, the sums over those whose action is `end` or more. Of whole lanes.
MOTE_ANY_VECTORS void sumOutside(const PlaneFrame& frame, const EndsOfPlane& end, const double* fromQ,
                                 const double* fromP, const double* actions, std::size_t size, Outside* to) {
    std::array<std::array<LaneVector, 6>, percentsOfPlane> sums{};
    for (std::size_t i = 0; i < size; i += lanes) {
        LaneVector q, p, action;
        load(q, fromQ + i);
        load(p, fromP + i);
        load(action, actions + i);
        q -= frame.q;
        p -= frame.p;
        const LaneVector qq = q * q, qp = q * p, pp = p * p;
#pragma GCC unroll 4
        for (std::size_t cut = 0; cut < sums.size(); ++cut) {
            const auto beyond = action >= end[cut];
            sums[cut][0] += beyond ? q : 0.0;
            sums[cut][1] += beyond ? p : 0.0;
            sums[cut][2] += beyond ? qq : 0.0;
            sums[cut][3] += beyond ? qp : 0.0;
            sums[cut][4] += beyond ? pp : 0.0;
            sums[cut][5] += beyond ? LaneVector{} + 1.0 : LaneVector{};
        }
    }
    for (std::size_t cut = 0; cut < sums.size(); ++cut) {
        const auto sum = [&](std::size_t i) { return sumOf(std::bit_cast<Lanes>(sums[cut][i])); };
        to[cut].q += sum(0);
        to[cut].p += sum(1);
        to[cut].qq += sum(2);
        to[cut].qp += sum(3);
        to[cut].pp += sum(4);
        to[cut].count += static_cast<std::uint64_t>(sum(5));
    }
}

constexpr std::size_t strideOfSome = 64;

/// Ends between which the value lies, if not by mischance, that so many of all are less than. `some`: one in
/// strideOfSome.
struct Bracket {
    double low = -infinite, high = infinite;  ///< both belong to it

    static Bracket of(std::vector<double> some, std::size_t place) {
        std::ranges::sort(some);
        // What some of them have below a value deviates by half of its root, mostly.
        const auto off = static_cast<std::size_t>(3.0 * std::sqrt(static_cast<double>(some.size()))) + 1;
        const auto middle = place / strideOfSome;
        Bracket bracket;
        if (middle >= off) bracket.low = some[middle - off];
        if (middle + off < some.size()) bracket.high = some[middle + off];
        return bracket;
    }
};

/// As std::nth_element finds it.
double nthOf(const std::vector<double>& values, std::size_t place) {
    std::vector<double> some;
    for (std::size_t i = 0; i < values.size(); i += strideOfSome) some.push_back(values[i]);
    const auto bracket = Bracket::of(std::move(some), place);
    std::vector<double> inside;
    std::size_t below = 0;
    for (const double value : values) {
        below += value < bracket.low ? 1 : 0;
        if (value >= bracket.low && value <= bracket.high) inside.push_back(value);
    }
    if (place < below || place >= below + inside.size()) {
        inside = values;
        below = 0;
    }
    const auto at = inside.begin() + static_cast<std::ptrdiff_t>(place - below);
    std::ranges::nth_element(inside, at);
    return *at;
}

BeamMoments::Sums momentsOf(std::span<const BeamSample> sample) {
    std::vector<BeamMoments> parts(sample.size());
    oneapi::tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
        auto rows = sample[i].rows();
        rows.block = i;
        parts[i].add(rows);
    });
    BeamMoments all;
    for (const auto& part : parts) all.merge(part.blocks());
    return all.total();
}

/// By plane, those of the particles that take part.
using ActionsOfPlanes = std::array<std::vector<double>, BeamRims::planes>;

ActionsOfPlanes actionsOf(const BeamRows& rows, const std::array<PlaneFrame, BeamRims::planes>& frames) {
    ActionsOfPlanes actions;
    PlanePiece piece;
    for (std::size_t begin = 0; begin < rows.size; begin += PlanePiece::most) {
        loadPiece(rows, begin, std::min(PlanePiece::most, rows.size - begin), piece);
        for (std::size_t plane = 0; plane < frames.size(); ++plane) {
            if (!frames[plane].defined) continue;
            auto& to = actions[plane];
            to.resize(to.size() + piece.count);
            findActions(frames[plane], piece.value[2 * plane].data(), piece.value[2 * plane + 1].data(),
                        piece.count, to.data() + to.size() - piece.count);
        }
    }
    return actions;
}

/// Actions by one ellipse are at least `least` and at most `most` times those by another about the same
/// means.
struct Stretch {
    double least, most;
};
Stretch stretchOf(const PlaneFrame& to, const PlaneFrame& from) {
    const double apart = to.k - from.k;
    const double qq = (to.a + to.b * apart * apart) / from.a, pp = to.b / from.b,
                 qp = -to.b * apart / std::sqrt(from.a * from.b);
    const double middle = 0.5 * (qq + pp), off = std::hypot(0.5 * (qq - pp), qp);
    return {middle - off, middle + off};
}

/// Second moments about means that lie (-q, -p) from those of the sums.
Outside movedBy(const Outside& of, double q, double p) {
    const auto count = static_cast<double>(of.count);
    return {of.count,
            0.0,
            0.0,
            of.qq + 2.0 * q * of.q + count * q * q,
            of.qp + q * of.p + p * of.q + count * q * p,
            of.pp + 2.0 * p * of.p + count * p * p};
}

void take(Outside& to, const Outside& from) {
    to.count += from.count;
    to.qq += from.qq;
    to.qp += from.qp;
    to.pp += from.pp;
}

}  // namespace

/// What of a plane lies outside the innermost rim's inner ellipse, some at a time.
class BeamRims::Piece {
  public:
    Piece(const BeamRims& rims, std::size_t plane, Gathered& to)
        : frame_(rims.frames_[plane]),
          rims_(std::span(rims.rims_).subspan(plane * percents.size()).first<percents.size()>()),
          outside_(to.outside.data() + plane * percents.size()),
          within_(to.within.data() + plane * percents.size()) {
        for (std::size_t i = 0; i < ends_.size(); ++i) ends_[i] = rims_[i].end;
    }

    /// At most pieceRows.
    void add(std::span<const double> q, const double* p) {
        constexpr double noEnd = std::numeric_limits<double>::quiet_NaN();
        if (size_ > pieceRows) empty();
        findActions(frame_, q.data(), p, q.size(), actions_.data());
        const auto chosen = std::span(chosen_).first(wordCount(q.size()));
        findWithin(std::span(actions_).first(q.size()), rims_.front().lowest, noEnd, chosen);
        forEachChosen(chosen, [&](std::size_t i) {
            q_[size_] = q[i];
            p_[size_++] = p[i];
        });
    }
    void empty() {
        findActions(frame_, q_.data(), p_.data(), size_, actions_.data());
        const auto whole = (size_ + lanes - 1) / lanes * lanes;
        for (std::size_t i = size_; i < whole; ++i) q_[i] = p_[i] = actions_[i] = -1.0;  // not outside
        sumOutside(frame_, ends_, q_.data(), p_.data(), actions_.data(), whole, outside_);
        const auto within = std::span(chosen_).first(wordCount(size_));
        for (std::size_t cut = 0; cut < rims_.size(); ++cut) {
            findWithin(std::span(actions_).first(size_), rims_[cut].lowest, rims_[cut].end, within);
            forEachChosen(within, [&](std::size_t i) { within_[cut].add({q_[i], p_[i]}); });
        }
        size_ = 0;
    }

  private:
    const PlaneFrame& frame_;
    const std::span<const Rim, percents.size()> rims_;
    EndsOfPlane ends_;
    Outside* const outside_;
    Places* const within_;
    std::size_t size_ = 0;
    alignas(64) Values actions_{}, q_{}, p_{};
    std::array<std::uint64_t, 2 * pieceRows / 64> chosen_{};
};

BeamRims::BeamRims(std::span<const BeamSample> sample, std::uint64_t particles)
    : mostWithin_(std::max(leastWithin, particles / shareWithin)) {
    const auto total = momentsOf(sample);
    if (!total.oneWeight || !(total.a.weight > 0.0) || total.a.count < leastSample) return;
    for (std::size_t plane = 0; plane < planes; ++plane) {
        frames_[plane] = planeFrame(total, plane);
        known_ = known_ || frames_[plane].defined;
    }
    std::vector<ActionsOfPlanes> parts(sample.size());
    oneapi::tbb::parallel_for(std::size_t{0}, parts.size(),
                              [&](std::size_t i) { parts[i] = actionsOf(sample[i].rows(), frames_); });
    oneapi::tbb::parallel_for(std::size_t{0}, planes, [&](std::size_t plane) {
        if (!frames_[plane].defined) return;
        std::vector<double> actions;
        actions.reserve(total.a.count);
        for (const auto& part : parts) actions.insert(actions.end(), part[plane].begin(), part[plane].end());
        findRims(plane, std::move(actions));
    });
}

void BeamRims::findRims(std::size_t plane, std::vector<double> actions) {
    const auto rims = std::span(rims_).subspan(plane * percents.size(), percents.size());
    const auto count = actions.size();
    const auto size = static_cast<double>(count);
    double squares = 0.0;
    for (const double action : actions) squares += action * action;
    const double off = marginOfActions * std::sqrt(squares) / size;
    std::size_t below = 0;  // that are left out
    for (std::size_t i = 0; i < percents.size(); ++i) {
        const double share = percents[i] / 100.0;
        const double margin = marginOfShare * std::sqrt(share * (1.0 - share) / size);
        const auto lowest = static_cast<std::size_t>(std::max(share - margin, 0.0) * size);
        const auto end = static_cast<std::size_t>((share + margin) * size);
        rims[i].lowest = nthOf(actions, lowest - below);
        // What is less is not asked about any more.
        if (i == 0) below = std::erase_if(actions, [&](double action) { return action < rims[0].lowest; });
        rims[i].end = end < count ? nthOf(actions, end - below) : infinite;
    }
    for (auto& rim : rims) {
        rim.lowest *= std::max(1.0 - off, 0.0);
        rim.end *= 1.0 + off;
    }
}

void BeamRims::add(const BeamRows& rows, bool whole, Gathered& gathered) {
    if (within_ > mostWithin_) return;
    const auto kept = [&] {
        std::uint64_t sum = 0;
        for (const auto& within : gathered.within) sum += within.size();
        return sum;
    };
    const auto before = kept();
    for (std::size_t plane = 0; plane < planes && whole; ++plane)
        addPlane(plane, rows.coordinate[plane], rows.coordinate[plane + 4].data(), gathered);
    PlanePiece good;
    for (std::size_t begin = 0; begin < rows.size && !whole; begin += PlanePiece::most) {
        loadPiece(rows, begin, std::min(PlanePiece::most, rows.size - begin), good);
        for (std::size_t plane = 0; plane < planes; ++plane)
            addPlane(plane, std::span(good.value[2 * plane]).first(good.count),
                     good.value[2 * plane + 1].data(), gathered);
    }
    within_ += kept() - before;
}

void BeamRims::addPlane(std::size_t plane, std::span<const double> q, const double* p,
                        Gathered& gathered) const {
    if (!frames_[plane].defined) return;
    Piece piece(*this, plane, gathered);
    for (std::size_t begin = 0; begin < q.size(); begin += pieceRows)
        piece.add(q.subspan(begin, std::min(pieceRows, q.size() - begin)), p + begin);
    piece.empty();
}

/// Whether all within the rim's inner ellipse have less than the action, or as much, and all outside the
/// outer one have more.
bool BeamRims::isIn(const PlaneFrame& exact, double action, std::size_t cut) const {
    const auto& frame = frames_[cut / percents.size()];
    const auto stretch = stretchOf(exact, frame);
    // The root of an action is a length: the way from one mean to the other adds at most as much.
    const double apart = std::sqrt(actionOf(exact, frame.q - exact.q, frame.p - exact.p));
    const double least = std::sqrt(stretch.least * rims_[cut].end) - apart;
    const double most = std::sqrt(stretch.most * rims_[cut].lowest) + apart;
    return least > 0.0 && least * least * (1.0 - roundedActions) > action &&
           most * most * (1.0 + roundedActions) < action;
}

std::optional<BeamRims::Emittances> BeamRims::emittances(const BeamMoments::Sums& total,
                                                         std::span<const Gathered> blocks) const {
    if (!total.oneWeight || within_ > mostWithin_) return std::nullopt;
    std::array<std::optional<double>, cuts> found;
    oneapi::tbb::parallel_for(std::size_t{0}, cuts,
                              [&](std::size_t cut) { found[cut] = emittance(total, cut, blocks); });
    Emittances all;
    for (std::size_t cut = 0; cut < cuts; ++cut) {
        if (!found[cut]) return std::nullopt;
        all[cut] = *found[cut];
    }
    return all;
}

/// The places within a rim, by the exact ellipse, of which the first so many are inside a cut.
class BeamRims::Within {
  public:
    Within(const PlaneFrame& exact, std::size_t cut, std::span<const Gathered> blocks, std::size_t inside)
        : exact_(exact), cut_(cut), blocks_(blocks), inside_(inside) {
        std::vector<double> some;
        std::size_t next = 0;
        each([&](double action, const Place&) {
            if (next++ % strideOfSome == 0) some.push_back(action);
        });
        if (!divide(Bracket::of(std::move(some), inside - 1))) divide({});
    }

    /// Of the last that is inside.
    double action() const { return action_; }
    /// Sums of those that have more, about the exact means.
    const Outside& outside() const { return outside_; }

  private:
    template <class Take>
    void each(const Take& take) const {
        for (const auto& block : blocks_) {
            for (const auto& chunk : block.within[cut_].chunks()) {
                for (const auto& at : chunk) {
                    const Place off{at.q - exact_.q, at.p - exact_.p};
                    take(actionOf(exact_, off.q, off.p), off);
                }
            }
        }
    }
    /// False if the cut is not in the bracket.
    bool divide(const Bracket& bracket) {
        outside_ = {};
        std::vector<double> actions;
        std::vector<Place> places;
        std::size_t below = 0;
        each([&](double action, const Place& off) {
            below += action < bracket.low ? 1 : 0;
            if (action > bracket.high) return takeOutside(off);
            if (action < bracket.low) return;
            actions.push_back(action);
            places.push_back(off);
        });
        if (inside_ <= below || inside_ > below + actions.size()) return false;
        auto sorted = actions;
        const auto last = sorted.begin() + static_cast<std::ptrdiff_t>(inside_ - below - 1);
        std::ranges::nth_element(sorted, last);
        action_ = *last;
        for (std::size_t i = 0; i < actions.size(); ++i)
            if (actions[i] > action_) takeOutside(places[i]);
        return true;
    }
    void takeOutside(const Place& off) {
        ++outside_.count;
        outside_.qq += off.q * off.q;
        outside_.qp += off.q * off.p;
        outside_.pp += off.p * off.p;
    }

    const PlaneFrame& exact_;
    const std::size_t cut_;
    const std::span<const Gathered> blocks_;
    const std::size_t inside_;
    double action_ = 0.0;
    Outside outside_;
};

std::optional<double> BeamRims::emittance(const BeamMoments::Sums& total, std::size_t cut,
                                          std::span<const Gathered> blocks) const {
    const std::size_t plane = cut / percents.size();
    const auto percent = percents[cut % percents.size()];
    const auto exact = planeFrame(total, plane);
    if (!exact.defined) return std::numeric_limits<double>::quiet_NaN();
    const auto& frame = frames_[plane];
    if (!frame.defined) return std::nullopt;
    Outside outside;
    std::uint64_t within = 0;
    for (const auto& block : blocks) {
        within += block.within[cut].size();
        take(outside, movedBy(block.outside[cut], frame.q - exact.q, frame.p - exact.p));
    }
    const std::uint64_t count = total.a.count, below = count - outside.count - within;
    std::uint64_t needed = count * percent / 100;
    if (!reachesPercent(needed, percent, count)) ++needed;
    if (needed <= below || needed > below + within) return std::nullopt;
    const Within divided(exact, cut, blocks, needed - below);
    if (!isIn(exact, divided.action(), cut)) return std::nullopt;
    take(outside, divided.outside());
    const auto all = moments::lowerOf(total.a, 2 * plane, 2 * plane + 1);
    const double weight = total.greatestWeight;
    const double qq = all.qq - weight * outside.qq, qp = all.qp - weight * outside.qp,
                 pp = all.pp - weight * outside.pp;
    // Else what was taken away has taken the digits of what is left.
    constexpr double leastLeft = 1.0 / 16.0;
    if (!(qq > leastLeft * all.qq && pp > leastLeft * all.pp)) return std::nullopt;
    return std::sqrt(std::max(qq * pp - qp * qp, 0.0)) /
           (all.weight - weight * static_cast<double>(outside.count));
}

}  // namespace mote::storage
