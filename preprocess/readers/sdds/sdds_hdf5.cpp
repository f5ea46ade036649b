// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "preprocess/readers/hdf5/h5_attribute.h"
#include "preprocess/readers/hdf5/h5_column.h"
#include "preprocess/readers/openpmd/layout.h"
#include "preprocess/readers/sdds/sdds_pages.h"

namespace mote::prep {
namespace {

constexpr std::string_view pagePattern = "page%T";
constexpr const char* firstColumns = "/page1/columns";

/// A column or parameter as its dataset says it: a name, a unit, and whether it holds numbers.
Result<SddsField> fieldOf(const H5File& file, const H5Object& group, const std::string& name) {
    SddsField field;
    field.name = name;
    MOTE_ASSIGN_OR_RETURN(auto dataset, file.require(group, name));
    MOTE_ASSIGN_OR_RETURN(auto units, textAttribute(dataset, "units"));
    field.units = units.value_or("");
    const auto column = H5Column::open(file, std::move(dataset));
    if (!column && column.error().code != ErrorCode::unsupported) return column.error();
    field.type = column ? SddsType::float64 : SddsType::string;
    return field;
}

Status addFields(const H5File& file, const char* path, std::vector<SddsField>& fields) {
    MOTE_ASSIGN_OR_RETURN(const auto group, file.find(file.root(), path));
    if (!group || !group->group) return success();
    MOTE_ASSIGN_OR_RETURN(const auto names, file.children(*group));
    for (const std::string& name : names) {
        MOTE_ASSIGN_OR_RETURN(auto field, fieldOf(file, *group, name));
        fields.push_back(std::move(field));
    }
    return success();
}

class Hdf5Pages : public SddsPages {
  public:
    Hdf5Pages(std::filesystem::path path, const SddsHeader& header)
        : path_(std::move(path)), header_(header) {}

    Status find(Progress& progress) {
        MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path_));
        MOTE_ASSIGN_OR_RETURN(const auto names, file.children(file.root()));
        for (const std::string& name : names) {
            const auto number = matchIteration(pagePattern, name);
            if (number) numbers_.push_back(*number);
        }
        std::sort(numbers_.begin(), numbers_.end());
        if (numbers_.size() > maxSddsPages) {
            return Error{ErrorCode::resourceExhausted, file.name(), "has more than 100000 pages"};
        }
        for (std::size_t i = 0; i < numbers_.size(); ++i) {
            if (progress.cancelled())
                return Error{ErrorCode::cancelled, "", "cancelled while a run was opened"};
            MOTE_RETURN_IF_ERROR(addPage(file, i));
        }
        return success();
    }

    Status read(std::size_t page, std::uint64_t begin, std::size_t count,
                const std::vector<std::size_t>& columns, std::optional<std::size_t> idColumn,
                SddsRows& rows) override {
        rows.columns.resize(columns.size());
        for (std::size_t i = 0; i < columns.size(); ++i) {
            MOTE_ASSIGN_OR_RETURN(const auto column, open(page, columns[i]));
            rows.columns[i].resize(count);
            MOTE_RETURN_IF_ERROR(column->read(begin, count, rows.columns[i].data()));
        }
        if (!idColumn) return success();
        MOTE_ASSIGN_OR_RETURN(const auto column, open(page, *idColumn));
        rows.ids.resize(count);
        return column->read(begin, count, rows.ids.data());
    }

  private:
    std::string group(std::size_t page, const char* name) const {
        return "/page" + std::to_string(numbers_[page]) + "/" + name;
    }

    Status addPage(const H5File& file, std::size_t index) {
        MOTE_ASSIGN_OR_RETURN(const auto columns, file.require(file.root(), group(index, "columns")));
        SddsPage page;
        std::optional<std::uint64_t> rows;
        for (const SddsField& field : header_.columns) {
            if (!field.number()) continue;
            MOTE_ASSIGN_OR_RETURN(auto dataset, file.require(columns, field.name));
            const std::string where = dataset.where;
            MOTE_ASSIGN_OR_RETURN(const auto column, H5Column::open(file, std::move(dataset)));
            if (!rows) rows = column.rows();
            if (column.rows() == *rows) continue;
            return corrupt(where, "has " + std::to_string(column.rows()) +
                                      " values where other columns have " + std::to_string(*rows));
        }
        page.rows = rows.value_or(0);
        MOTE_RETURN_IF_ERROR(readParameters(file, index, page.parameters));
        pages_.push_back(page);
        return success();
    }

    Status readParameters(const H5File& file, std::size_t index, SddsParameters& values) {
        MOTE_ASSIGN_OR_RETURN(const auto group, file.find(file.root(), this->group(index, "parameters")));
        if (!group || !group->group) return success();
        for (std::size_t i = 0; i < values.size(); ++i) {
            MOTE_ASSIGN_OR_RETURN(auto dataset, file.find(*group, sddsParameterNames[i]));
            if (!dataset || dataset->group) continue;
            const auto column = H5Column::open(file, std::move(*dataset));
            if (!column || column->rows() == 0) continue;  // a text: no number of ours
            MOTE_RETURN_IF_ERROR(column->read(0, 1, &values[i]));
        }
        return success();
    }

    /// The column of a page; those of the page that was read last stay open.
    Result<const H5Column*> open(std::size_t page, std::size_t index) {
        if (page != openPage_) open_.clear();
        openPage_ = page;
        open_.resize(header_.columns.size());
        if (!open_[index]) {
            MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path_));
            MOTE_ASSIGN_OR_RETURN(const auto columns, file.require(file.root(), group(page, "columns")));
            MOTE_ASSIGN_OR_RETURN(auto dataset, file.require(columns, header_.columns[index].name));
            MOTE_ASSIGN_OR_RETURN(open_[index], H5Column::open(file, std::move(dataset)));
        }
        return &*open_[index];
    }

    std::filesystem::path path_;
    SddsHeader header_;
    std::vector<std::int64_t> numbers_;  // of the pages, as in their names
    std::size_t openPage_ = 0;
    std::vector<std::optional<H5Column>> open_;
};

}  // namespace

bool looksLikeSddsHdf5(const H5File& file) {
    const auto columns = file.find(file.root(), firstColumns);
    return columns && *columns && (*columns)->group;
}

Result<SddsHeader> readSddsHdf5Header(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path));
    if (!looksLikeSddsHdf5(file)) {
        return corrupt(file.name(), "has no group /page1/columns, as sdds2hdf writes it");
    }
    SddsHeader header;
    MOTE_RETURN_IF_ERROR(addFields(file, firstColumns, header.columns));
    MOTE_RETURN_IF_ERROR(addFields(file, "/page1/parameters", header.parameters));
    return header;
}

Result<std::unique_ptr<SddsPages>> openSddsHdf5(const std::filesystem::path& path, const SddsHeader& header,
                                                Progress& progress) {
    auto pages = std::make_unique<Hdf5Pages>(path, header);
    MOTE_RETURN_IF_ERROR(pages->find(progress));
    return std::unique_ptr<SddsPages>(std::move(pages));
}

}  // namespace mote::prep
