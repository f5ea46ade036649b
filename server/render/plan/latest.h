// SPDX-License-Identifier: GPL-3.0-or-later
//
// A list of what was used last, kept short. A pure function.
#pragma once

#include <algorithm>
#include <list>

namespace mote::render {

/// The element that fits, or what `make` gives, in front of the list; the last one goes where there are more
/// than `kept`.
template <class T, class Fits, class Make>
T& latest(std::list<T>& list, std::size_t kept, const Fits& fits, const Make& make) {
    const auto found = std::find_if(list.begin(), list.end(), fits);
    if (found != list.end()) {
        list.splice(list.begin(), list, found);
    } else {
        list.push_front(make());
        if (list.size() > kept) list.pop_back();
    }
    return list.front();
}

}  // namespace mote::render
