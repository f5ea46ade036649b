// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/column_output.h"

#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <set>
#include <type_traits>
#include <utility>

#include "preprocess/on_threads.h"
#include "preprocess/particles/step_statistics.h"
#include "storage/arrays/array_file.h"
#include "storage/particles/mapped_columns.h"
#include "storage/particles/step_layout.h"

namespace mote::prep {
namespace {

KeptColumn columnOf(const PlotAxis& axis, const ParticleSource& source) {
    const bool weight = axis.name() == "weight";
    return {axis.name(), weight ? source.weightUnit() : axis.unit(), axis};
}

Result<KeptColumns> allColumns(const ParticleSource& source) {
    KeptColumns kept;
    const auto records = source.records();
    for (const auto column : columnsOf(source)) {
        if (isRecord(column) && !records[static_cast<std::size_t>(column) - columnCount].kept) continue;
        MOTE_ASSIGN_OR_RETURN(const auto axis, PlotAxis::make(columnName(column, source), source));
        kept.columns.push_back(columnOf(axis, source));
    }
    kept.ids = source.has(Column::id);
    return kept;
}

Status addColumn(const std::string& name, const ParticleSource& source, KeptColumns& kept) {
    const bool twice =
        name == "id" ? kept.ids : std::ranges::count(kept.columns, name, &KeptColumn::name) > 0;
    if (twice) return invalid("columns", fmt::format("\"{}\" is given twice", name));
    if (name == "id") {
        kept.ids = source.has(Column::id);
        if (kept.ids) return success();
        return notFound("columns", "the run has no column \"id\"");
    }
    const auto axis = PlotAxis::make(name, source);
    if (!axis.ok()) {
        return Error{axis.error().code, "columns",
                     fmt::format("\"{}\" {}", name.substr(0, 64), axis.error().message)};
    }
    kept.columns.push_back(columnOf(*axis, source));
    return success();
}

/// A quantity's name as it is; that of a record of vectors, as spin, becomes those of the components that the
/// run has: spin_x, spin_y, spin_z.
std::vector<std::string> columnsCalled(const std::string& name, const ParticleSource& source) {
    std::vector<std::string> components;
    for (const auto& record : source.records()) {
        for (const auto* const component : {"_x", "_y", "_z"}) {
            if (record.name == name + component) components.push_back(record.name);
        }
    }
    if (components.empty() || PlotAxis::make(name, source).ok()) return {name};
    return components;
}

struct IdArrays {
    std::size_t ids = 0, index = 0;  ///< in the file: u64, u32
    std::uint64_t points = 0;        ///< fewer than 2^32
};

constexpr std::uint64_t idsAtOnce = std::uint64_t{1} << 18;
constexpr unsigned bucketBits = 12;
constexpr std::size_t buckets = std::size_t{1} << bucketBits;
constexpr std::uint32_t nothing = 0xffffffff;  // more than any point

struct Entry {
    std::uint64_t id;
    std::uint32_t point;
    bool operator<(const Entry& other) const { return id != other.id ? id < other.id : point < other.point; }
};

struct IdRange {
    std::uint64_t least = std::numeric_limits<std::uint64_t>::max(), greatest = 0;

