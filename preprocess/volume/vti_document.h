// SPDX-License-Identifier: GPL-3.0-or-later
//
// VtiDocument: the elements of a VTK image file's XML that matter, as expat meets them. A value, free of
// threads.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/volume/byte_stream.h"
#include "preprocess/volume/header_fields.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// A DataArray element.
struct VtiArray {
    HeaderFields attributes;
    bool ofCells = false;         ///< not of points
    bool active = false;          ///< the Scalars of its points or cells
    std::uint64_t contentAt = 0;  ///< bytes of the file before what follows its tag

    bool isScalar() const {
        const auto count = attributes.text("NumberOfComponents");
        return count.empty() || count == "1";
    }
    /// Which points VTK hides, and numbers that it gives them for itself.
    bool isMark() const {
        const auto name = attributes.text("Name");
        return name == "vtkGhostType" || name == "vtkGhostLevels" || name == "vtkValidPointMask" ||
               name == "vtkOriginalPointIds" || name == "vtkOriginalCellIds" || name == "GlobalPointIds" ||
               name == "GlobalCellIds" || name == "GlobalNodeId" || name == "GlobalElementId";
    }
    /// Whether no array that follows can be the one to read: it has the name `field`, or is the active one of
    /// the points where there is no name.
    bool isSurely(std::string_view field) const {
        return field.empty() ? active && !ofCells && isScalar() && !isMark()
                             : attributes.text("Name") == field;
    }
};

struct VtiDocument {
    HeaderFields vtkFile, imageData, piece, appended;  ///< attributes; none where the element is missing
    std::vector<VtiArray> arrays;
    std::uint64_t appendedAt = 0;  ///< bytes of the file before what follows AppendedData; 0: there is none

    /// Reads `file` as far as needed to find the array `field`: expat never sees appended data, nor those of
    /// an array that is surely the one. Errors, at the file's name and line: corrupt (no XML; a document
    /// type; a tag of more than 1 MiB), unsupported (several pieces), cancelled, those of `file`.
    static Result<VtiDocument> parse(ByteStream& file, std::string_view field, const Progress& progress);

    /// The one that isSurely(), else, but for marks, without a name the first scalars of points, else of
    /// cells. Null: none.
    const VtiArray* chosen(std::string_view field) const;
};

}  // namespace mote::prep
