// SPDX-License-Identifier: GPL-3.0-or-later
//
// Parts of a mesh as a drawing sees them, and regions, which end where parts do.
#include <gtest/gtest.h>

#include <array>
#include <set>

#include "server/render/ink/segment_regions.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "tests/support/generated_mesh.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_views.h"
#include "tests/unit/ink/part_scenes.h"

namespace mote::render {
namespace {

constexpr std::array ways{Segmentation::growing, Segmentation::graph, Segmentation::cut,
                          Segmentation::texture};
constexpr std::size_t least = 36;

/// A chequered plane of columns x rows unit squares, each of any of five parts.
storage::SurfaceMesh chequers(test::Random& random, std::uint32_t columns, std::uint32_t rows) {
    storage::SurfaceMesh mesh;
    for (std::uint32_t i = 0; i < columns * rows; ++i) {
        const auto x = static_cast<float>(i % columns), y = static_cast<float>(i / columns);
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const auto& [right, up] : {std::pair{0.0F, 0.0F}, {1.0F, 0.0F}, {1.0F, 1.0F}, {0.0F, 1.0F}}) {
            mesh.positions.emplace_back(x + right, y + up, 0.0F);
            mesh.normals.emplace_back(0.0F, 0.0F, 1.0F);
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
        mesh.parts.insert(mesh.parts.end(), 2, static_cast<std::uint32_t>(random.below(5)));
    }
    return mesh;
}

TEST(InkParts, OfAPlaneAreSeenWhereTheyLie) {
    test::Random random(1);
    const std::uint32_t columns = 8, rows = 6, cell = 10, border = 5;
    const auto mesh = chequers(random, columns, rows);
    const auto surface = test::surfaceOf(mesh);
    Camera camera;
    camera.target = {0.5 * columns, 0.5 * rows, 0.0};
    camera.eye = camera.target + glm::dvec3(0.0, 0.0, 9.0);
    camera.up = {0.0, 1.0, 0.0};
    camera.orthographicHeight = rows + 1.0;
    auto plan = test::planOf(camera, columns * cell + 2 * border, rows * cell + 2 * border);
    for (const bool exact : {true, false}) {
        plan.exact = exact;
        const auto seen = modalitiesOf(*surface, glm::dmat4(1.0), test::usualInk(), plan, {}).modalities;
        for (std::uint32_t y = 0; y < plan.height; ++y) {
            for (std::uint32_t x = 0; x < plan.width; ++x) {
                const bool outside =
                    x < border || y < border || x >= plan.width - border || y >= plan.height - border;
                const auto square =
                    outside ? 0 : (rows - 1 - (y - border) / cell) * columns + (x - border) / cell;
                EXPECT_EQ(seen.part.at(x, y), outside ? Modalities::nothing : mesh.parts[2 * square]);
            }
        }
    }
}

TEST(InkParts, AreThoseOfTheTrianglesThatAreSeen) {
    test::Random random(2);
    for (const auto form : test::meshForms()) {
        auto mesh = test::meshOf(std::string(form), 0, 0)->mesh();
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            mesh.parts.push_back(static_cast<std::uint32_t>(random.below(1U << 20)));
        const auto parts = mesh.parts;
        const auto surface = test::surfaceOf(std::move(mesh));
        const auto plan = test::planOf(test::anyCamera(random, surface->bounds()), 61, 37);
        const auto made = modalitiesOf(*surface, glm::dmat4(1.0), test::usualInk(), plan, {});
        for (std::size_t i = 0; i < made.triangle.values.size(); ++i) {
            const auto triangle = made.triangle.values[i];
            EXPECT_EQ(made.modalities.part.values[i],
                      triangle == MeshMeeting::none ? Modalities::nothing : parts[triangle]);
        }
    }
}

/// Connected pixels of one part, by number, and which of them are too small to be regions.
struct Pieces {
    Segments segments;
    std::vector<bool> small;
};

Pieces piecesOf(const Modalities& modalities) {
    Segments parts{modalities.part, 0};
    for (std::size_t i = 0; i < parts.label.values.size(); ++i) {
        if (!std::isfinite(modalities.depth.values[i])) parts.label.values[i] = Segments::nothing;
    }
    Pieces made{intersected(parts, parts, parts, {}), {}};
    const auto& label = made.segments.label;
    std::vector<std::size_t> pixels(made.segments.count), inside(made.segments.count);
    for (std::uint32_t y = 0; y < label.height; ++y) {
        for (std::uint32_t x = 0; x < label.width; ++x) {
            const auto own = label.at(x, y);
            if (own == Segments::nothing) continue;
            ++pixels[own];
            inside[own] += (x == 0 || label.at(x - 1, y) == own) && (y == 0 || label.at(x, y - 1) == own) &&
                           (x + 1 == label.width || label.at(x + 1, y) == own) &&
                           (y + 1 == label.height || label.at(x, y + 1) == own);
        }
    }
    for (std::size_t i = 0; i < pixels.size(); ++i)
        made.small.push_back(pixels[i] < least || inside[i] < least / 4);
    return made;
}

/// No region has pixels of two pieces that are not small.
void expectWithinParts(const Segments& segments, const Pieces& pieces, const char* way) {
    std::vector<std::uint32_t> piece(segments.count, Segments::nothing);
    std::size_t crossing = 0;
    for (std::size_t i = 0; i < segments.label.values.size(); ++i) {
        const auto region = segments.label.values[i], one = pieces.segments.label.values[i];
        if (region == Segments::nothing || pieces.small[one]) continue;
        if (piece[region] == Segments::nothing) piece[region] = one;
        crossing += piece[region] != one ? 1 : 0;
    }
    EXPECT_EQ(crossing, 0U) << way;
}

Modalities flat(std::uint32_t width, std::uint32_t height) {
    return {Raster<float>(width, height, 0.5F), Raster<float>(width, height, 5.0F),
            Raster<float>(width, height, 0.7F), Raster<std::uint32_t>(width, height), 10.0};
}

/// Discs of any size over each other, some of one part, and single pixels of others.
void partByDiscs(test::Random& random, Modalities& modalities, double specks) {
    auto& part = modalities.part;
    for (int disc = 0; disc < 40; ++disc) {
        const double x = random.between(0.0, part.width), y = random.between(0.0, part.height);
        const double radius = random.between(1.0, 0.2 * part.width);
        const auto own = static_cast<std::uint32_t>(random.below(12));
        for (std::size_t i = 0; i < part.values.size(); ++i) {
            if (std::hypot(i % part.width - x, i / part.width - y) < radius) part.values[i] = own;
        }
    }
    for (auto& one : part.values) {
        if (random.chance(specks)) one = static_cast<std::uint32_t>(100 + random.below(1000));
    }
}

TEST(PartRegions, OfWhatIsOtherwiseAlikeAreTheParts) {
    auto modalities = flat(120, 90);
    for (const auto way : ways) EXPECT_EQ(segmentsOf(modalities, {way, least}, {}).count, 1U);
    for (std::size_t i = 0; i < modalities.part.values.size(); ++i)
        modalities.part.values[i] = static_cast<std::uint32_t>(i % 120 / 40 + 3 * (i / 120 / 45));
    const auto pieces = piecesOf(modalities).segments;
    for (const auto way : {Segmentation::growing, Segmentation::graph, Segmentation::texture})
        EXPECT_EQ(segmentsOf(modalities, {way, least}, {}).label, pieces.label) << static_cast<int>(way);
    const auto cut = segmentsOf(modalities, {Segmentation::cut, least}, {});
    EXPECT_EQ(cut.count, 6U);
}

TEST(PartRegions, NeverCrossFromOnePieceToAnotherUnlessItIsSmall) {
    for (std::uint64_t number = 0; number < 6; ++number) {
        test::Random random(number, 9);
        auto modalities = number < 2
                              ? flat(150, 110)
                              : test::partScene(random, 150, 110,
                                                number % 2 == 0 ? test::Relief::smooth : test::Relief::rough)
                                    .modalities;
        partByDiscs(random, modalities, number % 3 == 0 ? 0.05 : 0.0);
        const auto pieces = piecesOf(modalities);
        EXPECT_GT(std::count(pieces.small.begin(), pieces.small.end(), false), 5);
        for (const auto way : ways)
            expectWithinParts(segmentsOf(modalities, {way, least}, {}), pieces,
                              std::to_string(static_cast<int>(way)).c_str());
    }
}

TEST(PartRegions, TinyOnesJoinAcrossParts) {
    auto modalities = flat(300, 200);
    for (std::size_t i = 0; i < modalities.part.values.size(); ++i)
        modalities.part.values[i] = static_cast<std::uint32_t>(i / 300 / 3 * 100 + i % 300 / 3);
    for (const auto way : ways) {
        const auto made = segmentsOf(modalities, {way, least}, {});
        EXPECT_GT(made.count, 0U);
        std::vector<std::size_t> pixels(made.count);
        for (const auto label : made.label.values) ++pixels[label];
        for (const auto count : pixels) EXPECT_GE(count, least) << static_cast<int>(way);
    }
}

TEST(PartRegions, ASmallOneGoesToItsOwnPartFirst) {
    // A strip that is as light as its left side, but of its right side's part.
    auto modalities = flat(60, 40);
    Segments thirds{Raster<std::uint32_t>(60, 40), 3};
    for (std::size_t i = 0; i < thirds.label.values.size(); ++i) {
        thirds.label.values[i] = i % 60 < 30 ? 0 : i % 60 < 32 ? 1 : 2;
        modalities.grey.values[i] = i % 60 < 32 ? 0.2F : 0.9F;
    }
    EXPECT_EQ(withoutSmall(thirds, modalities, least, {}).label.at(31, 5), 0U);
    for (std::size_t i = 0; i < thirds.label.values.size(); ++i)
        modalities.part.values[i] = i % 60 < 30 ? 7 : 8;
    const auto made = withoutSmall(thirds, modalities, least, {});
    EXPECT_EQ(made.count, 2U);
    EXPECT_EQ(made.label.at(31, 5), made.label.at(50, 5));
}

}  // namespace
}  // namespace mote::render
