// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/id_index.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <functional>
#include <mutex>
#include <numeric>
#include <utility>
#include <vector>

#include "preprocess/on_threads.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t idsAtOnce = std::uint64_t{1} << 18;
constexpr unsigned bucketBits = 12;
constexpr std::size_t buckets = std::size_t{1} << bucketBits;
constexpr std::uint32_t nothing = 0xffffffff;  // more than any point

struct Entry {
    std::uint64_t id;
    std::uint32_t point;
    bool operator<(const Entry& other) const { return id != other.id ? id < other.id : point < other.point; }
};

/// The index of ids that lie in the file.
class IndexWriter {
  public:
    IndexWriter(const storage::ArrayFileWriter& file, const IdArrays& arrays, std::uint64_t mostBytes,
                const std::shared_ptr<StoreMemory>& stores, const Progress& progress)
        : file_(file), arrays_(arrays), mostBytes_(mostBytes), stores_(stores), progress_(progress) {}

    Status run() {
        if (arrays_.points == 0) return success();
        MOTE_RETURN_IF_ERROR(findRange());
        MOTE_ASSIGN_OR_RETURN(const bool written, writeDense());
        return written ? success() : writeSorted();
    }

  private:
    Result<bool> writeDense() {
        MOTE_ASSIGN_OR_RETURN(auto table,
                              IdTable::make({least_, greatest_}, arrays_.points, mostBytes_, stores_));
        if (!table) return false;
        MOTE_RETURN_IF_ERROR(forEachPart(
            [&](std::uint64_t point, std::span<const std::uint64_t> ids) { table->add(point, ids); }));
        return table->write(file_, arrays_, progress_);
    }

    /// By buckets of ids, as many at once as the memory holds.
    Status writeSorted() {
        const std::uint64_t most = std::max<std::uint64_t>(mostBytes_ / sizeof(Entry), idsAtOnce);
        counts_.assign(buckets, 0);
        MOTE_RETURN_IF_ERROR(countBuckets());
        std::uint64_t written = 0;
        for (std::size_t first = 0; first < buckets;) {
            std::size_t last = first;
            std::uint64_t count = 0;
            while (last < buckets && (last == first || count + counts_[last] <= most))
                count += counts_[last++];
            MOTE_RETURN_IF_ERROR(writeBuckets(first, last, count, written));
            written += count;
            first = last;
        }
        return success();
    }

    template <class Use>
    Status forEachPart(const Use& use) {
        const std::uint64_t parts = (arrays_.points + idsAtOnce - 1) / idsAtOnce;
        return inParallel(parts, [&](std::uint64_t part) -> Status {
            if (progress_.cancelled()) return wasCancelled();
            const std::uint64_t first = part * idsAtOnce;
            std::vector<std::uint64_t> ids(std::min(idsAtOnce, arrays_.points - first));
            MOTE_RETURN_IF_ERROR(file_.read(arrays_.ids, first * sizeof(std::uint64_t),
                                            std::as_writable_bytes(std::span(ids))));
            use(first, std::span<const std::uint64_t>(ids));
            return success();
        });
    }

    Status findRange() {
        std::mutex mutex;
        IdRange all;
        MOTE_RETURN_IF_ERROR(forEachPart([&](std::uint64_t, std::span<const std::uint64_t> ids) {
            IdRange part;
            part.add(ids);
            const std::lock_guard lock(mutex);
            all.add(part);
        }));
        least_ = all.least;
        greatest_ = all.greatest;
        const auto bits = static_cast<unsigned>(std::bit_width(greatest_ - least_));
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
        auto next = begin;
        std::mutex mutex;
        MOTE_ASSIGN_OR_RETURN(auto store, RecordStore::inMemory(count * sizeof(Entry), stores_));
        const auto entries = store.room<Entry>(0, count);
        MOTE_RETURN_IF_ERROR(forEachPart([&](std::uint64_t point, std::span<const std::uint64_t> ids) {
            std::vector<std::uint64_t> at(last - first);
            for (const auto id : ids) {
                const auto bucket = bucketOf(id);
                if (bucket >= first && bucket < last) ++at[bucket - first];
            }
            {
                const std::lock_guard lock(mutex);
                for (std::size_t i = 0; i < at.size(); ++i) {
                    next[i] += at[i];
                    at[i] = next[i] - at[i];
                }
            }
            for (const auto id : ids) {
                const auto bucket = bucketOf(id);
                if (bucket >= first && bucket < last) {
                    entries[at[bucket - first]++] = {id, static_cast<std::uint32_t>(point)};
                }
                ++point;
            }
        }));
        return inParallel(last - first, [&](std::size_t i) {
            const auto mine = entries.subspan(begin[i], begin[i + 1] - begin[i]);
            std::ranges::sort(mine, std::less<>());
            std::vector<std::uint32_t> points;
            points.reserve(mine.size());
            for (const auto& entry : mine) points.push_back(entry.point);
            return file_.write(arrays_.index, (before + begin[i]) * sizeof(std::uint32_t),
                               std::as_bytes(std::span(points)));
        });
    }

