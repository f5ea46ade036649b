// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/load_module.h"

#include <dlfcn.h>

#include <filesystem>
#include <string>
#include <system_error>

namespace mote::prep {

void* moduleFunction(const char* module, const char* name, int flags) {
    std::error_code code;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", code).parent_path();
    // In a build, beside the programs; installed, where libraries are that no others use.
    for (const char* place : {".", "../lib/mote", "../bin"}) {
        const auto path = program / place / (std::string(module) + ".so");
        if (!std::filesystem::exists(path, code)) continue;
        if (void* const loaded = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | flags))
            return dlsym(loaded, name);
    }
    return nullptr;
}

}  // namespace mote::prep
