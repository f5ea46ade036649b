// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/volume_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <type_traits>

#include "preprocess/readers/half_float.h"
#include "preprocess/readers/text/number.h"
#include "protocol/base/mote_check.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

/// The two directions of each axis, the one of RAS first.
constexpr std::array<std::array<std::string_view, 2>, 3> directions{
    {{"right", "left"}, {"anterior", "posterior"}, {"superior", "inferior"}}};

/// The sign of each axis, 1 if a patient's space goes as RAS does and -1 if it goes the other way.
std::optional<glm::dvec3> signsOf(std::string_view space) {
    glm::dvec3 signs(0.0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string_view word = space.substr(0, space.find('-'));
        const auto& two = directions[axis];
        const auto* const found = std::find(two.begin(), two.end(), word);
        if (found == two.end()) return std::nullopt;
        signs[static_cast<int>(axis)] = found == two.begin() ? 1.0 : -1.0;
        space.remove_prefix(std::min(word.size() + 1, space.size()));
    }
    return space.empty() ? std::optional(signs) : std::nullopt;
}

void scaleWorld(VolumeShape& shape, const glm::dvec3& factors) {
    for (int column = 0; column < 4; ++column) {
        for (int axis = 0; axis < 3; ++axis) {
            const double value = shape.indexToWorld[column][axis];
            // No place is at -0.
            shape.indexToWorld[column][axis] = value == 0.0 ? 0.0 : value * factors[axis];
        }
    }
}

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

struct TypeName {
    std::string_view name;
    std::size_t bytes;
};
/// Names and sizes by ScalarType.
constexpr std::array<TypeName, 11> types{{{"u8", 1},
                                          {"i8", 1},
                                          {"u16", 2},
                                          {"i16", 2},
                                          {"u32", 4},
                                          {"i32", 4},
                                          {"f32", 4},
                                          {"f64", 8},
                                          {"u64", 8},
                                          {"i64", 8},
                                          {"f16", 2}}};

template <class Number, bool swapped>
void decode(const char* from, const SampleFormat& format, std::span<float> values) {
    if (format.slope == 1.0 && format.intercept == 0.0) {
        for (std::size_t i = 0; i < values.size(); ++i) {
            values[i] = static_cast<float>(loadNumber<Number>(from + i * sizeof(Number), swapped));
        }
        return;
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto number = static_cast<double>(loadNumber<Number>(from + i * sizeof(Number), swapped));
        values[i] = static_cast<float>(format.slope * number + format.intercept);
    }
}

template <class Number>
void decode(const char* from, const SampleFormat& format, std::span<float> values) {
    return format.bigEndian && sizeof(Number) > 1 ? decode<Number, true>(from, format, values)
                                                  : decode<Number, false>(from, format, values);
}

template <class Number>
std::optional<std::string> inexact(std::span<const char> bytes, const SampleFormat& format) {
    const bool scaled = format.slope != 1.0 || format.intercept != 0.0;
    for (std::size_t at = 0; at + sizeof(Number) <= bytes.size(); at += sizeof(Number)) {
        const auto number = loadNumber<Number>(bytes.data() + at, format.bigEndian);
        auto magnitude = static_cast<std::uint64_t>(number);
        if (std::is_signed_v<Number> && static_cast<std::int64_t>(number) < 0) magnitude = 0 - magnitude;
        // Of an integer's digits, those from the first to the last that is not 0 must fit.
        const auto digits = std::bit_width(magnitude) - (magnitude == 0 ? 0 : std::countr_zero(magnitude));
        if (digits > (scaled ? 53 : 24)) return std::to_string(number);
    }
    return std::nullopt;
}

constexpr std::size_t maxUnit = 16;
// Axes of length 1 that span less than this volume lie in one plane, but for rounding.
constexpr double leastVolume = 1e-6;
constexpr double leastLength = 1e-30, greatestLength = 1e30;  // lest products of lengths overflow

}  // namespace

std::string longSpace(std::string_view name) {
    std::string space = lower(name);
    if (space.ends_with("-time")) space.resize(space.size() - 5);
    if (space.size() == 4 && space.back() == 't') space.pop_back();
    if (space.size() != 3) return space;
    std::string words;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& two = directions[axis];
        const auto* const found = std::find_if(
            two.begin(), two.end(), [&](std::string_view word) { return word.front() == space[axis]; });
        if (found == two.end()) return space;
        words += fmt::format("{}{}", axis == 0 ? "" : "-", *found);
    }
    return words;
}

