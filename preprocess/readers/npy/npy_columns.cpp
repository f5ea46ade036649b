// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/npy/npy_columns.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include "preprocess/readers/text/number.h"
#include "protocol/scene/utf8.h"

namespace mote::prep {
namespace {

constexpr Column unnamedOrder[] = {Column::x,  Column::y,  Column::z,     Column::px,
                                   Column::py, Column::pz, Column::weight};
constexpr std::uint64_t maxSteps = 100'000;
constexpr std::size_t vectorLength = 3;

/// How an array's elements lie: its dimensions are rows, or steps and rows, or none of both, and perhaps
/// components last.
struct Layout {
    std::optional<std::uint64_t> steps, rows;
    std::uint64_t stepStride = 0, rowStride = 0, componentStride = 0;  // bytes
};

/// Nothing where the array has another number of dimensions.
std::optional<Layout> layoutOf(const NpyHeader& header, bool components) {
    const std::size_t rank = header.shape.size();
    const std::size_t lead = rank - (components ? 1 : 0);
    if ((components && rank == 0) || lead > 2) return std::nullopt;
    std::vector<std::uint64_t> strides(rank);
    std::uint64_t stride = header.itemBytes;
    for (std::size_t i = 0; i < rank; ++i) {
        const std::size_t dimension = header.fortranOrder ? i : rank - 1 - i;
        strides[dimension] = stride;
        stride *= header.shape[dimension];  // the whole product was found to fit
    }
    Layout layout;
    if (components) layout.componentStride = strides[rank - 1];
    if (lead == 2) {
        layout.steps = header.shape[0];
        layout.stepStride = strides[0];
    }
    if (lead >= 1) {
        layout.rows = header.shape[lead - 1];
        layout.rowStride = strides[lead - 1];
    }
    return layout;
}

bool named(const NpyArray& array, std::string_view name) {
    return lower(array.name) == name;
}

/// Puts the columns together, array by array.
class Builder {
  public:
    Builder(NpyColumns& columns, const std::string& file) : columns_(columns), file_(file) {}

    Status build(double mass) {
        MOTE_RETURN_IF_ERROR(takeMass(mass));
        for (std::size_t i = 0; i < columns_.arrays.size(); ++i) MOTE_RETURN_IF_ERROR(addArray(i));
        if (columns_.items.empty()) MOTE_RETURN_IF_ERROR(addUnnamed());
        MOTE_RETURN_IF_ERROR(takeTimes());
        if (!columns_.unnamed) addRecords();
        MOTE_RETURN_IF_ERROR(checkReference());
        columns_.steps = steps_.value_or(1);
        columns_.rows = rows_.value_or(1);
        if (columns_.steps > maxSteps) {
            return unsupported(file_, "has more than 100000 steps");
        }
        if (columns_.steps == 0) return corrupt(file_, "has no step");
        return takeStepNumbers();
    }

  private:
    const NpyArray& at(std::size_t array) const { return columns_.arrays[array]; }
    const std::string& where(std::size_t array) const { return at(array).part.where; }

    const NpyArray* find(std::string_view name) const {
        for (const NpyArray& array : columns_.arrays) {
            if (named(array, name) && !array.header.structured()) return &array;
        }
        return nullptr;
    }

    static bool isNumber(const NpyArray& array) {
        return array.header.fields[0].kind != NpyField::other && array.header.fields[0].count == 1;
    }

    /// All numbers of a small array.
    Result<std::vector<double>> valuesOf(const NpyArray& array) const {
        if (!isNumber(array)) return unreadable(array.part.where);
        const std::uint64_t count = (array.part.bytes - array.header.dataOffset) / array.header.itemBytes;
        if (count > maxSteps) return corrupt(array.part.where, "has more than 100000 numbers");
        std::vector<double> values(static_cast<std::size_t>(count));
        const NpyField& type = array.header.fields[0];
        MOTE_ASSIGN_OR_RETURN(auto reader,
                              NpyReader::open(array, {type, array.header.dataOffset, type.bytes, 0}));
        MOTE_RETURN_IF_ERROR(reader.read(0, 0, true, std::span(values)));
        return values;
    }

