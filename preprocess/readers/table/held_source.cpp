// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/table/held_source.h"

#include <algorithm>

#include "preprocess/readers/text/byte_source.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxTextBytes = std::size_t{1} << 30;
constexpr double maxId = 18446744073709551616.0;

class HeldFiles : public HeldSource {
  public:
    HeldFiles(std::string format, TablesOfFile tablesOf, const AskedRun& run, Progress& progress)
        : HeldSource(std::move(format), run.mass, progress),
          tablesOf_(std::move(tablesOf)),
          several_(run.files.size() > 1) {}

  protected:
    Status addFile(const std::filesystem::path& path) override {
        MOTE_ASSIGN_OR_RETURN(auto tables, tablesOf_(fileAt(path)));
        if (several_ && tables.size() == 1) tables.front().iteration = fileNumber(path);
        for (HeldTable& table : tables) tables_.push_back(std::move(table));
        return success();
    }

  private:
    TablesOfFile tablesOf_;
    bool several_;
};

}  // namespace

void HeldTable::addUnknown(const std::string& name, std::vector<double> column) {
    const auto meaning = tableMeaning(name, "");
    const bool known = !meaning || meaning->has_value();
    const std::size_t rows = values.empty() ? 0 : values.front().size();
    if (!known && column.size() == rows) add(name, std::move(column));
}

double HeldTable::setMass(double mass, const std::string& who) {
    if (!(mass > 0.0)) {
        mass = electronMass;
        notes.push_back(who + " no mass: the particles are taken for electrons");
    }
    constants.push_back({TableQuantity::mass, mass});
    return mass;
}

Status HeldNumbers::add(std::uint64_t numbers, const std::string& where) {
    count_ += std::min(numbers, most + 1);
    if (count_ <= most) return success();
    return Error{ErrorCode::resourceExhausted, where,
                 "holds more than 1 GiB of numbers, in a format that is read whole; write openPMD or .npz"};
}

Result<std::string> HeldFile::text() const {
    return wholeFile(path, maxTextBytes,
                     "is longer than 1 GiB, in a format that is read whole; write openPMD or .npz", progress);
}

Status HeldSource::finish() {
    if (tables_.empty()) return notFound(format(), "holds no table of particles");
    const bool numbered =
        std::all_of(tables_.begin(), tables_.end(), [](const HeldTable& table) { return table.iteration; });
    if (numbered) {
        std::stable_sort(tables_.begin(), tables_.end(),
                         [](const HeldTable& a, const HeldTable& b) { return *a.iteration < *b.iteration; });
    } else {
        for (HeldTable& table : tables_)
            table.iteration.reset();  // some numbers and some places may be equal
    }
    std::set<std::string> notes;
    for (const HeldTable& table : tables_) MOTE_RETURN_IF_ERROR(addTable(table, notes));
    for (const std::string& note : notes) progress_.note(note);
    return success();
}

Status HeldSource::addTable(const HeldTable& table, std::set<std::string>& notes) {
    std::vector<TableField> fields;
    for (std::size_t i = 0; i < table.names.size(); ++i) fields.push_back({i, table.names[i]});
    const std::size_t rows = table.values.empty() ? 0 : table.values.front().size();
    for (std::size_t i = 0; i < table.values.size(); ++i) {
        if (table.values[i].size() == rows) continue;
        return corrupt(table.where, "has " + std::to_string(table.values[i].size()) + " values of '" +
                                        table.names[i] + "' and " + std::to_string(rows) + " of '" +
                                        table.names[0] + "'");
    }
    MOTE_ASSIGN_OR_RETURN(auto columns, TableColumns::of(fields, table.constants, wantedMass_, table.where));
    if (const auto field = columns.massField(); field && rows > 0) columns.setMass(table.values[*field][0]);
    if (const auto field = columns.chargeField(); field && rows > 0)
        columns.setCharge(table.values[*field][0]);
    columns.addRecords(table.names);
    notes.insert(table.notes.begin(), table.notes.end());
    notes.insert(columns.notes().begin(), columns.notes().end());
    steps_.push_back(
        {table.where, table.iteration.value_or(static_cast<std::int64_t>(steps_.size())), table.time, rows});
    columns_.push_back(std::move(columns));
    return success();
}

void HeldSource::readIds(std::size_t step, ParticleChunk& chunk) const {
    const auto field = columns_[step].idField();
    for (std::size_t i = 0; field && i < chunk.size; ++i) {
        const double id = tables_[step].values[*field][chunk.begin + i];
        if (id >= 0.0 && id < maxId) chunk.id[i] = static_cast<std::uint64_t>(id);
    }
}

Status HeldSource::readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) {
    if (std::find(wanted.begin(), wanted.end(), Column::id) != wanted.end()) readIds(step, chunk);
    TableColumns::Values values;
    for (const auto& column : tables_[step].values) values.push_back(column.data() + chunk.begin);
    columns_[step].fill(wanted, values, chunk);
    for (const Column column : wanted) {
        if (isRecord(column))
            std::copy_n(values[recordField(step, column)], chunk.size, chunk[column].data());
    }
    return success();
}

Result<std::unique_ptr<ParticleSource>> openHeld(std::string format, TablesOfFile tablesOf,
                                                 const AskedRun& run, Progress& progress) {
    return openSeries(std::make_unique<HeldFiles>(std::move(format), std::move(tablesOf), run, progress),
                      inOrder(run.files));
}

Result<std::unique_ptr<ParticleSource>> openHeld(std::string format,
                                                 Result<HeldTable> (*tableOf)(const HeldFile& file),
                                                 const AskedRun& run, Progress& progress) {
    const auto tablesOf = [tableOf](const HeldFile& file) -> Result<std::vector<HeldTable>> {
        MOTE_ASSIGN_OR_RETURN(auto table, tableOf(file));
        std::vector<HeldTable> tables;
        tables.push_back(std::move(table));
        return tables;
    };
    return openHeld(std::move(format), tablesOf, run, progress);
}

}  // namespace mote::prep
