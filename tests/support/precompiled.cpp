// SPDX-License-Identifier: GPL-3.0-or-later
//
// Nothing: what its target precompiles is used by all tests.
