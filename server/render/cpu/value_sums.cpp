// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/value_sums.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

#include "protocol/base/mote_check.h"
#include "server/render/cpu/flat_points.h"
#include "server/render/cpu/point_footprint.h"
#include "server/render/cpu/point_stream.h"
#include "server/render/cpu/values_kernel.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"
#include "server/render/plan/point_values.h"

namespace mote::render {
namespace {

constexpr std::size_t summedLeaves = 1024;
constexpr std::size_t blockPoints = 1024;
/// Room for the sums of all threads, bytes: of very large pictures fewer threads count.
constexpr std::size_t sumBytes = std::size_t{1} << 30;
constexpr float wholeDisc = 4096.0F;  // weight of a disc of full coverage

void least(std::uint64_t& word, std::uint64_t key) {
    const std::atomic_ref shared(word);
    auto present = shared.load(std::memory_order_relaxed);
    while (key < present && !shared.compare_exchange_weak(present, key, std::memory_order_relaxed)) {
    }
}

/// Leaves that follow each other, with what is drawn of them.
struct Chunk {
    std::array<std::uint32_t, summedLeaves> drawn{};
    LeafRun run;
    std::size_t first = 0;     ///< leaf
    std::uint64_t begin = 0;   ///< the first leaf's first point
    std::uint64_t points = 0;  ///< drawn
};

class Summing {
  public:
    Summing(const FramePlan& plan, const PointsPlan& points, std::span<const LeafCell> cells, bool count)
        : points_(points),
          nearest_(points.colors->nearest),
          leaves_(cells.empty() ? storage::Leaves{} : points.step->leaves()),
          cells_(cells),
          map_(PointMap::make(plan, points)),
          end_(points.step->positions(0, 0).data() + points.step->pointCount()),
          count_(count && nearest_ && points.look.size <= 1.0),
          full_(fullOfAnyColor(points.look)),
          sums_{nearest_, {}} {
        if (!points.colors->shade) {
            codes_ = points.colors->values->codes;
            MOTE_CHECK(codes_.size() == points.step->pointCount());
        }
        const std::size_t pixels = std::size_t{plan.width} * plan.height;
        resizeInTurns(sums_.words, 2 * pixels);
        if (nearest_) {
            for (std::size_t i = 0; i < pixels; ++i) sums_.words[2 * i] = noKey;
        }
        if (points.look.size > 1.0) discs_.emplace(points.look.size, points.look.discOpacity());
    }

    std::optional<ValueSums> sum(const std::stop_token& stop) {
        const std::size_t pixels = sums_.words.size() / 2;
        const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
        const std::size_t parts =
            discs_ ? threads : std::clamp<std::size_t>(sumBytes / (pixels * sizeof(ValueSum)), 1, threads);
        const std::size_t chunks = (cells_.size() + summedLeaves - 1) / summedLeaves;
        std::vector<Part> own(std::min(parts, chunks));
        forPartsInTurns(own.size(), chunks, stop, [&](std::size_t part, std::size_t number) {
            if (const Chunk chunk = chunkOf(number); chunk.points > 0) add(chunk, own[part]);
        });
        addPreview(stop);
        forInTurns(std::size_t{0}, own.size(), [&](std::size_t part) {
            if (own[part].added > 0) carryOff(own[part]);
        });
        if (stop.stop_requested()) return std::nullopt;
        return std::move(sums_);
    }

  private:
    /// What one thread found and has not carried off yet.
    struct Part {
        std::vector<ValueSum> sums = {};  ///< by pixel, spareCounts longer; empty: there is nothing yet
        std::vector<std::uint32_t> counts = {};  ///< likewise, where nearest ones are counted
        std::vector<ValueCode> codes = {};       ///< of a chunk's points, where they are told by leaf
        std::uint64_t added = 0;                 ///< points
        std::uint64_t counted = 0;               ///< likewise
    };

