// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/residual_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string_view>

#include "storage/hybrid/residual_encoder.h"
#include "storage/hybrid/residual_file.h"

namespace mote::storage {
namespace {

constexpr std::uint64_t kMagic = 0x56444220;
constexpr std::uint32_t kFloats = 0x2;  // compression of values: active ones alone, and no other
constexpr std::uint32_t kLongestText = 1024, kMostMetadata = 64, kLargestMetadata = 4096;
constexpr std::uint32_t kTopSide = 4096, kNodeSide = residualNodeBricks * residualBrickSide;
constexpr std::uint32_t kTopNodes = kTopSide / kNodeSide;

/// What a map of each kind has behind its name (math/Maps.h): of 8 bytes each.
constexpr std::pair<std::string_view, std::uint64_t> kMaps[] = {
    {"AffineMap", 16},
    {"UnitaryMap", 16},
    {"TranslationMap", 3},
    {"ScaleMap", 15},
    {"UniformScaleMap", 15},
    {"ScaleTranslateMap", 18},
    {"UniformScaleTranslateMap", 18},
};

float fromHalf(std::uint16_t half) {
    const auto magnitude = static_cast<std::uint32_t>(half & 0x7fffU);
    // Of an infinity or none at all nobody keeps the bits: it is no multiple of a step.
    if (magnitude >= 0x7c00U) return std::numeric_limits<float>::infinity();
    const float value = std::bit_cast<float>(magnitude << 13U) * 0x1p112F;
    return half & 0x8000U ? -value : value;
}

/// Calls visit(i) for each bit i that is set; ends with the first error.
template <class Visit>
Status eachBit(std::span<const std::uint64_t> words, const Visit& visit) {
    for (std::size_t word = 0; word < words.size(); ++word) {
        for (auto rest = words[word]; rest != 0; rest &= rest - 1) {
            const auto bit = static_cast<std::size_t>(std::countr_zero(rest));
            MOTE_RETURN_IF_ERROR(visit(static_cast<std::uint32_t>(word * 64 + bit)));
        }
    }
    return success();
}

/// The place of child `offset` of a node with `side` children along each axis, z fastest.
GridSize childOf(const GridSize& origin, std::uint32_t offset, std::uint32_t side, std::uint32_t childSide) {
    return {origin[0] + offset / side / side * childSide, origin[1] + offset / side % side * childSide,
            origin[2] + offset % side * childSide};
}

bool lies(const GridSize& place, const GridSize& within) {
    return place[0] < within[0] && place[1] < within[1] && place[2] < within[2];
}

}  // namespace

Error ResidualReader::damaged(std::string message) const {
    return {ErrorCode::corrupt, where_, std::move(message)};
}

Status ResidualReader::take(std::span<std::byte> bytes) {
    const auto count = static_cast<std::streamsize>(bytes.size());
    if (bytes_.sgetn(reinterpret_cast<char*>(bytes.data()), count) != count) return damaged("ends too early");
    at_ += bytes.size();
    return success();
}

template <class T>
Status ResidualReader::take(T& value) {
    return take(std::as_writable_bytes(std::span(&value, 1)));
}

Status ResidualReader::skip(std::uint64_t count) {
    std::array<std::byte, 512> unused;
    while (count > 0) {
        const auto now = std::min<std::uint64_t>(count, unused.size());
        MOTE_RETURN_IF_ERROR(take(std::span(unused).first(now)));
        count -= now;
    }
    return success();
}

Status ResidualReader::takeText(std::string& text) {
    std::uint32_t length = 0;
    MOTE_RETURN_IF_ERROR(take(length));
    if (length > kLongestText) return damaged("holds a name that is too long");
    text.resize(length);
    return take(std::as_writable_bytes(std::span(text)));
}

Status ResidualReader::read(const Visit& visit, const Cancelled& cancelled) {
    MOTE_RETURN_IF_ERROR(readHead());
    MOTE_RETURN_IF_ERROR(readMetadata());
    MOTE_RETURN_IF_ERROR(readTransform());
    MOTE_RETURN_IF_ERROR(readTree(cancelled));
    return readValues(visit);
}

/// Of the archive and of its one grid.
Status ResidualReader::readHead() {
    std::uint64_t magic = 0, gridAt = 0;
    std::uint32_t version = 0, metadata = 0, grids = 0, compression = 0;
    std::uint8_t offsets = 0;
    MOTE_RETURN_IF_ERROR(take(magic));
    MOTE_RETURN_IF_ERROR(take(version));
    if (magic != kMagic || version != residualFileVersion)
        return damaged(fmt::format("is no OpenVDB file of version {}", residualFileVersion));
    MOTE_RETURN_IF_ERROR(skip(8));  // the library's version
    MOTE_RETURN_IF_ERROR(take(offsets));
    MOTE_RETURN_IF_ERROR(skip(36));  // its identity
    MOTE_RETURN_IF_ERROR(take(metadata));
    MOTE_RETURN_IF_ERROR(take(grids));
    if (offsets != 1 || metadata != 0 || grids != 1) return damaged("holds other things than one grid");
    std::string name, type, parent;
    for (auto* text : {&name, &type, &parent}) MOTE_RETURN_IF_ERROR(takeText(*text));
    halves_ = type == "Tree_float_5_4_3_HalfFloat";
    if (name != residualGridName || (!halves_ && type != "Tree_float_5_4_3") || !parent.empty())
        return damaged("holds no FloatGrid \"residual\"");
    for (auto* place : {&gridAt, &valuesAt_, &endAt_}) MOTE_RETURN_IF_ERROR(take(*place));
    if (gridAt != at_) return damaged("has its grid at another place than it says");
    MOTE_RETURN_IF_ERROR(take(compression));
    if (compression != kFloats) return damaged("has compressed values, where the whole file is");
    return success();
}

/// It tells others what the manifest has told already.
Status ResidualReader::readMetadata() {
    std::uint32_t count = 0;
    MOTE_RETURN_IF_ERROR(take(count));
    if (count > kMostMetadata) return damaged("holds too many metadata");
    std::string text;
    for (std::uint32_t i = 0; i < count; ++i) {
        std::uint32_t size = 0;
        MOTE_RETURN_IF_ERROR(takeText(text));
        MOTE_RETURN_IF_ERROR(takeText(text));
        MOTE_RETURN_IF_ERROR(take(size));
        if (size > kLargestMetadata) return damaged("holds metadata that are too large");
        MOTE_RETURN_IF_ERROR(skip(size));
    }
    return success();
}

/// As above.
Status ResidualReader::readTransform() {
    std::string kind;
    MOTE_RETURN_IF_ERROR(takeText(kind));
    for (const auto& [name, numbers] : kMaps) {
        if (kind == name) return skip(numbers * sizeof(double));
    }
    return damaged("holds an unknown transform");
}

Status ResidualReader::readTree(const Cancelled& cancelled) {
    std::uint32_t buffers = 0, tiles = 0, tops = 0;
    float background = 0.0F;
    MOTE_RETURN_IF_ERROR(take(buffers));
    MOTE_RETURN_IF_ERROR(take(background));
    MOTE_RETURN_IF_ERROR(take(tiles));
    MOTE_RETURN_IF_ERROR(take(tops));
    if (buffers != 1 || background != 0.0F) return damaged("is not 0 where it holds no sample");
    if (tiles != 0) return damaged("holds tiles, where all are single samples");
    // Each has a brick.
    if (tops > promise_.bricks) return damaged("has not as many samples as the manifest says");
    for (std::uint32_t i = 0; i < tops; ++i) MOTE_RETURN_IF_ERROR(readTop(cancelled));
    if (bricks_.size() != promise_.bricks || at_ != valuesAt_)
        return damaged("has not as many samples as the manifest says");
    return success();
}

/// A node's masks: of its children, which are some, and of the values that it has itself, which are none. A
/// node without children would cost a few packed bytes and as much time as one that has a brick.
template <std::size_t Words>
Status ResidualReader::readNodeMasks(std::span<std::uint64_t, Words> children) {
    std::array<std::uint64_t, Words> own;
    std::uint8_t kind = 0;
    MOTE_RETURN_IF_ERROR(take(std::as_writable_bytes(children)));
    MOTE_RETURN_IF_ERROR(take(own));
    MOTE_RETURN_IF_ERROR(take(kind));
    const auto empty = [](std::span<const std::uint64_t> words) {
        return std::all_of(words.begin(), words.end(), [](auto word) { return word == 0; });
    };
    if (!empty(own) || kind != 0) return damaged("holds tiles, where all are single samples");
    return empty(children) ? Status(damaged("holds a node without samples")) : success();
}

Status ResidualReader::readTop(const Cancelled& cancelled) {
    GridSize origin{};
    MOTE_RETURN_IF_ERROR(take(origin));
    if (!lies(origin, promise_.size) ||
        std::any_of(origin.begin(), origin.end(), [](auto at) { return at % kTopSide != 0; })) {
        return damaged("holds a sample outside of the error grid");
    }
    constexpr std::int64_t many = maxGridSide;
    const auto number = (origin[0] * many + origin[1]) * many + origin[2];
    if (number <= lastTop_) return damaged("holds a node twice, or out of its order");
    lastTop_ = number;
    std::array<std::uint64_t, kTopNodes * kTopNodes * kTopNodes / 64> children;
    MOTE_RETURN_IF_ERROR(readNodeMasks(std::span(children)));
    return eachBit(children, [&](std::uint32_t i) {
        return readNode(childOf(origin, i, kTopNodes, kNodeSide), cancelled);
    });
}

Status ResidualReader::readNode(const GridSize& origin, const Cancelled& cancelled) {
    if (cancelled && cancelled()) return Error{ErrorCode::cancelled, where_, "cancelled"};
    constexpr auto side = residualNodeBricks;
    std::array<std::uint64_t, side * side * side / 64> children;
    MOTE_RETURN_IF_ERROR(readNodeMasks(std::span(children)));
    return eachBit(children, [&](std::uint32_t i) -> Status {
        const auto brick = childOf(origin, i, side, residualBrickSide);
        if (!lies(brick, promise_.size)) return damaged("holds a sample outside of the error grid");
        if (bricks_.size() == promise_.bricks) return damaged("has not as many samples as the manifest says");
        bricks_.push_back(brick);
        return skip(residualBrickSamples / 8);  // its mask, which comes again
    });
}

Status ResidualReader::readValues(const Visit& visit) {
    std::array<float, residualBrickSamples> values;
    for (const auto& brick : bricks_) {
        MOTE_RETURN_IF_ERROR(readBrick(brick, values));
        constexpr auto side = residualBrickSide;
        if (!visit({brick[0] / side, brick[1] / side, brick[2] / side}, values)) return success();
    }
    const bool ended = bytes_.sgetc() == std::streambuf::traits_type::eof();
    if (samples_ != promise_.samples || at_ != endAt_ || !ended)
        return damaged("has not as many samples as the manifest says");
    return success();
}

Status ResidualReader::readBrick(const GridSize& brick, std::span<float, residualBrickSamples> values) {
    std::array<std::uint64_t, residualBrickSamples / 64> mask;
    std::uint8_t kind = 0;
    MOTE_RETURN_IF_ERROR(take(mask));
    MOTE_RETURN_IF_ERROR(take(kind));
    if (kind != 0) return damaged("is not 0 where it holds no sample");
    std::size_t count = 0;
    for (const auto word : mask) count += static_cast<std::size_t>(std::popcount(word));
    samples_ += count;
    std::array<std::byte, residualBrickSamples * sizeof(float)> bytes;
    const auto size = halves_ ? sizeof(std::uint16_t) : sizeof(float);
    MOTE_RETURN_IF_ERROR(take(std::span(bytes).first(count * size)));
    std::ranges::fill(values, 0.0F);
    const auto* next = bytes.data();
    return eachBit(mask, [&](std::uint32_t i) -> Status {
        if (!lies(childOf(brick, i, residualBrickSide, 1), promise_.size))
            return damaged("holds a sample outside of the error grid");
        if (halves_) {
            std::uint16_t half = 0;
            std::copy_n(next, size, std::as_writable_bytes(std::span(&half, 1)).begin());
            values[i] = fromHalf(half);
        } else {
            std::copy_n(next, size, std::as_writable_bytes(std::span(&values[i], 1)).begin());
        }
        next += size;
        return success();
    });
}

}  // namespace mote::storage