    void add(std::span<const std::uint64_t> ids) {
        if (ids.empty()) return;
        const auto [low, high] = std::ranges::minmax(ids);
        add({low, high});
    }
    void add(const IdRange& other) {
        least = std::min(least, other.least);
        greatest = std::max(greatest, other.greatest);
    }
};

/// Where ids are little further apart than they are many, and none is twice, each has a place of its own in a
/// table, which then holds the points in their order.
class IdTable {
  public:
    /// None where ids are further apart, or where there are more than `mostBytes` to hold. `ids`: all ids
    /// that are added are in it.
    static Result<std::optional<IdTable>> make(const IdRange& ids, std::uint64_t points,
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

    /// Ids of points that follow each other. Any thread.
    void add(std::uint64_t point, std::span<const std::uint64_t> ids) {
        // The same id may come to two threads at once; that it did shows in the number of places taken.
        for (const auto id : ids) {
            std::atomic_ref(table_[id - least_])
                .store(static_cast<std::uint32_t>(point++), std::memory_order_relaxed);
        }
    }

    /// The index; called once. Returns whether no id was twice; else nothing is written.
    Result<bool> write(const storage::ArrayFileWriter& file, const IdArrays& arrays,
                       const Progress& progress) {
        std::vector<std::uint64_t> begin(parts() + 1);
        tbb::parallel_for(std::uint64_t{0}, parts(), [&](std::uint64_t part) {
            const auto of = partOf(part);
            begin[part + 1] = of.size() - static_cast<std::uint64_t>(std::ranges::count(of, nothing));
        });
        std::inclusive_scan(begin.begin(), begin.end(), begin.begin());
        if (begin.back() != arrays.points) return false;
        MOTE_RETURN_IF_ERROR(inParallel(parts(), [&](std::uint64_t part) -> Status {
            if (progress.cancelled()) return wasCancelled();
            const auto of = partOf(part);
            const auto end = std::ranges::remove(of, nothing).begin();
            return file.write(arrays.index, begin[part] * sizeof(std::uint32_t),
                              std::as_bytes(std::span(of.begin(), end)));
        }));
        return true;
    }

  private:
    IdTable(std::uint64_t least, std::uint64_t places, RecordStore store)
        : least_(least), store_(std::move(store)), table_(store_.room<std::uint32_t>(0, places)) {
        tbb::parallel_for(std::uint64_t{0}, parts(),
                          [&](std::uint64_t part) { std::ranges::fill(partOf(part), nothing); });
    }

    std::uint64_t parts() const { return (table_.size() + idsAtOnce - 1) / idsAtOnce; }
    std::span<std::uint32_t> partOf(std::uint64_t part) const {
        const std::uint64_t first = part * idsAtOnce;
        return table_.subspan(first, std::min(idsAtOnce, table_.size() - first));
    }

    std::uint64_t least_;
    RecordStore store_;
    std::span<std::uint32_t> table_;
};

/// The index of ids that lie in the file, where they did not go into a table on their way there.
class IndexWriter {
  public:
    IndexWriter(const storage::ArrayFileWriter& file, const IdArrays& arrays, const ColumnsRequest& request)
        : file_(file),
          arrays_(arrays),
          mostBytes_(request.memory / 4 * 3),
          stores_(request.stores),
          progress_(*request.progress) {}

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

constexpr std::size_t askedEach = 4096;  // rows, between two questions whether to stop

Status readRows(const storage::StepFile& points, std::uint64_t first, std::span<std::uint64_t> rows) {
    return points.read(storage::StepArray::pointRow, first * sizeof(std::uint64_t),
                       std::as_writable_bytes(rows));
}

Status readStrided(const storage::StepFile& points, std::uint64_t stride, std::vector<std::uint64_t>& rows,
                   const Progress& progress) {
    const std::size_t parts = (rows.size() + askedEach - 1) / askedEach;
    return inParallel(parts, [&](std::size_t part) -> Status {
        if (progress.cancelled()) return wasCancelled();
        const std::size_t end = std::min(rows.size(), (part + 1) * askedEach);
        for (std::size_t i = part * askedEach; i < end; ++i)
            MOTE_RETURN_IF_ERROR(readRows(points, i * stride, std::span(rows).subspan(i, 1)));
        return success();
    });
}

using storage::ArrayFileWriter;

constexpr std::uint64_t pointsAtOnce = std::uint64_t{1} << 18;
constexpr std::size_t mostTogether = 8;  // columns that share a cache line of rows

constexpr std::size_t rowsInCache = 1024;  // of records whose columns come one after another
constexpr std::size_t recordsAhead = 32;

/// Points whose values are gathered at once: a thread's memory.
template <class T>
struct Part {
    std::vector<std::uint64_t> rows;
    std::vector<T> values;  ///< column after column
};

/// Columns that are read and written together.
struct Group {
    std::size_t first = 0, count = 0;
    bool doubles = false;
};

struct Extent {
    double least = std::numeric_limits<double>::infinity();
    double greatest = -std::numeric_limits<double>::infinity();
    double stored = 0.0;  ///< greatest magnitude of what is in the file

