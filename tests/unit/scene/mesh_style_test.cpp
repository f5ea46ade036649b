// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/mesh_style.h"

#include <gtest/gtest.h>

#include "protocol/scene/json.h"
#include "protocol/scene/view.h"

namespace mote {
namespace {

Result<MeshStyle> styleOf(const char* json) {
    proto::MeshStyle message;
    const auto status = parseJson(json, message, "style");
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return parseMeshStyle(message);
}

TEST(MeshStyle, DefaultsAreTheDocumentedOnes) {
    const auto style = styleOf("{}");
    ASSERT_TRUE(style.ok());
    EXPECT_EQ(style->color, srgbToLinear(glm::dvec3(0.8)));
    EXPECT_EQ(style->opacity, 1.0);
    EXPECT_EQ(style->light.ambient, 0.15);
    EXPECT_FALSE(style->wire || style->light.shadow);
}

TEST(MeshStyle, TakesAllThatIsSaid) {
    const auto style = styleOf(
        R"({"color": [1, 0, 0], "opacity": 0.25, "wire": true, "light": {"specular": 0.5, "shadow": true}})");
    ASSERT_TRUE(style.ok());
    EXPECT_EQ(style->color, glm::dvec3(1.0, 0.0, 0.0));
    EXPECT_EQ(style->opacity, 0.25);
    EXPECT_TRUE(style->wire && style->light.shadow);
    EXPECT_EQ(style->light.specular, 0.5);
}

TEST(MeshStyle, NamesWhatIsOutOfRange) {
    EXPECT_EQ(styleOf(R"({"opacity": 1.5})").error().where, "opacity");
    EXPECT_EQ(styleOf(R"({"color": [1, 2, 0]})").error().where, "color[1]");
    EXPECT_EQ(styleOf(R"({"light": {"direction": [0, 0, 0]}})").error().where, "light.direction");
}

}  // namespace
}  // namespace mote
