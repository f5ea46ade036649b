// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lists of datasets and files share: what is found in them, the row that keys move, and how dates are
// told. Main thread, what draws within a Dear ImGui frame.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace mote::client {

/// "2026-11-28 14:05", by this machine's clock; empty if it is not known. `unixMs`: Unix time.
std::string dateOf(std::int64_t unixMs);

/// RowSearch: the rows of a list that hold all words that were typed, in an order. A value.
class RowSearch {
  public:
    /// Less than 0 if one row stands before another by a column.
    using Compare = std::function<int(int column, int one, int other)>;

    void clear();
    /// Adds a row: all that it is found by.
    void add(std::string_view text);
    std::size_t size() const { return texts_.size(); }
    /// Rows by their numbers; the same question is answered at once until there are others. Of equal ones,
    /// the first stands first.
    const std::vector<int>& find(std::string_view typed, int column, bool descending, const Compare& compare);

  private:
    std::vector<std::string> texts_;  // lower case
    std::string typed_;
    int column_ = 0;
    bool descending_ = false, known_ = false;
    std::vector<int> found_;
};

/// Moves a marked row by the arrows and by pages, within the list that is drawn, and scrolls to it. `height`:
/// of a row, pixels.
void moveRow(int& row, int count, float height);

}  // namespace mote::client
