// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/page.h"

#include "protocol/base/check.h"

namespace mote {

Result<Page> parsePage(const proto::Page& message) {
    if (message.format() != proto::Page::SVG && message.format() != proto::Page::EPS &&
        message.format() != proto::Page::PDF) {
        return Error{ErrorCode::invalidArgument, "format", "must be SVG, EPS or PDF"};
    }
    MOTE_RETURN_IF_ERROR(checkRange(message.width(), 0.0, Page::maxSide, "width"));
    MOTE_RETURN_IF_ERROR(checkRange(message.height(), 0.0, Page::maxSide, "height"));
    MOTE_RETURN_IF_ERROR(checkRange(message.margin(), 0.0, Page::maxSide, "margin"));
    MOTE_RETURN_IF_ERROR(checkRange(message.dot(), 0.0, 100.0, "dot"));
    for (const double side : {message.width(), message.height()}) {
        if (side > 0.0 && side - 2.0 * message.margin() < 1.0) {
            return Error{ErrorCode::invalidArgument, "margin", "leaves less than a millimetre of the page"};
        }
    }
    return Page{message.format(), message.width(), message.height(),
                message.margin(), message.dot(),   message.plotter()};
}

}  // namespace mote
