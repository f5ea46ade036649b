// SPDX-License-Identifier: GPL-3.0-or-later
//
// TableSource: runs whose steps are tables of named columns (TableColumns), however their rows are read.
// Owned as SeriesSource says; one thread.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "preprocess/readers/series_source.h"
#include "preprocess/readers/table/table_columns.h"

namespace mote::prep {

class TableSource : public SeriesSource {
  public:
    double mass() const override { return columns_.front().mass(); }
    std::string species() const override { return columns_.front().species(); }
    double particleCharge() const override { return columns_.front().charge(); }
    std::string weightUnit() const override {
        const std::string& unit = columns_.front().weightUnit();
        return all([&](const TableColumns& columns) { return columns.weightUnit() == unit; }) ? unit : "";
    }

  protected:
    using SeriesSource::SeriesSource;

    bool hasEverywhere(Column column) const override {
        return all([&](const TableColumns& columns) { return columns.has(column); });
    }

    std::vector<SourceRecord> recordsEverywhere() const override {
        auto records = columns_.front().records();
        std::erase_if(records, [&](const SourceRecord& record) {
            return !all([&](const TableColumns& columns) {
                return std::ranges::count(columns.records(), record.name, &SourceRecord::name) > 0;
            });
        });
        return records;
    }
    /// The field of a step's table that holds a record of the run.
    std::size_t recordField(std::size_t step, Column record) const {
        return columns_[step].recordField(recordName(record));
    }

    std::vector<TableColumns> columns_;  ///< by step

  private:
    template <class Condition>
    bool all(Condition condition) const {
        return std::all_of(columns_.begin(), columns_.end(), condition);
    }
};

}  // namespace mote::prep
