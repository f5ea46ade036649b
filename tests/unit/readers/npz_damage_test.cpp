// SPDX-License-Identifier: GPL-3.0-or-later
//
// Archives of NumPy arrays (.npz) that are cut or have flipped bits.
#include <gmock/gmock.h>

#include "tests/support/random.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/npy_test_file.h"
#include "tests/unit/readers/source_test.h"
#include "tests/unit/readers/zip_test_file.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::HasSubstr;
using Npz = SourceTest;

/// Every array that the reader understands, packed and not.
std::string variedArchive() {
    ZipTestFile zip;
    ZipTestFile::Form packedForm;
    packedForm.deflated = true;
    Random random(5);
    zip.add("x.npy", doubles("(2, 20)", randomValues(random, 40)), packedForm);
    zip.add("position_y.npy", doubles("(2, 20)", randomValues(random, 40)));
    zip.add("momentum.npy", doubles("(2, 20, 3)", randomValues(random, 120)), packedForm);
    zip.add("id.npy", npy("{'descr': '<u2', 'fortran_order': False, 'shape': (20,), }",
                          packed<std::uint16_t>(std::vector<double>(20, 3.0))));
    zip.add("status.npy", npy("{'descr': '|i1', 'fortran_order': False, 'shape': (2, 20), }",
                              packed<std::int8_t>(std::vector<double>(40, 1.0))));
    zip.add("mass.npy", doubles("()", {5e5}));
    zip.add("time.npy", doubles("(2,)", {1, 2}));
    zip.add("iteration.npy", doubles("(2,)", {1, 2}), packedForm);
    return zip.bytes();
}

/// All that a run says, or its error.
std::string everything(const std::filesystem::path& path) {
    NoteKeeper progress;
    auto source = openFiles({path}, progress);
    if (!source) return "error: " + source.error().toString();
    std::string all = std::to_string((*source)->mass());
    for (std::size_t step = 0; step < (*source)->steps().size(); ++step) {
        const auto& info = (*source)->steps()[step];
        all += " | " + std::to_string(info.iteration) + " " + std::to_string(info.time);
        prep::ParticleChunk chunk;
        std::vector<Column> wanted = {Column::id};
        for (std::size_t i = 0; i + 1 < prep::columnCount; ++i) {
            if ((*source)->has(static_cast<Column>(i))) wanted.push_back(static_cast<Column>(i));
        }
        const auto status = (*source)->read(step, 0, info.particles, wanted, chunk);
        if (!status) return "error: " + status.error().toString();
        for (const auto& column : chunk.columns) {
            all.append(reinterpret_cast<const char*>(column.data()), 8 * column.size()) += ";";
        }
        all.append(reinterpret_cast<const char*>(chunk.id.data()), 8 * chunk.id.size());
        all.append(chunk.lost.begin(), chunk.lost.end());
    }
    return all;
}

TEST_F(Npz, thatIsCutAnywhereIsRefused) {
    const std::string whole = variedArchive();
    for (std::size_t length = 4; length < whole.size(); ++length) {
        writeFile(folder / "beam.npz", std::string_view(whole).substr(0, length));
        ASSERT_THAT(everything(folder / "beam.npz"), HasSubstr("error: beam.npz")) << "cut at " << length;
    }
}

TEST_F(Npz, withAnyBitFlippedSaysTheSameOrIsRefused) {
    const std::string whole = variedArchive();
    writeFile(folder / "beam.npz", whole);
    const std::string truth = everything(folder / "beam.npz");
    ASSERT_THAT(truth, testing::Not(HasSubstr("error")));
    Random random(6);
    int refused = 0;
    for (std::size_t i = 2; i < whole.size(); ++i) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ (1 << random.below(8)));
        writeFile(folder / "beam.npz", damaged);
        const std::string said = everything(folder / "beam.npz");
        if (said.starts_with("error: ")) {
            ++refused;
        } else {
            ASSERT_TRUE(said == truth) << "a flipped bit of byte " << i << " changed what was read";
        }
    }
    // What may change unnoticed are dates, versions and attributes of the archive's entries.
    EXPECT_GT(refused, static_cast<int>(whole.size()) * 4 / 5);
}

TEST_F(Npz, isNotReadOnceItsJobIsCancelled) {
    writeFile(folder / "beam.npz", variedArchive());
    progress.cancel = true;
    const auto source = openFiles({folder / "beam.npz"}, progress);
    ASSERT_FALSE(source.ok());
    EXPECT_EQ(source.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mote::test
