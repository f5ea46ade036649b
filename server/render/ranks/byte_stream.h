// SPDX-License-Identifier: GPL-3.0-or-later
//
// Values as the ranks of one run hand them to each other: programs of the same build, so what does not fit is
// an invariant of ours that is broken. Values; one thread.
#pragma once

#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "protocol/base/mote_check.h"
#include "server/render/ranks/ranks.h"

namespace mote::render {

class ByteWriter {
  public:
    template <class T>
    void put(const T& value) {
        putAll(std::span<const T>(&value, 1));
    }
    /// Values of which the reader knows how many there are.
    template <class T>
    void putAll(std::span<const T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        const auto bytes = std::as_bytes(values);
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    }
    /// The values of a list, and before them how many there are.
    template <class List>
    void putList(const List& list) {
        put(std::uint64_t{list.size()});
        putAll(std::span<const typename List::value_type>(list));
    }
    Bytes take() { return std::move(bytes_); }

  private:
    Bytes bytes_;
};

class ByteReader {
  public:
    /// What it reads must outlive it.
    explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    template <class T>
    T get() {
        T value;
        getAll(&value, 1);
        return value;
    }
    template <class List>
    List getList() {
        const auto size = get<std::uint64_t>();
        MOTE_CHECK(size <= bytes_.size());
        List list;
        list.resize(size);
        getAll(list.data(), size);
        return list;
    }
    /// A list of bytes, where it lies.
    std::span<const std::byte> getSpan() {
        const auto size = get<std::uint64_t>();
        MOTE_CHECK(size <= bytes_.size());
        const auto list = bytes_.first(size);
        bytes_ = bytes_.subspan(size);
        return list;
    }
    template <class T>
    void getAll(T* values, std::size_t count) {
        static_assert(std::is_trivially_copyable_v<T>);
        MOTE_CHECK(count <= bytes_.size() / sizeof(T));
        if (count > 0) std::memcpy(values, bytes_.data(), count * sizeof(T));
        bytes_ = bytes_.subspan(count * sizeof(T));
    }
    bool atEnd() const { return bytes_.empty(); }

  private:
    std::span<const std::byte> bytes_;
};

}  // namespace mote::render
