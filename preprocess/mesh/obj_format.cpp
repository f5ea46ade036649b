// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <limits>

#include "preprocess/mesh/mesh_formats.h"
#include "preprocess/mesh/mesh_text.h"

namespace mote::prep {
namespace {

class ObjParser {
  public:
    ObjParser(std::string_view text, const std::string& name) : text_(text, name) {}

    Result<TriangleMesh> parse() {
        while (text_.nextLine()) {
            const auto key = text_.word();
            Status done = success();
            if (key == "v") done = addVertex();
            if (key == "f" || key == "fo") done = addFace();
            if (!done.ok()) return done.error();
        }
        MOTE_RETURN_IF_ERROR(checkForward());
        for (const auto& face : forward_) addPolygon(mesh_, face);
        return std::move(mesh_);
    }

  private:
    Status addVertex() {
        glm::vec3 position;
        for (int axis = 0; axis < 3; ++axis) {
            const auto value = MeshText::number(text_.word());
            if (!value) return text_.error("a vertex needs three numbers");
            position[axis] = static_cast<float>(*value);
        }
        mesh_.positions.push_back(position);
        return success();
    }

    /// "7", "7/1", "7//3", "7/1/3", "-1".
    Result<std::uint32_t> index(std::string_view word) const {
        const auto given = MeshText::integer(word.substr(0, word.find('/')));
        if (!given) return text_.error(fmt::format("\"{}\" is no vertex of a face", word.substr(0, 40)));
        const auto count = static_cast<std::int64_t>(mesh_.positions.size());
        const auto index = *given < 0 ? count + *given : *given - 1;
        if (*given == 0 || index < 0 || index >= std::numeric_limits<std::uint32_t>::max()) {
            return text_.error(fmt::format("a face names vertex {}, and {} stand before it", *given, count));
        }
        return static_cast<std::uint32_t>(index);
    }

    Status addFace() {
        corners_.clear();
        bool known = true;
        for (auto word = text_.word(); !word.empty(); word = text_.word()) {
            MOTE_ASSIGN_OR_RETURN(const auto corner, index(word));
            known = known && corner < mesh_.positions.size();
            corners_.push_back(corner);
        }
        if (corners_.size() < 3) return text_.error("a face needs three vertices");
        if (known) {
            addPolygon(mesh_, corners_);
        } else {
            forward_.push_back(corners_);
            forwardLine_.push_back(text_.line());
        }
        return success();
    }

    /// Faces may stand before their vertices.
    Status checkForward() const {
        for (std::size_t i = 0; i < forward_.size(); ++i) {
            for (const auto corner : forward_[i]) {
                if (corner < mesh_.positions.size()) continue;
                auto error = text_.error(fmt::format("the face of line {} names vertex {} of {}",
                                                     forwardLine_[i], corner + 1, mesh_.positions.size()));
                return error;
            }
        }
        return success();
    }

    MeshText text_;
    TriangleMesh mesh_;
    std::vector<std::uint32_t> corners_;
    std::vector<std::vector<std::uint32_t>> forward_;
    std::vector<std::uint64_t> forwardLine_;
};

}  // namespace

Result<TriangleMesh> parseObj(std::string_view text, const std::string& name) {
    return ObjParser(text, name).parse();
}

}  // namespace mote::prep
