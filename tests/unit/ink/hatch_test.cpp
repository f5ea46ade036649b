// SPDX-License-Identifier: GPL-3.0-or-later
//
// Hatches cover what they should, where they should, and nothing elsewhere changes.
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <stop_token>
#include <vector>

#include "server/render/ink/drawing.h"
#include "server/render/ink/hatch.h"
#include "server/render/ink/hatch_field.h"
#include "server/render/ink/solid.h"
#include "server/render/ink/tone_grid.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

constexpr std::uint32_t hatchSide = 160;

/// A flat picture of regions, each with strokes along its mean angle.
struct Region {
    Raster<std::uint32_t> label;
    Raster<float> angle, density;

    Region(std::uint32_t size, float direction, double wanted)
        : label(size, size), angle(size, size, direction), density(size, size, static_cast<float>(wanted)) {}

    std::vector<HatchStroke> hatched(const HatchOptions& options, std::uint32_t count = 1,
                                     const std::stop_token& stop = {}) const {
        const Modalities flat{Raster<float>(label.width, label.height),
                              Raster<float>(label.width, label.height, 5.0F), angle,
                              Raster<std::uint32_t>(label.width, label.height), 10.0};
        const InkCamera camera{.size = {label.width, label.height}};
        const auto field = hatchField(flat, camera, {label, count}, {}, {}, stop);
        auto wanted = density;
        for (std::size_t i = 0; i < wanted.values.size(); ++i) {
            if (label.values[i] >= count) wanted.values[i] = 0.0F;
        }
        const auto goesOn = [&](std::uint32_t x, std::uint32_t y, std::uint32_t toX, std::uint32_t toY) {
            return label.at(x, y) == label.at(toX, toY);
        };
        return hatch({field, wanted, goesOn}, {}, options, stop);
    }
};

double mostHatched(const HatchOptions& options) {
    return hatchPasses(options).back().reached;
}

template <class Take>
void eachPart(const HatchStroke& stroke, const Take& take) {
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) take(stroke.points[i], stroke.points[i + 1]);
}

/// The mean density of ink in the middle of a square that is hatched all over.
double drawnDensity(const std::vector<HatchStroke>& strokes, double width, std::uint32_t size) {
    Strokes made;
    for (const auto& stroke : strokes) test::addStroke(made, stroke.points, width);
    return densityOf(test::meanOf(test::coverOf(made, size, size), size / 8));
}

double lengthOf(const std::vector<HatchStroke>& strokes) {
    double length = 0.0;
    for (const auto& stroke : strokes)
        eachPart(stroke, [&](const auto& from, const auto& to) { length += glm::distance(from, to); });
    return length;
}

TEST(Hatch, NoStrokeOfAnEvenPictureIsBroken) {
    constexpr double large = 400.0;
    for (const double spacing : {3.0, 7.0}) {
        const HatchOptions options{.spacing = spacing, .width = 1.0};
        const auto strokes = Region(400, 0.4F, mostHatched(options)).hatched(options);
        EXPECT_GT(strokes.size(), 2.0 * large / spacing);
        std::size_t broken = 0;
        for (const auto& stroke : strokes) {
            for (const auto& end : {stroke.points.front(), stroke.points.back()}) {
                const double off = std::min({end.x, end.y, large - end.x, large - end.y});
                broken += off > 3.0 ? 1 : 0;
            }
        }
        // Two of one line may meet.
        EXPECT_LE(broken, strokes.size() / 5);
    }
}

/// Bands in which no stroke is long enough: each is begun and taken back. Steps that end a hair before a
/// multiple of a cell were put into one cell and taken out of the next, and the search never ended.
TEST(Hatch, StrokesThatAreTakenBackLeaveNothing) {
    constexpr std::uint32_t cells = 60;
    for (const float tilt : {0.0F, 1.2e-5F, -1.2e-5F}) {
        for (const double spacing : {2.79, 3.5}) {
            HatchField field;
            const glm::vec2 way = glm::normalize(glm::vec2(tilt, 1.0F));
            field.cells = {cells, cells, HatchField::Cell{way, {way.y, -way.x}, true, true}};
            const std::uint32_t side = cells * field.pixels;
            const HatchOptions options{.spacing = spacing, .width = 0.9};
            Raster<float> density(side, side);
            for (std::uint32_t y = 0; y < side; ++y) {
                for (std::uint32_t x = 0; x < side; ++x) {
                    if (y % 12 < 6 && x % 12 < 6)
                        density.at(x, y) = 1.1F * static_cast<float>(mostHatched(options));
                }
            }
            const auto goesOn = [](auto...) { return true; };
            EXPECT_TRUE(hatch({field, density, goesOn}, {}, options, {}).empty()) << tilt << ' ' << spacing;
        }
    }
}

