// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/text_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_dir.h"

namespace mote {
namespace {

TEST(TextFile, AFileOfAnySizeIsReadWholeInMemoryOfItsOwnSize) {
    const test::TempDir folder;
    constexpr std::size_t limit = 300'000;
    for (const std::size_t size :
         {0, 1, 65'535, 65'536, 65'537, 196'608, 299'999, 300'000, 300'001, 700'000}) {
        std::string text(size, 'a');
        for (std::size_t i = 0; i < size; i += 7) text[i] = static_cast<char>('a' + i % 26);
        std::ofstream(folder.path() / "some.json", std::ios::binary) << text;
        const auto read = readTextFile(folder.path() / "some.json", limit);
        ASSERT_EQ(read.ok(), size <= limit) << size;
        if (!read.ok()) continue;
        EXPECT_EQ(*read, text);
        EXPECT_LE(read->capacity(), 2 * size + 65'536) << size;
    }
}

}  // namespace
}  // namespace mote
