// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "preprocess/kept_notes.h"
#include "preprocess/look/look_at.h"
#include "preprocess/look/silent_notes.h"
#include "preprocess/readers/input_files.h"
#include "preprocess/volume/volume_source.h"
#include "preprocess/world_unit.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t slabBytes = 64 << 20;

/// "right" of a step of voxels along x of a patient's world, "+x" of others: the axis along which it goes
/// most.
std::string directionOf(const glm::dvec3& step, const std::string& space) {
    int most = 0;
    for (int i = 1; i < 3; ++i) most = std::abs(step[i]) > std::abs(step[most]) ? i : most;
    const bool forward = step[most] >= 0.0;
    if (space.empty()) return fmt::format("{}{}", forward ? "+" : "-", "xyz"[most]);
    static constexpr std::array<std::array<const char*, 2>, 3> words{
        {{"right", "left"}, {"anterior", "posterior"}, {"superior", "inferior"}}};
    const bool first = forward != (space == "lps" && most < 2);
    return words[static_cast<std::size_t>(most)][first ? 0 : 1];
}

void addPlace(const VolumeShape& shape, Found& found) {
    const std::string unit = shape.worldUnit.empty() ? "" : " " + shape.worldUnit;
    std::vector<double> sizes, origin, axes;
    std::vector<std::string> directions;
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 step(shape.indexToWorld[axis]);
        sizes.push_back(glm::length(step));
        origin.push_back(shape.indexToWorld[3][axis]);
        directions.push_back(directionOf(step, shape.worldSpace));
        for (int row = 0; row < 3; ++row) axes.push_back(step[row]);
    }
    found.facts.push_back({"voxelSize", sizes, "voxels",
                           fmt::format("{:.6g}{}{}", fmt::join(sizes, " x "), unit,
                                       unit.empty() ? ", of an unknown unit" : "")});
    found.facts.push_back(
        {"origin", origin, "origin", fmt::format("{:.10g}{}", fmt::join(origin, ", "), unit)});
    found.facts.push_back({"axes", axes, "axes", fmt::format("{}", fmt::join(directions, ", "))});
    found.facts.push_back({"orientation", fmt::format("{}", fmt::join(directions, " "))});
    found.facts.push_back({"unit", shape.worldUnit});
    found.facts.push_back({"valueUnit", shape.valueUnit});
    found.facts.push_back({"sourceSpace", shape.space});
    found.facts.push_back(
        {"space", shape.worldSpace, "space",
         fmt::format("{}, the file's {}", shape.worldSpace.empty() ? "as the file has it" : shape.worldSpace,
                     shape.space.empty() ? "is not said" : shape.space)});
}

void addShape(const VolumeShape& shape, std::size_t steps, Found& found) {
    const std::vector<std::uint64_t> size{shape.nx, shape.ny, shape.nz};
    const std::string type(name(shape.type));
    found.facts.push_back({"size", size, "size", fmt::format("{} of {}", fmt::join(size, " x "), type)});
    found.facts.push_back({"type", type});
    found.facts.push_back({"steps", static_cast<std::uint64_t>(steps), "steps", fmt::format("{}", steps)});
    addPlace(shape, found);
    if (shape.time) found.facts.push_back({"time", *shape.time, "time", fmt::format("{} s", *shape.time)});
}

Status readRange(VolumeSource& source, Progress& progress, FoundColumn& range) {
    const VolumeShape shape = source.shape();
    const std::uint64_t slice = shape.voxelsOfSlice();
    const auto together = static_cast<std::uint32_t>(
        std::clamp<std::uint64_t>(slabBytes / (slice * sizeof(float)), 1, shape.nz));
    std::vector<float> values;
    for (std::uint32_t z = 0; z < shape.nz; z += together) {
        if (progress.cancelled()) return wasCancelled();
        const std::uint32_t end = std::min(z + together, shape.nz);
        values.resize(slice * (end - z));
        MOTE_RETURN_IF_ERROR(source.read(z, end, values));
        for (const float value : values) range.take(static_cast<double>(value));
        progress.report(static_cast<double>(end) / shape.nz, "reading");
    }
    return success();
}