    void add(const Chunk& chunk, Part& part) {
        const ValueCode* const codes = codesOf(chunk, part.codes);
        if (discs_ || (!nearest_ && chunk.points > mostAdded)) return addOneByOne(chunk, codes);
        if (part.sums.empty())
            part.sums.assign(sums_.words.size() / 2 + spareCounts, nearest_ ? ValueSum{noKey} : 0);
        if (nearest_) {
            if (count_ && part.counts.empty()) part.counts.assign(part.sums.size(), 0);
            part.counted += addNearest(map_, chunk.run, codes, part.sums.data(), full_,
                                       count_ ? part.counts.data() : nullptr);
            part.added = 1;
            return;
        }
        if (part.added + chunk.points > mostAdded) carryOff(part);
        addValues(map_, chunk.run, codes, part.sums.data());
        part.added += chunk.points;
    }

    Chunk chunkOf(std::size_t number) const {
        const std::size_t first = number * summedLeaves;
        const std::size_t size = std::min(summedLeaves, cells_.size() - first);
        Chunk chunk;
        for (std::size_t i = 0; i < size; ++i) {
            chunk.drawn[i] = points_.drawn(first + i);
            chunk.points += chunk.drawn[i];
        }
        if (chunk.points == 0) return chunk;
        chunk.begin = leaves_.pointBegin[first];
        const auto end = leaves_.pointBegin[first + size - 1] + leaves_.pointCount[first + size - 1];
        chunk.run = {.cells = cells_.data() + first,
                     .drawn = chunk.drawn.data(),
                     .count = leaves_.pointCount.data() + first,
                     .points = points_.step->positions(chunk.begin, end - chunk.begin).data(),
                     .end = end_,
                     .leaves = size};
        chunk.first = first;
        return chunk;
    }

    /// Of a chunk's points. `room`: where they are told by leaf.
    const ValueCode* codesOf(const Chunk& chunk, std::vector<ValueCode>& room) const {
        if (!points_.colors->shade) return codes_.data() + chunk.begin;
        room.clear();
        for (std::size_t i = 0; i < chunk.run.leaves; ++i)
            room.insert(room.end(), chunk.run.count[i],
                        DensityLevels::code(points_.selection->levelOf(chunk.first + i)));
        return room.data();
    }

    /// The preview knows densities alone.
    void addPreview(const std::stop_token& stop) {
        if (points_.preview == nullptr) return;
        const PreviewBlocks blocks(points_);
        const float reach = discs_ ? discs_->reach() : 0.0F;
        forInTurns(std::size_t{0}, blocks.count(), [&](std::size_t block) {
            if (stop.stop_requested()) return;
            std::array<ScreenPoint, PreviewBlocks::blockPoints> screen;
            const std::size_t hits = projectPreview(map_, blocks.block(block), reach, screen.data());
            for (std::size_t i = 0; i < hits; ++i)
                addPoint(screen[i], DensityLevels::code(static_cast<unsigned>(screen[i].level)));
        });
    }

    void carryOff(Part& part) {
        for (std::size_t i = 0; i < sums_.words.size() / 2; ++i) {
            const ValueSum own = part.sums[i];
            if (nearest_) {
                least(sums_.words[2 * i], own);
                if (count_ && part.counts[i] != 0) addTo(2 * i + 1, part.counts[i]);
            } else if (own != 0) {
                addTo(i, own >> countShift, own & ((ValueSum{1} << countShift) - 1));
            }
        }
        std::atomic_ref(sums_.counted).fetch_add(part.counted, std::memory_order_relaxed);
        std::fill(part.sums.begin(), part.sums.end(), 0);
        part.added = 0;
    }

    void addTo(std::size_t word, std::uint64_t more) {
        std::atomic_ref(sums_.words[word]).fetch_add(more, std::memory_order_relaxed);
    }
    void addTo(std::size_t pixel, std::uint64_t weight, std::uint64_t sum) {
        addTo(2 * pixel, weight);
        addTo(2 * pixel + 1, sum);
    }

    void addOneByOne(const Chunk& chunk, const ValueCode* codes) {
        std::array<ScreenPoint, blockPoints> screen;
        const storage::PackedPosition* points = chunk.run.points;
        for (std::size_t leaf = 0; leaf < chunk.run.leaves; ++leaf) {
            for (std::size_t begin = 0; begin < chunk.drawn[leaf]; begin += blockPoints) {
                const std::size_t size = std::min<std::size_t>(blockPoints, chunk.drawn[leaf] - begin);
                projectEach(map_, chunk.run.cells[leaf], points + begin, size, end_, screen.data());
                for (std::size_t i = 0; i < size; ++i) {
                    if (codes[begin + i] != noValue) addPoint(screen[i], codes[begin + i]);
                }
            }
            points += chunk.run.count[leaf];
            codes += chunk.run.count[leaf];
        }
    }

