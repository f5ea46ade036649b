// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the tests of openPMD files share: the root's attributes, three particles, and a comparison.
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "tests/unit/readers/h5_test_file.h"

namespace mote::test {

// One eV/c in kg m/s, as BeamPhysics files write it.
inline constexpr double electronvolt = prep::elementaryCharge / prep::speedOfLight;

inline void writeRoot(H5TestFile& file, const std::string& basePath, const std::string& particlesPath) {
    file.text("/", "openPMD", "1.1.0");
    file.text("/", "basePath", basePath);
    file.text("/", "particlesPath", particlesPath);
}

/// Three particles at `path`: positions in mm, momenta in eV/c.
inline void writeParticles(H5TestFile& file, const std::string& path, double shift = 0.0) {
    for (const char* axis : {"x", "y", "z"}) {
        const double base = shift + 10.0 * (axis[0] - 'x');
        file.data(path + "/position/" + axis, std::vector<double>{base + 1, base + 2, base + 3});
        file.attribute(path + "/position/" + axis, "unitSI", 1e-3);
        file.data(path + "/momentum/" + axis, std::vector<double>{base + 100, base + 200, base + 300});
        file.attribute(path + "/momentum/" + axis, "unitSI", electronvolt);
    }
}

inline testing::Matcher<const std::vector<double>&> near(std::initializer_list<double> values) {
    // 1e-14: a handful of roundings of doubles.
    std::vector<testing::Matcher<double>> each;
    for (const double value : values) each.push_back(testing::DoubleNear(value, 1e-14 * std::abs(value)));
    return testing::ElementsAreArray(each);
}

}  // namespace mote::test
