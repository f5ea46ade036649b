// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/server_program.h"

int main(int argc, char** argv) {
    return mote::server::serverProgram(argc, argv, mote::render::createDevice);
}
