// SPDX-License-Identifier: GPL-3.0-or-later
//
// Selection: which particles of a run, as a tree of conditions. A value; a parsed one is valid in itself
// (whether its columns exist, the dataset knows). What each condition means: docs/SELECTIONS.md.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/camera.h"
#include "protocol/scene/clip.h"

namespace mote {

struct Selection {
    static constexpr int maxDepth = 16;
    static constexpr int maxConditions = 256;                       ///< of the whole tree
    static constexpr std::size_t maxPolygonPoints = 100000;         ///< of one polygon or lasso
    static constexpr std::size_t maxValues = std::size_t{1} << 20;  ///< ids and points of the whole tree

    struct Range {
        std::string column;
        double min = -std::numeric_limits<double>::infinity();  ///< what equals a bound belongs to it
        double max = std::numeric_limits<double>::infinity();
        bool operator==(const Range&) const = default;
    };
    struct Polygon {
        std::string first, second;       ///< columns or derived quantities
        std::vector<glm::dvec2> points;  ///< at least 3; even-odd, closed
        bool operator==(const Polygon&) const = default;
    };
    /// One of the axes of a plot, as the plot places particles by it.
    struct PlotAxis {
        std::string column;           ///< or a derived quantity
        double min = 0.0, max = 0.0;  ///< its values at -1 and at 1, ascending
        bool operator==(const PlotAxis&) const = default;
    };
    struct Lasso {
        Camera camera;
        double aspect = 1.0;             ///< width over height of the picture
        glm::dmat4 transform{1.0};       ///< layer space to world space
        std::vector<glm::dvec2> points;  ///< at least 3; parts of the picture's width and height, y down
        std::optional<proto::Clip> clip = {};  ///< checked: what it cuts away is not surrounded
        std::vector<PlotAxis> plot = {};       ///< in which it was drawn, x, y, z; none: that of who is asked
        bool operator==(const Lasso&) const = default;
    };
    struct Density {
        double min = -std::numeric_limits<double>::infinity();  ///< scaled log density of the leaf
        double max = std::numeric_limits<double>::infinity();
        bool operator==(const Density&) const = default;
    };
    struct Outermost {
        char plane = 'x';    ///< 'x', 'y' or 'z'
        double share = 0.0;  ///< of the step's weight, 0 to 1
        bool operator==(const Outermost&) const = default;
    };

    std::vector<Range> ranges;
    std::optional<Density> density;
    std::optional<Polygon> polygon;
    std::optional<Lasso> lasso;
    std::optional<Outermost> outermost;
    std::vector<std::uint64_t> ids;     ///< ascending, without repetition
    std::optional<std::uint32_t> step;  ///< in which it was made: in other steps it holds the same ids
    std::vector<Selection> all, any;
    std::vector<Selection> negated;  ///< none or one
    bool nothing = false;            ///< it holds no particle, whatever else it says

    /// Whether it holds every particle.
    bool everything() const { return *this == Selection(); }
    bool operator==(const Selection& other) const;
};

/// One that others may refer to.
struct NamedSelection {
    std::string name;
    Selection selection;
    bool operator==(const NamedSelection&) const = default;
};

using NamedSelectionMessages = google::protobuf::RepeatedPtrField<proto::NamedSelection>;

/// Resolves names by `named`, the view's. Errors, at the field: invalidArgument (not finite, too deep, too
/// many conditions or points, a name that is not there or holds itself).
Result<Selection> parseSelection(const proto::Selection& message, const NamedSelectionMessages& named);
/// Where there are no names.
Result<Selection> parseSelection(const proto::Selection& message);

/// All of a view, resolved. Errors, within the list: also a name that is empty, too long or given twice.
Result<std::vector<NamedSelection>> parseNamedSelections(const NamedSelectionMessages& named);

/// How many ids and points of polygons and lassos the whole tree holds.
std::size_t valueCount(const Selection& selection);

/// The message of a valid selection, without names: parsing it gives it again.
proto::Selection toProto(const Selection& selection);

}  // namespace mote