    void add(double value, double inFile) {
        if (!std::isfinite(value)) return;
        least = std::min(least, value);
        greatest = std::max(greatest, value);
        stored = std::max(stored, std::abs(inFile));
    }
    void add(const Extent& other) {
        least = std::min(least, other.least);
        greatest = std::max(greatest, other.greatest);
        stored = std::max(stored, other.stored);
    }
};

class Output {
  public:
    explicit Output(const ColumnsRequest& request)
        : request_(request),
          columns_(request.kept->columns),
          ranks_(*request.ranks),
          rows_(request.source->steps()[request.step].particles),
          extents_(columns_.size()) {}

    Result<WrittenColumns> run() {
        chooseCodings();
        MOTE_RETURN_IF_ERROR(openFile());
        MOTE_RETURN_IF_ERROR(agree(ranks_, writeMine()));
        MOTE_RETURN_IF_ERROR(shareExtents());
        if (request_.kept->ids)
            MOTE_RETURN_IF_ERROR(agree(ranks_, ranks_.first() && !indexed_ ? writeIndex() : success()));
        WrittenColumns written;
        MOTE_RETURN_IF_ERROR(agree(ranks_, ranks_.first() ? finish(written) : success()));
        written.codings = codings_;
        for (std::size_t i = 0; i < extents_.size(); ++i) {
            written.resolutions.push_back(resolutionOf(codings_[i], extents_[i].stored));
            written.least.push_back(extents_[i].least);
            written.greatest.push_back(extents_[i].greatest);
        }
        return written;
    }

  private:
    Status finish(WrittenColumns& written) {
        request_.writeback->begin(request_.directory / (request_.name + ".h5"));
        MOTE_ASSIGN_OR_RETURN(written.hash, file_->finish([&] { return request_.progress->cancelled(); }));
        return success();
    }

    /// The same on all ranks: so is the sample.
    void chooseCodings() {
        const auto& sample = *request_.sample;
        codings_.resize(columns_.size());
        tbb::parallel_for(std::size_t{0}, columns_.size(), [&](std::size_t i) {
            if (!columns_[i].axis) return;
            auto values = valuesOf(i, sample.rows());
            codings_[i] = columns_[i].isWeight()
                              ? weightCodingOf(values, sample.leastWeight(), sample.greatestWeight())
                              : codingOf(std::move(values));
        });
    }

    std::vector<double> valuesOf(std::size_t column, const ParticleChunk& chunk) const {
        std::vector<double> values(chunk.size);
        evaluateColumn(columns_[column], chunk, request_.context, values);
        return values;
    }

    /// Rank 0 makes the file; the others learn from it where the arrays lie.
    Status openFile() {
        std::vector<storage::ColumnInfo> infos;
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            infos.push_back({columns_[i].name, columns_[i].unit, codings_[i].offset, codings_[i].doubles});
        }
        const auto layout = storage::columnsLayout(infos, request_.kept->ids, request_.pointCount);
        Status status = success();
        const auto take = [&](Result<ArrayFileWriter> made) {
            if (!made.ok()) status = made.error();
            if (made.ok()) file_.emplace(*std::move(made));
        };
        if (ranks_.first()) take(ArrayFileWriter::create(request_.directory, request_.name, layout));
        MOTE_RETURN_IF_ERROR(agree(ranks_, status));
        const auto mine = file_ ? file_->places() : std::vector<storage::ArrayPlace>();
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<storage::ArrayPlace>(ranks_, mine));
        if (!file_) take(ArrayFileWriter::open(request_.directory, request_.name, layout, all.front()));
        // Who looks at the plot reads the step; columns are as large again, and mostly for later.
        if (file_) file_->passCache();
        if (file_ && alone()) file_->hashAhead([this] { return request_.progress->cancelled(); });
        return agree(ranks_, status);
    }

