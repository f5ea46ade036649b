// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the fuzzer of the text and NumPy readers and the replay of its corpus share. Functions without state.
#pragma once

#include <string>
#include <string_view>

namespace mote::test {

/// Reads `input` as the job would read a file: its first line names the format (csv, impactz, impactt, npy,
/// deck, track or auto), the rest is the file, which never touches the disk. Returns the error's sentence, ""
/// where all was read. Aborts where a reader breaks its contract: columns of another length than asked for, a
/// negative weight.
std::string readTable(std::string_view input);

}  // namespace mote::test
