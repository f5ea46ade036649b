// SPDX-License-Identifier: GPL-3.0-or-later
//
// Words: those of a line of an input, one after the other. A value; any thread.
#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>

namespace mote::test {

class Words {
  public:
    explicit Words(std::string_view line, char between = ' ') : rest_(line), between_(between) {}

    bool atEnd() const { return rest_.empty(); }
    /// "" behind the last one.
    std::string next() {
        const auto end = std::min(rest_.find(between_), rest_.size());
        std::string word = rest_.substr(0, end);
        rest_.erase(0, end + 1);
        return word;
    }
    /// `missing` where the next word is no number.
    template <class Number>
    Number number(Number missing) {
        const std::string word = next();
        Number value{};
        const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
        return code == std::errc() ? value : missing;
    }
    const std::string& rest() const { return rest_; }

  private:
    std::string rest_;
    char between_;
};

}  // namespace mote::test
