// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/composite/dark_cells.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace mote::render {
namespace {

constexpr std::size_t edge = GridBricks::edge, side = GridBricks::samples, sheet = side * side;
static_assert(edge == 8, "a row of cells is a byte of bits, a sheet a word");

/// Codes among which nothing shows, first and last included.
using CodeGap = CodeRange;

/// The number of the table's entry for a code, as all kinds of vectors tell it: some round once where others
/// round twice.
class EntryNumbers {
  public:
    EntryNumbers(std::uint32_t code, const CodePlaces& places) {
        const auto x = static_cast<float>(code);
        const float product = x * places.scale;
        const std::uint32_t once = numberOf(std::fma(x, places.scale, places.shift));
        const std::uint32_t twice = numberOf(product + places.shift);
        low = std::min(once, twice);
        high = std::max(once, twice);
    }

    std::uint32_t low, high;

  private:
    /// As GridSource finds it.
    static std::uint32_t numberOf(float exact) {
        const float density = (exact + 49152.0F) - 49152.0F;
        const float held = std::clamp(density, 0.5F, TransferTable::cells + 1.25F);
        return std::bit_cast<std::uint32_t>(held + 8388607.5F) - 0x4b000000U;
    }
};

/// The least code from 0 to 65536 of which `holds`, which does for all greater ones.
template <class Holds>
std::uint32_t leastCode(const Holds& holds) {
    std::uint32_t low = 0, high = 65536;
    while (low < high) {
        const std::uint32_t middle = (low + high) / 2;
        if (holds(middle))
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/// The widest gaps, no more than are quickly asked one by one.
std::vector<CodeGap> gapsOf(const TransferTable& table, const CodePlaces& places) {
    constexpr std::size_t most = 8;
    std::vector<CodeGap> gaps;
    constexpr std::uint32_t entries = TransferTable::cells + 2;
    for (std::uint32_t first = 0; first < entries; ++first) {
        const float next = table.nextVisible()[first];
        if (next == static_cast<float>(first)) continue;
        const std::uint32_t end = next < entries ? static_cast<std::uint32_t>(next) : entries;
        const std::uint32_t from =
            leastCode([&](std::uint32_t code) { return EntryNumbers(code, places).low >= first; });
        const std::uint32_t behind =
            leastCode([&](std::uint32_t code) { return EntryNumbers(code, places).high >= end; });
        if (from < behind)
            gaps.push_back({static_cast<std::uint16_t>(from), static_cast<std::uint16_t>(behind - 1)});
        first = end;
    }
    std::sort(gaps.begin(), gaps.end(),
              [](const CodeGap& a, const CodeGap& b) { return a.high - a.low > b.high - b.low; });
    if (gaps.size() > most) gaps.resize(most);
    return gaps;
}

/// A bit a cell, 8 sheets of 8 rows of 8.
using CellBits = std::array<std::uint64_t, edge>;

/// What a step along x, y and z reaches, diagonal ones included.
CellBits around(const CellBits& bits) {
    constexpr std::uint64_t notFirst = 0xfefefefefefefefeU, notLast = 0x7f7f7f7f7f7f7f7fU;
    CellBits wide;
    for (std::size_t z = 0; z < edge; ++z) {
        const std::uint64_t row = bits[z] | (bits[z] << 1U & notFirst) | (bits[z] >> 1U & notLast);
        wide[z] = row | row << 8U | row >> 8U;
    }
    CellBits all;
    for (std::size_t z = 0; z < edge; ++z)
        all[z] = wide[z] | (z > 0 ? wide[z - 1] : 0) | (z + 1 < edge ? wide[z + 1] : 0);
    return all;
}

/// Each bit of a byte, 4 apart.
constexpr std::array<std::uint32_t, 256> spreadBits() {
    std::array<std::uint32_t, 256> spread{};
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
        for (std::uint32_t i = 0; i < 8; ++i) spread[byte] |= (byte >> i & 1U) << (4 * i);
    }
    return spread;
}

void writeSteps(CellBits reached, std::uint32_t* rows) {
    static constexpr auto spread = spreadBits();
    std::array<CellBits, 4> counts{};  // bit by bit
    for (std::size_t step = 0; step < edge; ++step) {
        std::uint64_t anyLeft = 0;
        for (std::size_t z = 0; z < edge; ++z) {
            std::uint64_t carry = ~reached[z];
            anyLeft |= carry;
            for (auto& bits : counts) {
                const std::uint64_t both = bits[z] & carry;
                bits[z] ^= carry;
                carry = both;
            }
        }
        if (anyLeft == 0) break;
        reached = around(reached);
    }
    for (std::size_t row = 0; row < DarkCells::rowsOfBrick; ++row) {
        std::uint32_t word = 0;
        for (std::size_t bit = 0; bit < counts.size(); ++bit)
            word |= spread[counts[bit][row / edge] >> (8 * (row % edge)) & 255U] << bit;
        rows[row] = word;
    }
}

/// The cells of a brick in which something may show.
CellBits litCells(const std::uint16_t* values, const std::vector<CodeGap>& gaps) {
    // Whole vectors of 8 codes; what is beyond the last cell is not looked at.
    constexpr std::size_t alongX = 728, alongY = 720, asked = 640;
    static_assert(alongX + 1 == GridBricks::volume && asked >= (edge - 1) * (sheet + side) + edge);
    std::array<std::uint16_t, alongX + side> low{}, high{};
    for (std::size_t i = 0; i < alongX; ++i) {
        low[i] = std::min(values[i], values[i + 1]);
        high[i] = std::max(values[i], values[i + 1]);
    }
    for (std::size_t i = 0; i < alongY; ++i) {
        low[i] = std::min(low[i], low[i + side]);
        high[i] = std::max(high[i], high[i + side]);
    }
    for (std::size_t i = 0; i < asked; ++i) {
        low[i] = std::min(low[i], low[i + sheet]);
        high[i] = std::max(high[i], high[i + sheet]);
    }
    std::array<std::uint8_t, asked> lit;
    lit.fill(1);
    for (const CodeGap& gap : gaps) {
        const std::uint16_t first = gap.low, last = gap.high;
        for (std::size_t i = 0; i < asked; ++i)
            lit[i] &= static_cast<std::uint8_t>(static_cast<int>(low[i] < first) |
                                                static_cast<int>(high[i] > last));
    }
    CellBits bits{};
    for (std::size_t row = 0; row < DarkCells::rowsOfBrick; ++row) {
        std::uint64_t eight = 0;
        std::memcpy(&eight, lit.data() + row / edge * sheet + row % edge * side, sizeof eight);
        // Brings the lowest bit of each byte into the highest byte.
        bits[row / edge] |= (eight * 0x0102040810204080U) >> 56U << (8 * (row % edge));
    }
    return bits;
}

std::size_t rowsOf(const GridBricks& bricks) {
    return std::max<std::size_t>(bricks.corrected(), 1) * DarkCells::rowsOfBrick;
}

}  // namespace

CodePlaces::CodePlaces(const GridField& field, const TransferTable& table) {
    const double perValue = TransferTable::cells / (table.high() - table.low());
    scale = static_cast<float>((field.range.high - field.range.low) / 65535.0 * perValue);
    shift = static_cast<float>(1.0 + (field.range.low - table.low()) * perValue);
}

std::uint64_t DarkCells::bytesOf(const GridField& field) {
    return field.bricks->numbers.size() * sizeof(std::int32_t) +
           rowsOf(*field.bricks) * sizeof(std::uint32_t);
}

DarkCells::DarkCells(const GridField& field, const TransferTable& table, const VisibleBlocks& blocks)
    : places_(field.bricks->numbers) {
    const GridBricks& bricks = *field.bricks;
    const std::vector<CodeGap> gaps = gapsOf(table, CodePlaces(field, table));
    rows_.resize(rowsOf(bricks));
    tbb::parallel_for(std::size_t{0}, bricks.numbers.size(), [&](std::size_t i) {
        const std::uint8_t kind = blocks.steps()[i];
        if (kind < VisibleBlocks::visible) {
            places_[i] = unknown - kind;
        } else if (bricks.numbers[i] != GridBricks::none) {
            const auto number = static_cast<std::size_t>(bricks.numbers[i]);
            writeSteps(litCells(bricks.values.data() + number * GridBricks::volume, gaps),
                       rows_.data() + number * rowsOfBrick);
        }
    });
}

}  // namespace mote::render