    static Error unreadable(std::string where) {
        return {ErrorCode::unsupported, std::move(where), "holds no integers, f4 or f8"};
    }

    /// Momenta beside deviations from a reference particle are in units of its momentum, and so no eV/c.
    Status checkReference() const {
        const auto is = [&](const std::string& name) {
            for (const char* known : {"p0c", "delta", "zeta", "ptau", "pzeta"}) {
                if (name == known) return true;
            }
            return false;
        };
        bool relative = false, plain = false;
        for (const NpyArray& array : columns_.arrays) {
            relative = relative || is(array.name);
            for (const NpyField& field : array.header.fields) relative = relative || is(field.name);
        }
        for (const NpyColumns::Item& item : columns_.items)
            plain = plain || item.name == "px" || item.name == "py";
        if (!relative || !plain) return success();
        return unsupported(
            file_,
            "has momenta without a unit beside deviations from a reference particle, whose momentum "
            "is no array p0c (eV/c) of an archive; write that, or the momenta's unit");
    }

    Status takeMass(double mass) {
        columns_.mass = mass;
        const NpyArray* array = find("mass");
        if (mass > 0.0 || array == nullptr || array->header.shape.size() > 1) return success();
        if (!array->header.shape.empty() && array->header.shape[0] != 1) return success();
        MOTE_ASSIGN_OR_RETURN(const auto values, valuesOf(*array));
        if (!(values[0] > 0.0) || !std::isfinite(values[0])) {
            return corrupt(array->part.where, "is no rest mass in eV/c^2");
        }
        columns_.mass = values[0];
        return success();
    }

    Status addArray(std::size_t array) {
        if (at(array).header.structured()) return addFields(array);
        // What one number says of all the file is no column.
        if (named(at(array), "mass") || named(at(array), "iteration")) return success();
        if (named(at(array), "time") && at(array).header.shape.empty()) return success();
        const std::string& name = at(array).name;
        MOTE_ASSIGN_OR_RETURN(const auto meaning, fieldMeaning(name, columns_.mass, where(array)));
        if (meaning) return addPlain(array, *meaning);
        return named(at(array), "position") || named(at(array), "momentum") ? addVector(array) : success();
    }

    Status addPlain(std::size_t array, const FieldMeaning& meaning) {
        if (!isNumber(at(array))) return unreadable(where(array));
        const auto layout = layoutOf(at(array).header, false);
        if (!layout) {
            return unsupported(where(array),
                               "has more than two dimensions; a column is [particle] or [step, particle]");
        }
        const bool time = named(at(array), "time");
        if (time) {
            time_ = array;
            timeLayout_ = *layout;
            timeMeaning_ = meaning;
            return success();
        }
        return add(array, meaning, *layout, at(array).header.fields[0], at(array).header.dataOffset);
    }

    /// "position" and "momentum" with three numbers a row.
    Status addVector(std::size_t array) {
        const NpyHeader& header = at(array).header;
        if (header.shape.size() < 2 || header.shape.back() != vectorLength) {
            return unsupported(where(array), "has not three numbers for each particle");
        }
        const auto layout = layoutOf(header, true);
        if (!layout) {
            return unsupported(
                where(array),
                "has more than three dimensions; a vector is [particle, 3] or [step, particle, 3]");
        }
        if (!isNumber(at(array))) return unreadable(where(array));
        for (std::size_t i = 0; i < vectorLength; ++i) {
            const std::string name = at(array).name + "_" + "xyz"[i];
            MOTE_ASSIGN_OR_RETURN(const auto meaning, fieldMeaning(name, columns_.mass, where(array)));
            MOTE_RETURN_IF_ERROR(add(array, *meaning, *layout, header.fields[0],
                                     header.dataOffset + i * layout->componentStride));
        }
        return success();
    }

