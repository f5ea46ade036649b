// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/h5part/h5part_step.h"

#include <cmath>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/hdf5/h5_attribute.h"

namespace mote::prep {
namespace {

constexpr double gigaelectronvolt = 1e9;

struct Name {
    Column column;
    const char* name;
};

// The first name that a step has is taken.
constexpr Name names[] = {{Column::x, "x"},           {Column::y, "y"},    {Column::z, "z"},
                          {Column::t, "t"},           {Column::t, "time"}, {Column::px, "px"},
                          {Column::py, "py"},         {Column::pz, "pz"},  {Column::weight, "q"},
                          {Column::weight, "weight"}, {Column::id, "id"}};

}  // namespace

Result<H5PartStep> H5PartStep::open(const H5File& file, const std::string& path, double mass) {
    const auto group = file.require(file.root(), path);
    if (!group) return group.error();
    H5PartStep step;
    step.mass_ = mass;
    MOTE_RETURN_IF_ERROR(step.readMeaning(file, *group));
    for (const Name& name : names) {
        const auto column = static_cast<std::size_t>(name.column);
        if (!step.columns_[column]) MOTE_RETURN_IF_ERROR(step.openColumn(file, *group, column, name.name));
    }
    bool first = true;
    for (const auto& column : step.columns_) {
        if (!column) continue;
        if (first) step.rows_ = column->rows();
        first = false;
        if (column->rows() != step.rows_) {
            return Error{ErrorCode::corrupt, column->object().where,
                         "has " + std::to_string(column->rows()) + " values where other columns have " +
                             std::to_string(step.rows_)};
        }
    }
    if (first)
        return Error{ErrorCode::notFound, group->where, "holds none of the columns x, y, z, px, py, pz"};
    return step;
}

Status H5PartStep::readMeaning(const H5File& file, const H5Object& step) {
    for (const H5Object* object : {&step, &file.root()}) {
        const auto mass = numberAttribute(*object, "MASS");
        if (!mass) return mass.error();
        if (mass_ == 0.0 && *mass && **mass > 0.0 && std::isfinite(**mass)) mass_ = **mass * gigaelectronvolt;
    }
    for (const char* name : {"TIME", "Time", "time"}) {
        const auto time = numberAttribute(step, name);
        if (!time) return time.error();
        if (!*time || !std::isfinite(**time)) continue;
        time_ = **time;
        break;
    }
    return success();
}

Status H5PartStep::openColumn(const H5File& file, const H5Object& step, std::size_t column,
                              const char* name) {
    auto found = file.find(step, name);
    if (!found) return found.error();
    if (!found->has_value() || (*found)->group) return success();
    auto opened = H5Column::open(file, std::move(**found));
    if (!opened) return opened.error();
    const auto factor = unitOf(file, step, column, name);
    if (!factor) return factor.error();
    columns_[column] = std::move(*opened);
    factors_[column] = *factor;
    return success();
}

/// The unit that an attribute of the step or of the file gives to a column.
Result<double> H5PartStep::unitOf(const H5File& file, const H5Object& step, std::size_t column,
                                  const char* name) {
    const std::string attribute = std::string(name) + "Unit";
    for (const H5Object* object : {&step, &file.root()}) {
        const auto unit = textAttribute(*object, attribute.c_str());
        if (!unit) return unit.error();
        if (!*unit || (*unit)->empty()) continue;
        unitsGiven_ = true;
        if (static_cast<Column>(column) == Column::id) return 1.0;
        const auto meaning =
            fieldMeaning(std::string(name) + " [" + **unit + "]", mass_, object->where + "@" + attribute);
        if (!meaning) return meaning.error();
        return *meaning ? (*meaning)->factor : 1.0;
    }
    return 1.0;
}

Status H5PartStep::read(std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                        ParticleChunk& chunk) {
    chunk.begin = begin;
    chunk.size = count;
    chunk.lost.assign(count, 0);
    for (const Column column : wanted) {
        const auto& source = columns_[static_cast<std::size_t>(column)];
        if (column == Column::id) {
            chunk.id.resize(count);
            for (std::size_t i = 0; i < count && !source; ++i) chunk.id[i] = begin + i;
            if (source) MOTE_RETURN_IF_ERROR(source->read(begin, count, chunk.id.data()));
            continue;
        }
        chunk[column].assign(count, 1.0);
        if (!source && column == Column::weight) continue;
        if (!source)
            return Error{ErrorCode::invalidArgument, "", "a column that the run does not have was asked for"};
        MOTE_RETURN_IF_ERROR(source->read(begin, count, chunk[column].data()));
        const double factor = factors_[static_cast<std::size_t>(column)];
        for (double& value : chunk[column])
            value = column == Column::weight ? std::abs(value * factor) : value * factor;
    }
    return success();
}

}  // namespace mote::prep
