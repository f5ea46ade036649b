// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/hdf5/h5_column.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace mote::prep {
namespace {

/// Larger chunks would be decoded by each of several threads that want a part of them.
constexpr std::uint64_t mostChunkBytes = std::uint64_t{1} << 20;
constexpr std::size_t bytesTogether = std::size_t{1} << 15;  // with what is made of them, in a core's cache

bool readBytes(int file, std::uint64_t offset, std::span<std::byte> bytes) {
    while (!bytes.empty()) {
        const auto got = ::pread(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;  // an error, or the file has become shorter
        offset += static_cast<std::uint64_t>(got);
        bytes = bytes.subspan(static_cast<std::size_t>(got));
    }
    return true;
}

}  // namespace

Result<H5Column> H5Column::open(const H5File& file, H5Object dataset) {
    MOTE_ASSIGN_OR_RETURN(auto numbers, H5Numbers::open(file, std::move(dataset), true));
    H5Column column(std::move(numbers));
    const auto& extent = column.numbers_.extent();
    for (std::size_t i = 0; i < extent.size(); ++i) {
        if (extent[i] == 1) continue;
        column.rows_ = extent[i];
        column.axis_ = i;
    }
    column.own_ = column.ownReading(file);
    return column;
}

std::optional<H5Column::Own> H5Column::ownReading(const H5File& file) const {
    const auto stored = storedAs(numbers_.type());
    if (!stored) return std::nullopt;
    if (numbers_.offset() && file.descriptor())
        return Own{*stored, file.descriptor(), *numbers_.offset(), nullptr, 0};
    hbool_t threads = false;
    if (numbers_.chunks() == nullptr || H5is_library_threadsafe(&threads) < 0 || !threads)
        return std::nullopt;
    const auto& shape = numbers_.chunks()->shape();
    const auto rows = shape[axis_];
    const bool flat = std::ranges::count(shape, hsize_t{1}) + (rows == 1 ? 0 : 1) ==
                      static_cast<std::ptrdiff_t>(shape.size());
    if (!flat || rows > mostChunkBytes / numbers_.valueBytes()) return std::nullopt;
    return Own{*stored, nullptr, 0, std::make_unique<H5ChunkStore>(), rows};
}

/// Nothing if it is no type of this machine.
std::optional<H5Column::Stored> H5Column::storedAs(hid_t type) {
    const std::pair<hid_t, Stored> types[] = {
        {H5T_NATIVE_DOUBLE, double{}},        {H5T_NATIVE_FLOAT, float{}},
        {H5T_NATIVE_INT8, std::int8_t{}},     {H5T_NATIVE_INT16, std::int16_t{}},
        {H5T_NATIVE_INT32, std::int32_t{}},   {H5T_NATIVE_INT64, std::int64_t{}},
        {H5T_NATIVE_UINT8, std::uint8_t{}},   {H5T_NATIVE_UINT16, std::uint16_t{}},
        {H5T_NATIVE_UINT32, std::uint32_t{}}, {H5T_NATIVE_UINT64, std::uint64_t{}},
    };
    for (const auto& [native, stored] : types) {
        if (H5Tequal(type, native) > 0) return stored;
    }
    return std::nullopt;
}

bool H5Column::readsIntegersAtOnce() const {
    return own_ && std::visit([](auto stored) { return std::is_integral_v<decltype(stored)>; }, own_->stored);
}

Status H5Column::read(std::uint64_t begin, std::size_t count, double* values) const {
    MOTE_RETURN_IF_ERROR(check(begin, count));
    if (own_) {
        return std::visit([&](auto stored) { return readOwn<decltype(stored)>(begin, count, values); },
                          own_->stored);
    }
    if (!numbers_.isNativeFloat()) return readAs(H5T_NATIVE_DOUBLE, begin, count, values);
    // HDF5 converts in a buffer of its own and copies twice: three times as slow.
    floats_.resize(count);
    MOTE_RETURN_IF_ERROR(readAs(H5T_NATIVE_FLOAT, begin, count, floats_.data()));
    std::copy(floats_.begin(), floats_.end(), values);
    return success();
}

Status H5Column::read(std::uint64_t begin, std::size_t count, std::uint64_t* values) const {
    MOTE_RETURN_IF_ERROR(check(begin, count));
    if (!readsIntegersAtOnce()) {
        return readAs(numbers_.isSigned() ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64, begin, count, values);
    }
    return std::visit(
        [&](auto stored) -> Status {
            if constexpr (std::is_integral_v<decltype(stored)>)
                return readOwn<decltype(stored)>(begin, count, values);
            return success();  // not reached: floats are HDF5's to convert
        },
        own_->stored);
}

Status H5Column::check(std::uint64_t begin, std::size_t count) const {
    if (begin <= rows_ && count <= rows_ - begin) return success();
    return corrupt(object().where, "has " + std::to_string(rows_) + " values; more were asked for");
}

template <class As, class Value>
Status H5Column::readOwn(std::uint64_t begin, std::size_t count, Value* values) const {
    constexpr bool same = std::is_same_v<As, Value>;
    constexpr std::size_t together = bytesTogether / sizeof(As);
    std::array<As, same ? 1 : together> stored;
    const std::size_t most = same ? std::max<std::size_t>(count, 1) : together;
    for (std::size_t at = 0; at < count; at += most) {
        const auto size = std::min(most, count - at);
        std::span<std::byte> bytes;
        if constexpr (same)
            bytes = std::as_writable_bytes(std::span(values, count));
        else
            bytes = std::as_writable_bytes(std::span(stored).first(size));
        MOTE_RETURN_IF_ERROR(fetch(begin + at, sizeof(As), bytes));
        if constexpr (!same) {
            for (std::size_t i = 0; i < size; ++i) values[at + i] = static_cast<Value>(stored[i]);
        }
    }
    return success();
}

Status H5Column::fetch(std::uint64_t begin, std::size_t valueBytes, std::span<std::byte> bytes) const {
    if (!own_->file) return fetchChunks(begin, valueBytes, bytes);
    if (readBytes(own_->file->get(), own_->offset + begin * valueBytes, bytes)) return success();
    return corrupt(object().where,
                   "rows from " + std::to_string(begin) + " on cannot be read: the file is damaged");
}

Status H5Column::fetchChunks(std::uint64_t begin, std::size_t valueBytes, std::span<std::byte> bytes) const {
    std::vector<hsize_t> first(numbers_.extent().size(), 0);
    while (!bytes.empty()) {
        first[axis_] = begin / own_->chunkRows * own_->chunkRows;
        auto chunk = own_->chunks->take(first);
        MOTE_RETURN_IF_ERROR(numbers_.chunks()->load(object().handle.get(), first, object().where, *chunk));
        const auto from = std::as_bytes(std::span(chunk->bytes)).subspan((begin - first[axis_]) * valueBytes);
        const auto size = std::min(bytes.size(), from.size());
        std::copy_n(from.begin(), size, bytes.begin());
        own_->chunks->giveBack(std::move(chunk));
        begin += size / valueBytes;
        bytes = bytes.subspan(size);
    }
    return success();
}

Status H5Column::readAs(hid_t memoryType, std::uint64_t begin, std::size_t count, void* values) const {
    if (count == 0) return success();
    std::vector<hsize_t> first(numbers_.extent().size(), 0), size(first.size(), 1);
    if (!first.empty()) {
        first[axis_] = begin;
        size[axis_] = count;
    }
    return numbers_.read(first, size, memoryType, values);
}

}  // namespace mote::prep