    /// An array of named fields. Of "position" and "momentum" with three numbers each, every number has its
    /// column.
    Status addFields(std::size_t array) {
        const NpyHeader& header = at(array).header;
        const auto layout = layoutOf(header, false);
        for (const NpyField& type : header.fields) {
            const bool vector = type.count == vectorLength;
            if (type.count != 1 && !vector) continue;
            for (std::size_t i = 0; i < type.count; ++i) {
                const std::string name = vector ? type.name + "_" + "xyz"[i] : type.name;
                const std::string place = where(array) + ", field '" + type.name + "'";
                MOTE_ASSIGN_OR_RETURN(const auto meaning, fieldMeaning(name, columns_.mass, place));
                if (!meaning) continue;
                if (type.kind == NpyField::other) return unreadable(place);
                if (!layout) {
                    return unsupported(where(array),
                                       "is an array of named fields with more than two dimensions");
                }
                NpyField one = type;
                one.count = 1;
                MOTE_RETURN_IF_ERROR(
                    add(array, *meaning, *layout, one, header.dataOffset + type.offset + i * type.bytes));
            }
        }
        return success();
    }

    /// What has a number for each particle, under a name of its own.
    void addRecords() {
        const auto add = [&](std::size_t array, const Layout& layout, const NpyField& type,
                             const std::string& name, std::uint64_t offset) {
            const auto record = recordOf(name);
            const bool fits = layout.rows == rows_ && (!layout.steps || layout.steps == steps_);
            if (!record || !fits || type.kind == NpyField::other || type.count != 1) return;
            const auto known = fieldMeaning(name, columns_.mass, "");
            if (!known.ok() || known->has_value() || columns_.findRecord(record->name) != nullptr) return;
            FieldMeaning meaning;
            meaning.kind = FieldMeaning::Kind::record;
            columns_.items.push_back(
                {meaning, array, {type, offset, layout.rowStride, layout.stepStride}, name});
        };
        for (std::size_t array = 0; array < columns_.arrays.size(); ++array) {
            const NpyHeader& header = at(array).header;
            const auto layout = layoutOf(header, false);
            const bool told =
                named(at(array), "mass") || named(at(array), "iteration") || named(at(array), "time");
            if (!layout || told) continue;
            for (const NpyField& type : header.fields)
                add(array, *layout, type, header.structured() ? type.name : at(array).name,
                    header.dataOffset + (header.structured() ? type.offset : 0));
        }
    }

    /// The only array of the file as N x 3, N x 6 or N x 7.
    Status addUnnamed() {
        const bool single = columns_.arrays.size() == 1;
        if (single && columns_.arrays[0].header.structured()) {
            return corrupt(file_, "has none of the fields x, y, z, t, px, py, pz");
        }
        std::vector<std::size_t> candidates;
        for (std::size_t i = 0; i < columns_.arrays.size(); ++i) {
            const std::size_t rank = at(i).header.shape.size();
            if (single || (!at(i).header.structured() && (rank == 2 || rank == 3))) candidates.push_back(i);
        }
        if (candidates.size() != 1) {
            return corrupt(file_, "has no array of a name x, y, z, t, px, py or pz");
        }
        const std::size_t array = candidates[0];
        const NpyHeader& header = at(array).header;
        const std::uint64_t count = header.shape.empty() ? 0 : header.shape.back();
        const auto layout = layoutOf(header, true);
        if (!layout || !layout->rows || (count != 3 && count != 6 && count != 7)) {
            return unsupported(
                where(array),
                "is an array without names whose shape is not N x 3 (x, y, z), N x 6 (and px, py, "
                "pz) or N x 7 (and weight)");
        }
        if (!isNumber(at(array))) return unreadable(where(array));
        columns_.unnamed = true;
        for (std::uint64_t i = 0; i < count; ++i) {
            FieldMeaning meaning;
            meaning.column = unnamedOrder[i];
            MOTE_RETURN_IF_ERROR(add(array, meaning, *layout, header.fields[0],
                                     header.dataOffset + i * layout->componentStride));
        }
        return success();
    }

