// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/column_output.h"

#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <set>
#include <type_traits>
#include <utility>

#include "preprocess/on_threads.h"
#include "preprocess/particles/id_index.h"
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
// Columns whose values of a row lie together: with them a row takes no more memory than its particle did,
// whose pages are there. More of them take fresh ones, which cost more than to look for a row once more.
constexpr std::size_t mostTogether = 4;

constexpr std::size_t rowsInCache = 1024;  // of records whose columns come one after another
constexpr std::size_t recordsAhead = 32;

/// Points whose values are gathered at once: a thread's memory.
template <class T>
struct Part {
    std::vector<std::uint64_t> rows;
    std::vector<T> values;  ///< column after column
    std::vector<std::uint64_t> ids;
};

/// Columns that are read and written together.
struct Group {
    std::size_t first = 0, count = 0;
    bool doubles = false;
    bool withIds = false;  ///< which go with them as long as all fit 32 bits

    std::size_t values() const { return count + (withIds ? 1 : 0); }
    /// Values from one row to the next: such that no row lies in two lines of the cache.
    std::size_t stride() const { return std::bit_ceil(values()); }
    std::vector<std::size_t> arrays() const {
        std::vector<std::size_t> arrays(count);
        std::iota(arrays.begin(), arrays.end(), first);
        return arrays;
    }
};

/// Values of a group as they are gathered. Ids are behind them, their 32 bits as those of a float.
template <class T>
struct Records {
    std::span<const T> values;
    std::uint64_t begin, end;  ///< rows
    std::size_t stride;        ///< values from one row to the next
    std::vector<std::size_t> arrays;
    bool withIds = false;

    std::size_t columns() const { return arrays.size() + (withIds ? 1 : 0); }
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
        MOTE_RETURN_IF_ERROR(workMeanwhile());
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
    /// What is asked for, while the file is written and hashed as far as it goes by itself.
    Status workMeanwhile() {
        if (ranks_.first()) {
            request_.writeback->begin(request_.directory / (request_.name + ".h5"));
            if (request_.kept->ids) file_->complete(idArrays().index);
        }
        return request_.meanwhile ? request_.meanwhile() : success();
    }

    Status finish(WrittenColumns& written) {
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
        if (file_ && (!alone() || tbb::this_task_arena::max_concurrency() > 1)) file_->writeTogether();
        if (file_ && alone()) {
            file_->hashAhead([this] { return request_.progress->cancelled(); },
                             [this](auto array, auto at, auto bytes) { return readHeld(array, at, bytes); });
        }
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
        const std::size_t count =
            std::clamp<std::size_t>(std::min(std::bit_floor(held), even), 1, mostTogether);
        std::vector<Group> groups;
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            const bool doubles = codings_[i].doubles;
            const std::size_t most = doubles ? std::max<std::size_t>(1, count / 2) : count;
            const bool joins =
                !groups.empty() && groups.back().doubles == doubles && groups.back().count < most;
            if (!joins) groups.push_back({i, 0, doubles});
            ++groups.back().count;
        }
        if (request_.kept->ids && alone() && !groups.empty() && !groups.back().doubles) {
            auto& last = groups.back();
            last.withIds =
                last.count < count && rowsFor(sizeof(float) * std::bit_ceil(last.count + 1)) >= rows_;
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
        if (request_.kept->ids && !idsWritten_ && rank == parts.size() % size) return writeIds();
        return success();
    }

