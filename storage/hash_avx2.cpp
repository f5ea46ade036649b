// SPDX-License-Identifier: GPL-3.0-or-later
//
// Compiled for AVX2 (CMakeLists.txt): nothing may be included of which others could get this source's copy.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "storage/hash_kernel.h"

#ifdef MOTE_HASH_BY_AVX2
namespace mote::storage {

std::uint64_t hashByAvx2(const void* bytes, std::size_t size) {
    return XXH3_64bits(bytes, size);
}

void addByAvx2(void* state, const void* bytes, std::size_t size) {
    XXH3_128bits_update(static_cast<XXH3_state_t*>(state), bytes, size);
}

}  // namespace mote::storage
#endif