TEST(Hatch, CoversWhatIsWanted) {
    for (const double spacing : {4.0, 12.0}) {
        for (const float direction : {0.3F, 1.2F, -0.7F}) {
            const HatchOptions options{.spacing = spacing, .width = 1.0};
            const double most = mostHatched(options);
            double sum = 0.0, count = 0.0;
            for (int i = 0; i < 24; ++i) {
                const double wanted = std::lerp(0.05, most, i / 23.0);
                const Region region(hatchSide, direction, wanted);
                const double drawn = drawnDensity(region.hatched(options), options.width, hatchSide);
                // Strokes come half of a layer at a time.
                EXPECT_NEAR(coverOf(drawn), coverOf(wanted), 0.08)
                    << spacing << ' ' << direction << ' ' << wanted;
                sum += coverOf(drawn) - coverOf(wanted);
                count += 1.0;
            }
            EXPECT_NEAR(sum / count, 0.0, 0.03) << spacing << ' ' << direction;
        }
    }
}

TEST(Hatch, StaysInsideItsRegion) {
    test::Random random(1);
    Region region(hatchSide, 0.4F, 1.0);
    std::vector<glm::dvec2> middles;
    for (int i = 0; i < 9; ++i)
        middles.emplace_back(random.between(0.0, hatchSide), random.between(0.0, hatchSide));
    for (std::uint32_t row = 0; row < hatchSide; ++row) {
        for (std::uint32_t column = 0; column < hatchSide; ++column) {
            const auto nearest =
                std::min_element(middles.begin(), middles.end(), [&](const auto& a, const auto& b) {
                    return glm::distance(a, glm::dvec2(column, row)) <
                           glm::distance(b, glm::dvec2(column, row));
                });
            region.label.at(column, row) = static_cast<std::uint32_t>(nearest - middles.begin());
        }
    }
    const auto strokes = region.hatched({}, 1);
    EXPECT_FALSE(strokes.empty());
    for (const auto& stroke : strokes) {
        eachPart(stroke, [&](const glm::dvec2& from, const glm::dvec2& to) {
            for (const double share : {0.0, 0.3, 0.7, 1.0}) {
                const glm::dvec2 at = glm::mix(from, to, share);
                bool inside = false;
                for (const double x : {-1.0, 0.0, 1.0}) {
                    for (const double y : {-1.0, 0.0, 1.0})
                        inside = inside || region.label.near(at.x + x, at.y + y) == 0;
                }
                ASSERT_TRUE(inside) << at.x << ' ' << at.y;
            }
        });
    }
}

TEST(Hatch, GoesTheMeanWayWhereNothingBends) {
    test::Random random(2);
    for (int turn = 0; turn < 20; ++turn) {
        const double wanted = random.between(-3.1, 3.1);
        Region region(64, 0.0F, 0.1);
        // Directions have no sign.
        for (auto& angle : region.angle.values) {
            const double flipped = random.chance(0.5) ? std::numbers::pi : 0.0;
            angle = static_cast<float>(wanted + flipped + random.between(-0.5, 0.5));
        }
        const auto strokes = region.hatched({});
        ASSERT_FALSE(strokes.empty());
        for (const auto& stroke : strokes) {
            const glm::dvec2 way = glm::normalize(stroke.points.back() - stroke.points.front());
            EXPECT_LT(std::abs(way.x * std::sin(wanted) - way.y * std::cos(wanted)), 0.03);
        }
    }
}

