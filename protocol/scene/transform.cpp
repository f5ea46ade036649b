// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/transform.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/matrix.hpp>

#include "protocol/scene/check.h"

namespace mote {
Result<glm::dmat4> parseTransform(const google::protobuf::RepeatedField<double>& rows) {
    if (rows.empty()) return glm::dmat4(1.0);
    if (rows.size() != 16)
        return invalid("transform", fmt::format("16 numbers are needed, not {}", rows.size()));
    glm::dmat4 transform(1.0);
    for (int i = 0; i < 16; ++i) {
        MOTE_RETURN_IF_ERROR(checkRange(rows[i], -1e9, 1e9, fmt::format("transform[{}]", i)));
        transform[i % 4][i / 4] = rows[i];  // glm keeps columns
    }
    if (rows[12] != 0.0 || rows[13] != 0.0 || rows[14] != 0.0 || rows[15] != 1.0)
        return invalid("transform", "the last row must be 0, 0, 0, 1");
    const double determinant = std::abs(glm::determinant(glm::dmat3(transform)));
    if (!(determinant > 1e-18 && determinant < 1e18))
        return invalid("transform", "the matrix must be invertible and of sensible scale");
    return transform;
}

void writeTransform(const glm::dmat4& transform, google::protobuf::RepeatedField<double>* rows) {
    if (transform == glm::dmat4(1.0)) return;
    for (int i = 0; i < 16; ++i) rows->Add(transform[i % 4][i / 4]);
}

}  // namespace mote