    void addPoint(const ScreenPoint& at, ValueCode code) {
        const auto width = static_cast<std::int32_t>(map_.width);
        const auto height = static_cast<std::int32_t>(map_.height);
        const auto pixelOf = [&](std::int32_t column, std::int32_t row) {
            return static_cast<std::size_t>(row) * map_.width + static_cast<std::size_t>(column);
        };
        const NearKey key = nearKey(at.slab, code);
        const float reach = discs_ ? discs_->reach() : 0.0F;
        const bool near = at.x > -reach && at.y > -reach && at.x < static_cast<float>(width) + reach &&
                          at.y < static_cast<float>(height) + reach;
        if (!near) return;
        if (!discs_) {
            if (!(at.x >= 0.0F && at.y >= 0.0F && at.x < static_cast<float>(width) &&
                  at.y < static_cast<float>(height)))
                return;
            const auto pixel = pixelOf(static_cast<std::int32_t>(at.x), static_cast<std::int32_t>(at.y));
            return addTo(pixel, 1, code);
        }
        discs_->spread(at.x, at.y, {0, 0, width, height},
                       [&](std::int32_t column, std::int32_t row, float weight) {
                           const auto pixel = pixelOf(column, row);
                           if (nearest_) {
                               const float x = static_cast<float>(column) + 0.5F - at.x;
                               const float y = static_cast<float>(row) + 0.5F - at.y;
                               const bool half = std::sqrt(x * x + y * y) <= reach - 0.5F;
                               least(sums_.words[2 * pixel], half ? key : key | farBit);
                           } else {
                               // As in PointFootprint: NOLINTNEXTLINE(bugprone-incorrect-roundings)
                               const auto units = static_cast<std::uint64_t>(weight * wholeDisc + 0.5F);
                               addTo(pixel, units, units * code);
                           }
                       });
    }

    /// Points that cover less than half of a pixel come after all that cover more.
    static constexpr std::uint64_t farBit = std::uint64_t{1} << 63;

    const PointsPlan& points_;
    std::span<const ValueCode> codes_;  // by point; none: they are told by leaf
    const bool nearest_;
    const storage::Leaves leaves_;
    const std::span<const LeafCell> cells_;
    const PointMap map_;
    std::optional<DiscFootprint> discs_;
    const storage::PackedPosition* end_;
    const bool count_;
    const FullCount full_;
    ValueSums sums_;
};

/// The code of a pixel by what is known of it; noValue where nothing is.
ValueCode codeOf(const ValueSums& sums, std::size_t pixel) {
    const std::uint64_t weight = sums.words[2 * pixel], sum = sums.words[2 * pixel + 1];
    if (sums.nearest) return weight == noKey ? noValue : static_cast<ValueCode>(weight & 0xffff);
    return weight == 0 ? noValue : static_cast<ValueCode>((sum + weight / 2) / weight);
}

/// Columns from the first to the last that were added.
struct Span {
    std::uint32_t first = std::numeric_limits<std::uint32_t>::max(), end = 0;

