// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/deflate.h"

#include <zlib.h>

namespace mote::test {
namespace {

std::string deflated(const std::string& bytes, int window) {
    z_stream stream{};
    deflateInit2(&stream, 9, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&stream, bytes.size()), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

}  // namespace

std::string gzipped(const std::string& bytes) {
    return deflated(bytes, 15 + 16);
}

std::string zlibDeflated(const std::string& bytes) {
    return deflated(bytes, 15);
}

}  // namespace mote::test
