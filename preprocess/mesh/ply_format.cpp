// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>

#include "preprocess/mesh/mesh_formats.h"
#include "preprocess/mesh/ply_values.h"

namespace mote::prep {
namespace {

enum class Meaning { nothing, x, y, z, polygon, strips };

Meaning meaningOf(const PlyElement& element, const PlyProperty& property) {
    const bool indices = property.name == "vertex_indices" || property.name == "vertex_index";
    if (property.countType) {
        if (element.name == "face" && indices) return Meaning::polygon;
        return element.name == "tristrips" && indices ? Meaning::strips : Meaning::nothing;
    }
    if (element.name != "vertex") return Meaning::nothing;
    if (property.name == "x") return Meaning::x;
    if (property.name == "y") return Meaning::y;
    return property.name == "z" ? Meaning::z : Meaning::nothing;
}

class PlyParser {
  public:
    PlyParser(std::string_view bytes, PlyHeader header, const std::string& name)
        : header_(std::move(header)), values_(bytes, header_, name), name_(name) {}

    Result<TriangleMesh> parse() {
        MOTE_RETURN_IF_ERROR(checkMeanings());
        for (const auto& element : header_.elements) {
            for (std::uint64_t i = 0; i < element.count; ++i) MOTE_RETURN_IF_ERROR(read(element));
        }
        MOTE_RETURN_IF_ERROR(addWaiting());
        return toFloats(std::move(mesh_));
    }

  private:
    /// Vertices have a place. What names them may stand before them, and waits then until they are there.
    Status checkMeanings() {
        int axes = 0;
        bool indexed = false;
        for (const auto& element : header_.elements) {
            for (const auto& property : element.properties) {
                const auto meaning = meaningOf(element, property);
                if (meaning == Meaning::x || meaning == Meaning::y || meaning == Meaning::z) ++axes;
                const bool indices = meaning == Meaning::polygon || meaning == Meaning::strips;
                if (indices && isFraction(property.type)) {
                    return corrupt(name_, "its faces name vertices by fractions");
                }
                indexed = indexed || indices;
            }
            if (element.name != "vertex") continue;
            mesh_.positions.reserve(element.count);
            vertices_ = element.count;
        }
        if (axes != 3) return corrupt(name_, "its vertices have not one x, y and z each");
        if (indexed) return success();
        return unsupported(name_, "has no faces: a cloud of points is no mesh");
    }

    Status read(const PlyElement& element) {
        glm::dvec3 position(0.0);
        for (const auto& property : element.properties) {
            const auto meaning = meaningOf(element, property);
            if (property.countType) {
                MOTE_RETURN_IF_ERROR(readList(property, meaning));
                continue;
            }
            MOTE_ASSIGN_OR_RETURN(const auto value, values_.next(property.type));
            if (meaning == Meaning::x) position.x = value;
            if (meaning == Meaning::y) position.y = value;
            if (meaning == Meaning::z) position.z = value;
        }
        if (element.name == "vertex") mesh_.positions.push_back(position);
        return success();
    }

    Status readList(const PlyProperty& property, Meaning meaning) {
        MOTE_ASSIGN_OR_RETURN(const auto count, values_.next(*property.countType));
        if (!(count >= 0.0) || count != std::floor(count) || count > 4294967295.0 ||
            !values_.mayHold(static_cast<std::uint64_t>(count), property.type)) {
            return values_.error(fmt::format("a list of {} values does not fit the file", count));
        }
        corners_.clear();
        const auto length = static_cast<std::uint64_t>(count);
        for (std::uint64_t i = 0; i < length; ++i) {
            MOTE_ASSIGN_OR_RETURN(const auto value, values_.next(property.type));
            if (meaning == Meaning::nothing) continue;
            if (meaning == Meaning::strips && value == -1.0) {
                addStrip();
                continue;
            }
            if (!(value >= 0.0) || value >= static_cast<double>(vertices_) || value != std::floor(value)) {
                return values_.error(fmt::format("a face names vertex {} of {}", value, vertices_));
            }
            corners_.push_back(static_cast<std::uint32_t>(value));
        }
        if (meaning == Meaning::polygon && mesh_.positions.size() < vertices_) {
            waiting_.insert(waiting_.end(), corners_.begin(), corners_.end());
            waitingCounts_.push_back(static_cast<std::uint32_t>(corners_.size()));
        } else if (meaning == Meaning::polygon) {
            addPolygon(mesh_, corners_);
        }
        if (meaning == Meaning::strips) addStrip();
        return success();
    }

    /// Polygons that stood before their vertices.
    Status addWaiting() {
        if (mesh_.positions.size() < vertices_) return values_.error("has fewer vertices than it says");
        std::span<const std::uint32_t> left(waiting_);
        for (const auto count : waitingCounts_) {
            addPolygon(mesh_, left.first(count));
            left = left.subspan(count);
        }
        return success();
    }

    /// Every other triangle of a strip turns the other way round.
    void addStrip() {
        for (std::size_t i = 2; i < corners_.size(); ++i) {
            const auto a = corners_[i - 2];
            const auto b = corners_[i - 1];
            if (i % 2 == 0) {
                mesh_.triangles.push_back({a, b, corners_[i]});
            } else {
                mesh_.triangles.push_back({b, a, corners_[i]});
            }
        }
        corners_.clear();
    }

    PlyHeader header_;
    PlyValues values_;
    std::string name_;
    ExactMesh mesh_;
    std::uint64_t vertices_ = 0;
    std::vector<std::uint32_t> corners_, waiting_, waitingCounts_;
};

}  // namespace

Result<TriangleMesh> parsePly(std::string_view bytes, const std::string& name) {
    MOTE_ASSIGN_OR_RETURN(auto header, readPlyHeader(bytes, name));
    return PlyParser(bytes, std::move(header), name).parse();
}

}  // namespace mote::prep
