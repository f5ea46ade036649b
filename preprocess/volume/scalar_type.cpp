// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/scalar_type.h"

#include <algorithm>
#include <array>

#include "preprocess/readers/load_number.h"
#include "protocol/scene/mote_check.h"

namespace mote::prep {
namespace {

struct TypeName {
    std::string_view name;
    std::size_t bytes;
};
/// Names and sizes by ScalarType.
constexpr std::array<TypeName, 8> types{
    {{"u8", 1}, {"i8", 1}, {"u16", 2}, {"i16", 2}, {"u32", 4}, {"i32", 4}, {"f32", 4}, {"f64", 8}}};

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
    }
}

}  // namespace mote::prep
