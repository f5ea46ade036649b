// SPDX-License-Identifier: GPL-3.0-or-later
//
// Modules: parts of mote-prep that are loaded when they are needed, for they come with libraries that take
// long to load, or need not be there. Between a module and the program stand the standard library's types
// alone.
#pragma once

namespace mote::prep {

/// The function `name` of a module beside the program, or where it is installed, "mote-adios2"; loaded by
/// dlopen with `flags` too, and never unloaded. Null: it is not there.
void* moduleFunction(const char* module, const char* name, int flags = 0);

}  // namespace mote::prep
