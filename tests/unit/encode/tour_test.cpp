// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/tour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <random>

namespace mote::server {
namespace {

std::vector<glm::dvec2> randomPlaces(std::size_t count) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> unit(0.0, 100.0);
    std::vector<glm::dvec2> places(count);
    for (auto& place : places) place = {unit(random), unit(random)};
    return places;
}

double lengthOf(const std::vector<glm::dvec2>& places, const std::vector<std::uint32_t>& order) {
    double length = 0.0;
    for (std::size_t i = 1; i < order.size(); ++i) {
        length += glm::distance(places[order[i - 1]], places[order[i]]);
    }
    return length;
}

TEST(Tour, visitsEachOnce) {
    for (const std::size_t count : {0, 1, 2, 3, 5, 1000}) {
        auto order = shortTour(randomPlaces(count));
        std::sort(order.begin(), order.end());
        ASSERT_EQ(order.size(), count);
        for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(order[i], i);
    }
}

/// The shortest way through n random points of an area A is 0.7124 sqrt(n A) long (Johnson, McGeoch and
/// Rothberg 1996). A space-filling curve is 25% above that (Platzman and Bartholdi 1989), 2-opt with
/// neighbours 5% (Johnson and McGeoch 1997); ours, with a bounded window, is to lie between.
TEST(Tour, isShort) {
    const auto places = randomPlaces(10000);
    const double shortest = 0.7124 * std::sqrt(10000.0 * 100.0 * 100.0);
    EXPECT_LT(lengthOf(places, shortTour(places)), 1.2 * shortest);
}

TEST(Tour, placesThatAreAllTheSame) {
    const std::vector<glm::dvec2> places(100, glm::dvec2(3.0, 4.0));
    EXPECT_EQ(shortTour(places).size(), 100u);
}

}  // namespace
}  // namespace mote::server
