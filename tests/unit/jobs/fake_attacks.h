// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a program that foreign bytes have taken over would try, for fake_prep. A function without state.
#pragma once

#include <string>

/// Tries `verb` on `word` and prints on stderr "VERB: allowed" or why not; false: it knows no such verb.
///   kill:PID     SIGKILL to another process       fork:        a child
///   take:MIB     private memory, written to       share:MIB    the same, shared and no file's
///   setsid:      a child in a session of its own  namespace:   CLONE_NEWUSER
///   unshare:     the same by unshare()            ptrace:PID   attaches
///   memory:PID   process_vm_readv                 chmod:PATH   takes all rights from a file
///   fchmod:PATH  the same of an open one          times:PATH   makes a file older
///   cut:PATH     opens to read with O_TRUNC       remove:PATH  unlinks
///   link:PATH    a second name in ROOT            renice:PID   lowers another's priority
///   limit:PID    lowers another's limits          bind:        an abstract Unix socket
///   memfd:       memory as a file                 prctl:       no more a signal when the parent ends
///   terminal:    writes into its terminal's input environment: prints its variables' names
bool attack(const std::string& verb, const std::string& word, const std::string& root);