    /// A row takes so many bytes of what is held while its columns change their order.
    std::uint64_t rowsFor(std::uint64_t bytesOfRow) const {
        const std::uint64_t most = request_.memory / 4 * 3 / bytesOfRow / rowsOfChunk * rowsOfChunk;
        return std::clamp(most, rowsOfChunk, std::max(rows_, rowsOfChunk));
    }

    /// Puts as many columns together as there is memory for, but so that every rank has some.
    std::vector<Group> groups() const {
        const auto size = static_cast<std::size_t>(ranks_.size());
        const auto held = static_cast<std::size_t>(request_.memory / 4 * 3 / sizeof(float) /
                                                   std::max<std::uint64_t>(rows_, 1));
        const std::size_t even = (columns_.size() + size - 1) / size;
        const std::size_t count = std::clamp<std::size_t>(std::min(held, even), 1, mostTogether);
        std::vector<Group> groups;
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            const bool doubles = codings_[i].doubles;
            const std::size_t most = doubles ? std::max<std::size_t>(1, count / 2) : count;
            const bool joins =
                !groups.empty() && groups.back().doubles == doubles && groups.back().count < most;
            if (!joins) groups.push_back({i, 0, doubles});
            ++groups.back().count;
        }
        return groups;
    }

    Status writeMine() {
        const auto parts = groups();
        const auto size = static_cast<std::size_t>(ranks_.size());
        const auto rank = static_cast<std::size_t>(ranks_.rank());
        for (std::size_t i = rank; i < parts.size(); i += size) {
            MOTE_RETURN_IF_ERROR(parts[i].doubles ? writeGroup<double>(parts[i])
                                                  : writeGroup<float>(parts[i]));
        }
        if (request_.kept->ids && rank == parts.size() % size) return writeIds();
        return success();
    }

    template <class T>
    Status writeGroup(const Group& group) {
        std::set<Column> wanted;
        for (std::size_t i = 0; i < group.count; ++i) {
            const auto sources = columns_[group.first + i].sources();
            wanted.insert(sources.begin(), sources.end());
        }
        const auto fill = [&](std::uint64_t begin, RecordStore& store) {
            return [this, &group, &store, begin](const ParticleChunk& chunk) {
                const auto records =
                    store.room<T>((chunk.begin - begin) * group.count, chunk.size * group.count);
                std::array<std::vector<double>, mostTogether> made;
                std::array<std::span<const double>, mostTogether> values;
                for (std::size_t i = 0; i < group.count; ++i) {
                    const auto& axis = columns_[group.first + i].axis;
                    const bool asRead = axis && axis->isColumn();
                    if (!asRead) made[i] = valuesOf(group.first + i, chunk);
                    values[i] = asRead ? std::span(chunk[axis->columns().front()]) : std::span(made[i]);
                }
                for (std::size_t first = 0; first < chunk.size; first += rowsInCache) {
                    const std::size_t last = std::min(chunk.size, first + rowsInCache);
                    for (std::size_t i = 0; i < group.count; ++i) {
                        const double offset = codings_[group.first + i].offset;
                        for (std::size_t k = first; k < last; ++k)
                            records[k * group.count + i] = static_cast<T>(values[i][k] - offset);
                    }
                }
            };
        };
        std::vector<std::size_t> arrays;
        for (std::size_t i = 0; i < group.count; ++i) arrays.push_back(group.first + i);
        return moveRows<T>({wanted.begin(), wanted.end()}, arrays, fill);
    }

    bool alone() const { return ranks_.size() == 1; }