    template <class T>
    Status writeGroup(const Group& group) {
        std::set<Column> wanted;
        if (group.withIds) wanted.insert(Column::id);
        for (std::size_t i = 0; i < group.count; ++i) {
            const auto sources = columns_[group.first + i].sources();
            wanted.insert(sources.begin(), sources.end());
        }
        const std::size_t stride = group.stride();
        const auto fill = [&](std::uint64_t begin, RecordStore& store) {
            return [this, &group, &store, begin, stride](const ParticleChunk& chunk) {
                const auto records = store.room<T>((chunk.begin - begin) * stride, chunk.size * stride);
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
                            records[k * stride + i] = static_cast<T>(values[i][k] - offset);
                    }
                    for (std::size_t k = first; k < last && group.withIds; ++k)
                        records[k * stride + group.count] = shortId<T>(chunk.id[k]);
                }
                if (group.withIds) addIds(chunk);
            };
        };
        return moveRows<T>({wanted.begin(), wanted.end()}, group, fill);
    }

    /// The last 32 bits of an id, as those of a float.
    template <class T>
    static T shortId(std::uint64_t id) {
        if constexpr (std::is_same_v<T, float>)
            return std::bit_cast<float>(static_cast<std::uint32_t>(id));
        else
            return {};
    }

    bool alone() const { return ranks_.size() == 1; }

    void addIds(const ParticleChunk& chunk) {
        IdRange part;
        part.add(std::span(chunk.id).first(chunk.size));
        const std::lock_guard lock(extentMutex_);
        idRange_.add(part);
    }

    Status writeIds() {
        idRange_ = {};
        const auto fill = [this](std::uint64_t begin, RecordStore& store) {
            return [this, &store, begin](const ParticleChunk& chunk) {
                std::ranges::copy(std::span(chunk.id).first(chunk.size),
                                  store.room<std::uint64_t>(chunk.begin - begin, chunk.size).begin());
                addIds(chunk);
            };
        };
        return moveRows<std::uint64_t>({Column::id}, {columns_.size(), 1}, fill);
    }

    /// Reads records of a group by the chunks that `fill` takes, and writes them in the order of the points.
    template <class T, class Fill>
    Status moveRows(const std::vector<Column>& wanted, const Group& group, const Fill& fill) {
        const std::uint64_t recordBytes = sizeof(T) * group.stride();
        const std::uint64_t together = rowsFor(recordBytes);
        MOTE_ASSIGN_OR_RETURN(
            auto store, RecordStore::inMemory(std::min(together, rows_) * recordBytes, request_.stores));
        std::vector<T> unused;
        for (std::uint64_t begin = 0; begin < rows_; begin += together) {
            const std::uint64_t end = std::min(rows_, begin + together);
            MOTE_RETURN_IF_ERROR(forEachChunk(*request_.source, request_.step, begin, end, wanted,
                                              *request_.progress, fill(begin, store)));
            MOTE_ASSIGN_OR_RETURN(const auto values,
                                  store.read<T>(0, (end - begin) * group.stride(), unused));
            Records<T> records{values, begin, end, group.stride(), group.arrays(), false};
            records.withIds = group.withIds && idRange_.greatest <= std::numeric_limits<std::uint32_t>::max();
            const bool ids = records.withIds || std::is_same_v<T, std::uint64_t>;
            if (ids && end - begin == rows_) MOTE_RETURN_IF_ERROR(makeIdTable(rows_ * recordBytes));
            // The last group's: nobody asks for a point's row after its own values.
            idsHeld_ = records.withIds && !request_.heldRows.empty();
            MOTE_RETURN_IF_ERROR(gather(records));
            if (ids) MOTE_RETURN_IF_ERROR(finishIds(end));
            if (end == rows_) request_.writeback->begin(request_.directory / (request_.name + ".h5"));
        }
        for (const auto array : group.arrays()) file_->complete(array);
        return success();
    }

    /// Where all are moved at once, ids go to their places in the index on the way to their points. `held`:
    /// bytes of memory that their records take.
    Status makeIdTable(std::uint64_t held) {
        const std::uint64_t most = request_.memory / 4 * 3;
        if (!alone() || held > most) return success();
        MOTE_ASSIGN_OR_RETURN(idTable_,
                              IdTable::make(idRange_, request_.pointCount, most - held, request_.stores));
        return success();
    }

    Status finishIds(std::uint64_t end) {
        if (end < rows_) return success();
        idsWritten_ = true;
        file_->complete(columns_.size());
        if (!idTable_) return success();
        MOTE_ASSIGN_OR_RETURN(indexed_, idTable_->write(*file_, idArrays(), *request_.progress));
        if (!indexed_) idTable_.reset();
        return success();
    }

    /// Ids and their index, where they are in memory. Hashing them need not wait for the disk.
    bool readHeld(std::size_t array, std::uint64_t at, std::span<std::byte> bytes) const {
        const auto arrays = idArrays();
        const bool ids = array == arrays.ids && idsHeld_, index = array == arrays.index && indexed_;
        if (index) idTable_->read(at, bytes);
        if (ids) {
            const auto held = request_.heldRows.subspan(at / sizeof(std::uint64_t));
            for (std::size_t i = 0; i < bytes.size() / sizeof(std::uint64_t); ++i) {
                const std::uint64_t id = held[i];
                std::memcpy(bytes.data() + i * sizeof id, &id, sizeof id);
            }
        }
        return ids || index;
    }

    template <class T>
    Status gather(const Records<T>& records) {
        const std::uint64_t parts = (request_.pointCount + pointsAtOnce - 1) / pointsAtOnce;
        tbb::enumerable_thread_specific<Part<T>> buffers;
        return inParallel(parts, [&](std::uint64_t part) -> Status {
            if (request_.progress->cancelled()) return wasCancelled();
            return gatherPart(records, part * pointsAtOnce, buffers.local());
        });
    }

    /// Points of other ranges of rows keep what an earlier range gave them.
    template <class T>
    Status gatherPart(const Records<T>& records, std::uint64_t first, Part<T>& part) {
        const auto count = static_cast<std::size_t>(std::min(pointsAtOnce, request_.pointCount - first));
        const auto& arrays = records.arrays;
        const bool whole = records.end - records.begin == rows_;
        auto& [rows, values, ids] = part;
        rows.resize(count);
        values.resize(count * records.columns());
        MOTE_RETURN_IF_ERROR(readRows(*request_.points, first, rows));
        for (std::size_t i = 0; i < arrays.size() && !whole; ++i) {
            MOTE_RETURN_IF_ERROR(
                file_->read(arrays[i], first * sizeof(T),
                            std::as_writable_bytes(std::span(values).subspan(i * count, count))));
        }
        pick<T>(records, rows, values);
        for (std::size_t i = 0; i < arrays.size(); ++i) {
            const auto mine = std::span<const T>(values).subspan(i * count, count);
            MOTE_RETURN_IF_ERROR(file_->write(arrays[i], first * sizeof(T), std::as_bytes(mine)));
            if constexpr (std::is_floating_point_v<T>) {
                if (records.end == rows_) addExtent(arrays[i], mine);
            } else {
                if (idTable_) idTable_->add(first, mine);
            }
        }
        if constexpr (std::is_same_v<T, float>) {
            if (!records.withIds) return success();
            ids.resize(count);
            for (std::size_t k = 0; k < count; ++k)
                ids[k] = std::bit_cast<std::uint32_t>(values[arrays.size() * count + k]);
            if (idTable_) idTable_->add(first, ids);
            for (std::size_t k = 0; k < count && idsHeld_; ++k)
                request_.heldRows[first + k] = static_cast<std::uint32_t>(ids[k]);
            return file_->write(columns_.size(), first * sizeof(std::uint64_t),
                                std::as_bytes(std::span(ids)));
        }
        return success();
    }

    /// Values of `rows`, column after column; those that the records do not have stay.
    template <class T>
    static void pick(const Records<T>& records, std::span<const std::uint64_t> rows, std::span<T> values) {
        const std::size_t columns = records.columns();
        const auto holds = [&](std::uint64_t row) { return row >= records.begin && row < records.end; };
        const auto recordOf = [&](std::uint64_t row) {
            return records.values.data() + (row - records.begin) * records.stride;
        };
        for (std::size_t k = 0; k < rows.size(); ++k) {
            // Each record is somewhere else: many are asked for before the first one comes.
            const auto later = rows[std::min(k + recordsAhead, rows.size() - 1)];
            if (holds(later)) __builtin_prefetch(recordOf(later));
            if (!holds(rows[k])) continue;
            const T* const record = recordOf(rows[k]);
            for (std::size_t i = 0; i < columns; ++i) values[i * rows.size() + k] = record[i];
        }
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

    Status writeIndex() {
        return writeIdIndex(*file_, idArrays(), request_.memory / 4 * 3, request_.stores, *request_.progress);
    }

    IdArrays idArrays() const { return {columns_.size(), columns_.size() + 1, request_.pointCount}; }

    const ColumnsRequest& request_;
    const std::vector<KeptColumn>& columns_;
    Communicator& ranks_;
    const std::uint64_t rows_;
    std::vector<ColumnCoding> codings_;
    std::mutex extentMutex_;
    std::vector<Extent> extents_;  ///< under it while parts are gathered
    IdRange idRange_;              ///< of the rows that were read, under the mutex above
    bool idsWritten_ = false;
    bool idsHeld_ = false;            ///< in the place of rows
    std::optional<IdTable> idTable_;  ///< while ids are gathered, and as the index
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
