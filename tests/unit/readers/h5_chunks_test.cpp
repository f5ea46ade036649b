// SPDX-License-Identifier: GPL-3.0-or-later
//
// Datasets in chunks: decoded by our own code, encoded here by HDF5.
#include <gmock/gmock.h>

#include <cstring>
#include <optional>
#include <random>

#include "preprocess/readers/hdf5/lzf.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/h5_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string chunkedX = "/data/1/particles/e/position/x";

class H5ChunksTest : public testing::Test {
  protected:
    /// Makes a run whose x `fill` writes.
    template <class Fill>
    void write(Fill fill) {
        H5TestFile file(path());
        file.text("/", "openPMD", "1.1.0");
        file.text("/", "particlesPath", "particles/");
        fill(file);
    }
    std::filesystem::path path() const { return folder_ / "run.h5"; }

    TempDir folder_;
};

/// Replaces the only chunk of x by other bytes; bit i of `skipped`: its filter i was left out.
void replaceChunk(H5TestFile& file, const std::string& bytes, std::uint32_t skipped) {
    const hid_t dataset = H5Dopen2(file.id(), chunkedX.c_str(), H5P_DEFAULT);
    const hsize_t start = 0;
    EXPECT_GE(H5Dwrite_chunk(dataset, H5P_DEFAULT, skipped, &start, bytes.size(), bytes.data()), 0);
    H5Dclose(dataset);
}

enum Filter : unsigned { deflate = 1, shuffle = 2, fletcherFirst = 4, fletcherLast = 8, plane = 16 };

class H5ChunkFilters : public H5ChunksTest, public testing::WithParamInterface<unsigned> {};

/// Every kind of number; chunks that do not divide the rows; a second dimension of length 1 with longer
/// chunks.
TEST_P(H5ChunkFilters, areUndone) {
    constexpr std::size_t rows = 1001;
    std::vector<double> values(rows);
    for (std::size_t i = 0; i < rows; ++i) values[i] = static_cast<double>(i * i % 127);
    const unsigned filters = GetParam();
    for (const hid_t type :
         {H5T_IEEE_F64LE, H5T_IEEE_F64BE, H5T_IEEE_F32LE, H5T_STD_I8LE, H5T_STD_U16BE, H5T_STD_I64LE}) {
        const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
        const hsize_t chunk[2] = {101, 3};
        const bool twoDimensions = (filters & plane) != 0;
        ASSERT_GE(H5Pset_chunk(creation, twoDimensions ? 2 : 1, chunk), 0);
        if (filters & fletcherFirst) H5Pset_fletcher32(creation);
        if (filters & shuffle) H5Pset_shuffle(creation);
        if (filters & deflate) H5Pset_deflate(creation, 4);
        if (filters & fletcherLast) H5Pset_fletcher32(creation);
        write([&](H5TestFile& file) {
            std::vector<char> bytes(rows * sizeof(double));
            std::memcpy(bytes.data(), values.data(), bytes.size());
            ASSERT_GE(H5Tconvert(H5T_NATIVE_DOUBLE, type, rows, bytes.data(), nullptr, H5P_DEFAULT), 0);
            const std::vector<hsize_t> flat = {rows}, narrow = {rows, 1};
            file.write(chunkedX, type, bytes.data(), twoDimensions ? narrow : flat, creation);
        });
        H5Pclose(creation);
        NoteKeeper progress;
        MOTE_OPEN(source, {path()}, progress);
        EXPECT_EQ(column(*source, 0, Column::x), values);
        prep::ParticleChunk part;
        ASSERT_TRUE(source->read(0, 100, 2, {Column::x}, part).ok());
        EXPECT_THAT(part[Column::x], ElementsAre(values[100], values[101]));
    }
}

INSTANTIATE_TEST_SUITE_P(All, H5ChunkFilters,
                         testing::Values(0u, plane, deflate, deflate | plane, shuffle | deflate, shuffle,
                                         fletcherLast, fletcherLast | plane, fletcherFirst | deflate,
                                         shuffle | deflate | fletcherLast | plane,
                                         fletcherFirst | shuffle | deflate));

