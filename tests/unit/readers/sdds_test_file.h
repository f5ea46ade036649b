// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the tests of SDDS data sets share: seeded particles as elegant has them, and a writer of every way to
// store them. Values and functions without state.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/deflate.h"

namespace mote::test {

struct SddsParticle {
    double x = 0, xp = 0, y = 0, yp = 0, t = 0, p = 0;  // m, 1, m, 1, s, m c
    std::uint64_t id = 0;
    std::string label;
    char mark = 'a';
};

struct SddsTestPage {
    std::int32_t step = 0;
    double charge = 0, place = 0, centralMomentum = 0;  // C, m, m c
    std::string title;
    std::vector<SddsParticle> particles;
};

/// How a data set is stored.
struct SddsForm {
    bool ascii = false, big = false, columnMajor = false;
    bool texts = false;           ///< a parameter, an array and a column of texts
    bool noRowCounts = false;     ///< ascii
    int linesPerRow = 1;          ///< ascii
    bool wideCount = false;       ///< binary: row counts of 64 bits
    int additionalLines = 0;      ///< behind the header
    bool orderInComment = false;  ///< "!# big-endian" in place of endian=big
    bool orderUnsaid = false;
    bool comments = false;  ///< ascii
};

/// Pages of `rows` particles each, with float values where the file has floats.
std::vector<SddsTestPage> sddsPages(std::uint64_t seed, std::size_t pages, std::size_t rows);

/// The header alone, and the whole data set.
std::string sddsHeader(const SddsForm& form);
std::string sddsFile(const SddsForm& form, const std::vector<SddsTestPage>& pages);

}  // namespace mote::test
