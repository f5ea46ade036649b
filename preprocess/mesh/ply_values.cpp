// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/ply_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace mote::prep {
namespace {

static_assert(std::endian::native == std::endian::little);

template <class T>
double valueOf(const std::array<char, 8>& bytes) {
    T value;
    std::memcpy(&value, bytes.data(), sizeof value);
    return static_cast<double>(value);
}

double valueOf(const std::array<char, 8>& bytes, PlyType type) {
    switch (type) {
        case PlyType::int8:
            return valueOf<std::int8_t>(bytes);
        case PlyType::uint8:
            return valueOf<std::uint8_t>(bytes);
        case PlyType::int16:
            return valueOf<std::int16_t>(bytes);
        case PlyType::uint16:
            return valueOf<std::uint16_t>(bytes);
        case PlyType::int32:
            return valueOf<std::int32_t>(bytes);
        case PlyType::uint32:
            return valueOf<std::uint32_t>(bytes);
        case PlyType::float32:
            return valueOf<float>(bytes);
        case PlyType::float64:
            return valueOf<double>(bytes);
    }
    return 0.0;
}

}  // namespace

bool PlyValues::mayHold(std::uint64_t count, PlyType type) const {
    const bool text = encoding_ == PlyEncoding::ascii;
    const std::size_t left =
        text ? bytes_.size() - text_.offset() + text_.restOfLine().size() : bytes_.size() - at_;
    return count <= left / (text ? 1 : bytesOf(type));
}

Error PlyValues::error(std::string message) const {
    if (encoding_ == PlyEncoding::ascii) return text_.error(std::move(message));
    return {ErrorCode::corrupt, fmt::format("{}: byte {}", name_, at_), std::move(message)};
}

Result<double> PlyValues::nextText() {
    const auto word = text_.wordAcrossLines();
    if (word.empty()) return error("ends before the values that its header says");
    const auto value = MeshText::number(word);
    if (!value) return error(fmt::format("\"{}\" is no number", word.substr(0, 40)));
    return *value;
}

Result<double> PlyValues::nextBinary(PlyType type) {
    const auto size = bytesOf(type);
    if (bytes_.size() - at_ < size) return error("ends before the values that its header says");
    std::array<char, 8> value{};
    std::memcpy(value.data(), bytes_.data() + at_, size);
    if (encoding_ == PlyEncoding::bigEndian) std::reverse(value.begin(), value.begin() + size);
    at_ += size;
    return valueOf(value, type);
}

}  // namespace mote::prep