TEST(Hatch, StrokesOfBeforeStayWhereTheyMay) {
    const Region region(hatchSide, 0.4F, 0.7);
    const auto strokes = region.hatched({});
    const Modalities flat{Raster<float>(hatchSide, hatchSide), Raster<float>(hatchSide, hatchSide, 5.0F),
                          region.angle, Raster<std::uint32_t>(hatchSide, hatchSide), 10.0};
    // The other way round: strokes of before count more than what the regions say.
    Raster<float> across(hatchSide, hatchSide, 1.2F);
    const auto field = hatchField({flat.grey.copy(), flat.depth.copy(), across, flat.part.copy(), 10.0},
                                  {.size = {hatchSide, hatchSide}}, {region.label, 1}, strokes, {}, {});
    const auto again = hatch({field, region.density, [](auto...) { return true; }}, strokes, {}, {});
    std::size_t stay = 0;
    for (const auto& stroke : strokes) {
        stay += std::any_of(again.begin(), again.end(), [&](const HatchStroke& other) {
            return other.pass == stroke.pass &&
                   glm::distance(other.points.front(), stroke.points.front()) < 4.0 &&
                   glm::distance(other.points.back(), stroke.points.back()) < 4.0;
        });
    }
    EXPECT_GT(stay, strokes.size() * 9 / 10);
}

TEST(Hatch, MoreInkIsMoreHatching) {
    double before = 0.0;
    for (int i = 0; i <= 30; ++i) {
        const double length = lengthOf(Region(80, 0.4F, i / 10.0).hatched({}));
        EXPECT_GE(length, 0.95 * before);
        before = std::max(before, length);
    }
    EXPECT_GT(before, 80.0 * 80.0 / 4.0 * 4.0);
}

TEST(Hatch, ExtremesDoNoHarm) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const double spacing : {1.0, 4.0, 31.7, 256.0}) {
        for (const double width : {0.1, 1.0, 64.0}) {
            for (const double wanted : {-infinity, -1.0, 0.0, 1e-30, 1.0, 1e30, infinity, -std::nan("")}) {
                Region region(48, static_cast<float>(spacing), wanted);
                if (wanted > 1.0) region.angle.values[7] = std::numeric_limits<float>::quiet_NaN();
                const HatchOptions options{.spacing = spacing, .width = width};
                EXPECT_TRUE(std::isfinite(mostHatched(options)) && mostHatched(options) > 0.0);
                const auto strokes = region.hatched(options);
                if (!(wanted > 0.0)) {
                    EXPECT_TRUE(strokes.empty());
                }
                EXPECT_LE(strokes.size(), 48U * 48U);
                for (const auto& stroke : strokes) {
                    ASSERT_GE(stroke.points.size(), 2U);
                    for (const auto& at : stroke.points) EXPECT_TRUE(std::isfinite(at.x + at.y));
                }
            }
        }
    }
    EXPECT_TRUE(Region(8, 0.0F, 1.0).hatched({}, 0).empty());
    std::stop_source source;
    source.request_stop();
    EXPECT_TRUE(Region(80, 0.0F, 1.0).hatched({}, 1, source.get_token()).empty());
}

// Solid ink in generated pictures: what is inked, what stays paper, and that nothing is drawn twice.

constexpr std::uint32_t solidSide = 160;
constexpr double reading = 6.0;

glm::dvec2 middleOf(std::size_t pixel) {
    return {static_cast<double>(pixel % solidSide) + 0.5, static_cast<double>(pixel / solidSide) + 0.5};
}

/// A flat picture that is complex where `cover` says.
struct Flat {
    Modalities modalities{Raster<float>(solidSide, solidSide, 0.5F),
                          Raster<float>(solidSide, solidSide, 5.0F), Raster<float>(solidSide, solidSide),
                          Raster<std::uint32_t>(solidSide, solidSide, 0U), 10.0};
    Raster<float> wanted{solidSide, solidSide, 0.8F}, cover{solidSide, solidSide, 1.0F};

    SolidInk inked(double strength, double complexity = 0.3) const {
        return solidInk({modalities, wanted, cover}, {.strength = strength, .complexity = complexity},
                        reading, {});
    }
};

template <class Change>
void eachPixel(const Change& change) {
    for (std::size_t i = 0; i < std::size_t{solidSide} * solidSide; ++i) change(i, middleOf(i));
}

double countOf(const SolidInk& ink, Ground ground) {
    return static_cast<double>(std::count(ink.ground.values.begin(), ink.ground.values.end(), ground));
}

double areaOf(const SolidInk& ink) {
    double sum = 0.0;
    for (const auto& outline : ink.outlines) sum += signedArea(outline);
    return sum;
}

