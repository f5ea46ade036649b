// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/npy/npy_array.h"
#include "preprocess/readers/npy/zip_directory.h"
#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/particle_source.h"
#include "preprocess/readers/series_source.h"
#include "preprocess/readers/table/held_source.h"
#include "preprocess/readers/table/table_quantity.h"
#include "preprocess/readers/text/number.h"
#include "protocol/base/error.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

// Archives of NumPy arrays as tables: those in units of p0c, and Ocelot's particle arrays: rparticles (x,
// px/p0, y, py/p0, tau, (E - E0) / (p0 c)), q_array (C), E (GeV), s.
constexpr std::uint64_t components = 6;
constexpr const char* componentNames[components] = {"x [m]",   "px [p0]",  "y [m]",
                                                    "py [p0]", "late [m]", "ptau"};

const NpyArray* arrayNamed(const std::vector<NpyArray>& arrays, std::string_view name) {
    for (const NpyArray& array : arrays) {
        if (array.name == name && !array.header.structured()) return &array;
    }
    return nullptr;
}

/// The numbers of one row of an array [row, column], or of a plain list where `row` is 0.
Result<std::vector<double>> rowOf(const NpyArray& array, std::uint64_t row, std::uint64_t columns,
                                  HeldNumbers& held) {
    const NpyHeader& header = array.header;
    if (header.fields[0].kind == NpyField::other || header.fields[0].count != 1)
        return unsupported(array.part.where, "holds no integers, f4 or f8");
    MOTE_RETURN_IF_ERROR(held.add(columns, array.part.where));
    const bool turned = header.fortranOrder && header.shape.size() == 2;
    const std::uint64_t step = turned ? header.itemBytes : header.itemBytes * columns;
    const std::uint64_t stride = turned ? header.itemBytes * components : header.itemBytes;
    std::vector<double> values(static_cast<std::size_t>(columns));
    MOTE_ASSIGN_OR_RETURN(auto reader,
                          NpyReader::open(array, {header.fields[0], header.dataOffset, stride, step}));
    const bool last = turned || row + 1 == components || header.shape.size() < 2;
    MOTE_RETURN_IF_ERROR(reader.read(row, 0, last && row + 1 >= header.shape.size(), std::span(values)));
    return values;
}

Result<HeldTable> tableOfScaledNpz(const HeldFile& file) {
    MOTE_ASSIGN_OR_RETURN(const auto arrays, openNpyArrays(file.path));
    HeldTable table;
    table.where = file.name();
    for (const NpyArray& array : arrays) {
        const NpyHeader& header = array.header;
        MOTE_ASSIGN_OR_RETURN(const auto meaning, tableMeaning(array.name, array.part.where));
        const bool numbers = !header.structured() && header.fields[0].kind != NpyField::other &&
                             header.fields[0].count == 1 && header.shape.size() < 2;
        if (!meaning || !numbers) continue;
        const bool list = !header.shape.empty();
        MOTE_ASSIGN_OR_RETURN(auto values, rowOf(array, 0, list ? header.shape[0] : 1, file.held));
        if (list)
            table.add(array.name, std::move(values));
        else
            table.constants.push_back({meaning->quantity, values[0] * meaning->factor});
    }
    return table;
}

Result<HeldTable> tableOfOcelot(const HeldFile& file) {
    MOTE_ASSIGN_OR_RETURN(const auto arrays, openNpyArrays(file.path));
    const NpyArray* particles = arrayNamed(arrays, "rparticles");
    const NpyArray* energy = arrayNamed(arrays, "E");
    if (particles == nullptr || energy == nullptr)
        return unsupported(file.name(), "has no arrays rparticles and E, as Ocelot writes them");
    const auto& shape = particles->header.shape;
    if (shape.size() != 2 || shape[0] != components)
        return unsupported(particles->part.where, "is not of shape 6 x N");
    HeldTable table;
    table.where = file.name();
    for (std::uint64_t i = 0; i < components; ++i) {
        MOTE_ASSIGN_OR_RETURN(auto values, rowOf(*particles, i, shape[1], file.held));
        table.add(componentNames[i], std::move(values));
    }
    const NpyArray* charges = arrayNamed(arrays, "q_array");
    if (charges != nullptr && charges->header.shape == std::vector<std::uint64_t>{shape[1]}) {
        MOTE_ASSIGN_OR_RETURN(auto values, rowOf(*charges, 0, shape[1], file.held));
        table.add("q [C]", std::move(values));
    }
    MOTE_ASSIGN_OR_RETURN(const auto total, rowOf(*energy, 0, 1, file.held));
    const double mass = table.setMass(file.mass, "Ocelot names");
    const double reference = total[0] * 1e9;
    if (!(reference > mass) || !std::isfinite(reference))
        return corrupt(energy->part.where, "is no energy above the particles' mass, in GeV");
    table.constants.push_back(
        {TableQuantity::referenceMomentum, std::sqrt((reference - mass) * (reference + mass))});
    return table;
}

