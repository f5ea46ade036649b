// SPDX-License-Identifier: GPL-3.0-or-later
//
// From a mesh to strokes: every picture that may be shown, any style, any form, any number of threads.
#include "server/render/ink/drawing.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <array>
#include <cmath>

#include "server/render/layers/ink/lower_ink.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "tests/support/generated_mesh.h"
#include "tests/unit/ink/ink_cover.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

constexpr std::array shows{InkPicture::drawing,  InkPicture::grey,   InkPicture::depth,
                           InkPicture::angle,    InkPicture::edges,  InkPicture::complexity,
                           InkPicture::segments, InkPicture::target, InkPicture::lighten,
                           InkPicture::darken};

struct Look {
    Camera camera;
    glm::dmat4 transform{1.0};
    std::uint32_t width = 64, height = 48;
    double pixels = 1.0;
    bool exact = true;
    std::stop_token stop = {};
};

FramePlan lowered(const InkData& data, const InkStyle& style, const Look& look) {
    auto plan = test::planOf(look.camera, look.width, look.height);
    plan.exact = look.exact;
    const Quality quality;
    SelectionCache selections;
    Lowering out{.plan = plan,
                 .quality = quality,
                 .selections = selections,
                 .device = {},
                 .reading = Reading::all,
                 .pixels = look.pixels,
                 .slabs = 192,
                 .stop = look.stop};
    const Layer layer{.dataset = "data/a", .transform = look.transform, .style = proto::InkStyle()};
    lowerInk(layer, style, data, nullptr, out);
    return plan;
}

std::shared_ptr<const MeshSurface> surfaceOf(std::string_view form, std::uint32_t number) {
    return test::surfaceOf(test::meshOf(std::string(form), number, 0)->mesh());
}

Look fitted(const MeshSurface& surface) {
    return {.camera = fitCamera(surface.bounds(), 64.0 / 48.0)};
}

TEST(InkDrawing, EveryShowIsAPictureOfTheSize) {
    for (const auto form : test::meshForms()) {
        const auto surface = surfaceOf(form, 0);
        for (const auto show : shows) {
            auto style = test::usualInk();
            style.show = show;
            const auto plan = lowered(surface, style, fitted(*surface));
            if (show == InkPicture::drawing) {
                EXPECT_TRUE(plan.fragments.empty());
                ASSERT_EQ(plan.strokes.size(), 1U) << form;
                EXPECT_FALSE(plan.strokes[0]->lines.empty());
                continue;
            }
            EXPECT_TRUE(plan.strokes.empty());
            ASSERT_EQ(plan.fragments.size(), 1U) << form;
            const auto& fragments = *plan.fragments[0];
            ASSERT_EQ(fragments.size(), 64U * 48U);
            float least = 2.0F, most = -1.0F;
            for (const auto& one : fragments) {
                EXPECT_TRUE(std::isfinite(one.depth));
                for (int i = 0; i < 3; ++i) {
                    EXPECT_TRUE(one.color[i] >= 0.0F && one.color[i] <= 1.0F);
                    least = std::min(least, one.color[i]);
                    most = std::max(most, one.color[i]);
                }
            }
            if (show != InkPicture::lighten && show != InkPicture::darken) {
                EXPECT_LT(least, most) << form << ' ' << static_cast<int>(show);
            }
        }
    }
}

TEST(InkDrawing, ARequestToStopIsHeard) {
    const auto surface = surfaceOf("leaves", 0);
    std::stop_source source;
    source.request_stop();
    auto look = fitted(*surface);
    look.width = look.height = 512;
    look.stop = source.get_token();
    for (const auto show : shows) {
        auto style = test::usualInk();
        style.show = show;
        const auto plan = lowered(surface, style, look);
        EXPECT_TRUE(plan.strokes.empty() && plan.fragments.empty());
    }
}

TEST(InkDrawing, ThreadsChangeNothing) {
    for (const auto form : test::meshForms()) {
        const auto surface = surfaceOf(form, 0);
        auto style = test::usualInk();
        style.waver = 1.0;
        style.taper = true;
        style.solid.strength = 0.7;
        auto look = fitted(*surface);
        look.width = 160;
        look.height = 120;
        tbb::task_arena one(1), more(2);
        FramePlan alone, together;
        one.execute([&] { alone = lowered(surface, style, look); });
        more.execute([&] { together = lowered(surface, style, look); });
        ASSERT_EQ(alone.strokes.size(), together.strokes.size());
        for (std::size_t i = 0; i < alone.strokes.size(); ++i)
            EXPECT_EQ(*alone.strokes[i], *together.strokes[i]) << form;
    }
}

