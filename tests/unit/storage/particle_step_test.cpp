// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/particle_step.h"

#include <gmock/gmock.h>
#include <hdf5.h>

#include <fstream>
#include <functional>
#include <thread>

#include "protocol/base/json.h"
#include "storage/hash.h"
#include "storage/manifest.h"
#include "storage/particles/step_file.h"
#include "storage/particles/step_layout.h"
#include "storage/storage_error.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/storage/forged_digest.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;
using test::digestOf;
using test::forgeDigest;
using test::TinyDataset;
using testing::HasSubstr;

std::shared_ptr<const ParticleStep> openStep(const fs::path& dataset) {
    auto opened = ParticleStep::open(dataset, *readManifest(dataset), 0);
    EXPECT_TRUE(opened.ok()) << opened.error().toString();
    return *opened;
}

Error openError(const fs::path& dataset) {
    const auto opened = ParticleStep::open(dataset, *readManifest(dataset), 0);
    EXPECT_FALSE(opened.ok());
    return opened.ok() ? Error{} : opened.error();
}

void flipByte(const fs::path& path, std::uint64_t offset) {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.seekg(static_cast<std::streamoff>(offset));
    const char before = static_cast<char>(file.get());
    file.seekp(static_cast<std::streamoff>(offset));
    file.put(static_cast<char>(before ^ 0x10));
}

/// Touches everything that a renderer may touch.
void useAll(const ParticleStep& step) {
    step.nodes();
    step.leaves();
    step.positions(0, step.pointCount());
    step.rows(0, step.pointCount());
    step.volume();
    step.preview(Preview::mostPoints);
}

TEST(ParticleStep, GivesBackWhatWasWritten) {
    const test::TempDir dir;
    const TinyDataset tiny;
    tiny.write(dir / "a.mote");
    const auto step = openStep(dir / "a.mote");
    const auto same = [](const auto& span, const auto& vector) {
        return std::equal(span.begin(), span.end(), vector.begin(), vector.end());
    };
    EXPECT_TRUE(same(step->nodes().level, tiny.level));
    EXPECT_TRUE(same(step->nodes().morton, tiny.morton));
    EXPECT_TRUE(same(step->nodes().firstChild, tiny.firstChild));
    EXPECT_TRUE(same(step->nodes().childCount, tiny.childCount));
    EXPECT_TRUE(same(step->nodes().count, tiny.count));
    EXPECT_TRUE(same(step->nodes().density, tiny.density));
    EXPECT_TRUE(same(step->nodes().minDensity, tiny.minDensity));
    EXPECT_TRUE(same(step->leaves().node, tiny.leafNode));
    EXPECT_TRUE(same(step->leaves().pointBegin, tiny.leafPointBegin));
    EXPECT_TRUE(same(step->leaves().pointCount, tiny.leafPointCount));
    EXPECT_TRUE(same(step->leaves().density, tiny.leafDensity));
    EXPECT_TRUE(same(step->volume(), tiny.volume));
    EXPECT_TRUE(same(step->rows(0, TinyDataset::points), tiny.row));
    EXPECT_EQ(step->rows(250000, 3)[2], tiny.row[250002]);
    EXPECT_EQ(step->positions(299999, 1)[0].z, tiny.position[299999].z);
    EXPECT_TRUE(step->positions(TinyDataset::points, 0).empty());
    EXPECT_EQ(step->volumeSize(), 4U);
    EXPECT_EQ(step->preview(4500).points.size(), 4500U);
    EXPECT_EQ(step->preview(5001).points.size(), 5000U);
    EXPECT_EQ(step->preview(0).total, 5000U);
    EXPECT_EQ(step->preview(5000).points[4999].x, 4999);
    EXPECT_TRUE(same(step->preview(0).threshold, tiny.threshold));
    EXPECT_EQ(step->preview(0).scale.min, 8e5);
    EXPECT_EQ(step->preview(0).scale.max, 16e5);
    EXPECT_EQ(step->logDensity().max, 16e5);
}