/// Looks at the first of several volumes, of whose steps the others are.
Result<Found> lookAtField(const std::vector<std::filesystem::path>& inputs, const LookOptions& options,
                          const proto::VolumeSourceOptions& wanted, Progress& progress) {
    SilentNotes silent(progress);
    KeptNotes notes(silent);
    MOTE_ASSIGN_OR_RETURN(const auto steps, volumeSteps(wanted, inputs));
    Found found;
    found.kind = "volume";
    found.name = wanted.field();
    FoundColumn range{"value", ""};
    for (std::size_t i = 0; i < (options.all ? steps.size() : 1); ++i) {
        const auto source = openVolumeSource(steps[i], notes);
        if (!source.ok() && i == 0) return source.error();
        if (i == 0) {
            found.format = (*source)->format();
            found.told = toldBy(wanted.format(), toldOfVolume(found.format));
            range.unit = (*source)->shape().valueUnit;
            VolumeShape shape = (*source)->shape();
            MOTE_ASSIGN_OR_RETURN(shape.worldUnit, worldUnitFor(proto::JobRequest{}, shape, notes));
            addShape(shape, steps.size(), found);
        }
        const Status read = source.ok() ? readRange(**source, notes, range) : Status(source.error());
        if (!read.ok() && read.error().code == ErrorCode::cancelled) return read.error();
        if (!read.ok()) found.refused.push_back(read.error().toString());
    }
    found.columns.push_back(range);
    found.notes = notes.notes();
    return found;
}

/// Looks at each of several values for each voxel, of which a job wants one to be named. `error`
/// is what it says where none is.
Result<std::vector<Found>> lookAtComponents(const std::vector<std::filesystem::path>& inputs,
                                            const LookOptions& options, const Error& error,
                                            Progress& progress) {
    constexpr int most = 64;
    std::vector<Found> all;
    for (int i = 0; i < most; ++i) {
        auto wanted = options.volume;
        wanted.set_field(fmt::format(":{}", i));
        auto found = lookAtField(inputs, options, wanted, progress);
        if (!found.ok() && found.error().code == ErrorCode::cancelled) return found.error();
        if (!found.ok()) break;
        found->notes.push_back(error.toString());
        all.push_back(std::move(*found));
    }
    if (all.empty()) return error;
    return all;
}

/// Looks at those of a file of several, with how each is stored.
Result<std::vector<Found>> lookAtFields(const VolumeFields& several, const LookOptions& options,
                                        const std::function<Result<Found>(const std::string&)>& look) {
    std::vector<std::string> names;
    for (const VolumeField& field : several.fields) names.push_back(field.name);
    const std::string told = toldBy(options.volume.format(), toldOfVolume(several.format));
    MOTE_ASSIGN_OR_RETURN(auto all,
                          lookAtEach(names, {"volume", several.format, told, "", {}, {}, {}, {}}, look));
    for (std::size_t i = 0; i < all.size(); ++i) {
        const VolumeField& field = several.fields[i];
        all[i].name = printableText(field.name);
        if (field.type.empty()) continue;
        all[i].facts.push_back(
            {"components", field.components, "stored",
             fmt::format("{} at each place, as {}", field.components, printableText(field.type))});
    }
    return all;
}

/// Files behind a name with %T; else the input itself, which may be a folder of pictures.
Result<std::vector<std::filesystem::path>> filesOf(const std::filesystem::path& input) {
    std::error_code code;
    if (std::filesystem::exists(input, code) || input.filename().string().find('%') == std::string::npos)
        return std::vector<std::filesystem::path>{input};
    MOTE_ASSIGN_OR_RETURN(const auto files, inputFiles({input}));
    std::vector<std::filesystem::path> paths;
    for (const InputFile& file : files) paths.push_back(file.path);
    return paths;
}

}  // namespace

Result<std::vector<Found>> lookAtVolume(const std::filesystem::path& input, const LookOptions& options,
                                        Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const auto inputs, filesOf(input));
    const std::string& field = options.volume.field();
    const auto look = [&](const std::string& name) {
        auto wanted = options.volume;
        wanted.set_field(name);
        return lookAtField(inputs, options, wanted, progress);
    };
    const auto several =
        field.empty() ? volumeFields(options.volume, inputs.front(), progress) : VolumeFields();
    if (!several.fields.empty()) return lookAtFields(several, options, look);
    auto found = look(field);
    if (found.ok()) return std::vector<Found>{std::move(*found)};
    const Error error = found.error();
    if (error.code != ErrorCode::unsupported || !field.empty()) return error;
    return lookAtComponents(inputs, options, error, progress);
}

}  // namespace mote::prep
