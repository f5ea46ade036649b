// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/supervise/supervise.h"

#include <charconv>
#include <string_view>

namespace mote::server {

const char* const orderHelp =
    R"(Runs one job of mote-server, with few rights, and outlives the server that started it.
Usage: mote-supervise --directory DIR [OPTIONS] -- PROGRAM [ARGUMENT]...

Options:
  --help                      Print this help message and exit
  --directory DIR REQUIRED    The job's folder, for its progress and its result
  --memory BYTES              What the program may take
  --file-size BYTES           No file that it writes to becomes larger
  --nice STEPS                How far its priority lies below this program's
  --sockets unix              It may open Unix sockets, and no others
  --launcher mpi              It is mpirun: it starts processes, which talk to each other; its output is progress
  --time-limit SECONDS        It is ended then
  --gate none                 Begin at once
  --read DIR ...              What the program may read besides the system
  --write DIR ...             What it may write
  --publish output|steps      It makes what the file "output" in its folder says, in a folder beside that; with
                              "steps" these may be further ones of the live dataset there
  --unconfined allowed        It runs even where the kernel cannot take rights away
)";

std::optional<Order> parseOrder(int argc, char** argv) {
    Order order;
    int i = 1;
    for (; i + 1 < argc && std::string_view(argv[i]) != "--"; i += 2) {
        const std::string_view option(argv[i]), value(argv[i + 1]);
        if (option == "--directory") {
            order.directory = value;
        } else if (option == "--read") {
            order.rights.readable.emplace_back(value);
        } else if (option == "--write") {
            order.rights.writable.emplace_back(value);
        } else if (option == "--publish" && (value == "output" || value == "steps")) {
            order.publishes = true;
            order.grows = value == "steps";
        } else if (option == "--unconfined" && value == "allowed") {
            order.unconfined = true;
        } else if (option == "--memory") {
            std::from_chars(value.data(), value.data() + value.size(), order.rights.memory);
        } else if (option == "--file-size") {
            std::from_chars(value.data(), value.data() + value.size(), order.rights.fileSize);
        } else if (option == "--nice") {
            std::from_chars(value.data(), value.data() + value.size(), order.rights.niceness);
        } else if (option == "--sockets" && value == "unix") {
            order.rights.unixSockets = true;
        } else if (option == "--launcher" && value == "mpi") {
            order.rights.launcher = true;
        } else if (option == "--time-limit") {
            std::from_chars(value.data(), value.data() + value.size(), order.timeLimit);
        } else if (option == "--gate" && value == "none") {
            order.gate = false;
        } else {
            return std::nullopt;
        }
    }
    if (order.directory.empty() || i + 1 >= argc) return std::nullopt;
    order.program.assign(argv + i + 1, argv + argc);
    order.program.push_back(nullptr);
    return order;
}

}  // namespace mote::server
