// SPDX-License-Identifier: GPL-3.0-or-later
//
// RewrittenFile: a file that somebody writes to and cuts off in place, never making it anew, while others
// have it open and mapped. One owner, one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "tests/support/random.h"
#include "tests/unit/damage/damaged_dataset.h"

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

// Damage that no hash tells, in datasets of any kind: every hash is made anew from what lies on the disk.

/// The blocks in the digests of all arrays, the files in the manifest, and the manifest's own digest. What
/// cannot be read as what it should be is left as it is.
void forgeHashes(const std::filesystem::path& dataset);

// A dataset whose files somebody rewrites, cuts off and puts back in place while it is read, drawn and
// counted. A function that makes threads of its own.

/// Asks so many questions, each of a dataset that is as it was made when it is asked; meanwhile a thread
/// changes some of it, a little earlier or later. The dataset counts the answers. Returns how often it was
/// changed.
std::uint64_t askWhileRewritten(DamagedDataset& dataset, std::uint64_t questions, std::uint64_t seed);

}  // namespace mote::test
