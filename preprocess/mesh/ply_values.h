// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlyValues: the numbers behind the header of a PLY file, one after the other, whatever their encoding. A
// view of the file's bytes, which must outlive it; one thread.
#pragma once

#include <string>
#include <string_view>

#include "preprocess/mesh/mesh_text.h"
#include "preprocess/mesh/ply_header.h"

namespace mote::prep {

class PlyValues {
  public:
    PlyValues(std::string_view bytes, const PlyHeader& header, const std::string& name)
        : bytes_(bytes), encoding_(header.encoding), at_(header.bytes), text_(bytes, name), name_(name) {
        for (std::uint64_t line = 0; text_.line() < header.lines && text_.nextLine(); ++line) {
        }
        if (encoding_ == PlyEncoding::ascii) text_.nextLine();
    }

    /// Exact for every type that there is. Errors: corrupt (the end of the file, no number).
    Result<double> next(StoredNumber type) {
        return encoding_ == PlyEncoding::ascii ? nextText() : nextBinary(type);
    }
    /// Whether `count` more values of a type may still come.
    bool mayHold(std::uint64_t count, StoredNumber type) const;
    /// corrupt, at the line or byte that was reached.
    Error error(std::string message) const;

  private:
    Result<double> nextText();
    Result<double> nextBinary(StoredNumber type);

    std::string_view bytes_;
    PlyEncoding encoding_;
    std::size_t at_;
    MeshText text_;
    std::string name_;
};

}  // namespace mote::prep