    void add(std::uint32_t column) { add({column, column + 1}); }
    void add(const Span& other) {
        first = std::min(first, other.first);
        end = std::max(end, other.end);
    }
    /// Whether a column is one of them or beside one.
    bool isAround(std::uint32_t column) const { return column + 1 >= first && column <= end; }
};

/// A point right at a pixel's border may be drawn in the next one, by the rounding of a device: there it has
/// the value of the pixels around.
ValueCode codeAround(std::span<const ValueCode> codes, std::uint32_t width, std::uint32_t height,
                     std::uint32_t column, std::uint32_t row) {
    std::uint32_t sum = 0, count = 0;
    for (std::uint32_t y = row - std::min(row, 1U); y < std::min(row + 2, height); ++y) {
        for (std::uint32_t x = column - std::min(column, 1U); x < std::min(column + 2, width); ++x) {
            const ValueCode code = codes[std::size_t{y} * width + x];
            if (code == noValue) continue;
            sum += code;
            ++count;
        }
    }
    return count == 0 ? noValue : static_cast<ValueCode>((sum + count / 2) / count);
}

}  // namespace

void ValueSums::add(const ValueSums& others) {
    MOTE_CHECK(others.words.size() == words.size() && others.nearest == nearest);
    for (std::size_t i = 0; i < words.size(); ++i) {
        const bool key = nearest && i % 2 == 0;
        words[i] = key ? std::min(words[i], others.words[i]) : words[i] + others.words[i];
    }
    counted += others.counted;
}

std::optional<ValueSums> valueSums(const FramePlan& plan, const PointsPlan& points,
                                   std::span<const LeafCell> cells, const std::stop_token& stop, bool count) {
    return Summing(plan, points, cells, count).sum(stop);
}

PixelColors pixelColors(const FramePlan& plan, const PointsPlan& points, const ValueSums& sums) {
    constexpr std::size_t shades = 4096;  // of the map; and one for pixels without a value
    std::vector<glm::vec3> colors;
    for (std::size_t i = 0; i < shades; ++i)
        colors.emplace_back(points.colors->color(static_cast<double>(i) / (shades - 1)));
    colors.emplace_back(points.look.color);
    const std::size_t pixels = std::size_t{plan.width} * plan.height;
    MOTE_CHECK(sums.words.size() == 2 * pixels);
    const bool all = points.colors->shade || points.colors->values->complete;
    const bool counted = sums.nearest ? sums.counted > 0 : all && points.look.size <= 1.0;
    auto counts = listInTurns<std::uint32_t>(counted ? pixels : 0);
    auto codes = listInTurns<ValueCode>(pixels);
    std::vector<Span> known(plan.height);  // of the pixels of each row that have a code
    forInTurns(std::uint32_t{0}, plan.height, [&](std::uint32_t row) {
        constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
        for (std::uint32_t column = 0; column < plan.width; ++column) {
            const std::size_t i = std::size_t{row} * plan.width + column;
            codes[i] = codeOf(sums, i);
            if (codes[i] != noValue) known[row].add(column);
            const std::uint64_t held = sums.words[sums.nearest ? 2 * i + 1 : 2 * i];
            if (counted) counts[i] = static_cast<std::uint32_t>(std::min(held, most));
        }
    });
    auto places = listInTurns<std::uint16_t>(pixels);
    forInTurns(std::uint32_t{0}, plan.height, [&](std::uint32_t row) {
        Span near;
        for (std::uint32_t y = row - std::min(row, 1U); y < std::min(row + 2, plan.height); ++y)
            near.add(known[y]);
        for (std::uint32_t column = 0; column < plan.width; ++column) {
            const std::size_t pixel = std::size_t{row} * plan.width + column;
            ValueCode code = codes[pixel];
            if (code == noValue && all && near.isAround(column))
                code = codeAround(codes, plan.width, plan.height, column, row);
            const auto shade = (std::uint32_t{code} * (shades - 1) + greatestValue / 2) / greatestValue;
            places[pixel] = static_cast<std::uint16_t>(code == noValue ? shades : shade);
        }
    });
    return {plan.width, plan.height, std::move(colors), std::move(places), std::move(counts), sums.counted};
}

std::optional<FrameColors> frameColors(const FramePlan& plan, ResidentLeaves& leaves,
                                       const std::stop_token& stop, ColorSearch search) {
    FrameColors colors(plan.points.size());
    for (std::size_t i = 0; i < plan.points.size(); ++i) {
        const PointsPlan& points = plan.points[i];
        if (!points.colors || (points.preview != nullptr && !points.colors->shade)) continue;
        if (search.cellsAreShaded && shadesCells(plan, points)) continue;
        const auto cells = leaves.of(points.step).upTo(*points.step, points.selection->drawn.size());
        const auto sums = valueSums(plan, points, cells, stop, search.count);
        if (!sums) return std::nullopt;
        colors[i] = std::make_shared<const PixelColors>(pixelColors(plan, points, *sums));
    }
    return colors;
}

}  // namespace mote::render