/// The paper's tone where a ball is drawn is that of its shading, blurred.
TEST(InkDrawing, IsAsDarkAsWhatItShows) {
    const auto surface = surfaceOf("sphere", 0);
    auto style = test::usualInk();
    style.hatch.spacing = 6.0;
    auto look = fitted(*surface);
    look.width = 256;
    look.height = 192;
    look.camera.orthographicHeight = 2.0;
    const auto plan = lowered(surface, style, look);
    const auto scene = modalitiesOf(*surface, look.transform, style, plan, {}).modalities;
    const auto cover = test::coverOf(*plan.strokes.at(0), look.width, look.height);
    // Over blocks, as the eye blurs.
    constexpr std::uint32_t block = 24;
    double off = 0.0, count = 0.0;
    for (std::uint32_t top = 0; top < look.height; top += block) {
        for (std::uint32_t left = 0; left < look.width; left += block) {
            double drawn = 0.0, wanted = 0.0, pixels = 0.0;
            for (std::uint32_t y = top; y < std::min(top + block, look.height); ++y) {
                for (std::uint32_t x = left; x < std::min(left + block, look.width); ++x) {
                    drawn += cover.at(x, y);
                    wanted += std::min(0.98, 1.0 - static_cast<double>(scene.grey.at(x, y)));
                    pixels += 1.0;
                }
            }
            off += std::abs(drawn - wanted) / pixels;
            count += 1.0;
        }
    }
    EXPECT_LT(off / count, 0.06);
}

/// Values at both ends of what a style may say, and between.
InkStyle anyStyle(test::Random& random) {
    const auto number = [&](double least, double most) {
        return random.oneOf({least, most, random.between(least, most), least + 0.02 * (most - least)});
    };
    auto style = test::usualInk();
    style.silhouettes.mode =
        random.oneOf({SilhouetteMode::none, SilhouetteMode::all, SilhouetteMode::important,
                      SilhouetteMode::adjusted, SilhouetteMode::adjusted});
    style.silhouettes.importance = number(0.0, 1.0);
    style.silhouettes.width = number(0.1, 64.0);
    style.silhouettes.crease = number(0.0, 180.0);
    style.silhouettes.omit = random.chance(0.5);
    style.hatch = {.strength = number(0.0, 1.0),
                   .spacing = number(1.0, 256.0),
                   .width = number(0.1, 64.0),
                   .segments = style.hatch.segments};
    if (random.chance(0.5)) style.solid = {.strength = number(0.0, 1.0), .complexity = number(0.0, 1.0)};
    style.reading = number(1.0, 256.0);
    style.light.ambient = number(0.0, 1.0);
    style.light.shadow = random.chance(0.5);
    style.light.fixed = random.chance(0.5);
    style.inkIsDark = random.chance(0.5);
    if (random.chance(0.3)) style.show = shows[random.below(shows.size())];
    style.waver = number(0.0, 16.0);
    style.taper = random.chance(0.5);
    return style;
}

TEST(InkDrawing, AnyStyleDoesNoHarm) {
    test::Random random(21);
    std::size_t points = 0;
    for (int i = 0; i < 120; ++i) {
        const auto form = test::meshForms()[i % test::meshForms().size()];
        const auto surface = surfaceOf(form, static_cast<std::uint32_t>(random.below(4)));
        const auto style = anyStyle(random);
        Look look;
        look.transform = test::anyTransform(random);
        look.camera = test::anyCamera(random, surface->bounds().transformed(look.transform));
        look.pixels = random.oneOf({0.05, 0.5, 1.0, 4.0});
        look.exact = random.chance(0.5);
        if (i % 20 == 0) look.width = look.height = 1;
        const auto plan = lowered(surface, style, look);
        for (const auto& strokes : plan.strokes) {
            EXPECT_FALSE(strokes->empty());
            for (const auto& point : strokes->points) {
                EXPECT_TRUE(std::isfinite(point.x) && std::isfinite(point.y)) << i;
                EXPECT_TRUE(std::isfinite(point.width) && point.width > 0.0F) << i;
                EXPECT_TRUE(std::isfinite(point.depth)) << i;
            }
            points += strokes->points.size();
        }
        for (const auto& fragments : plan.fragments) {
            for (const auto& one : *fragments) EXPECT_TRUE(std::isfinite(one.depth)) << i;
        }
    }
    EXPECT_GT(points, 10000U);
}

}  // namespace
}  // namespace mote::render