TEST_F(H5ChunksTest, thatWereNeverWrittenHoldTheFillValue) {
    write([](H5TestFile& file) {
        const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
        const hsize_t chunk = 4, begin = 4, count = 4;
        const double fill = -7, values[] = {1, 2, 3, 4};
        H5Pset_chunk(creation, 1, &chunk);
        H5Pset_deflate(creation, 1);
        H5Pset_fill_value(creation, H5T_NATIVE_DOUBLE, &fill);
        file.empty(chunkedX, {10}, creation);
        const hid_t dataset = H5Dopen2(file.id(), chunkedX.c_str(), H5P_DEFAULT);
        const hid_t space = H5Dget_space(dataset), memory = H5Screate_simple(1, &count, nullptr);
        H5Sselect_hyperslab(space, H5S_SELECT_SET, &begin, nullptr, &count, nullptr);
        EXPECT_GE(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values), 0);
        H5Sclose(memory);
        H5Sclose(space);
        H5Dclose(dataset);
        H5Pclose(creation);
    });
    NoteKeeper progress;
    MOTE_OPEN(source, {path()}, progress);
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(-7, -7, -7, -7, 1, 2, 3, 4, -7, -7));
}

/// HDF5 1.10 reads beyond a chunk whose filters were left out, as a flipped bit can say.
TEST_F(H5ChunksTest, ofAnotherSizeAreRefused) {
    write([](H5TestFile& file) {
        file.gzipped(chunkedX, std::vector<double>(1000, 1.0), 1000);
        replaceChunk(file, std::string(40, 'x'), 3);
    });
    EXPECT_THAT(errorOf({path()}), HasSubstr("corrupt: run.h5:" + chunkedX +
                                             ": has a chunk that holds 40 bytes instead of 8000"));
    write([](H5TestFile& file) {
        file.gzipped(chunkedX, std::vector<double>(1000, 1.0), 1000);
        replaceChunk(file, std::string(40, 'x'), 0);
    });
    EXPECT_THAT(errorOf({path()}), HasSubstr("its compressed data is damaged"));
}

TEST_F(H5ChunksTest, whoseChecksumIsWrongAreRefused) {
    write([](H5TestFile& file) {
        const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
        const hsize_t chunk = 10;
        H5Pset_chunk(creation, 1, &chunk);
        H5Pset_fletcher32(creation);
        file.empty(chunkedX, {10}, creation);
        replaceChunk(file, std::string(84, 'x'), 0);
        H5Pclose(creation);
    });
    EXPECT_THAT(errorOf({path()}), HasSubstr("its checksum does not fit its data"));
}

std::optional<std::string> undone(const std::vector<std::uint8_t>& packed, std::size_t most) {
    std::vector<std::uint8_t> bytes;
    if (!prep::undoLzf(packed, most, bytes)) return std::nullopt;
    return std::string(bytes.begin(), bytes.end());
}

TEST(Lzf, isUndone) {
    EXPECT_EQ(undone({}, 10), "");
    EXPECT_EQ(undone({2, 'a', 'b', 'c'}, 3), "abc");
    EXPECT_EQ(undone({0, 'a', 0x20, 0}, 4), "aaaa") << "a copy of what is still in the making";
    EXPECT_EQ(undone({1, 'a', 'b', 0x40, 1, 0, 'c'}, 10), "abababc");
    EXPECT_EQ(undone({0, 'a', 0xe0, 10, 0}, 100), std::string(20, 'a'));
}

TEST(Lzf, isRefusedWhereItIsDamaged) {
    EXPECT_FALSE(undone({2, 'a'}, 10)) << "cut in a run";
    EXPECT_FALSE(undone({0, 'a', 0x20}, 10)) << "cut in a copy";
    EXPECT_FALSE(undone({0, 'a', 0xe0}, 10)) << "cut in a length";
    EXPECT_FALSE(undone({0x20, 0}, 10)) << "a copy of nothing";
    EXPECT_FALSE(undone({0, 'a', 0x20, 1}, 10)) << "from before the beginning";
    EXPECT_FALSE(undone({2, 'a', 'b', 'c'}, 2)) << "more than there may be";
    EXPECT_FALSE(undone({0, 'a', 0xe0, 255, 0}, 100));
    std::mt19937 random(11);
    for (int i = 0; i < 20'000; ++i) {
        std::vector<std::uint8_t> packed(random() % 40);
        for (auto& byte : packed) byte = static_cast<std::uint8_t>(random());
        const auto made = undone(packed, 300);
        EXPECT_TRUE(!made || made->size() <= 300);
    }
}

}  // namespace
}  // namespace mote::test
