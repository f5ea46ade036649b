// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/volume_parts.h"

#include <fmt/format.h>

#include <optional>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/volume_shape.h"

namespace mote::prep {
namespace {

struct Wanted {
    std::string_view volume, component;  ///< "": left open
};

Wanted wantedOf(std::string_view field, const VolumeParts& parts) {
    const auto colon = field.find(':');
    if (colon != std::string_view::npos) return {field.substr(0, colon), field.substr(colon + 1)};
    return parts.volumes > 1 ? Wanted{field, ""} : Wanted{"", field};
}

/// "0, 1, 2" or "0 to 63".
std::string listOf(std::uint64_t count) {
    if (count > 8) return fmt::format("0 to {}", count - 1);
    std::string list;
    for (std::uint64_t i = 0; i < count; ++i) list += fmt::format("{}{}", i == 0 ? "" : ", ", i);
    return list;
}

Result<std::uint64_t> choose(std::string_view wanted, std::uint64_t count, const char* what,
                             const char* example, const std::string& where) {
    if (wanted.empty() && count == 1) return std::uint64_t{0};
    if (wanted.empty()) {
        return unsupported(where, fmt::format("says {} {}: ask for one of {} as the field ({})", count, what,
                                              listOf(count), example));
    }
    const auto number = parseId(wanted);
    if (!number) {
        return invalid("field", fmt::format("\"{:.20}\" is no number of one of the {} {}: give {}", wanted,
                                            count, what, listOf(count)));
    }
    if (*number < count) return *number;
    return notFound(where,
                    fmt::format("has no number {} among its {} {}: {}", *number, count, what, listOf(count)));
}

}  // namespace

Result<VolumeParts> chooseParts(std::string_view field, VolumeParts parts, const std::string& where) {
    if (parts.volumes > VolumeShape::maxDimension || parts.components > VolumeShape::maxDimension) {
        return Error{ErrorCode::resourceExhausted, where,
                     fmt::format("says {} volumes of {} values for each voxel; at most {} are counted",
                                 parts.volumes, parts.components, VolumeShape::maxDimension)};
    }
    const auto wanted = wantedOf(field, parts);
    const bool both = parts.volumes > 1 && parts.components > 1;
    // First what no series is made of.
    MOTE_ASSIGN_OR_RETURN(parts.component, choose(wanted.component, parts.components, "values for each voxel",
                                                  both ? "\":0\"" : "\"0\"", where));
    MOTE_ASSIGN_OR_RETURN(parts.volume,
                          choose(wanted.volume, parts.volumes, "volumes", both ? "\"0:0\"" : "\"0\"", where));
    return parts;
}

std::vector<std::string> fieldsOfSeries(const std::string& field, const VolumeParts& parts) {
    const auto wanted = wantedOf(field, parts);
    const bool open = parts.volumes > 1 && wanted.volume.empty();
    if (!open || parts.volumes > VolumeShape::maxDimension) return {field};
    if (parts.components > 1 && wanted.component.empty()) return {field};  // refused where it is opened
    std::vector<std::string> fields;
    for (std::uint64_t i = 0; i < parts.volumes; ++i) {
        fields.push_back(parts.components > 1 ? fmt::format("{}:{}", i, wanted.component)
                                              : fmt::format("{}", i));
    }
    return fields;
}

}  // namespace mote::prep
