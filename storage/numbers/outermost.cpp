// SPDX-License-Identifier: GPL-3.0-or-later
//
// The threshold is found as a digit after the other of the emittances' own bits: the weight of each value of
// the first 16 bits, then of the next ones among those that share the first. So no emittance is ever stored.
#include "storage/numbers/outermost.h"

#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

constexpr int digitBits = 16;
constexpr std::size_t digits = std::size_t{1} << digitBits;
/// Points are summed in so many parts at most, one after the other: the same sums on any number of threads.
constexpr std::uint64_t mostGridParts = 64;

/// A value that orders as the emittance, which is not NaN, does.
std::uint64_t keyOf(double emittance) {
    const auto bits = std::bit_cast<std::uint64_t>(emittance);
    return (bits >> 63) != 0 ? ~bits : bits | (std::uint64_t{1} << 63);
}
double ofKey(std::uint64_t key) {
    return std::bit_cast<double>((key >> 63) != 0 ? key & ~(std::uint64_t{1} << 63) : ~key);
}

struct Moments {
    double weight = 0.0, q = 0.0, p = 0.0, qq = 0.0, qp = 0.0, pp = 0.0;
};

class Plane {
  public:
    Plane(const ParticleColumns& columns, QuantityReader reader, bool weighted,
          const std::function<bool()>& cancelled)
        : reader_(std::move(reader)),
          weighted_(weighted),
          cancelled_(cancelled),
          points_(columns.pointCount()) {
        const auto blocks = blockCount(points_);
        blocksAPart_ = std::max<std::uint64_t>(1, (blocks + mostGridParts - 1) / mostGridParts);
        parts_ = (blocks + blocksAPart_ - 1) / blocksAPart_;
    }

    std::uint64_t parts() const { return parts_; }

    /// Calls take(part, q, p, weight) with all that count; those of a part one after the other.
    template <class Take>
    bool visit(const Take& take) const {
        std::atomic<bool> stopped{false};
        const bool whole = forBlocks(parts_, cancelled_, [&](std::uint64_t part) {
            QuantityReader::Scratch scratch;
            std::array<std::vector<double>, 3> values;
            for (auto& one : values) one.resize(blockPoints, 1.0);
            const auto last = std::min((part + 1) * blocksAPart_, blockCount(points_));
            for (auto block = part * blocksAPart_; block < last; ++block) {
                if (stopped) return;
                if (cancelled_ && cancelled_()) {
                    stopped = true;
                    return;
                }
                const auto range = pointsOfBlock(block, points_);
                const auto count = static_cast<std::size_t>(range.count);
                std::array<std::span<double>, 3> out;
                for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::span(values[i]).first(count);
                reader_.read(range.begin, count, scratch, std::span(out).first(weighted_ ? 3 : 2));
                for (std::size_t i = 0; i < count; ++i) {
                    const double q = values[0][i], p = values[1][i], weight = values[2][i];
                    if (weight > 0.0 && std::isfinite(weight) && std::isfinite(q) && std::isfinite(p))
                        take(part, q, p, weight);
                }
            }
        });
        return whole && !stopped;
    }

  private:
    QuantityReader reader_;
    bool weighted_;
    const std::function<bool()>& cancelled_;
    std::uint64_t points_, parts_ = 0, blocksAPart_ = 1;
};

/// Means and second moments about them.
bool findEllipse(const Plane& plane, OutermostTest& test, double& weight) {
    std::vector<Moments> parts(plane.parts());
    const auto sum = [&](auto&& add) {
        parts.assign(plane.parts(), {});
        return plane.visit(
            [&](std::uint64_t part, double q, double p, double w) { add(parts[part], q, p, w); });
    };
    const auto total = [&](double Moments::*member) {
        double all = 0.0;
        for (const auto& part : parts) all += part.*member;
        return all;
    };
    if (!sum([](Moments& m, double q, double p, double w) {
            m.weight += w;
            m.q += w * q;
            m.p += w * p;
        }))
        return false;
    weight = total(&Moments::weight);
    if (!(weight > 0.0)) return true;
    test.meanQ = total(&Moments::q) / weight;
    test.meanP = total(&Moments::p) / weight;
    if (!sum([&](Moments& m, double q, double p, double w) {
            q -= test.meanQ;
            p -= test.meanP;
            m.qq += w * q * q;
            m.qp += w * q * p;
            m.pp += w * p * p;
        }))
        return false;
    test.qq = total(&Moments::qq) / weight;
    test.qp = total(&Moments::qp) / weight;
    test.pp = total(&Moments::pp) / weight;
    return true;
}

/// The greatest emittance from which on there is so much weight.
bool findThreshold(const Plane& plane, double wanted, OutermostTest& test) {
    std::uint64_t known = 0;  // the first digits of the threshold's key
    std::vector<double> weights;
    for (int shift = 64 - digitBits; shift >= 0; shift -= digitBits) {
        weights.assign(plane.parts() * digits, 0.0);
        const bool whole = plane.visit([&](std::uint64_t part, double q, double p, double w) {
            const auto key = keyOf(test.emittance(q, p));
            if (shift + digitBits < 64 && key >> (shift + digitBits) != known) return;
            weights[part * digits + ((key >> shift) & (digits - 1))] += w;
        });
        if (!whole) return false;
        // The last digit with any weight is taken where rounding leaves the sum short.
        std::size_t chosen = digits;
        double beyond = 0.0;
        for (std::size_t digit = digits; digit-- > 0;) {
            double own = 0.0;
            for (std::uint64_t part = 0; part < plane.parts(); ++part) own += weights[part * digits + digit];
            if (!(own > 0.0)) continue;
            chosen = digit;
            if (beyond + own >= wanted) break;
            beyond += own;
        }
        known = known << digitBits | chosen;
        wanted -= beyond;
    }
    test.threshold = ofKey(known);
    return true;
}

}  // namespace

std::span<const std::string> planeColumns(char plane) {
    static const std::array<std::array<std::string, 2>, 3> names{{{"x", "px"}, {"y", "py"}, {"z", "pz"}}};
    return names[static_cast<std::size_t>(plane - 'x')];
}

Result<OutermostTest> findOutermost(const Selection::Outermost& wanted, const StepNumbers& step,
                                    const std::function<bool()>& cancelled) {
    const auto names = planeColumns(wanted.plane);
    std::vector<std::string> read(names.begin(), names.end());
    const bool weighted = step.columns->find("weight").has_value();
    if (weighted) read.emplace_back("weight");
    MOTE_ASSIGN_OR_RETURN(auto reader, QuantityReader::make(*step.columns, step.context, read));
    const Plane plane(*step.columns, std::move(reader), weighted, cancelled);
    OutermostTest test;
    double weight = 0.0;
    if (!findEllipse(plane, test, weight)) return wasCancelled();
    if (!(weight > 0.0) || !(wanted.share > 0.0)) return test;
    if (!findThreshold(plane, wanted.share * weight, test)) return wasCancelled();
    test.none = false;
    return test;
}

}  // namespace mote::storage
