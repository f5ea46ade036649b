// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/bounds_rule.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace mote::prep {
namespace {

constexpr std::uint64_t sampleSize = 65536;
constexpr double reach = 1000.0;
constexpr double apart = 10.0;
constexpr double mostWeight = 0.01;
constexpr std::uint64_t fewest = 3, mostEver = 300, shareOfAll = 10'000;

/// A quantile of a sorted sample, linear between neighbours.
double quantile(const std::vector<double>& sorted, double share) {
    const double at = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(at);
    const auto above = std::min(below + 1, sorted.size() - 1);
    // Not a + (b - a) f: the difference of two finite numbers may not be finite.
    const double f = at - static_cast<double>(below);
    return sorted[below] * (1.0 - f) + sorted[above] * f;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

/// What a pass looks for.
struct Question {
    std::uint64_t stride = 1;
    std::vector<std::uint64_t> before;  ///< by block of this rank: particles of the blocks before it
    std::array<CoreRange, 3> core{everything, everything, everything};
    std::uint64_t most = 0;  ///< far values at each end that are wanted

    static constexpr CoreRange everything{Range{-infinity, infinity}, 0.0};
};

/// The furthest values at both ends of an axis, below and above.
using Ends = std::array<std::vector<FarValue>, 2>;

/// Keeps the furthest, which come first.
void trim(Ends& ends, std::uint64_t most) {
    for (std::size_t end = 0; end < ends.size(); ++end) {
        std::sort(ends[end].begin(), ends[end].end(), [&](const FarValue& a, const FarValue& b) {
            if (a.value == b.value) return a.weight > b.weight;
            return end == 0 ? a.value < b.value : a.value > b.value;
        });
        if (ends[end].size() > most) ends[end].resize(most);
    }
}

void addFar(Ends& ends, const Ends& other, std::uint64_t most) {
    for (std::size_t end = 0; end < ends.size(); ++end)
        ends[end].insert(ends[end].end(), other[end].begin(), other[end].end());
    trim(ends, most);
}

/// What a block answers, or the whole step.
struct Answer {
    std::uint64_t particles = 0;
    double weight = 0.0;
    std::array<Range, 3> range;                 ///< of what is near
    std::array<std::vector<double>, 3> sample;  ///< every stride-th particle of the step
    std::array<Ends, 3> far;

    void append(const Answer& other, std::uint64_t most) {
        particles += other.particles;
        weight += other.weight;
        for (std::size_t a = 0; a < 3; ++a) {
            range[a] = range[a].united(other.range[a]);
            sample[a].insert(sample[a].end(), other.sample[a].begin(), other.sample[a].end());
            addFar(far[a], other.far[a], most);
        }
    }
};

Ends farOf(const ParticleBlock& block, std::size_t axis, const Question& question) {
    Ends ends;
    const Range& near = question.core[axis].near;
    for (std::size_t i = 0; i < block.size(); ++i) {
        const double value = block.coordinate[axis][i];
        if (near.contains(value)) continue;
        ends[value < near.min ? 0 : 1].push_back({value, block.weight[i]});
    }
    trim(ends, question.most);
    return ends;
}

Answer answerOf(const ParticleBlock& block, const Question& question, std::uint64_t before) {
    Answer answer;
    answer.particles = block.size();
    answer.weight = std::accumulate(block.weight.begin(), block.weight.end(), 0.0);
    const std::uint64_t first = (question.stride - before % question.stride) % question.stride;
    for (std::size_t a = 0; a < 3; ++a) {
        double least = infinity;
        double greatest = -infinity;
        const Range& inside = question.core[a].near;
        for (const double value : block.coordinate[a]) {
            const bool counts = inside.contains(value);
            least = counts ? std::min(least, value) : least;
            greatest = counts ? std::max(greatest, value) : greatest;
        }
        if (least <= greatest) answer.range[a] = {least, greatest};
        if (question.most > 0) answer.far[a] = farOf(block, a, question);
        for (auto i = first; i < block.size(); i += question.stride) {
            answer.sample[a].push_back(block.coordinate[a][i]);
        }
    }
    return answer;
}

class Search {
  public:
    Search(StepReader& reader, Communicator& ranks) : reader_(reader), ranks_(ranks) {}

    Result<StepBounds> run() {
        // As if every row took part: mostly so.
        question_.stride = sampleStride(reader_.rows());
        for (std::size_t i = 0; i < reader_.blockCount(); ++i) {
            question_.before.push_back((reader_.firstBlock() + i) * StepReader::blockRows);
        }
        auto answer = ask();
        if (answer.ok() && answer->particles != reader_.rows()) {
            correct(*answer);
            answer = ask();
        }
        if (!answer.ok()) return answer.error();
        bool allNear = true;
        for (std::size_t a = 0; a < 3; ++a) {
            question_.core[a] = coreOf(std::move(answer->sample[a]));
            const auto& near = question_.core[a].near;
            allNear = allNear && near.contains(answer->range[a].min) && near.contains(answer->range[a].max);
        }
        if (allNear || answer->particles == 0) return StepBounds{answer->range, {}};
        question_.most = mostCut(answer->particles) + 1;
        answer = ask();
        if (!answer.ok()) return answer.error();
        StepBounds bounds;
        for (std::size_t a = 0; a < 3; ++a) cutAxis(*answer, a, bounds);
        return bounds;
    }

  private:
    void cutAxis(const Answer& answer, std::size_t axis, StepBounds& bounds) const {
        const double median = question_.core[axis].median;
        auto& range = bounds.ranges[axis];
        range = answer.range[axis];
        for (std::size_t end = 0; end < 2; ++end) {
            const auto& far = answer.far[axis][end];
            const double next = range.empty() ? median
                                : end == 0    ? answer.range[axis].min
                                              : answer.range[axis].max;
            const auto cut = cutFrom(far, median, next, answer.weight, question_.most - 1);
            if (cut < far.size()) range = range.united({far[cut].value, far[cut].value});
            for (std::size_t i = 0; i < cut; ++i) {
                bounds.cuts[axis].values = bounds.cuts[axis].values.united({far[i].value, far[i].value});
            }
            bounds.cuts[axis].particles += cut;
        }
    }

    /// Makes one pass over the step.
    Result<Answer> ask() {
        std::vector<Answer> answers(reader_.blockCount());
        const auto read = reader_.forEach(0, answers.size(), [&](const ParticleBlock& block, std::size_t i) {
            answers[i] = answerOf(block, question_, question_.before[i]);
        });
        MOTE_RETURN_IF_ERROR(agree(ranks_, read));
        Answer mine;
        sizes_.clear();
        for (const auto& answer : answers) {
            mine.append(answer, question_.most);
            sizes_.push_back(answer.particles);
        }
        return united(mine);
    }

    Result<Answer> united(const Answer& mine) {
        Answer all;
        for (std::size_t a = 0; a < 3; ++a) {
            MOTE_ASSIGN_OR_RETURN(const auto samples, shareValues<double>(ranks_, mine.sample[a]));
            for (const auto& sample : samples) {
                all.sample[a].insert(all.sample[a].end(), sample.begin(), sample.end());
            }
        }
        struct Head {
            std::uint64_t particles;
            double weight;
            std::array<Range, 3> range;
        };
        const Head head{mine.particles, mine.weight, mine.range};
        MOTE_ASSIGN_OR_RETURN(const auto heads, shareValues<Head>(ranks_, std::span(&head, 1)));
        earlier_ = 0;
        for (std::size_t rank = 0; rank < heads.size(); ++rank) {
            const Head& one = heads[rank].front();
            all.append({one.particles, one.weight, one.range, {}, {}}, question_.most);
            if (rank < static_cast<std::size_t>(ranks_.rank())) earlier_ += one.particles;
        }
        for (std::size_t a = 0; a < 3 && question_.most > 0; ++a) {
            for (std::size_t end = 0; end < 2; ++end) {
                MOTE_ASSIGN_OR_RETURN(const auto parts, shareValues<FarValue>(ranks_, mine.far[a][end]));
                for (const auto& part : parts)
                    all.far[a][end].insert(all.far[a][end].end(), part.begin(), part.end());
            }
            trim(all.far[a], question_.most);
        }
        return all;
    }

    /// The stride of the particles that take part, and where each block begins among them.
    void correct(const Answer& answer) {
        question_.stride = sampleStride(answer.particles);
        std::uint64_t before = earlier_;
        for (std::size_t i = 0; i < sizes_.size(); ++i) {
            question_.before[i] = before;
            before += sizes_[i];
        }
    }

    StepReader& reader_;
    Communicator& ranks_;
    Question question_;
    std::vector<std::uint64_t> sizes_;  ///< by block of this rank, of the last pass
    std::uint64_t earlier_ = 0;         ///< particles of the ranks before this one
};

}  // namespace

Range Range::united(const Range& other) const {
    if (empty()) return other;
    if (other.empty()) return *this;
    return {std::min(min, other.min), std::max(max, other.max)};
}

std::uint64_t sampleStride(std::uint64_t values) {
    return std::max<std::uint64_t>(1, (values + sampleSize - 1) / sampleSize);
}

CoreRange coreOf(std::vector<double> sample) {
    CoreRange core{{-infinity, infinity}, 0.0};
    if (sample.empty()) return core;
    std::sort(sample.begin(), sample.end());
    core.median = quantile(sample, 0.5);
    for (const double tail : {0.25, 0.05, 0.01}) {
        const double spread = quantile(sample, 1.0 - tail) - quantile(sample, tail);
        if (!(spread > 0.0)) continue;
        core.near = {core.median - reach * spread, core.median + reach * spread};
        return core;
    }
    return core;
}

std::uint64_t mostCut(std::uint64_t particles) {
    return std::clamp(particles / shareOfAll, fewest, mostEver);
}

std::size_t cutFrom(const std::vector<FarValue>& far, double median, double next, double totalWeight,
                    std::uint64_t most) {
    double weight = 0.0;
    std::size_t cut = 0;
    for (std::size_t i = 0; i < std::min<std::uint64_t>(far.size(), most); ++i) {
        weight += far[i].weight;
        if (weight > mostWeight * totalWeight) break;
        const double following = i + 1 < far.size() ? far[i + 1].value : next;
        if (std::abs(far[i].value - median) > apart * std::abs(following - median)) cut = i + 1;
    }
    return cut;
}

Result<Range> widened(Range range) {
    if (range.min == range.max) {
        const double value = range.min;
        const double half = value == 0.0 ? 1.0 : std::max(1e-3 * std::abs(value), 1e-300);
        range = {value - half, value + half};
    }
    if (std::isfinite(range.max - range.min)) return range;
    return Error{ErrorCode::resourceExhausted, "",
                 fmt::format("its values reach from {} to {}, too wide for a plot; give it bounds", range.min,
                             range.max)};
}

Result<StepBounds> stepBounds(StepReader& reader, Communicator& ranks) {
    return Search(reader, ranks).run();
}

}  // namespace mote::prep
