// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/table/held_source.h"

#include <algorithm>
#include <set>

#include "preprocess/readers/file_number.h"
#include "preprocess/readers/text/byte_source.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxTextBytes = std::size_t{1} << 30;
constexpr std::size_t pieceBytes = std::size_t{1} << 20;
constexpr double maxId = 18446744073709551616.0;

class HeldSource : public ParticleSource {
  public:
    HeldSource(std::string format, double mass) : format_(std::move(format)), mass_(mass) {}

    Status add(HeldTable table, std::set<std::string>& notes);

    std::string format() const override { return format_; }
    const std::vector<SourceStep>& steps() const override { return steps_; }
    bool has(Column column) const override {
        return std::all_of(columns_.begin(), columns_.end(),
                           [&](const TableColumns& columns) { return columns.has(column); });
    }
    double mass() const override { return columns_.front().mass(); }
    std::string species() const override { return columns_.front().species(); }
    double particleCharge() const override { return columns_.front().charge(); }
    std::string weightUnit() const override {
        const std::string& unit = columns_.front().weightUnit();
        const bool same = std::all_of(columns_.begin(), columns_.end(), [&](const TableColumns& columns) {
            return columns.weightUnit() == unit;
        });
        return same ? unit : "";
    }
    Status read(std::size_t step, std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk) override;

  private:
    void readIds(std::size_t step, ParticleChunk& chunk) const;

    std::string format_;
    double mass_;
    std::vector<SourceStep> steps_;
    std::vector<TableColumns> columns_;
    std::vector<HeldTable> tables_;
};

Status HeldSource::add(HeldTable table, std::set<std::string>& notes) {
    std::vector<TableField> fields;
    for (std::size_t i = 0; i < table.names.size(); ++i) fields.push_back({i, table.names[i]});
    const std::size_t rows = table.values.empty() ? 0 : table.values.front().size();
    for (std::size_t i = 0; i < table.values.size(); ++i) {
        if (table.values[i].size() == rows) continue;
        return Error{ErrorCode::corrupt, table.where,
                     "has " + std::to_string(table.values[i].size()) + " values of '" + table.names[i] +
                         "' and " + std::to_string(rows) + " of '" + table.names[0] + "'"};
    }
    MOTE_ASSIGN_OR_RETURN(auto columns, TableColumns::of(fields, table.constants, mass_, table.where));
    if (const auto field = columns.massField(); field && rows > 0) columns.setMass(table.values[*field][0]);
    if (const auto field = columns.chargeField(); field && rows > 0)
        columns.setCharge(table.values[*field][0]);
    notes.insert(table.notes.begin(), table.notes.end());
    notes.insert(columns.notes().begin(), columns.notes().end());
    steps_.push_back(
        {table.where, table.iteration.value_or(static_cast<std::int64_t>(steps_.size())), table.time, rows});
    columns_.push_back(std::move(columns));
    tables_.push_back(std::move(table));
    return success();
}

void HeldSource::readIds(std::size_t step, ParticleChunk& chunk) const {
    const auto field = columns_[step].idField();
    chunk.id.resize(chunk.size);
    for (std::size_t i = 0; i < chunk.size; ++i) {
        const double id = field ? tables_[step].values[*field][chunk.begin + i] : -1.0;
        const bool valid = id >= 0.0 && id < maxId;
        chunk.id[i] = valid ? static_cast<std::uint64_t>(id) : chunk.begin + i;
    }
}

Status HeldSource::read(std::size_t step, std::uint64_t begin, std::size_t count,
                        const std::vector<Column>& wanted, ParticleChunk& chunk) {
    MOTE_RETURN_IF_ERROR(checkRange(steps_, step, begin, count));
    const TableColumns& columns = columns_[step];
    chunk.begin = begin;
    chunk.size = count;
    for (const Column column : wanted) {
        if (column == Column::id) {
            readIds(step, chunk);
        } else if (!columns.has(column) && column != Column::weight) {
            return Error{ErrorCode::invalidArgument, steps_[step].file,
                         "has not all columns that were asked for"};
        }
    }
    TableColumns::Values values;
    for (const auto& column : tables_[step].values) values.push_back(column.data() + begin);
    columns.fill(wanted, values, chunk);
    return success();
}

}  // namespace

Status HeldNumbers::add(std::uint64_t numbers, const std::string& where) {
    count_ += std::min(numbers, most + 1);
    if (count_ <= most) return success();
    return Error{ErrorCode::resourceExhausted, where,
                 "holds more than 1 GiB of numbers, in a format that is read whole; write openPMD or .npz"};
}

Result<std::string> readText(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(path));
    std::string text;
    for (;;) {
        const std::size_t size = text.size();
        if (size > maxTextBytes) {
            return Error{ErrorCode::resourceExhausted, source->name(),
                         "is longer than 1 GiB, in a format that is read whole; write openPMD or .npz"};
        }
        text.resize(size + pieceBytes);
        MOTE_ASSIGN_OR_RETURN(const auto got, source->read({text.data() + size, pieceBytes}));
        text.resize(size + got);
        if (got == 0) return text;
    }
}

Result<std::unique_ptr<ParticleSource>> holdTables(std::string format, std::vector<HeldTable> tables,
                                                   double mass, Progress& progress) {
    if (tables.empty()) return Error{ErrorCode::notFound, format, "holds no table of particles"};
    const bool numbered =
        std::all_of(tables.begin(), tables.end(), [](const HeldTable& table) { return table.iteration; });
    if (numbered) {
        std::stable_sort(tables.begin(), tables.end(),
                         [](const HeldTable& a, const HeldTable& b) { return *a.iteration < *b.iteration; });
    }
    auto source = std::make_unique<HeldSource>(std::move(format), mass);
    std::set<std::string> notes;
    for (HeldTable& table : tables) MOTE_RETURN_IF_ERROR(source->add(std::move(table), notes));
    for (const std::string& note : notes) progress.note(note);
    return std::unique_ptr<ParticleSource>(std::move(source));
}

}  // namespace mote::prep