/// Beside where a disc is complex, and a straight line where its tone changes.
TEST(SolidInk, IsWhatIsDarkOfWhatIsComplex) {
    test::Random random(1);
    for (int i = 0; i < 20; ++i) {
        Flat flat;
        const glm::dvec2 middle(random.between(60.0, 100.0), random.between(60.0, 100.0));
        const double radius = random.between(30.0, 60.0), angle = random.between(0.0, 6.28);
        const glm::dvec2 across(std::cos(angle), std::sin(angle));
        const double strength = random.between(0.2, 0.8);
        eachPixel([&](std::size_t pixel, const glm::dvec2& at) {
            flat.cover.values[pixel] = glm::distance(at, middle) < radius ? 1.0F : 0.0F;
            const double dark = glm::dot(at - middle, across) > 0.0 ? 0.12 : -0.12;
            flat.wanted.values[pixel] = static_cast<float>(1.0 - strength + dark);
        });
        const auto ink = flat.inked(strength);
        eachPixel([&](std::size_t pixel, const glm::dvec2& at) {
            const double inside = radius - glm::distance(at, middle), dark = glm::dot(at - middle, across);
            if (std::abs(inside) < 2.0 * reading || (inside > 0.0 && std::abs(dark) < 3.0)) return;
            const Ground expected = inside < 0.0 ? Ground::simple
                                    : dark > 0.0 ? Ground::solid
                                                 : Ground::paper;
            EXPECT_EQ(ink.ground.values[pixel], expected) << i << ": " << at.x << ' ' << at.y;
        });
        EXPECT_NEAR(areaOf(ink) / countOf(ink, Ground::solid), 1.0, 0.01);
    }
}

TEST(SolidInk, IsNothingWithoutStrengthAndAllThatIsComplexWithAll) {
    test::Random random(2);
    Flat flat;
    for (auto& value : flat.wanted.values) value = static_cast<float>(random.between(0.02, 0.98));
    EXPECT_EQ(countOf(flat.inked(1.0), Ground::solid), double(solidSide) * solidSide);
    EXPECT_TRUE(flat.inked(0.001).outlines.empty());
    EXPECT_EQ(countOf(flat.inked(0.001), Ground::paper), double(solidSide) * solidSide);
    for (auto& value : flat.cover.values) value = 0.25F;
    EXPECT_EQ(countOf(flat.inked(1.0), Ground::simple), double(solidSide) * solidSide);
    // White stays paper.
    for (auto& value : flat.wanted.values) value = 0.0F;
    EXPECT_TRUE(flat.inked(1.0, 0.0).outlines.empty());
}

/// Discs, dark ones on paper and light ones in ink: of two pixels no region, of ten one. A blur by s moves
/// the edge of a disc of r by about s^2 / 2r, here 0.45 of ten pixels.
TEST(SolidInk, HasNoSpecks) {
    for (const bool dark : {false, true}) {
        for (const double radius : {2.0, 10.0}) {
            Flat flat;
            eachPixel([&](std::size_t pixel, const glm::dvec2& at) {
                const glm::dvec2 off = glm::mod(at, glm::dvec2(40.0)) - 20.0;
                flat.wanted.values[pixel] = (glm::length(off) < radius) == dark ? 0.9F : 0.1F;
            });
            const auto ink = flat.inked(0.5);
            const std::size_t around = dark ? 0 : 1;
            EXPECT_EQ(ink.outlines.size(), around + (radius < 3.0 ? 0 : 16)) << dark << ' ' << radius;
            for (std::size_t i = around; i < ink.outlines.size(); ++i)
                EXPECT_NEAR(signedArea(ink.outlines[i]) / (std::numbers::pi * radius * radius),
                            dark ? 1.0 : -1.0, 0.1);
        }
    }
}

/// What lies behind a crowd of lines gets no dark border, and its own is as sharp.
TEST(SolidInk, EndsWhereTheDepthSteps) {
    Flat flat;
    eachPixel([&](std::size_t pixel, const glm::dvec2& at) {
        const bool near = at.x < 70.0 + 0.3 * at.y;
        flat.modalities.depth.values[pixel] = near ? 1.0F : 9.0F;
        flat.cover.values[pixel] = near ? 1.0F : 0.0F;
    });
    const auto ink = flat.inked(0.5);
    eachPixel([&](std::size_t pixel, const glm::dvec2& at) {
        const double off = at.x - 70.0 - 0.3 * at.y;
        if (std::abs(off) < 1.5) return;
        EXPECT_EQ(ink.ground.values[pixel], off > 0.0 ? Ground::simple : Ground::solid)
            << at.x << ' ' << at.y;
    });
    // Its edge is no staircase.
    for (const auto& point : ink.outlines.at(0).points) {
        if (point.y < 4.0 || point.y > solidSide - 4.0 || point.x < 4.0) continue;
        EXPECT_NEAR(point.x - 70.0 - 0.3 * point.y, 0.0, 0.35);
    }
}

