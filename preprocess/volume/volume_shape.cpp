// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/volume_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <type_traits>

#include "preprocess/readers/half_float.h"
#include "preprocess/readers/text/number.h"
#include "protocol/scene/mote_check.h"

namespace mote::prep {
namespace {

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
