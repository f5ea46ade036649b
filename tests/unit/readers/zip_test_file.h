// SPDX-License-Identifier: GPL-3.0-or-later
//
// ZipTestFile: writes zip archives for the tests, with every form and lie that they need. One owner, one
// thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace mote::test {

class ZipTestFile {
  public:
    /// How an entry is written; what is set here goes before the truth.
    struct Form {
        bool deflated = false;
        bool wide = false;  ///< sizes and offset in zip64 fields, also of the entry's own header
        std::optional<std::uint16_t> method, flags;
        std::optional<std::uint32_t> checksum, bytes, storedBytes, offset;
        std::optional<std::string> localName;
    };

    void add(const std::string& name, const std::string& content, const Form& form);
    void add(const std::string& name, const std::string& content) { add(name, content, Form()); }
    /// The archive, `wide`: with the records of zip64; `comment` behind it.
    std::string bytes(bool wide = false, const std::string& comment = "") const;
    /// Stands before the first entry; call it before add().
    void prefix(const std::string& junk) { archive_ += junk; }

  private:
    std::string archive_, directory_;
    std::uint16_t entries_ = 0;
};

/// RFC 1951, without any header.
std::string rawDeflated(const std::string& bytes);

}  // namespace mote::test
