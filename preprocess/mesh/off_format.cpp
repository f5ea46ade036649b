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
        return std::move(mesh_);
    }

  private:
    Error unsupported(std::string message) const {
        return {ErrorCode::unsupported, name_, std::move(message)};
    }

    Status readHeader() {
        auto word = text_.wordAcrossLines();
        if (word.ends_with("OFF")) {
            if (word.find_first_of("4n") != std::string_view::npos) {
                return unsupported("is an OFF file of other than three dimensions, which is not read");
            }
            word = text_.wordAcrossLines();
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
        // The count of edges is often wrong, and sometimes missing.
        while (!text_.word().empty()) {
        }
        return success();
    }

    Status readVertices() {
        mesh_.positions.reserve(vertices_);
        for (std::uint64_t i = 0; i < vertices_; ++i) {
            if (!text_.nextLine()) return text_.error(fmt::format("ends after {} vertices", i));
            glm::vec3 position;
            for (int axis = 0; axis < 3; ++axis) {
                const auto value = MeshText::number(text_.word());
                if (!value) return text_.error("a vertex needs three numbers");
                position[axis] = static_cast<float>(*value);
            }
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
    TriangleMesh mesh_;
};

}  // namespace

Result<TriangleMesh> parseOff(std::string_view text, const std::string& name) {
    return OffParser(text, name).parse();
}

}  // namespace mote::prep
