// SPDX-License-Identifier: GPL-3.0-or-later
//
// Inbox: callbacks on their way from the I/O thread to the owner's, in order. News of a state (a job, the
// catalogue) has a key; newer news of the same key takes the older one's place at the end, so that an owner
// who seldom looks costs bounded memory. Its owner guards it.
#pragma once

#include <deque>
#include <functional>
#include <string>
#include <utility>

namespace mote::client {

class Inbox {
  public:
    using Callback = std::function<void()>;

    /// An empty key: kept whatever comes later.
    void push(std::string key, Callback callback) {
        if (!key.empty()) {
            std::erase_if(entries_, [&](const Entry& entry) { return entry.key == key; });
        }
        entries_.push_back({std::move(key), std::move(callback)});
    }
    bool empty() const { return entries_.empty(); }

    struct Entry {
        std::string key;
        Callback callback;
    };
    std::deque<Entry> takeAll() { return std::exchange(entries_, {}); }

  private:
    std::deque<Entry> entries_;
};

}  // namespace mote::client
