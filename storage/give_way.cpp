// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/give_way.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

namespace mote::storage {

constexpr int niceness = 10;

/// On Linux both concern the calling thread alone, whatever it inherits.
void giveWay() {
    const sched_param none{};
    ::sched_setscheduler(0, SCHED_BATCH, &none);
    ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), niceness);
}

}  // namespace mote::storage
