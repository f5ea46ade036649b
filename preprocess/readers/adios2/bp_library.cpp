// SPDX-License-Identifier: GPL-3.0-or-later
#include <dlfcn.h>

#include "preprocess/load_module.h"
#include "preprocess/readers/adios2/bp_file.h"

namespace mote::prep {
namespace {

// The module's read(2) is to be ADIOS2's; sanitizers, which have names of theirs everywhere, refuse it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int ownNamesFirst = 0;
#else
constexpr int ownNamesFirst = RTLD_DEEPBIND;
#endif

}  // namespace

OpenBp openBp() {
    static const auto found =
        reinterpret_cast<OpenBp>(moduleFunction("mote-adios2", openBpName, ownNamesFirst));
    return found;
}

}  // namespace mote::prep