    Status writeIds() {
        std::mutex mutex;
        IdRange range;
        const auto fill = [&](std::uint64_t begin, RecordStore& store) {
            return [&, begin](const ParticleChunk& chunk) {
                const auto ids = std::span(chunk.id).first(chunk.size);
                std::ranges::copy(ids, store.room<std::uint64_t>(chunk.begin - begin, chunk.size).begin());
                IdRange part;
                part.add(ids);
                const std::lock_guard lock(mutex);
                range.add(part);
            };
        };
        // All ids at once: on the way to their points each goes to its place in the index, too.
        const std::uint64_t held = rows_ * sizeof(std::uint64_t), most = request_.memory / 4 * 3;
        const auto filled = [&]() -> Status {
            if (!alone() || held > most) return success();
            MOTE_ASSIGN_OR_RETURN(idTable_,
                                  IdTable::make(range, request_.pointCount, most - held, request_.stores));
            return success();
        };
        MOTE_RETURN_IF_ERROR(moveRows<std::uint64_t>({Column::id}, {columns_.size()}, fill, filled));
        if (!idTable_) return success();
        MOTE_ASSIGN_OR_RETURN(indexed_, idTable_->write(*file_, idArrays(), *request_.progress));
        idTable_.reset();
        return success();
    }

    /// Reads records of `arrays.size()` values a row by the chunks that `fill` takes, and writes them in the
    /// order of the points. `filled`: called between the two.
    template <class T, class Fill>
    Status moveRows(const std::vector<Column>& wanted, const std::vector<std::size_t>& arrays,
                    const Fill& fill, const std::function<Status()>& filled = {}) {
        const std::uint64_t recordBytes = sizeof(T) * arrays.size();
        const std::uint64_t together = rowsFor(recordBytes);
        MOTE_ASSIGN_OR_RETURN(
            auto store, RecordStore::inMemory(std::min(together, rows_) * recordBytes, request_.stores));
        for (std::uint64_t begin = 0; begin < rows_; begin += together) {
            const std::uint64_t end = std::min(rows_, begin + together);
            MOTE_RETURN_IF_ERROR(forEachChunk(*request_.source, request_.step, begin, end, wanted,
                                              *request_.progress, fill(begin, store)));
            if (filled) MOTE_RETURN_IF_ERROR(filled());
            MOTE_RETURN_IF_ERROR(gather<T>(store, begin, end, arrays));
            if (end == rows_) request_.writeback->begin(request_.directory / (request_.name + ".h5"));
        }
        for (const auto array : arrays) file_->complete(array);
        return success();
    }

    template <class T>
    Status gather(const RecordStore& store, std::uint64_t begin, std::uint64_t end,
                  const std::vector<std::size_t>& arrays) {
        std::vector<T> unused;
        MOTE_ASSIGN_OR_RETURN(const auto records, store.read<T>(0, (end - begin) * arrays.size(), unused));
        const std::uint64_t parts = (request_.pointCount + pointsAtOnce - 1) / pointsAtOnce;
        tbb::enumerable_thread_specific<Part<T>> buffers;
        return inParallel(parts, [&](std::uint64_t part) -> Status {
            if (request_.progress->cancelled()) return wasCancelled();
            return gatherPart<T>(records, begin, end, arrays, part * pointsAtOnce, buffers.local());
        });
    }