Status bringTo(std::string_view wanted, VolumeShape& shape) {
    if (!wanted.empty() && wanted != "ras" && wanted != "lps" && wanted != "file") {
        return invalid("space", fmt::format("\"{:.20}\" is none of ras, lps and file", wanted));
    }
    if (wanted == "file") return success();
    if (const auto signs = signsOf(shape.space)) {
        const glm::dvec3 there = wanted == "lps" ? glm::dvec3(-1.0, -1.0, 1.0) : glm::dvec3(1.0);
        scaleWorld(shape, *signs * there);
        shape.worldSpace = wanted == "lps" ? "lps" : "ras";
        return success();
    }
    if (shape.space == "3d-left-handed") {
        scaleWorld(shape, {1.0, 1.0, -1.0});
        shape.notes.emplace_back(
            "its space is left-handed: z was turned round, so that what is drawn is no mirror image");
    }
    return success();
}

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

std::string_view name(ScalarType type) {
    return types[static_cast<std::size_t>(type)].name;
}

std::size_t bytesOf(ScalarType type) {
    return types[static_cast<std::size_t>(type)].bytes;
}

std::optional<ScalarType> scalarType(std::string_view name) {
    const auto found =
        std::find_if(types.begin(), types.end(), [&](const TypeName& type) { return type.name == name; });
    if (found == types.end()) return std::nullopt;
    return static_cast<ScalarType>(found - types.begin());
}

void decodeSamples(std::span<const char> bytes, const SampleFormat& format, std::span<float> values) {
    MOTE_CHECK(bytes.size() == values.size() * bytesOf(format.type));
    switch (format.type) {
        case ScalarType::u8:
            return decode<std::uint8_t>(bytes.data(), format, values);
        case ScalarType::i8:
            return decode<std::int8_t>(bytes.data(), format, values);
        case ScalarType::u16:
            return decode<std::uint16_t>(bytes.data(), format, values);
        case ScalarType::i16:
            return decode<std::int16_t>(bytes.data(), format, values);
        case ScalarType::u32:
            return decode<std::uint32_t>(bytes.data(), format, values);
        case ScalarType::i32:
            return decode<std::int32_t>(bytes.data(), format, values);
        case ScalarType::f32:
            return decode<float>(bytes.data(), format, values);
        case ScalarType::f64:
            return decode<double>(bytes.data(), format, values);
        case ScalarType::u64:
            return decode<std::uint64_t>(bytes.data(), format, values);
        case ScalarType::i64:
            return decode<std::int64_t>(bytes.data(), format, values);
        case ScalarType::f16:
            return decode<HalfFloat>(bytes.data(), format, values);
    }
}

std::optional<std::string> inexactNumber(std::span<const char> bytes, const SampleFormat& format) {
    if (format.type == ScalarType::u64) return inexact<std::uint64_t>(bytes, format);
    if (format.type == ScalarType::i64) return inexact<std::int64_t>(bytes, format);
    if (format.type == ScalarType::u32) return inexact<std::uint32_t>(bytes, format);
    if (format.type == ScalarType::i32) return inexact<std::int32_t>(bytes, format);
    return std::nullopt;
}

Status setDimensions(VolumeShape& shape, std::uint64_t nx, std::uint64_t ny, std::uint64_t nz,
                     const std::string& where) {
    const auto [least, greatest] = std::minmax({nx, ny, nz});
    if (least == 0) {
        return corrupt(where, fmt::format("says {} x {} x {}: no voxels", nx, ny, nz));
    }
    if (greatest > VolumeShape::maxDimension) {
        return Error{ErrorCode::resourceExhausted, where,
                     fmt::format("says {} x {} x {} voxels; at most {} are read along an axis", nx, ny, nz,
                                 VolumeShape::maxDimension)};
    }
    shape.nx = static_cast<std::uint32_t>(nx);
    shape.ny = static_cast<std::uint32_t>(ny);
    shape.nz = static_cast<std::uint32_t>(nz);
    return success();
}

Status setPlacement(VolumeShape& shape, const glm::dmat3& axes, const glm::dvec3& origin,
                    const std::string& where) {
    double product = 1.0;
    for (int i = 0; i < 3; ++i) {
        const double length = glm::length(axes[i]);
        if (!(length > leastLength && length < greatestLength)) {
            return corrupt(where,
                           fmt::format("says that voxels along axis {} lie {} apart", "xyz"[i], length));
        }
        product *= length;
        if (!(std::abs(origin[i]) < greatestLength)) {
            return corrupt(where, "says an origin that is no place");
        }
        shape.indexToWorld[i] = glm::dvec4(axes[i], 0.0);
    }
    if (!(std::abs(glm::determinant(axes)) > leastVolume * product)) {
        return corrupt(where, "says axes that lie in one plane");
    }
    shape.indexToWorld[3] = glm::dvec4(origin, 1.0);
    return success();
}

std::string printableText(std::string_view text) {
    std::string printable(text);
    std::replace_if(
        printable.begin(), printable.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return printable;
}

std::string unitText(std::string_view text) {
    return printableText(text) == text && text.size() <= maxUnit ? std::string(text) : std::string();
}

}  // namespace mote::prep
