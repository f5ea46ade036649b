// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lists of millions of values in work that gives way (work_in_turns.h): the system fetches their memory as it
// is written to, which takes long, so they grow step by step. Functions of any thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "server/render/plan/work_in_turns.h"

namespace mote::render {

/// Values that are written before work may give way.
template <class T>
inline constexpr std::size_t longListStep = std::max<std::size_t>((std::size_t{1} << 20) / sizeof(T), 1);

/// Makes a list as long as `size`. New values are `value`; those that it had are of no meaning any more.
template <class T>
void resizeInTurns(std::vector<T>& list, std::size_t size, const T& value = T()) {
    if (list.capacity() < size) {
        list.clear();
        list.reserve(size);
    }
    while (list.size() < size) {
        list.resize(std::min(size, list.size() + longListStep<T>), value);
        giveWay();
    }
    list.resize(size);
}

template <class T>
std::vector<T> listInTurns(std::size_t size, const T& value = T()) {
    std::vector<T> list;
    resizeInTurns(list, size, value);
    return list;
}

template <class T>
std::vector<T> copyInTurns(const std::vector<T>& list) {
    std::vector<T> copy;
    copy.reserve(list.size());
    while (copy.size() < list.size()) {
        const auto from = list.begin() + static_cast<std::ptrdiff_t>(copy.size());
        const std::size_t step = std::min(longListStep<T>, list.size() - copy.size());
        copy.insert(copy.end(), from, from + static_cast<std::ptrdiff_t>(step));
        giveWay();
    }
    return copy;
}

}  // namespace mote::render
