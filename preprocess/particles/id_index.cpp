// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/id_index.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>
#include <mutex>
#include <numeric>
#include <span>
#include <vector>

namespace mote::prep {
namespace {

constexpr std::uint64_t idsAtOnce = std::uint64_t{1} << 18;
constexpr unsigned bucketBits = 12;
constexpr std::size_t buckets = std::size_t{1} << bucketBits;

struct Entry {
    std::uint64_t id;
    std::uint32_t point;
    bool operator<(const Entry& other) const { return id != other.id ? id < other.id : point < other.point; }
};

class IndexWriter {
  public:
    IndexWriter(const storage::ArrayFileWriter& file, const IdArrays& arrays, std::uint64_t memory,
                const Progress& progress)
        : file_(file),
          arrays_(arrays),
          most_(std::max<std::uint64_t>(memory / 4 * 3 / sizeof(Entry), idsAtOnce)),
          progress_(progress),
          counts_(buckets) {}

    Status run() {
        if (arrays_.points == 0) return success();
        MOTE_RETURN_IF_ERROR(findRange());
        MOTE_RETURN_IF_ERROR(countBuckets());
        std::uint64_t written = 0;
        for (std::size_t first = 0; first < buckets;) {
            std::size_t last = first;
            std::uint64_t count = 0;
            while (last < buckets && (last == first || count + counts_[last] <= most_))
                count += counts_[last++];
            MOTE_RETURN_IF_ERROR(writeBuckets(first, last, count, written));
            written += count;
            first = last;
        }
        return success();
    }

  private:
    template <class Use>
    Status forEachPart(const Use& use) {
        const std::uint64_t parts = (arrays_.points + idsAtOnce - 1) / idsAtOnce;
        std::vector<Status> statuses(parts, success());
        tbb::parallel_for(std::uint64_t{0}, parts, [&](std::uint64_t part) {
            const std::uint64_t first = part * idsAtOnce;
            std::vector<std::uint64_t> ids(std::min(idsAtOnce, arrays_.points - first));
            statuses[part] = progress_.cancelled() ? Status(cancelledError())
                                                   : file_.read(arrays_.ids, first * sizeof(std::uint64_t),
                                                                std::as_writable_bytes(std::span(ids)));
            if (statuses[part].ok()) use(first, std::span<const std::uint64_t>(ids));
        });
        for (const auto& status : statuses) MOTE_RETURN_IF_ERROR(status);
        return success();
    }

    Status findRange() {
        std::mutex mutex;
        std::uint64_t greatest = 0;
        least_ = std::numeric_limits<std::uint64_t>::max();
        MOTE_RETURN_IF_ERROR(forEachPart([&](std::uint64_t, std::span<const std::uint64_t> ids) {
            const auto [low, high] = std::ranges::minmax(ids);
            const std::lock_guard lock(mutex);
            least_ = std::min(least_, low);
            greatest = std::max(greatest, high);
        }));
        const auto bits = static_cast<unsigned>(std::bit_width(greatest - least_));
        shift_ = bits > bucketBits ? bits - bucketBits : 0;
        return success();
    }

    std::size_t bucketOf(std::uint64_t id) const { return static_cast<std::size_t>((id - least_) >> shift_); }

    Status countBuckets() {
        std::mutex mutex;
        return forEachPart([&](std::uint64_t, std::span<const std::uint64_t> ids) {
            std::vector<std::uint32_t> counts(buckets);
            for (const auto id : ids) ++counts[bucketOf(id)];
            const std::lock_guard lock(mutex);
            for (std::size_t i = 0; i < buckets; ++i) counts_[i] += counts[i];
        });
    }

    /// Entries come into their bucket in any order; sorting gives them the only one there is.
    Status writeBuckets(std::size_t first, std::size_t last, std::uint64_t count, std::uint64_t before) {
        std::vector<std::uint64_t> begin(last - first + 1);
        std::inclusive_scan(counts_.begin() + static_cast<std::ptrdiff_t>(first),
                            counts_.begin() + static_cast<std::ptrdiff_t>(last), begin.begin() + 1);
        std::vector<std::atomic<std::uint64_t>> next(last - first);
        for (std::size_t i = 0; i < next.size(); ++i) next[i] = begin[i];
        std::vector<Entry> entries(count);
        MOTE_RETURN_IF_ERROR(forEachPart([&](std::uint64_t point, std::span<const std::uint64_t> ids) {
            for (const auto id : ids) {
                const auto bucket = bucketOf(id);
                if (bucket >= first && bucket < last) {
                    entries[next[bucket - first]++] = {id, static_cast<std::uint32_t>(point)};
                }
                ++point;
            }
        }));
        std::vector<Status> statuses(last - first, success());
        tbb::parallel_for(std::size_t{0}, statuses.size(), [&](std::size_t i) {
            const auto mine = std::span(entries).subspan(begin[i], begin[i + 1] - begin[i]);
            std::ranges::sort(mine, std::less<>());
            std::vector<std::uint32_t> points;
            points.reserve(mine.size());
            for (const auto& entry : mine) points.push_back(entry.point);
            statuses[i] = file_.write(arrays_.index, (before + begin[i]) * sizeof(std::uint32_t),
                                      std::as_bytes(std::span(points)));
        });
        for (const auto& status : statuses) MOTE_RETURN_IF_ERROR(status);
        return success();
    }

    const storage::ArrayFileWriter& file_;
    const IdArrays arrays_;
    const std::uint64_t most_;  ///< entries in memory at once
    const Progress& progress_;
    std::vector<std::uint64_t> counts_;  ///< by bucket
    std::uint64_t least_ = 0;
    unsigned shift_ = 0;
};

}  // namespace

Status writeIdIndex(const storage::ArrayFileWriter& file, const IdArrays& arrays, std::uint64_t memory,
                    const Progress& progress) {
    return IndexWriter(file, arrays, memory, progress).run();
}

}  // namespace mote::prep