bool isScaledNpz(const std::filesystem::path& path) {
    const auto arrays = openNpyArrays(path);
    return arrays && std::any_of(arrays->begin(), arrays->end(),
                                 [](const NpyArray& array) { return array.name == "p0c"; });
}

Result<std::unique_ptr<ParticleSource>> openScaledNpz(const AskedRun& run, Progress& progress) {
    return openHeld("npz", tableOfScaledNpz, run, progress);
}

/// What the arrays of a file mean for a run: which numbers are which column, how many steps and
/// rows there are, and what stands beside them (mass, times, iterations). Which names and shapes are
/// understood: docs/READERS.md. A value, made once a file.
struct NpyColumns {
    struct Item {
        FieldMeaning meaning;
        std::size_t array = 0;  ///< which of them
        NpyNumbers numbers;
        std::string name;  ///< as it is written, for messages
    };

    std::vector<NpyArray> arrays;
    std::vector<Item> items;
    std::uint64_t steps = 1, rows = 0;     ///< rows of each step
    std::vector<double> times;             ///< s, of each step; empty where the file does not say
    std::vector<std::int64_t> iterations;  ///< the same
    double mass = 0.0;                     ///< eV/c^2; 0: unknown
    bool unnamed = false;                  ///< columns by their order, not by name

    const Item* find(Column column) const;
    const Item* findRecord(std::string_view name) const;  ///< by recordOf(its name)

    /// `mass` goes before the file's. Errors: corrupt (arrays of different lengths, two of one meaning, a
    /// mass or an iteration that is none), unsupported (other shapes, more than 100 000 steps, types that are
    /// not read), invalidArgument (units that need a mass), those of NpyReader.
    static Result<NpyColumns> of(std::vector<NpyArray> arrays, double mass, const std::string& file);
};

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

class NpySource : public SeriesSource {
  public:
    NpySource(std::string format, double mass, Progress& progress)
        : SeriesSource(std::move(format), progress), mass_(mass) {}

    double mass() const override { return files_.front().mass; }
    std::string weightUnit() const override {
        const bool charges = std::all_of(files_.begin(), files_.end(), [](const NpyColumns& file) {
            const auto* const item = file.find(Column::weight);
            return item != nullptr && item->meaning.coulomb;
        });
        return charges ? "C" : "";
    }

  protected:
    Status addFile(const std::filesystem::path& path) override;
    Status finish() override;
    bool hasEverywhere(Column column) const override {
        return std::all_of(files_.begin(), files_.end(),
                           [&](const NpyColumns& file) { return file.find(column) != nullptr; });
    }
    Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) override;

  private:
    void noteUnits() const;
    std::vector<SourceRecord> recordsEverywhere() const override;

    struct Place {
        std::size_t file = 0;
        std::uint64_t step = 0;
    };

    Status readColumn(const Place& place, Column column, ParticleChunk& chunk);
    Status readLost(const Place& place, std::uint64_t begin, std::vector<std::uint8_t>& lost);
    template <class Value>
    Status readItem(const Place& place, const NpyColumns::Item& item, std::uint64_t begin,
                    std::span<Value> values);

    double mass_;
    bool numbered_ = true;  // every file says its iterations
    std::vector<Place> places_;
    std::vector<NpyColumns> files_;
    std::size_t open_ = 0;                           // the file of readers_
    std::vector<std::optional<NpyReader>> readers_;  // by item
    std::vector<double> scratch_;
};

Status NpySource::addFile(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto arrays, openNpyArrays(path));
    const std::string name = path.filename().string();
    MOTE_ASSIGN_OR_RETURN(auto file, NpyColumns::of(std::move(arrays), mass_, name));
    const auto number = file.steps == 1 ? fileNumber(path) : std::nullopt;
    for (std::uint64_t i = 0; i < file.steps; ++i) {
        SourceStep step{name, number.value_or(static_cast<std::int64_t>(steps_.size())), 0.0, file.rows};
        if (!file.iterations.empty()) step.iteration = file.iterations[i];
        if (!file.times.empty()) step.time = file.times[i];
        steps_.push_back(std::move(step));
        places_.push_back({files_.size(), i});
    }
    numbered_ = numbered_ && !file.iterations.empty();
    files_.push_back(std::move(file));
    return success();
}

Status NpySource::finish() {
    const auto is = [&](auto what) { return std::any_of(files_.begin(), files_.end(), what); };
    if (is([](const NpyColumns& file) { return file.unnamed; })) {
        progress_.note(
            "an array without field names is taken as x, y, z [m], and px, py, pz [eV/c] and a weight where "
            "it has so many columns");
    }
    noteUnits();
    if (is([&](const NpyColumns& file) { return file.mass != files_.front().mass; })) {
        progress_.note("the files' masses differ: that of the first one is taken");
    }
    if (numbered_) sortByIteration(places_);
    return success();
}

std::vector<SourceRecord> NpySource::recordsEverywhere() const {
    std::vector<SourceRecord> records;
    for (const NpyColumns::Item& item : files_.front().items) {
        if (item.meaning.kind != FieldMeaning::Kind::record) continue;
        auto record = *recordOf(item.name);
        if (std::ranges::all_of(files_,
                                [&](const auto& file) { return file.findRecord(record.name) != nullptr; }))
            records.push_back(std::move(record));
    }
    return records;
}