    Status add(std::size_t array, const FieldMeaning& meaning, const Layout& layout, const NpyField& type,
               std::uint64_t offset) {
        if (meaning.kind == FieldMeaning::Kind::column && columns_.find(meaning.column) != nullptr) {
            return corrupt(where(array),
                           "has two fields of the same meaning, or means the same as another "
                           "array");
        }
        MOTE_RETURN_IF_ERROR(agree(rows_, layout.rows, where(array), "particles"));
        MOTE_RETURN_IF_ERROR(agree(steps_, layout.steps, where(array), "steps"));
        const std::string& name = type.name.empty() ? at(array).name : type.name;
        columns_.items.push_back({meaning, array, {type, offset, layout.rowStride, layout.stepStride}, name});
        return success();
    }

    static Status agree(std::optional<std::uint64_t>& all, const std::optional<std::uint64_t>& one,
                        const std::string& where, std::string_view what) {
        if (!all) all = one;
        if (!one || *one == *all) return success();
        return corrupt(where, "has " + std::to_string(*one) + " " + std::string(what) +
                                  " where another array has " + std::to_string(*all));
    }

    /// "time" is the steps' where it has one number for each of them, else a column.
    Status takeTimes() {
        if (!time_) return success();
        const std::optional<std::uint64_t> length = timeLayout_.rows;
        const bool ofSteps = steps_ ? length == steps_ : length == 1 && rows_ != 1;
        if (timeLayout_.steps || !ofSteps) {
            return add(*time_, timeMeaning_, timeLayout_, at(*time_).header.fields[0],
                       at(*time_).header.dataOffset);
        }
        timesArray_ = &at(*time_);
        return success();
    }

    Status takeStepNumbers() {
        if (timesArray_ == nullptr) {
            const NpyArray* array = find("time");
            if (array != nullptr && array->header.shape.empty()) timesArray_ = array;
        }
        if (timesArray_ != nullptr) {
            MOTE_ASSIGN_OR_RETURN(columns_.times, perStep(*timesArray_));
            for (double& time : columns_.times) time = std::isfinite(time) ? time : 0.0;
        }
        const NpyArray* array = find("iteration");
        if (array == nullptr) return success();
        MOTE_ASSIGN_OR_RETURN(const auto numbers, perStep(*array));
        for (const double number : numbers) {
            if (!(std::abs(number) <= 9007199254740992.0) || number != std::floor(number)) {
                return corrupt(array->part.where, "is no whole number");
            }
            columns_.iterations.push_back(static_cast<std::int64_t>(number));
        }
        return success();
    }

    /// One number for each step, or one for all.
    Result<std::vector<double>> perStep(const NpyArray& array) const {
        MOTE_ASSIGN_OR_RETURN(auto values, valuesOf(array));
        if (values.size() == 1) values.resize(columns_.steps, values[0]);
        if (values.size() == columns_.steps) return values;
        return corrupt(array.part.where, "has " + std::to_string(values.size()) + " numbers for " +
                                             std::to_string(columns_.steps) + " steps");
    }

    NpyColumns& columns_;
    const std::string& file_;
    std::optional<std::uint64_t> steps_, rows_;
    std::optional<std::size_t> time_;
    Layout timeLayout_;
    FieldMeaning timeMeaning_;
    const NpyArray* timesArray_ = nullptr;
};

}  // namespace

const NpyColumns::Item* NpyColumns::find(Column column) const {
    for (const Item& item : items) {
        if (item.meaning.kind == FieldMeaning::Kind::column && item.meaning.column == column) return &item;
    }
    return nullptr;
}

const NpyColumns::Item* NpyColumns::findRecord(std::string_view name) const {
    for (const Item& item : items) {
        if (item.meaning.kind == FieldMeaning::Kind::record && recordOf(item.name)->name == name)
            return &item;
    }
    return nullptr;
}

Result<NpyColumns> NpyColumns::of(std::vector<NpyArray> arrays, double mass, const std::string& file) {
    NpyColumns columns;
    columns.arrays = std::move(arrays);
    MOTE_RETURN_IF_ERROR(Builder(columns, file).build(mass));
    return columns;
}

}  // namespace mote::prep