TEST(ParticleStep, TheSameContentGivesTheSameBytes) {
    const test::TempDir dir;
    for (const char* name : {"a.mote", "b.mote"}) TinyDataset().write(dir / name);
    for (const char* name : {"step-000000.h5", "step-000000.digest", "manifest.json"}) {
        EXPECT_EQ(hashFile(dir / "a.mote" / name)->xxh3_128, hashFile(dir / "b.mote" / name)->xxh3_128)
            << name;
    }
}

/// What HDF5 itself makes of the file: docs/FORMAT.md promises that any tool reads it.
TEST(ParticleStep, IsAnHdf5File) {
    const test::TempDir dir;
    const TinyDataset tiny;
    tiny.write(dir / "a.mote");
    const hid_t file = H5Fopen((dir / "a.mote" / "step-000000.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    std::vector<std::uint64_t> rows(TinyDataset::points);
    const hid_t array = H5Dopen2(file, "/points/row", H5P_DEFAULT);
    EXPECT_GE(H5Dread(array, H5T_NATIVE_UINT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()), 0);
    EXPECT_EQ(rows, tiny.row);
    H5Dclose(array);
    double weight = 0.0;
    const hid_t attribute = H5Aopen(file, "total_weight", H5P_DEFAULT);
    EXPECT_GE(H5Aread(attribute, H5T_NATIVE_DOUBLE, &weight), 0);
    EXPECT_EQ(weight, 3e5);
    H5Aclose(attribute);
    H5Fclose(file);
}

TEST(ParticleStep, AFlippedByteOfAnyArrayIsFoundAndNamed) {
    const test::TempDir dir;
    const auto dataset = dir / "a.mote";
    TinyDataset().write(dataset);
    const auto digest = digestOf(dataset);
    ASSERT_EQ(static_cast<std::size_t>(digest.arrays_size()), stepArrays.size());
    for (const auto& array : digest.arrays()) {
        SCOPED_TRACE(array.name());
        std::uint64_t bytes = array.type() == "u8"    ? 1
                              : array.type() == "u16" ? 2
                              : array.type() == "u64" ? 8
                                                      : 4;
        for (const auto extent : array.shape()) bytes *= extent;
        // First, last and, in arrays of several blocks, one in the second.
        for (const std::uint64_t at : {std::uint64_t{0}, bytes - 1, std::min(bytes - 1, blockBytes + 1)}) {
            const auto path = dataset / "step-000000.h5";
            flipByte(path, array.offset() + at);
            const auto step = openStep(dataset);
            try {
                useAll(*step);
                ADD_FAILURE() << "the damage at " << at << " was not noticed";
            } catch (const StorageError& error) {
                EXPECT_EQ(error.error().code, ErrorCode::corrupt);
                EXPECT_THAT(error.error().where, HasSubstr("step-000000.h5:" + array.name()));
                const auto block = std::to_string(at / blockBytes * blockBytes);
                EXPECT_THAT(error.error().message, HasSubstr("at byte " + block + " of the array"));
            }
            // verify names it too, and the file's hash.
            const auto errors = verifyDataset(dataset);
            EXPECT_THAT(errors,
                        testing::Contains(testing::Field(&Error::where, HasSubstr(":" + array.name()))));
            EXPECT_THAT(errors, testing::Contains(testing::Field(&Error::where, path.string())));
            flipByte(path, array.offset() + at);
        }
    }
    EXPECT_TRUE(verifyDataset(dataset).empty());
}

TEST(ParticleStep, OnlyWhatIsUsedIsVerified) {
    const test::TempDir dir;
    TinyDataset().write(dir / "a.mote");
    const auto digest = digestOf(dir / "a.mote");
    // The second block of the rows.
    flipByte(dir / "a.mote" / "step-000000.h5",
             digest.arrays(static_cast<int>(StepArray::pointRow)).offset() + blockBytes + 5);
    const auto step = openStep(dir / "a.mote");
    EXPECT_NO_THROW(step->rows(0, blockBytes / 8));
    EXPECT_NO_THROW(step->positions(0, TinyDataset::points));
    EXPECT_THROW(step->rows(blockBytes / 8 - 1, 2), StorageError);
    EXPECT_THROW(step->rows(0, TinyDataset::points), StorageError);
    EXPECT_NO_THROW(step->rows(2 * blockBytes / 8, 10));
}

TEST(ParticleStep, ManyThreadsMayTouchItFirst) {
    const test::TempDir dir;
    TinyDataset().write(dir / "a.mote");
    const auto step = openStep(dir / "a.mote");
    std::atomic<int> good{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
        threads.emplace_back([&] {
            useAll(*step);
            if (step->rows(100000, 1)[0] == 700000) ++good;
        });
    }
    for (auto& thread : threads) thread.join();
    EXPECT_EQ(good, 4);
}

TEST(ParticleStep, ATruncatedOrMissingFileIsAnErrorAtOpen) {
    const test::TempDir dir;
    const auto dataset = dir / "a.mote";
    TinyDataset().write(dataset);
    const auto path = dataset / "step-000000.h5";
    const auto size = fs::file_size(path);
    for (const std::uint64_t shorter : {size - 1, size / 2, std::uint64_t{0}}) {
        fs::resize_file(path, shorter);
        EXPECT_EQ(openError(dataset).code, ErrorCode::corrupt);
        EXPECT_THAT(openError(dataset).toString(), HasSubstr("truncated"));
        EXPECT_FALSE(verifyDataset(dataset).empty());
    }
    fs::resize_file(path, size + 1);
    EXPECT_EQ(openError(dataset).code, ErrorCode::corrupt);
    fs::remove(path);
    EXPECT_EQ(openError(dataset).code, ErrorCode::notFound);
    // Nothing of the dataset may be a link to something else, or a folder.
    fs::create_symlink("/dev/zero", path);
    EXPECT_EQ(openError(dataset).code, ErrorCode::corrupt);
    fs::remove(path);
    fs::create_directory(path);
    EXPECT_EQ(openError(dataset).code, ErrorCode::corrupt);
}

TEST(ParticleStep, ADamagedDigestIsAnErrorAtOpen) {
    const test::TempDir dir;
    const auto dataset = dir / "a.mote";
    TinyDataset().write(dataset);
    flipByte(dataset / "step-000000.digest", 100);
    EXPECT_EQ(openError(dataset).code, ErrorCode::corrupt);
    EXPECT_THAT(openError(dataset).where, HasSubstr("step-000000.digest"));
    EXPECT_EQ(ParticleStep::open(dataset, *readManifest(dataset), 1).error().code, ErrorCode::notFound);
}

TEST(ParticleStep, AForgedDigestIsAnErrorAtOpen) {
    using Change = std::function<void(proto::Digest&)>;
    const auto rows = static_cast<int>(StepArray::pointRow);
    const std::vector<Change> changes{
        [](auto& digest) { digest.mutable_arrays()->RemoveLast(); },
        [&](auto& digest) { digest.mutable_arrays(rows)->set_type("u32"); },
        [&](auto& digest) { digest.mutable_arrays(rows)->set_type("x"); },
        [&](auto& digest) { digest.mutable_arrays(rows)->set_offset(1ULL << 63); },
        [&](auto& digest) { digest.mutable_arrays(rows)->set_offset(~0ULL); },
        [&](auto& digest) { digest.mutable_arrays(rows)->set_offset(digest.arrays(rows).offset() + 1); },
        [&](auto& digest) { digest.mutable_arrays(rows)->set_shape(0, 1ULL << 61); },
        [&](auto& digest) { digest.mutable_arrays(rows)->set_shape(0, 5); },
        [&](auto& digest) { digest.mutable_arrays(rows)->clear_shape(); },
        [&](auto& digest) { digest.mutable_arrays(rows)->add_shape(1ULL << 40); },
        [&](auto& digest) { digest.mutable_arrays(rows)->clear_blocks(); },
        [&](auto& digest) { digest.mutable_arrays(rows)->add_blocks(1); },
        [](auto& digest) { digest.mutable_arrays(0)->set_shape(0, 0); },
        [](auto& digest) {
            digest.mutable_arrays(static_cast<int>(StepArray::volumeDensity))->set_shape(2, 2);
        },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
        SCOPED_TRACE(i);
        const test::TempDir dir;
        TinyDataset().write(dir / "a.mote");
        forgeDigest(dir / "a.mote", changes[i]);
        EXPECT_EQ(openError(dir / "a.mote").code, ErrorCode::corrupt);
    }
}

TEST(ParticleStep, AnImpossibleOctreeIsAnErrorAtItsFirstUse) {
    using Change = std::function<void(TinyDataset&)>;
    const std::vector<Change> changes{
        [](auto& tiny) { tiny.firstChild[0] = 0; },  // a cycle
        [](auto& tiny) { tiny.firstChild[0] = 2; },  // a node without a parent
        [](auto& tiny) { tiny.firstChild[0] = 4000000000U; },
        [](auto& tiny) { tiny.childCount[0] = 3; },  // beyond the end
        [](auto& tiny) { tiny.childCount[0] = 255; },
        [](auto& tiny) { tiny.childCount[2] = 1; },
        [](auto& tiny) { tiny.firstChild[1] = 2; },  // no such leaf
        [](auto& tiny) { tiny.firstChild[1] = 0; },  // another's leaf
        [](auto& tiny) { tiny.leafNode[0] = 9; },
        [](auto& tiny) { tiny.leafNode[0] = 0; },
        [](auto& tiny) { tiny.level[1] = 2; },
        [](auto& tiny) { tiny.level[1] = 200; },
        [](auto& tiny) { tiny.level[0] = 1; },
        [](auto& tiny) { tiny.morton[1] = 8; },
        [](auto& tiny) { tiny.morton[1] = 6; },
        [](auto& tiny) { tiny.morton[0] = 1; },
        [](auto& tiny) { tiny.count[1] = 200001; },
        [](auto& tiny) { tiny.leafPointBegin[1] = 99999; },
        [](auto& tiny) { tiny.leafPointBegin[0] = 1; },
        [](auto& tiny) { tiny.leafPointCount[1] = 200001; },
        [](auto& tiny) { tiny.leafPointCount[1] = 0; },
        [](auto& tiny) { tiny.leafDensity[0] = 1e9F; },
        [](auto& tiny) { tiny.leafDensity[1] = std::numeric_limits<float>::quiet_NaN(); },
        [](auto& tiny) { tiny.density[2] = -1.0F; },
        [](auto& tiny) { tiny.density[0] = std::numeric_limits<float>::infinity(); },
        [](auto& tiny) { tiny.minDensity[0] = 1.0F; },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
        SCOPED_TRACE(i);
        const test::TempDir dir;
        TinyDataset tiny;
        changes[i](tiny);
        tiny.write(dir / "a.mote");
        const auto step = openStep(dir / "a.mote");
        for (int attempt = 0; attempt < 2; ++attempt) {
            EXPECT_THROW(step->nodes(), StorageError);
            EXPECT_THROW(step->leaves(), StorageError);
        }
        const auto errors = verifyDataset(dir / "a.mote");
        ASSERT_EQ(errors.size(), 1U);
        EXPECT_EQ(errors.front().code, ErrorCode::corrupt);
    }
}

TEST(Verify, MissingAndExtraFilesAndBytesOutsideTheArrays) {
    const test::TempDir dir;
    const auto dataset = dir / "a.mote";
    TinyDataset().write(dataset);
    std::ofstream(dataset / "note.txt") << "mine";
    auto errors = verifyDataset(dataset);
    ASSERT_EQ(errors.size(), 1U);
    EXPECT_EQ(errors.front().where, (dataset / "note.txt").string());
    fs::remove(dataset / "note.txt");
    flipByte(dataset / "step-000000.h5", 9);  // in the superblock
    errors = verifyDataset(dataset);
    ASSERT_EQ(errors.size(), 1U);
    EXPECT_THAT(errors.front().message, HasSubstr("hash in the manifest"));
    fs::remove(dataset / "step-000000.digest");
    errors = verifyDataset(dataset);
    EXPECT_THAT(errors, testing::Contains(testing::Field(&Error::code, ErrorCode::notFound)));
    EXPECT_EQ(verifyDataset(dir / "none.mote").front().code, ErrorCode::notFound);
    EXPECT_EQ(verifyDataset(dataset, [] { return true; }).front().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mote::storage