/// Steps on both sides of a line keep it from being blurred.
TEST(SolidInk, ALoneLineIsNotComplex) {
    Flat flat;
    flat.cover = Raster<float>(solidSide, solidSide);
    for (std::uint32_t row = 0; row < solidSide; ++row) {
        for (const std::uint32_t column : {40U, 120U}) flat.cover.at(column, row) = 1.3F;
        flat.modalities.depth.at(120, row) = 1.0F;
    }
    EXPECT_EQ(countOf(flat.inked(1.0), Ground::simple), double(solidSide) * solidSide);
}

TEST(SolidInk, AnyPictureDoesNoHarm) {
    test::Random random(3);
    for (const auto& [width, height] : {std::pair(1U, 1U), std::pair(1U, 40U), std::pair(37U, 3U)}) {
        for (int i = 0; i < 20; ++i) {
            Modalities modalities{Raster<float>(width, height), Raster<float>(width, height),
                                  Raster<float>(width, height), Raster<std::uint32_t>(width, height), 1.0};
            Raster<float> wanted(width, height), cover(width, height);
            for (std::size_t k = 0; k < wanted.values.size(); ++k) {
                modalities.depth.values[k] = random.oneOf({1.0F, 2.0F, HUGE_VALF});
                wanted.values[k] = random.oneOf({0.0F, 0.5F, 1.0F});
                cover.values[k] = random.oneOf({0.0F, 0.3F, 1e9F});
            }
            const double strength = random.oneOf({1e-9, 0.5, 1.0});
            const auto ink = solidInk({modalities, wanted, cover},
                                      {.strength = strength, .complexity = random.oneOf({0.0, 0.3, 1.0})},
                                      random.oneOf({1.0, 6.0, 1e3}), {});
            EXPECT_EQ(ink.ground.values.size(), wanted.values.size());
            for (const auto& outline : ink.outlines) EXPECT_GE(outline.points.size(), 3U);
        }
    }
}

/// Compared with what lies in each pixel that straight lines pass.
TEST(LinesBeside, KeepsWhatLiesOnSimpleGround) {
    test::Random random(4);
    for (int i = 0; i < 20; ++i) {
        const Flat flat;
        Raster<Ground> ground(solidSide, solidSide);
        eachPixel([&](std::size_t pixel, const glm::dvec2& at) {
            const double wave = std::sin(0.1 * at.x + i) + std::sin(0.13 * at.y - 2.0 * i);
            ground.values[pixel] = wave < 0.0 ? Ground::simple : wave < 0.7 ? Ground::paper : Ground::solid;
        });
        std::vector<InkLine> lines(10);
        double expected = 0.0;
        for (auto& line : lines) {
            for (int k = 0; k < 5; ++k)
                line.points.push_back({{random.between(-20.0, 180.0), random.between(-20.0, 180.0)},
                                       5.0,
                                       random.oneOf({0.1, 0.9})});
            for (int k = 0; k < 4; ++k) {
                const auto &from = line.points[k], &to = line.points[k + 1];
                for (int part = 0; part < 2000; ++part) {
                    const auto at = glm::mix(from.at, to.at, (part + 0.5) / 2000.0);
                    const Ground here = ground.near(at.x, at.y);
                    if (here == Ground::simple || (here == Ground::paper && from.step > 0.5))
                        expected += glm::distance(from.at, to.at) / 2000.0;
                }
            }
        }
        const auto kept = linesBeside(lines, ground, flat.modalities, {.leastStep = 0.5}, {});
        double length = 0.0;
        for (const auto& line : kept) {
            ASSERT_GE(line.points.size(), 2U);
            for (std::size_t k = 0; k + 1 < line.points.size(); ++k) {
                const auto &from = line.points[k], &to = line.points[k + 1];
                length += glm::distance(from.at, to.at);
                const auto at = glm::mix(from.at, to.at, 0.5);
                const Ground here = ground.near(at.x, at.y);
                // Half a pixel's way around a boundary is not looked at.
                if (glm::distance(from.at, to.at) > 2.0) {
                    EXPECT_TRUE(here == Ground::simple || (here == Ground::paper && from.step > 0.5));
                }
            }
        }
        EXPECT_NEAR(length / expected, 1.0, 0.01);
        const auto longer =
            linesBeside(lines, ground, flat.modalities, {.leastStep = 0.5, .shortest = 8.0}, {});
        EXPECT_LT(longer.size(), kept.size());
    }
}

