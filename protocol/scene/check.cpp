// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/check.h"

#include <fmt/format.h>

#include <cmath>

#include "protocol/scene/srgb.h"

namespace mote {

Result<double> checkRange(double value, double least, double greatest, std::string_view field) {
    if (std::isfinite(value) && value >= least && value <= greatest) return value;
    return Error{ErrorCode::invalidArgument, std::string(field),
                 fmt::format("{} is not a number from {} to {}", value, least, greatest)};
}

Result<ScreenLength> checkLength(bool has, double value, const ScreenLength& usual,
                                 const LengthField& field) {
    if (!has) return usual;
    MOTE_ASSIGN_OR_RETURN(const double checked, checkRange(value, field.least, field.greatest, field.name()));
    return ScreenLength(checked);
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

Result<glm::dvec3> checkColor(const google::protobuf::RepeatedField<double>& values,
                              const glm::dvec3& fallback, std::string_view field) {
    if (values.empty()) return fallback;
    MOTE_ASSIGN_OR_RETURN(auto color, checkVector(values, 1.0, field));
    for (int i = 0; i < 3; ++i) {
        MOTE_RETURN_IF_ERROR(checkRange(color[i], 0.0, 1.0, fmt::format("{}[{}]", field, i)));
    }
    return srgbToLinear(color);
}

}  // namespace mote
