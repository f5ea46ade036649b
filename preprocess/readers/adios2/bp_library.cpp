// SPDX-License-Identifier: GPL-3.0-or-later
#include <dlfcn.h>

#include <filesystem>
#include <system_error>

#include "preprocess/readers/adios2/bp_file.h"

namespace mote::prep {
namespace {

// The module's read(2) is to be ADIOS2's; sanitizers, which have names of theirs everywhere, refuse it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int ownNamesFirst = 0;
#else
constexpr int ownNamesFirst = RTLD_DEEPBIND;
#endif

OpenBp findBpModule() {
    std::error_code code;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", code).parent_path();
    // In a build, beside the programs; installed, where libraries are that no others use.
    for (const char* place : {".", "../lib/mote", "../bin"}) {
        const auto path = program / place / "mote-adios2.so";
        if (!std::filesystem::exists(path, code)) continue;
        if (void* const module = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | ownNamesFirst))
            return reinterpret_cast<OpenBp>(dlsym(module, openBpName));
    }
    return nullptr;
}

}  // namespace

OpenBp openBp() {
    static const OpenBp found = findBpModule();
    return found;
}

}  // namespace mote::prep