/// Left a crowd of short lines whose tone changes from top to bottom, right a few.
InkScene crowdedScene(test::Random& random) {
    InkScene scene{.modalities = Flat().modalities, .lines = {}, .camera = {}};
    eachPixel([&](std::size_t pixel, const glm::dvec2& at) {
        scene.modalities.grey.values[pixel] = at.x < 80.0 ? static_cast<float>(at.y / solidSide) : 0.6F;
    });
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec2 from(i < 1990 ? random.between(0.0, 80.0) : random.between(100.0, 150.0),
                              random.between(0.0, solidSide));
        const double angle = random.between(0.0, 6.28);
        const glm::dvec2 to = from + random.between(4.0, 12.0) * glm::dvec2(std::cos(angle), std::sin(angle));
        scene.lines.push_back({LineKind::silhouette, {{from, 5.0, 0.1}, {to, 5.0, 0.1}}});
    }
    return scene;
}

TEST(SolidDrawing, DrawsNothingTwice) {
    test::Random random(5);
    const auto scene = crowdedScene(random);
    for (const double strength : {0.3, 0.5, 0.8}) {
        auto style = test::usualInk();
        style.solid.strength = strength;
        auto lines = drawInk(scene, style, 1.0, {}).strokes;
        auto areas = lines;
        lines.areas.clear();
        areas.lines.clear();
        const auto inked = test::coverOf(areas, solidSide, solidSide),
                   drawn = test::coverOf(lines, solidSide, solidSide);
        double solid = 0.0, left = 0.0, bare = 0.0;
        eachPixel([&](std::size_t pixel, const glm::dvec2& at) {
            // The crowd ends about there, and outlines round a picture's corners.
            if (at.x > 70.0 || (at.x < 1.0 && (at.y < 1.0 || at.y > solidSide - 1.0))) return;
            const double tone = 1.0 - at.y / solidSide;
            left += 1.0;
            solid += inked.values[pixel];
            bare += 1.0 - std::max(inked.values[pixel], drawn.values[pixel]);
            if (std::abs(tone - 1.0 + strength) < 0.04) return;
            EXPECT_EQ(inked.values[pixel], tone > 1.0 - strength ? 1.0 : 0.0) << at.x << ' ' << at.y;
            EXPECT_EQ(drawn.values[pixel], 0.0) << at.x << ' ' << at.y;
        });
        EXPECT_NEAR(solid / left, strength, 0.01);
        EXPECT_NEAR(bare / left, 1.0 - strength, 0.01);
    }
}

TEST(SolidDrawing, LeavesTheRestAsDarkAsItIs) {
    test::Random random(6);
    const auto scene = crowdedScene(random);
    auto style = test::usualInk();
    const auto without = test::coverOf(drawInk(scene, style, 1.0, {}).strokes, solidSide, solidSide);
    style.solid.strength = 0.5;
    const auto with = test::coverOf(drawInk(scene, style, 1.0, {}).strokes, solidSide, solidSide);
    double before = 0.0, tone = 0.0, count = 0.0;
    eachPixel([&](std::size_t pixel, const glm::dvec2& at) {
        if (at.x < 110.0) return;
        before += without.values[pixel];
        tone += with.values[pixel];
        count += 1.0;
    });
    EXPECT_NEAR(tone / count, before / count, 0.02);
    EXPECT_NEAR(tone / count, 0.4, 0.04);
    // Beside the crowd, where its own tone is not taken for that of hatches.
    double beside = 0.0, pixels = 0.0;
    eachPixel([&](std::size_t pixel, const glm::dvec2& at) {
        if (at.x < 92.0 || at.x > 104.0) return;
        beside += with.values[pixel];
        pixels += 1.0;
    });
    EXPECT_NEAR(beside / pixels, 0.4, 0.08);
}

}  // namespace
}  // namespace mote::render
