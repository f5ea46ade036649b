// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <limits>

#include "preprocess/mesh/mesh_formats.h"
#include "preprocess/mesh/mesh_text.h"

namespace mote::prep {
namespace {

class OffParser {
  public:
    OffParser(std::string_view text, const std::string& name)
        : text_(text, name), name_(name), bytes_(text.size()) {}

    Result<TriangleMesh> parse() {
        MOTE_RETURN_IF_ERROR(readHeader());
        MOTE_RETURN_IF_ERROR(readVertices());
        MOTE_RETURN_IF_ERROR(readFaces());
        return toFloats(std::move(mesh_));
    }

  private:
    Error unsupported(std::string message) const {
        return {ErrorCode::unsupported, name_, std::move(message)};
    }

    Status readHeader() {
        auto word = text_.wordAcrossLines();
        if (const auto mark = offMark(word)) {
            if (word.substr(0, *mark).find_first_of("4n") != std::string_view::npos) {
                return unsupported("is an OFF file of other than three dimensions, which is not read");
            }
            // ModelNet's files have the first count right behind it.
            word.remove_prefix(*mark + 3);
            if (word.empty()) word = text_.wordAcrossLines();
            if (word == "BINARY") return unsupported("is a binary OFF file, which is not read: use PLY");
        }
        for (auto* count : {&vertices_, &faces_}) {
            const auto value = MeshText::integer(word);
            // Each takes a line of its own: two bytes at least.
            if (!value || *value < 0 || static_cast<std::uint64_t>(*value) > bytes_ / 2) {
                return text_.error("the counts of vertices and faces do not fit the file");
            }
            *count = static_cast<std::uint64_t>(*value);
            if (count == &vertices_) word = text_.wordAcrossLines();
        }
        // The count of edges is often wrong, sometimes missing, and sometimes alone in a line.
        bool edges = false;
        while (!text_.word().empty()) edges = true;
        if (edges) return success();
        MeshText ahead = text_;
        const auto only = ahead.nextLine() ? ahead.word() : std::string_view();
        if (MeshText::integer(only) && ahead.word().empty()) text_ = ahead;
        return success();
    }

    Status readVertices() {
        mesh_.positions.reserve(vertices_);
        for (std::uint64_t i = 0; i < vertices_; ++i) {
            if (!text_.nextLine()) return text_.error(fmt::format("ends after {} vertices", i));
            MOTE_ASSIGN_OR_RETURN(const auto position, text_.place());
            mesh_.positions.push_back(position);
        }
        return success();
    }

    Status readFaces() {
        std::vector<std::uint32_t> corners;
        for (std::uint64_t i = 0; i < faces_; ++i) {
            if (!text_.nextLine()) return text_.error(fmt::format("ends after {} faces", i));
            const auto count = MeshText::integer(text_.word());
            if (!count || *count < 0) return text_.error("a face begins with its number of vertices");
            corners.clear();
            for (std::int64_t corner = 0; corner < *count; ++corner) {
                const auto index = MeshText::integer(text_.word());
                if (!index) return text_.error("a face has fewer vertices than it says");
                if (*index < 0 || static_cast<std::uint64_t>(*index) >= vertices_) {
                    return text_.error(fmt::format("a face names vertex {} of {}", *index, vertices_));
                }
                corners.push_back(static_cast<std::uint32_t>(*index));
            }
            addPolygon(mesh_, corners);
        }
        return success();
    }

    MeshText text_;
    std::string name_;
    std::uint64_t bytes_;
    std::uint64_t vertices_ = 0;
    std::uint64_t faces_ = 0;
    ExactMesh mesh_;
};

}  // namespace

std::optional<std::size_t> offMark(std::string_view word) {
    const auto mark = word.find("OFF");
    if (mark == std::string_view::npos || mark > 5) return std::nullopt;
    const auto before = word.substr(0, mark), behind = word.substr(mark + 3);
    const bool known = before.find_first_not_of("STCN4n") == std::string_view::npos &&
                       behind.find_first_not_of("0123456789") == std::string_view::npos;
    return known ? std::optional(mark) : std::nullopt;
}

Result<TriangleMesh> parseOff(std::string_view text, const std::string& name) {
    return OffParser(text, name).parse();
}

}  // namespace mote::prep