/// Says which units are assumed.
void NpySource::noteUnits() const {
    std::map<std::string, std::set<std::string>> byUnit;
    for (const NpyColumns& file : files_) {
        for (const NpyColumns::Item& item : file.items) {
            // "position" and "momentum" are vectors.
            for (const std::string& name : {item.name, item.name + "_x"}) {
                const auto meaning = tableMeaning(name, "");
                if (!meaning || !meaning->has_value() || (*meaning)->unitGiven) continue;
                byUnit[std::string(assumedUnit((*meaning)->quantity))].insert(item.name);
                break;
            }
        }
    }
    for (const auto& [unit, names] : byUnit) {
        std::string all;
        for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
        progress_.note("no unit is given for " + all + ": taken as " + unit);
    }
}

Status NpySource::readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) {
    const Place& place = places_[step];
    if (open_ != place.file) readers_.clear();
    open_ = place.file;
    readers_.resize(files_[place.file].items.size());
    for (const Column column : wanted) MOTE_RETURN_IF_ERROR(readColumn(place, column, chunk));
    return readLost(place, chunk.begin, chunk.lost);
}

/// Every item has a reader of its own, so that each goes through its bytes once.
template <class Value>
Status NpySource::readItem(const Place& place, const NpyColumns::Item& item, std::uint64_t begin,
                           std::span<Value> values) {
    if (values.empty()) return success();
    const NpyColumns& file = files_[place.file];
    auto& reader = readers_[static_cast<std::size_t>(&item - file.items.data())];
    if (!reader) {
        MOTE_ASSIGN_OR_RETURN(reader, NpyReader::open(file.arrays[item.array], item.numbers));
    }
    const bool lastStep = item.numbers.stepStride == 0 || place.step + 1 == file.steps;
    return reader->read(place.step, begin, lastStep && begin + values.size() == file.rows, values);
}

Status NpySource::readColumn(const Place& place, Column column, ParticleChunk& chunk) {
    const NpyColumns& file = files_[place.file];
    const NpyColumns::Item* item = isRecord(column) ? file.findRecord(recordName(column)) : file.find(column);
    if (item == nullptr) return success();
    if (column == Column::id) return readItem(place, *item, chunk.begin, std::span(chunk.id));
    MOTE_RETURN_IF_ERROR(readItem(place, *item, chunk.begin, std::span(chunk[column])));
    for (double& value : chunk[column]) {
        value *= item->meaning.factor;
        if (column == Column::weight) value = std::abs(value);
    }
    return success();
}

Status NpySource::readLost(const Place& place, std::uint64_t begin, std::vector<std::uint8_t>& lost) {
    for (const NpyColumns::Item& item : files_[place.file].items) {
        using Kind = FieldMeaning::Kind;
        if (item.meaning.kind == Kind::column || item.meaning.kind == Kind::record) continue;
        scratch_.resize(lost.size());
        MOTE_RETURN_IF_ERROR(readItem(place, item, begin, std::span(scratch_)));
        for (std::size_t i = 0; i < lost.size(); ++i)
            lost[i] |= saysLost(item.meaning.kind, scratch_[i]) ? 1 : 0;
    }
    return success();
}

Result<std::unique_ptr<ParticleSource>> openNpy(const char* format, const AskedRun& run, Progress& progress) {
    return openSeries(std::make_unique<NpySource>(format, run.mass, progress), inOrder(run.files));
}

}  // namespace

extern const ParticleReader npyReader;
constinit const ParticleReader npyReader{
    "npy", "NumPy's mark of one array", ParticleReader::Kind::bytes,
    [](const AskedFile& file) -> Result<bool> { return file.begin.starts_with("\x93NUMPY"); },
    [](const AskedRun& run, Progress& progress) { return openNpy("npy", run, progress); }};
extern const ParticleReader npzReader;
constinit const ParticleReader npzReader{
    "npz", "an archive of NumPy's arrays", ParticleReader::Kind::bytes,
    [](const AskedFile& file) -> Result<bool> { return looksLikeZip(file.begin); },
    [](const AskedRun& run, Progress& progress) {
        return isScaledNpz(run.files.front()) ? openScaledNpz(run, progress) : openNpy("npz", run, progress);
    }};
extern const ParticleReader ocelotReader;
constinit const ParticleReader ocelotReader{
    "ocelot", "an archive with the arrays rparticles and E", ParticleReader::Kind::bytes,
    [](const AskedFile& file) -> Result<bool> {
        if (!looksLikeZip(file.begin)) return false;
        const auto arrays = openNpyArrays(file.path);
        return arrays && arrayNamed(*arrays, "rparticles") != nullptr && arrayNamed(*arrays, "E") != nullptr;
    },
    [](const AskedRun& run, Progress& progress) { return openHeld("ocelot", tableOfOcelot, run, progress); }};

}  // namespace mote::prep
