// SPDX-License-Identifier: GPL-3.0-or-later
//
// HDF5 files from a few lines of text, which may say anything. Of one thread, as HDF5 is.
//
//   group PATH                           soft PATH TARGET    hard PATH TARGET    external PATH
//   data PATH TYPE SHAPE STORAGE VALUE...
//   numbers PATH NAME TYPE SHAPE VALUE...     an attribute
//   text PATH NAME KIND TEXT                  an attribute; TEXT may be TEXT|TEXT...
//   cut BYTES                                 off the file's end
//
// PATH: groups on the way are made, too. TYPE: i8, u8, ..., f64, with "be" behind it big-endian; or enum,
// text, opaque, compound. SHAPE: 3x4, "-" for one value, "null" for none. STORAGE: plain, compact, unwritten,
// external, chunks, deflate, shuffle, fletcher, nbit, several joined by commas. VALUE: from the first one
// again where there are too few; 0, 1, 2... where there is none. KIND: fixed or variable.
#pragma once

#include <string>
#include <string_view>

namespace mote::test {

/// The file's bytes. What HDF5 does not take is left out; "" where there is nothing left.
std::string hdf5Of(std::string_view text);

}  // namespace mote::test
