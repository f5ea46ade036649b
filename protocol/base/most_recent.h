// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lists of what was used last, kept short: the latest use stands in front. Pure functions; the list's owner
// locks it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <list>
#include <utility>

namespace mote {

/// The element that fits, moved to the front; null where there is none.
template <class T, class Fits>
T* mostRecent(std::list<T>& list, const Fits& fits) {
    const auto found = std::find_if(list.begin(), list.end(), fits);
    if (found == list.end()) return nullptr;
    list.splice(list.begin(), list, found);
    return &list.front();
}

/// Puts a new element in front; the last one goes where there are more than `most`.
template <class T>
T& keepMostRecent(std::list<T>& list, std::size_t most, T value) {
    list.push_front(std::move(value));
    if (list.size() > most) list.pop_back();
    return list.front();
}

/// The element that fits, else what `make` gives, in front of the list.
template <class T, class Fits, class Make>
T& mostRecent(std::list<T>& list, std::size_t most, const Fits& fits, const Make& make) {
    if (T* const known = mostRecent(list, fits)) return *known;
    return keepMostRecent(list, most, make());
}

}  // namespace mote
