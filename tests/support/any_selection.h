// SPDX-License-Identifier: GPL-3.0-or-later
//
// Selections that nobody chose. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "protocol/scene/selection.h"
#include "tests/support/random.h"

namespace mote::test {

/// What a generated selection may speak of.
struct SelectionShape {
    struct Column {
        std::string name;
        double low, high;  ///< where most of its values lie
    };
    std::vector<Column> columns;
    bool density = true;
    bool lasso = true;
    std::string planes = "xyz";    ///< of outermost; empty: none
    std::uint64_t ids = 0;         ///< as many, from 0; 0: none
    std::uint32_t steps = 0;       ///< as many, from 0; 0: none
    int depth = 3;                 ///< of selections in each other
    std::uint64_t mostPoints = 9;  ///< of a polygon
    bool nothing = false;          ///< some of them, or of their parts, hold no particle
};

/// A valid one; most hold some particles and not others.
Selection anySelection(Random& random, const SelectionShape& shape);

/// A closed line within a box: a star, a triangle, or corners anywhere, some of them the same or on one line.
std::vector<glm::dvec2> anyPolygon(Random& random, glm::dvec2 low, glm::dvec2 high, std::uint64_t most);

}  // namespace mote::test
