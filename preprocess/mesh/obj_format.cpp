// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "preprocess/mesh/mesh_formats.h"
#include "preprocess/mesh/mesh_text.h"

namespace mote::prep {
namespace {

/// Which part of the mesh a face belongs to. Each name is kept once, however many combinations it is in.
class PartNames {
  public:
    enum Kind : std::size_t { group, object, material };

    /// The words that are left of the line. Faces before any group are in the one named "default".
    void take(Kind kind, MeshText& text) {
        std::string name;
        for (auto word = text.word(); !word.empty(); word = text.word()) {
            if (!name.empty()) name += ' ';
            name += word;
        }
        if (kind == group && name == "default") name.clear();
        named_[kind] = std::move(name);
    }
    /// The part of the faces that follow, from 0 on as they are asked for.
    std::uint32_t part() {
        for (const Kind kind : {group, object, material}) {
            if (!named_[kind]) continue;
            current_[kind] = named_[kind]->empty() ? 0 : numberOf(numbers_[kind], *std::move(named_[kind]));
            named_[kind].reset();
        }
        return numberOf(parts_, current_) - 1;
    }

  private:
    /// From 1 on, in the order in which keys come.
    template <class Key>
    static std::uint32_t numberOf(std::map<Key, std::uint32_t>& numbers, Key key) {
        const auto next = static_cast<std::uint32_t>(numbers.size() + 1);
        return numbers.try_emplace(std::move(key), next).first->second;
    }

    std::array<std::map<std::string, std::uint32_t>, 3> numbers_;
    std::array<std::optional<std::string>, 3> named_;  // since the last face: names of none are not kept
    std::array<std::uint32_t, 3> current_{};           // 0: without a name
    std::map<std::array<std::uint32_t, 3>, std::uint32_t> parts_;
};

/// A face whose vertices follow it.
struct ForwardFace {
    std::vector<std::uint32_t> corners;
    std::uint64_t line;
    std::uint32_t part;
};

class ObjParser {
  public:
    ObjParser(std::string_view text, const std::string& name) : text_(text, name) {}

    Result<TriangleMesh> parse() {
        while (text_.nextLine()) {
            const auto key = text_.word();
            Status done = success();
            if (key == "v") done = addVertex();
            if (key == "f" || key == "fo") done = addFace();
            if (key == "g") names_.take(PartNames::group, text_);
            if (key == "o") names_.take(PartNames::object, text_);
            if (key == "usemtl") names_.take(PartNames::material, text_);
            if (!done.ok()) return done.error();
        }
        MOTE_RETURN_IF_ERROR(checkForward());
        for (const auto& face : forward_) add(face.corners, face.part);
        return toFloats(std::move(mesh_));
    }

  private:
    Status addVertex() {
        MOTE_ASSIGN_OR_RETURN(const auto position, text_.place());
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
        const auto part = names_.part();
        if (known) {
            add(corners_, part);
        } else {
            forward_.push_back({corners_, text_.line(), part});
        }
        return success();
    }

    /// Adds the face; as long as there is but one part, none are told.
    void add(std::span<const std::uint32_t> corners, std::uint32_t part) {
        if (part > 0) mesh_.parts.resize(mesh_.triangles.size());
        addPolygon(mesh_, corners);
        if (part > 0 || !mesh_.parts.empty()) mesh_.parts.resize(mesh_.triangles.size(), part);
    }

    /// Faces may stand before their vertices.
    Status checkForward() const {
        for (const auto& face : forward_) {
            for (const auto corner : face.corners) {
                if (corner < mesh_.positions.size()) continue;
                auto error = text_.error(fmt::format("the face of line {} names vertex {} of {}", face.line,
                                                     corner + 1, mesh_.positions.size()));
                return error;
            }
        }
        return success();
    }

    MeshText text_;
    ExactMesh mesh_;
    std::vector<std::uint32_t> corners_;
    PartNames names_;
    std::vector<ForwardFace> forward_;
};

}  // namespace

Result<TriangleMesh> parseObj(std::string_view text, const std::string& name) {
    return ObjParser(text, name).parse();
}

}  // namespace mote::prep