    /// Points of other ranges of rows keep what an earlier range gave them.
    template <class T>
    Status gatherPart(std::span<const T> records, std::uint64_t begin, std::uint64_t end,
                      const std::vector<std::size_t>& arrays, std::uint64_t first, Part<T>& part) {
        const auto count = static_cast<std::size_t>(std::min(pointsAtOnce, request_.pointCount - first));
        const bool whole = end - begin == rows_;
        auto& [rows, values] = part;
        rows.resize(count);
        values.resize(count * arrays.size());
        MOTE_RETURN_IF_ERROR(request_.points->read(storage::StepArray::pointRow,
                                                   first * sizeof(std::uint64_t),
                                                   std::as_writable_bytes(std::span(rows))));
        for (std::size_t i = 0; i < arrays.size() && !whole; ++i) {
            MOTE_RETURN_IF_ERROR(
                file_->read(arrays[i], first * sizeof(T),
                            std::as_writable_bytes(std::span(values).subspan(i * count, count))));
        }
        for (std::size_t k = 0; k < count; ++k) {
            // Each record is somewhere else: many are asked for before the first one comes.
            const auto later = rows[std::min(k + recordsAhead, count - 1)];
            if (later >= begin && later < end) {
                const T* const ahead = records.data() + (later - begin) * arrays.size();
                __builtin_prefetch(ahead);
                __builtin_prefetch(ahead + arrays.size() - 1);
            }
            if (!whole && (rows[k] < begin || rows[k] >= end)) continue;
            const T* const record = records.data() + (rows[k] - begin) * arrays.size();
            for (std::size_t i = 0; i < arrays.size(); ++i) values[i * count + k] = record[i];
        }
        for (std::size_t i = 0; i < arrays.size(); ++i) {
            const auto mine = std::span<const T>(values).subspan(i * count, count);
            MOTE_RETURN_IF_ERROR(file_->write(arrays[i], first * sizeof(T), std::as_bytes(mine)));
            if constexpr (std::is_floating_point_v<T>) {
                if (end == rows_) addExtent(arrays[i], mine);
            }
        }
        if constexpr (std::is_same_v<T, std::uint64_t>) {
            if (idTable_) idTable_->add(first, values);
        }
        return success();
    }

    template <class T>
    void addExtent(std::size_t column, std::span<const T> values) {
        Extent extent;
        const double offset = codings_[column].offset;
        for (const T value : values) {
            extent.add(offset + static_cast<double>(value), static_cast<double>(value));
        }
        const std::lock_guard lock(extentMutex_);
        extents_[column].add(extent);
    }

    Status shareExtents() {
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<Extent>(ranks_, extents_));
        for (const auto& ofRank : all) {
            for (std::size_t i = 0; i < extents_.size(); ++i) extents_[i].add(ofRank[i]);
        }
        return success();
    }

    Status writeIndex() { return IndexWriter(*file_, idArrays(), request_).run(); }

    IdArrays idArrays() const { return {columns_.size(), columns_.size() + 1, request_.pointCount}; }

    const ColumnsRequest& request_;
    const std::vector<KeptColumn>& columns_;
    Communicator& ranks_;
    const std::uint64_t rows_;
    std::vector<ColumnCoding> codings_;
    std::mutex extentMutex_;
    std::vector<Extent> extents_;     ///< under it while parts are gathered
    std::optional<IdTable> idTable_;  ///< while ids are gathered
    bool indexed_ = false;            ///< whether it became the index
    std::optional<ArrayFileWriter> file_;
};

}  // namespace

Result<KeptColumns> keptColumns(const google::protobuf::RepeatedPtrField<std::string>& names,
                                const ParticleSource& source, bool marked) {
    if (names.size() == 1 && names[0] == "none") return KeptColumns();
    KeptColumns kept;
    if (names.empty()) {
        MOTE_ASSIGN_OR_RETURN(kept, allColumns(source));
    }
    for (const auto& name : names) {
        if (name == "lost" && marked) continue;
        for (const auto& column : columnsCalled(name, source))
            MOTE_RETURN_IF_ERROR(addColumn(column, source, kept));
    }
    if (marked) kept.columns.push_back({"lost", "1", std::nullopt});
    return kept;
}

std::vector<Column> KeptColumns::sources() const {
    std::set<Column> all;
    for (const auto& column : columns) {
        const auto own = column.sources();
        all.insert(own.begin(), own.end());
    }
    return {all.begin(), all.end()};
}

void KeptColumns::describe(const ParticleSource& source, proto::ParticlesManifest& manifest) const {
    for (const auto& column : columns) {
        auto& entry = *manifest.add_columns();
        entry.set_name(column.name);
        entry.set_unit(column.unit);
        // Nothing yet: the first step's range is taken as it is.
        entry.set_min(0.0);
        entry.set_max(-1.0);
    }
    manifest.set_ids(ids);
    manifest.set_mass(source.mass());
    manifest.set_species(source.species());
    manifest.set_particle_charge(source.particleCharge());
    manifest.set_weight_unit(source.weightUnit());
}