    const storage::ArrayFileWriter& file_;
    const IdArrays arrays_;
    const std::uint64_t mostBytes_;  ///< of memory
    const std::shared_ptr<StoreMemory>& stores_;
    const Progress& progress_;
    std::vector<std::uint64_t> counts_;  ///< by bucket
    std::uint64_t least_ = 0, greatest_ = 0;
    unsigned shift_ = 0;
};

}  // namespace

void IdRange::add(std::span<const std::uint64_t> ids) {
    // One comparison each, of numbers that wait for no other, where std::ranges::minmax branches.
    for (const auto id : ids) least = std::min(least, id);
    for (const auto id : ids) greatest = std::max(greatest, id);
}

void IdRange::add(const IdRange& other) {
    least = std::min(least, other.least);
    greatest = std::max(greatest, other.greatest);
}

Result<std::optional<IdTable>> IdTable::make(const IdRange& ids, std::uint64_t points,
                                             std::uint64_t mostBytes,
                                             const std::shared_ptr<StoreMemory>& stores) {
    constexpr std::uint64_t slotsEach = 2;
    const std::uint64_t last = ids.greatest - ids.least;
    if (ids.greatest < ids.least || last / slotsEach >= points ||
        (last + 1) * sizeof(std::uint32_t) > mostBytes)
        return std::optional<IdTable>();
    MOTE_ASSIGN_OR_RETURN(auto store, RecordStore::inMemory((last + 1) * sizeof(std::uint32_t), stores));
    return std::optional<IdTable>(IdTable(ids.least, last + 1, std::move(store)));
}

IdTable::IdTable(std::uint64_t least, std::uint64_t places, RecordStore store)
    : least_(least), store_(std::move(store)), table_(store_.room<std::uint32_t>(0, places)) {
    tbb::parallel_for(std::uint64_t{0}, parts(),
                      [&](std::uint64_t part) { std::ranges::fill(partOf(part), nothing); });
}

std::uint64_t IdTable::parts() const {
    return (table_.size() + idsAtOnce - 1) / idsAtOnce;
}

std::span<std::uint32_t> IdTable::partOf(std::uint64_t part) const {
    const std::uint64_t first = part * idsAtOnce;
    return table_.subspan(first, std::min(idsAtOnce, table_.size() - first));
}

void IdTable::add(std::uint64_t point, std::span<const std::uint64_t> ids) {
    // The same id may come to two threads at once; that it did shows in the number of places taken.
    for (const auto id : ids) {
        std::atomic_ref(table_[id - least_])
            .store(static_cast<std::uint32_t>(point++), std::memory_order_relaxed);
    }
}

Result<bool> IdTable::write(const storage::ArrayFileWriter& file, const IdArrays& arrays,
                            const Progress& progress) {
    begin_.assign(parts() + 1, 0);
    tbb::parallel_for(std::uint64_t{0}, parts(), [&](std::uint64_t part) {
        const auto of = partOf(part);
        begin_[part + 1] = of.size() - static_cast<std::uint64_t>(std::ranges::count(of, nothing));
    });
    std::inclusive_scan(begin_.begin(), begin_.end(), begin_.begin());
    if (begin_.back() != arrays.points) return false;
    MOTE_RETURN_IF_ERROR(inParallel(parts(), [&](std::uint64_t part) -> Status {
        if (progress.cancelled()) return wasCancelled();
        const auto of = partOf(part);
        const auto end = std::remove(of.begin(), of.end(), nothing);
        return file.write(arrays.index, begin_[part] * sizeof(std::uint32_t),
                          std::as_bytes(std::span(of.begin(), end)));
    }));
    return true;
}

void IdTable::read(std::uint64_t at, std::span<std::byte> bytes) const {
    constexpr std::uint64_t size = sizeof(std::uint32_t);
    std::uint64_t first = at / size;
    auto next = std::ranges::upper_bound(begin_, first);  // where the part ends that holds the first one
    while (!bytes.empty()) {
        const auto part = static_cast<std::uint64_t>(next - begin_.begin()) - 1;
        const auto count = std::min(bytes.size() / size, *next - first);
        const auto points = std::as_bytes(partOf(part).subspan(first - begin_[part], count));
        std::ranges::copy(points, bytes.begin());
        bytes = bytes.subspan(points.size());
        first += count;
        ++next;
    }
}

Status writeIdIndex(const storage::ArrayFileWriter& file, const IdArrays& arrays, std::uint64_t mostBytes,
                    const std::shared_ptr<StoreMemory>& stores, const Progress& progress) {
    return IndexWriter(file, arrays, mostBytes, stores, progress).run();
}

}  // namespace mote::prep
