// SPDX-License-Identifier: GPL-3.0-or-later
//
// MeshText: the lines and words of a mesh file in memory, with the line's number for errors. A view of the
// text, which must outlive it; one thread.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/base/error.h"

namespace mote::prep {

class MeshText {
  public:
    /// `name` is the file's, for errors.
    MeshText(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {
        if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;  // a mark of UTF-8, which is no word
    }

    /// Goes to the next line that has a word, what stands behind '#' left out; a line that ends in '\' goes
    /// on in the next one. False at the end.
    bool nextLine();
    /// The next word of the line; empty at its end.
    std::string_view word();
    /// The next word of this line or of those that follow; empty at the end of the text.
    std::string_view wordAcrossLines();
    /// What follows the words that were taken, up to the line's end.
    std::string_view restOfLine() const { return line_; }

    /// The word as a number, nothing if it is none.
    static std::optional<double> number(std::string_view word);
    static std::optional<std::int64_t> integer(std::string_view word);

    /// Three words as a place. Errors: corrupt.
    Result<glm::dvec3> place();

    std::uint64_t line() const { return number_; }  ///< of the line that nextLine went to, from 1
    std::size_t offset() const { return at_; }      ///< bytes, of what follows that line
    /// corrupt, "NAME: line N".
    Error error(std::string message) const;

  private:
    std::string_view text_;
    std::string name_;
    std::string_view line_;
    bool goesOn_ = false;  ///< in the next line
    std::size_t at_ = 0;
    std::uint64_t number_ = 0;
};

}  // namespace mote::prep
