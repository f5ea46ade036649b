// SPDX-License-Identifier: GPL-3.0-or-later
//
// From a picture file to a dataset and back, and what becomes of damage.
#include "preprocess/image/image_job.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>

#include <fstream>

#include "preprocess/image/read_picture.h"
#include "storage/files/dataset_file.h"
#include "storage/image/image_file.h"
#include "storage/manifest.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ImageJob : public ::testing::Test {
  protected:
    ImageJob() {
        OIIO::ImageSpec spec(300, 200, 3, OIIO::TypeDesc::UINT8);
        std::vector<float> values(300 * 200 * 3);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 256) / 255.0F;
        auto output = OIIO::ImageOutput::create(input_.string());
        EXPECT_TRUE(output->open(input_.string(), spec));
        EXPECT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()) && output->close());
    }

    Result<proto::Manifest> make(const fs::path& output, long cancelAfter = -1) {
        proto::JobRequest request;
        request.set_output(output.string());
        request.mutable_image()->set_input(input_.string());
        QuietProgress progress(cancelAfter);
        return prep::runImageJob(request, input_, output, {}, progress);
    }

    TempDir folder_;
    fs::path input_ = folder_ / "photo.png";
};

TEST_F(ImageJob, readsBackWhatWasRead) {
    const auto made = make(folder_ / "a.mote");
    ASSERT_TRUE(made.ok()) << made.error().toString();
    const auto manifest = storage::readManifest(folder_ / "a.mote");
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    EXPECT_EQ(manifest->title(), "photo.png");
    EXPECT_EQ(manifest->request().image().input(), "photo.png");
    EXPECT_EQ(manifest->image().color_space(), "sRGB");
    const auto read = storage::readImage(folder_ / "a.mote", *manifest);
    ASSERT_TRUE(read.ok()) << read.error().toString();
    QuietProgress progress;
    const auto picture = prep::readPicture(input_, 0, progress);
    ASSERT_TRUE(picture.ok());
    EXPECT_EQ(*read, picture->luminance);
    EXPECT_TRUE(storage::verifyDataset(folder_ / "a.mote").empty());
}

/// A mean of means is that of all, where the factor divides the sides: 300 x 200 by 2 is 15,000 pixels.
TEST_F(ImageJob, largeImagesAreAveragedDown) {
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    const auto manifest = *storage::readManifest(folder_ / "a.mote");
    const auto whole = storage::readImage(folder_ / "a.mote", manifest);
    const auto half = storage::readImage(folder_ / "a.mote", manifest, 15000);
    ASSERT_TRUE(whole.ok() && half.ok());
    ASSERT_EQ(half->width, 150u);
    ASSERT_EQ(half->height, 100u);
    EXPECT_NEAR(half->at(7, 9),
                (whole->at(14, 18) + whole->at(15, 18) + whole->at(14, 19) + whole->at(15, 19)) / 4.0F,
                1e-6F);
    const auto odd = storage::readImage(folder_ / "a.mote", manifest, 1000);  // by 8
    ASSERT_TRUE(odd.ok());
    EXPECT_EQ(odd->width, 38u);
    EXPECT_EQ(odd->height, 25u);
    double corner = 0.0;  // 4 x 8 pixels are left at the right edge
    for (std::size_t y = 192; y < 200; ++y) {
        for (std::size_t x = 296; x < 300; ++x) corner += whole->at(x, y) / 32.0;
    }
    EXPECT_NEAR(odd->at(37, 24), corner, 1e-6);
}

TEST_F(ImageJob, sameFileSameBytes) {
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    ASSERT_TRUE(make(folder_ / "b.mote").ok());
    for (const char* name : {"manifest.json", "image.h5", "image.digest"}) {
        const auto a = storage::readWhole(folder_ / "a.mote" / name, 1 << 24);
        const auto b = storage::readWhole(folder_ / "b.mote" / name, 1 << 24);
        ASSERT_TRUE(a.ok() && b.ok());
        EXPECT_TRUE(*a == *b) << name;
    }
}

TEST_F(ImageJob, aFlippedBitIsFoundAndNamed) {
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    const auto path = folder_ / "a.mote" / "image.h5";
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(-1000, std::ios::end);
    const auto byte = static_cast<char>(file.peek() ^ 4);
    file.seekp(-1000, std::ios::end);
    file.put(byte);
    file.close();
    const auto manifest = storage::readManifest(folder_ / "a.mote");
    const auto read = storage::readImage(folder_ / "a.mote", *manifest);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().code, ErrorCode::corrupt);
    EXPECT_THAT(read.error().toString(), HasSubstr("image.h5:/image/luminance"));
    EXPECT_FALSE(storage::verifyDataset(folder_ / "a.mote").empty());
}

TEST_F(ImageJob, leavesNothingBehindWhenItFails) {
    for (long after = 0; after < 6; ++after) {
        const auto made = make(folder_ / "a.mote", after);
        if (made.ok()) fs::remove_all(folder_ / "a.mote");
        std::size_t files = 0;
        for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder_.path())) ++files;
        EXPECT_EQ(files, 1u) << after;
    }
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    const auto again = make(folder_ / "a.mote");
    ASSERT_FALSE(again.ok());
    EXPECT_EQ(again.error().code, ErrorCode::alreadyExists);
}

TEST_F(ImageJob, manifestsThatContradictThemselves) {
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    auto manifest = *storage::readManifest(folder_ / "a.mote");
    auto wrong = manifest;
    wrong.mutable_image()->set_width(0);
    EXPECT_FALSE(storage::checkManifest(wrong).ok());
    wrong.mutable_image()->set_width(1u << 30);
    EXPECT_FALSE(storage::checkManifest(wrong).ok());
    wrong = manifest;
    wrong.mutable_image()->set_width(299);
    ASSERT_TRUE(storage::checkManifest(wrong).ok());
    EXPECT_FALSE(storage::readImage(folder_ / "a.mote", wrong).ok());
    wrong = manifest;
    wrong.clear_files();
    EXPECT_FALSE(storage::checkManifest(wrong).ok());
}

}  // namespace
}  // namespace mote::test
