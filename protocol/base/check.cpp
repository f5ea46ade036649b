// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/check.h"

#include <fmt/format.h>

#include <cmath>

namespace mote {

Result<double> checkRange(double value, double least, double greatest, std::string_view field) {
    if (std::isfinite(value) && value >= least && value <= greatest) return value;
    return Error{ErrorCode::invalidArgument, std::string(field),
                 fmt::format("{} is not a number from {} to {}", value, least, greatest)};
}

Result<glm::dvec3> checkVector(const google::protobuf::RepeatedField<double>& values, double limit,
                               std::string_view field) {
    if (values.size() != 3) {
        return Error{ErrorCode::invalidArgument, std::string(field),
                     fmt::format("three numbers are needed, not {}", values.size())};
    }
    glm::dvec3 vector(0.0);
    for (int i = 0; i < 3; ++i) {
        MOTE_ASSIGN_OR_RETURN(const auto checked,
                              checkRange(values[i], -limit, limit, fmt::format("{}[{}]", field, i)));
        vector[i] = checked;
    }
    return vector;
}

}  // namespace mote