void evaluateColumn(const KeptColumn& column, const ParticleChunk& chunk, const BeamContext& context,
                    std::span<double> out) {
    if (column.axis) return column.axis->evaluate(chunk, context, out);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = i < chunk.lost.size() && chunk.lost[i] != 0 ? 1.0 : 0.0;
}

ColumnSample::ColumnSample(ColumnSample&& other) noexcept
    : wanted_(std::move(other.wanted_)),
      lost_(other.lost_),
      row_(std::move(other.row_)),
      taken_(std::move(other.taken_)),
      chunk_(std::move(other.chunk_)),
      leastWeight_(other.leastWeight_),
      greatestWeight_(other.greatestWeight_) {}

Result<ColumnSample> ColumnSample::make(const storage::StepFile& points, std::uint64_t pointCount,
                                        std::vector<Column> wanted, LostParticles lost,
                                        const Progress& progress) {
    ColumnSample sample;
    sample.lost_ = lost;
    sample.wanted_ = std::move(wanted);
    const std::uint64_t stride = std::max<std::uint64_t>(1, (pointCount + most - 1) / most);
    sample.row_.resize((pointCount + stride - 1) / stride);
    if (stride == 1) MOTE_RETURN_IF_ERROR(readRows(points, 0, sample.row_));
    if (stride > 1) MOTE_RETURN_IF_ERROR(readStrided(points, stride, sample.row_, progress));
    std::sort(sample.row_.begin(), sample.row_.end());
    sample.taken_.assign(sample.row_.size(), 0);
    sample.chunk_.size = sample.row_.size();
    for (const auto column : sample.wanted_) {
        if (column != Column::id) sample.chunk_[column].resize(sample.row_.size());
    }
    return sample;
}

void ColumnSample::take(const ParticleChunk& chunk) {
    const auto first = std::ranges::lower_bound(row_, chunk.begin);
    const auto last = std::lower_bound(first, row_.end(), chunk.begin + chunk.size);
    for (auto it = first; it != last; ++it) {
        const auto i = static_cast<std::size_t>(it - row_.begin());
        for (const auto column : wanted_) {
            if (column != Column::id) chunk_[column][i] = chunk[column][*it - chunk.begin];
        }
        taken_[i] = 1;
    }
    const auto& weights = chunk[Column::weight];
    double least = std::numeric_limits<double>::infinity(), greatest = -least;
    for (std::size_t i = 0; i < std::min(chunk.size, weights.size()); ++i) {
        if (!takesPart(lost_, i < chunk.lost.size() && chunk.lost[i] != 0)) continue;
        least = std::min(least, weights[i]);
        greatest = std::max(greatest, weights[i]);
    }
    const std::lock_guard lock(mutex_);
    leastWeight_ = std::min(leastWeight_, least);
    greatestWeight_ = std::max(greatestWeight_, greatest);
}

Status ColumnSample::share(Communicator& ranks) {
    for (const auto column : wanted_) {
        if (column == Column::id) continue;
        std::vector<double> mine;
        for (std::size_t i = 0; i < row_.size(); ++i) {
            if (taken_[i] != 0) mine.push_back(chunk_[column][i]);
        }
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<double>(ranks, mine));
        chunk_[column].clear();
        for (const auto& part : all) {
            chunk_[column].insert(chunk_[column].end(), part.begin(), part.end());
        }
        chunk_.size = chunk_[column].size();
    }
    const std::array ends{leastWeight_, greatestWeight_};
    MOTE_ASSIGN_OR_RETURN(const auto weights, shareValues<double>(ranks, ends));
    for (const auto& part : weights) {
        leastWeight_ = std::min(leastWeight_, part[0]);
        greatestWeight_ = std::max(greatestWeight_, part[1]);
    }
    return success();
}

Result<WrittenColumns> writeColumns(const ColumnsRequest& request) {
    return Output(request).run();
}

}  // namespace mote::prep
