// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/bounds_rule.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace mote::prep {
namespace {

constexpr std::uint64_t sampleSize = 65536;
constexpr double reach = 1000.0;

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
    std::array<Range, 3> inside{Range{-infinity, infinity}, Range{-infinity, infinity},
                                Range{-infinity, infinity}};
};

/// What a block answers, or the whole step.
struct Answer {
    std::uint64_t particles = 0;
    std::array<Range, 3> range;
    std::array<std::vector<double>, 3> sample;  ///< every stride-th particle of the step

    void append(const Answer& other) {
        particles += other.particles;
        for (std::size_t a = 0; a < 3; ++a) {
            range[a] = range[a].united(other.range[a]);
            sample[a].insert(sample[a].end(), other.sample[a].begin(), other.sample[a].end());
        }
    }
};

Answer answerOf(const ParticleBlock& block, const Question& question, std::uint64_t before) {
    Answer answer;
    answer.particles = block.size();
    const std::uint64_t first = (question.stride - before % question.stride) % question.stride;
    for (std::size_t a = 0; a < 3; ++a) {
        double least = infinity;
        double greatest = -infinity;
        const Range& inside = question.inside[a];
        for (const double value : block.coordinate[a]) {
            const bool counts = inside.contains(value);
            least = counts ? std::min(least, value) : least;
            greatest = counts ? std::max(greatest, value) : greatest;
        }
        if (least <= greatest) answer.range[a] = {least, greatest};
        for (auto i = first; i < block.size(); i += question.stride) {
            answer.sample[a].push_back(block.coordinate[a][i]);
        }
    }
    return answer;
}

class Search {
  public:
    Search(StepReader& reader, Communicator& ranks) : reader_(reader), ranks_(ranks) {}

    Result<std::array<Range, 3>> run() {
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
        bool allInside = true;
        for (std::size_t a = 0; a < 3; ++a) {
            auto& inside = question_.inside[a];
            inside = acceptedRange(std::move(answer->sample[a]));
            allInside =
                allInside && inside.contains(answer->range[a].min) && inside.contains(answer->range[a].max);
        }
        if (!allInside && answer->particles > 0) answer = ask();
        if (!answer.ok()) return answer.error();
        return answer->range;
    }

  private:
    /// One pass over the step.
    Result<Answer> ask() {
        std::vector<Answer> answers(reader_.blockCount());
        const auto read = reader_.forEach(0, answers.size(), [&](const ParticleBlock& block, std::size_t i) {
            answers[i] = answerOf(block, question_, question_.before[i]);
        });
        MOTE_RETURN_IF_ERROR(agree(ranks_, read));
        Answer mine;
        sizes_.clear();
        for (const auto& answer : answers) {
            mine.append(answer);
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
            std::array<Range, 3> range;
        };
        const Head head{mine.particles, mine.range};
        MOTE_ASSIGN_OR_RETURN(const auto heads, shareValues<Head>(ranks_, std::span(&head, 1)));
        earlier_ = 0;
        for (std::size_t rank = 0; rank < heads.size(); ++rank) {
            const Head& one = heads[rank].front();
            all.append({one.particles, one.range, {}});
            if (rank < static_cast<std::size_t>(ranks_.rank())) earlier_ += one.particles;
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

Range acceptedRange(std::vector<double> sample) {
    const Range all{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    if (sample.empty()) return all;
    std::sort(sample.begin(), sample.end());
    const double median = quantile(sample, 0.5);
    for (const double tail : {0.25, 0.05, 0.01}) {
        const double spread = quantile(sample, 1.0 - tail) - quantile(sample, tail);
        if (spread > 0.0) return {median - reach * spread, median + reach * spread};
    }
    return all;
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

Result<std::array<Range, 3>> stepBounds(StepReader& reader, Communicator& ranks) {
    return Search(reader, ranks).run();
}

}  // namespace mote::prep
