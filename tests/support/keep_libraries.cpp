// SPDX-License-Identifier: GPL-3.0-or-later
//
// Linked into programs that are built with a sanitizer: what a library was loaded for stays loaded, so that
// memory which a driver of Mesa keeps in its globals to the end is no leak, and stacks name their functions.
extern "C" int dlclose(void* /*handle*/);

int dlclose(void* /*handle*/) {
    return 0;
}
