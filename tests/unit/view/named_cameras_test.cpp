// SPDX-License-Identifier: GPL-3.0-or-later
//
// Cameras have names, outlive the viewer, and are gone to in a moment.
#include "client/view/hand/named_cameras.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_dir.h"

namespace mote::client {
namespace {

using What = CameraWish::What;

Camera cameraAt(double x) {
    Camera camera;
    camera.eye = {x, 0.5, 4.0};
    return camera;
}

std::vector<std::string> namesOf(const CameraShelf& shelf, const std::string& dataset) {
    std::vector<std::string> names;
    for (const auto& camera : shelf.of(dataset)) names.push_back(camera.name);
    return names;
}

TEST(CameraShelf, CamerasAreKeptReplacedRenamedAndRemoved) {
    CameraShelf shelf;
    ASSERT_TRUE(shelf.apply("a", {What::keep, 0, "front"}, cameraAt(1.0)).ok());
    ASSERT_TRUE(shelf.apply("a", {What::keep}, cameraAt(2.0)).ok());
    ASSERT_TRUE(shelf.apply("a", {What::keep}, cameraAt(3.0)).ok());
    EXPECT_THAT(namesOf(shelf, "a"), testing::ElementsAre("front", "camera 1", "camera 2"));
    EXPECT_TRUE(shelf.of("b").empty());
    ASSERT_TRUE(shelf.apply("a", {What::keep, 0, "front"}, cameraAt(4.0)).ok());  // of that name
    ASSERT_TRUE(shelf.apply("a", {What::replace, 2}, cameraAt(5.0)).ok());
    ASSERT_TRUE(shelf.apply("a", {What::rename, 2, "side"}, cameraAt(6.0)).ok());
    ASSERT_TRUE(shelf.apply("a", {What::remove, 1}, cameraAt(6.0)).ok());
    EXPECT_THAT(namesOf(shelf, "a"), testing::ElementsAre("front", "side"));
    EXPECT_EQ(shelf.of("a")[0].camera, cameraAt(4.0));
    EXPECT_EQ(shelf.of("a")[1].camera, cameraAt(5.0));
    for (const char* name : {"two\nlines", "\xff"})
        EXPECT_FALSE(shelf.apply("a", {What::keep, 0, name}, cameraAt(1.0)).ok());
    EXPECT_FALSE(shelf.apply("a", {What::rename, 0, std::string(65, 'x')}, cameraAt(1.0)).ok());
    EXPECT_THAT(namesOf(shelf, "a"), testing::ElementsAre("front", "side"));
}

TEST(CameraShelf, AStateIsTakenBack) {
    CameraShelf shelf;
    const auto before = shelf.state();
    ASSERT_TRUE(shelf.apply("a", {What::keep}, cameraAt(1.0)).ok());
    const auto after = shelf.state();
    ASSERT_TRUE(shelf.restore(before).ok());
    EXPECT_TRUE(shelf.of("a").empty());
    ASSERT_TRUE(shelf.restore(after).ok());
    EXPECT_EQ(shelf.of("a").size(), 1U);
}

TEST(CameraShelf, AFileOutlivesItAndBelongsToSeveral) {
    const test::TempDir folder;
    const auto file = folder.path() / "state" / "key.cameras";
    CameraShelf one, other;
    ASSERT_TRUE(one.keepIn(file).ok());
    ASSERT_TRUE(other.keepIn(file).ok());
    ASSERT_TRUE(one.apply("a b", {What::keep, 0, "von vorn \xc3\xa4"}, cameraAt(1.0 / 3.0)).ok());
    ASSERT_TRUE(other.apply("c", {What::keep}, cameraAt(2.0)).ok());  // which knows nothing of "a b"
    CameraShelf later;
    ASSERT_TRUE(later.keepIn(file).ok());
    ASSERT_EQ(later.of("a b").size(), 1U);
    EXPECT_EQ(later.of("a b")[0], (NamedCamera{"von vorn \xc3\xa4", cameraAt(1.0 / 3.0)}));
    EXPECT_EQ(later.of("c").size(), 1U);
    ASSERT_TRUE(later.apply("c", {What::remove, 0}, cameraAt(2.0)).ok());
    CameraShelf last;
    ASSERT_TRUE(last.keepIn(file).ok());
    EXPECT_TRUE(last.of("c").empty());
    EXPECT_EQ(last.of("a b").size(), 1U);
}

TEST(CameraShelf, AFileOfSomethingElseStaysAsItIs) {
    const test::TempDir folder;
    const auto file = folder.path() / "key.cameras";
    for (const char* content : {"", "something\n", "mote-view cameras 1\ncamera x\n{}\n",
                                "mote-view cameras 1\ndataset a\ncamera x\n{\"eye\": [1]}\n"}) {
        std::ofstream(file) << content;
        CameraShelf shelf;
        EXPECT_FALSE(shelf.keepIn(file).ok()) << content;
        EXPECT_TRUE(shelf.apply("a", {What::keep}, cameraAt(1.0)).ok());
        std::ostringstream there;
        there << std::ifstream(file).rdbuf();
        EXPECT_EQ(there.str(), content);
    }
}

TEST(CameraGlide, EndsExactlyWhereItGoes) {
    CameraGlide glide;
    const auto from = cameraAt(0.0), to = cameraAt(3.0);
    EXPECT_FALSE(glide.next(0.0, from));
    glide.begin(from, to, 10.0);
    auto seen = from;
    for (const double now : {10.1, 10.2, 10.3}) {
        const auto camera = glide.next(now, seen);
        ASSERT_TRUE(camera);
        EXPECT_GT(camera->eye.x, seen.eye.x);
        EXPECT_LT(camera->eye.x, to.eye.x);
        seen = *camera;
    }
    EXPECT_EQ(glide.next(10.01 + CameraGlide::seconds, seen), to);
    EXPECT_FALSE(glide.underWay());
}

TEST(CameraGlide, EndsWhereAHandMoves) {
    CameraGlide glide;
    glide.begin(cameraAt(0.0), cameraAt(3.0), 10.0);
    ASSERT_TRUE(glide.next(10.1, cameraAt(0.0)));
    EXPECT_FALSE(glide.next(10.2, cameraAt(9.0)));
    EXPECT_FALSE(glide.underWay());
}

}  // namespace
}  // namespace mote::client
