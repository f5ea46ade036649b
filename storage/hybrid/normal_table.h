// SPDX-License-Identifier: GPL-3.0-or-later
//
// NormalTable: normals as one byte, an index into directions spread evenly over the sphere (section 3.2.1.3
// of the dissertation). Shared by the job that writes them, the devices that light them, and the tests. A
// value that never changes; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace mote::storage {

class NormalTable {
  public:
    /// The code of a place without a gradient: it has no direction and is lit from nowhere.
    static constexpr std::uint8_t none = 0;
    static constexpr int directions = 255;

    NormalTable();

    /// Unit length; zero for `none`.
    const glm::vec3& direction(std::uint8_t code) const { return directions_[code]; }
    /// The code of the nearest direction, the lower of two that are equally near. `vector` has any length;
    /// `none` if that is zero or not finite.
    std::uint8_t code(const glm::vec3& vector) const;

  private:
    std::array<glm::vec3, directions + 1> directions_{};
    /// The codes that are the nearest of some direction in each cell of an octahedral map.
    std::vector<std::uint8_t> nearby_;
    std::vector<std::uint32_t> nearbyBegin_;
};

}  // namespace mote::storage
