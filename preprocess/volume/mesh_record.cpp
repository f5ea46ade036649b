// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/mesh_record.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "preprocess/readers/hdf5/h5_attribute.h"
#include "preprocess/readers/openpmd/layout.h"

namespace mote::prep {
namespace {

using Dimension = std::array<double, 7>;
struct KnownUnit {
    Dimension dimension;
    const char* name;
};
/// Powers of m, kg, s, A, K, mol, cd.
constexpr std::array<KnownUnit, 6> units{{{{1, 1, -3, -1, 0, 0, 0}, "V/m"},
                                          {{0, 1, -2, -1, 0, 0, 0}, "T"},
                                          {{-3, 0, 1, 1, 0, 0, 0}, "C/m^3"},
                                          {{-2, 0, 0, 1, 0, 0, 0}, "A/m^2"},
                                          {{-3, 0, 0, 0, 0, 0, 0}, "1/m^3"},
                                          {{2, 1, -3, -1, 0, 0, 0}, "V"}}};

Error noneOf(const std::string& where, const std::string& what, const std::vector<std::string>& there) {
    return {ErrorCode::notFound, where,
            there.empty() ? what + "; it holds none"
                          : fmt::format("{}; there {} {}", what, there.size() == 1 ? "is" : "are",
                                        fmt::join(there, ", "))};
}

Result<OpenpmdIteration> chosenIteration(const H5File& file, const OpenpmdLayout& layout,
                                         const MeshField& field) {
    const auto& all = layout.iterations;
    if (!field.iteration && all.size() == 1) return all.front();
    for (const auto& each : all) {
        if (field.iteration == each.number) return each;
    }
    std::vector<std::string> numbers;
    for (std::size_t i = 0; i < std::min<std::size_t>(all.size(), 20); ++i)
        numbers.push_back(std::to_string(all[i].number));
    return noneOf(file.name(),
                  field.iteration ? fmt::format("has no iteration {}", *field.iteration)
                                  : "has several iterations: name one, as ITERATION:RECORD",
                  numbers);
}

/// "/data/550/fields" of the meshes, where they are.
Result<std::optional<H5Object>> meshesGroup(const H5File& file, const OpenpmdIteration& iteration) {
    MOTE_ASSIGN_OR_RETURN(const auto path, textAttribute(file.root(), "meshesPath"));
    MOTE_ASSIGN_OR_RETURN(const auto group, file.require(file.root(), iteration.path));
    auto meshes = path.value_or("meshes/");
    while (meshes.starts_with('/')) meshes.erase(0, 1);
    return file.find(group, meshes);
}

/// The names of what can be drawn: records, and components of records that have some.
Result<std::vector<std::string>> fieldNames(const H5File& file, const H5Object& meshes) {
    std::vector<std::string> names;
    MOTE_ASSIGN_OR_RETURN(const auto records, file.children(meshes));
    for (const auto& record : records) {
        MOTE_ASSIGN_OR_RETURN(const auto object, file.find(meshes, record));
        if (!object) continue;
        if (!object->group) {
            names.push_back(record);
            continue;
        }
        MOTE_ASSIGN_OR_RETURN(const auto components, file.children(*object));
        if (components.empty()) names.push_back(record);  // a constant
        for (const auto& component : components) names.push_back(record + "/" + component);
    }
    return names;
}

std::string nameOf(const MeshField& field) {
    return field.component.empty() ? field.record : field.record + "/" + field.component;
}

/// The record, and the component, which may be the record itself.
struct Found {
    H5Object record, component;
    std::string name;  ///< of the component, within the meshes
};

Result<Found> findField(const H5File& file, const H5Object& meshes, const MeshField& field) {
    MOTE_ASSIGN_OR_RETURN(const auto names, fieldNames(file, meshes));
    auto wanted = nameOf(field);
    if (wanted.empty() && names.size() == 1) wanted = names.front();
    if (std::ranges::find(names, wanted) == names.end()) {
        return noneOf(meshes.where,
                      wanted.empty() ? "holds several fields: name one with --field"
                                     : fmt::format("holds no field \"{:.60}\"", wanted),
                      names);
    }
    MOTE_ASSIGN_OR_RETURN(auto record, file.require(meshes, wanted.substr(0, wanted.find('/'))));
    MOTE_ASSIGN_OR_RETURN(auto component, file.require(meshes, wanted));
    if (!component.group) return Found{std::move(record), std::move(component), wanted};
    return unsupported(component.where,
                       "is a constant, or more than numbers on a mesh: there is nothing to draw");
}

/// As many finite numbers as there are axes.
Result<std::vector<double>> perAxis(const H5Object& object, const char* name, std::size_t axes,
                                    std::optional<double> missing) {
    MOTE_ASSIGN_OR_RETURN(auto values, numbersAttribute(object, name));
    if (!values && missing) return std::vector<double>(axes, *missing);
    const auto where = object.where + "@" + name;
    if (!values) return corrupt(where, "is missing: the mesh has no place");
    if (values->size() != axes) {
        return corrupt(where, fmt::format("has {} numbers where the mesh has {} axes", values->size(), axes));
    }
    for (const double value : *values) {
        if (!std::isfinite(value)) return corrupt(where, "is not finite");
    }
    return *std::move(values);
}

/// Some write a number for each dimension of the data, where in thetaMode the first is the one of the modes
/// and lies nowhere: the others are r's and z's.
Result<std::vector<double>> positionInCell(const H5Object& component, std::size_t axes, MeshRecord& record) {
    MOTE_ASSIGN_OR_RETURN(const auto values, numbersAttribute(component, "position"));
    const bool ofModes = record.thetaMode && values && values->size() == axes + 1;
    MOTE_ASSIGN_OR_RETURN(auto numbers, perAxis(component, "position", axes + (ofModes ? 1 : 0), 0.0));
    if (!ofModes) return numbers;
    if (std::ranges::count(numbers, numbers.front()) != std::ssize(numbers)) {
        record.notes.push_back(component.where +
                               "@position: has three numbers, of which the last two were taken for r and z");
    }
    numbers.erase(numbers.begin());
    return numbers;
}

Status readAxes(const Found& found, std::size_t dimensions, MeshRecord& record) {
    MOTE_ASSIGN_OR_RETURN(auto labels, textsAttribute(found.record, "axisLabels"));
    MOTE_ASSIGN_OR_RETURN(const auto order, textAttribute(found.record, "dataOrder"));
    const auto where = found.record.where + "@axisLabels";
    if (!labels) return corrupt(where, "is missing");
    if (labels->size() != dimensions) {
        return corrupt(where, fmt::format("names {} axes of a mesh of {}", labels->size(), dimensions));
    }
    MOTE_ASSIGN_OR_RETURN(const auto spacing, perAxis(found.record, "gridSpacing", dimensions, std::nullopt));
    MOTE_ASSIGN_OR_RETURN(const auto offset, perAxis(found.record, "gridGlobalOffset", dimensions, 0.0));
    MOTE_ASSIGN_OR_RETURN(const auto inCell, positionInCell(found.component, dimensions, record));
    MOTE_ASSIGN_OR_RETURN(const auto unit, numbersAttribute(found.record, "gridUnitSI"));
    for (std::size_t i = 0; i < dimensions; ++i) {
        // One for all axes; since version 2 one for each.
        const double scale = !unit || unit->empty() ? 1.0 : (*unit)[unit->size() == dimensions ? i : 0];
        MeshRecord::Axis axis{(*labels)[i], spacing[i] * scale, (offset[i] + inCell[i] * spacing[i]) * scale};
        if (!(axis.spacing > 0.0) || !std::isfinite(axis.spacing) || !std::isfinite(axis.first))
            return corrupt(found.record.where + "@gridSpacing", "is no spacing of a mesh");
        record.axes.push_back(std::move(axis));
    }
    // The first axis is the fastest one then.
    if (order && order->starts_with('F')) std::ranges::reverse(record.axes);
    return success();
}

Status checkAxes(const MeshRecord& record) {
    const std::string_view allowed = record.thetaMode ? "rz" : "xyz";
    std::string seen;
    for (const auto& axis : record.axes) {
        const bool known = axis.label.size() == 1 && allowed.find(axis.label) != std::string_view::npos;
        if (!known || seen.find(axis.label) != std::string::npos) {
            return unsupported(record.where,
                               fmt::format("has an axis \"{:.20}\"; meshes of {} are read", axis.label,
                                           record.thetaMode ? "r and z" : "x, y and z"));
        }
        seen += axis.label;
    }
    return success();
}

Status readGeometry(const Found& found, MeshRecord& record) {
    MOTE_ASSIGN_OR_RETURN(const auto geometry, textAttribute(found.record, "geometry"));
    MOTE_ASSIGN_OR_RETURN(const auto parameters, textAttribute(found.record, "geometryParameters"));
    record.thetaMode = geometry.value_or("cartesian") == "thetaMode";
    if (!record.thetaMode && geometry.value_or("cartesian") != "cartesian") {
        return unsupported(
            record.where,
            fmt::format("is of geometry \"{:.20}\"; cartesian and thetaMode are read", *geometry));
    }
    if (parameters && parameters->find("imag=-") != std::string::npos) record.sineSign = -1.0;
    const auto rank = record.numbers.extent().size();
    const std::size_t least = record.thetaMode ? 3 : 2;
    if (rank < least || rank > 3) {
        return unsupported(record.where, fmt::format("has {} dimensions", rank));
    }
    if (record.thetaMode && record.numbers.extent()[0] % 2 == 0) {
        return corrupt(record.where,
                       fmt::format("has {} parts of modes; the first mode has one, each other two",
                                   record.numbers.extent()[0]));
    }
    MOTE_RETURN_IF_ERROR(readAxes(found, record.thetaMode ? 2 : rank, record));
    return checkAxes(record);
}

Status readUnits(const Found& found, const H5Object& iteration, MeshRecord& record) {
    MOTE_ASSIGN_OR_RETURN(const auto scale, numberAttribute(found.component, "unitSI"));
    MOTE_ASSIGN_OR_RETURN(const auto dimension, numbersAttribute(found.record, "unitDimension"));
    MOTE_ASSIGN_OR_RETURN(const auto time, numberAttribute(iteration, "time"));
    MOTE_ASSIGN_OR_RETURN(const auto timeUnit, numberAttribute(iteration, "timeUnitSI"));
    record.unitSI = scale.value_or(1.0);
    if (!std::isfinite(record.unitSI)) return corrupt(record.where + "@unitSI", "is not finite");
    for (const auto& unit : units) {
        if (dimension && std::ranges::equal(*dimension, unit.dimension)) record.unit = unit.name;
    }
    if (time && std::isfinite(*time * timeUnit.value_or(1.0))) record.time = *time * timeUnit.value_or(1.0);
    return success();
}

}  // namespace

Result<MeshRecord> MeshRecord::open(const std::filesystem::path& path, const MeshField& field) {
    MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path));
    MOTE_ASSIGN_OR_RETURN(const auto layout, readOpenpmdLayout(file));
    MOTE_ASSIGN_OR_RETURN(const auto iteration, chosenIteration(file, layout, field));
    MOTE_ASSIGN_OR_RETURN(const auto meshes, meshesGroup(file, iteration));
    if (!meshes || !meshes->group) return notFound(file.name() + ":" + iteration.path, "holds no meshes");
    MOTE_ASSIGN_OR_RETURN(auto found, findField(file, *meshes, field));
    const auto where = found.component.where;
    // The numbers are read as long as the volume is, the attributes only now.
    MOTE_ASSIGN_OR_RETURN(auto again, file.require(*meshes, found.name));
    MOTE_ASSIGN_OR_RETURN(auto numbers, H5Numbers::open(file, std::move(again)));
    MeshRecord record{std::move(numbers), {}, false, 1.0, 1.0, "", std::nullopt, where};
    MOTE_RETURN_IF_ERROR(readGeometry(found, record));
    MOTE_ASSIGN_OR_RETURN(const auto group, file.require(file.root(), iteration.path));
    MOTE_RETURN_IF_ERROR(readUnits(found, group, record));
    return record;
}

Result<std::vector<std::string>> meshFields(const std::filesystem::path& path) {
    if (!H5File::looksLikeHdf5(path)) return std::vector<std::string>();
    MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path));
    if (!looksLikeOpenpmd(file)) return std::vector<std::string>();
    MOTE_ASSIGN_OR_RETURN(const auto layout, readOpenpmdLayout(file));
    if (layout.iterations.empty()) return notFound(file.name(), "holds no iteration");
    MOTE_ASSIGN_OR_RETURN(const auto meshes, meshesGroup(file, layout.iterations.front()));
    if (!meshes || !meshes->group) {
        return notFound(file.name() + ":" + layout.iterations.front().path, "holds no meshes");
    }
    return fieldNames(file, *meshes);
}

}  // namespace mote::prep
