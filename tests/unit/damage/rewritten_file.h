// SPDX-License-Identifier: GPL-3.0-or-later
//
// RewrittenFile: a file that somebody writes to and cuts off in place, never making it anew, while others
// have it open and mapped. One owner, one thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "tests/support/random.h"

namespace mote::test {

class RewrittenFile {
  public:
    explicit RewrittenFile(const std::filesystem::path& path);
    RewrittenFile(const RewrittenFile&) = delete;
    RewrittenFile& operator=(const RewrittenFile&) = delete;
    ~RewrittenFile();

    /// As it was when this was made.
    const std::string& original() const { return original_; }
    /// Bytes beyond the original's end are left out.
    void write(std::size_t at, std::string_view bytes) const;
    void cutOff(std::size_t at) const;
    void restore() const { write(0, original_); }

  private:
    std::string original_;
    int file_;
};

/// Some bytes of the file become what nobody chose: bytes of any values, all the same, those of `other`, or
/// those that were there.
void disturb(const RewrittenFile& file, const std::string& other, Random& random);

}  // namespace mote::test
