// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/log/line_limit.h"

namespace mote::server::log {

bool LineLimit::admit(std::string_view kind, Clock::time_point now) {
    auto found = windows_.find(kind);
    if (found == windows_.end()) found = windows_.emplace(kind, Window{now}).first;
    return ++found->second.lines <= lines_;
}

std::vector<LineLimit::LeftOut> LineLimit::over(Clock::time_point now) {
    std::vector<LeftOut> left;
    for (auto window = windows_.begin(); window != windows_.end();) {
        if (now < window->second.begin + window_) {
            ++window;
            continue;
        }
        if (window->second.lines > lines_) left.push_back({window->first, window->second.lines - lines_});
        window = windows_.erase(window);
    }
    return left;
}

}  // namespace mote::server::log
