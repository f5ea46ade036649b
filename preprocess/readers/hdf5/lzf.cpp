// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/hdf5/lzf.h"

namespace mote::prep {
namespace {

// A byte below this begins a run of so many bytes and one, others a copy.
constexpr std::size_t firstCopy = 32;
constexpr std::size_t longCopy = 7;      // in its upper three bits: its length goes on in the next byte
constexpr std::size_t shortestCopy = 2;  // is 0 there

}  // namespace

bool undoLzf(std::span<const std::uint8_t> packed, std::size_t most, std::vector<std::uint8_t>& bytes) {
    bytes.clear();
    for (std::size_t at = 0; at < packed.size();) {
        const std::size_t head = packed[at++];
        if (head < firstCopy) {
            const std::size_t count = head + 1;
            if (count > packed.size() - at || count > most - bytes.size()) return false;
            bytes.insert(bytes.end(), packed.begin() + static_cast<std::ptrdiff_t>(at),
                         packed.begin() + static_cast<std::ptrdiff_t>(at + count));
            at += count;
            continue;
        }
        std::size_t count = head >> 5u;
        if (count == longCopy) {
            if (at == packed.size()) return false;
            count += packed[at++];
        }
        count += shortestCopy;
        if (at == packed.size()) return false;
        const std::size_t back = ((head & 31u) << 8u | packed[at++]) + 1;
        if (back > bytes.size() || count > most - bytes.size()) return false;
        // What is copied may still be in the making: byte by byte.
        for (std::size_t i = 0; i < count; ++i) bytes.push_back(bytes[bytes.size() - back]);
    }
    return true;
}

}  // namespace mote::prep
