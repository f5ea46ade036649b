// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/web/gateway/gateway.h"
#include "protocol/base/text_file.h"

#include <fmt/format.h>

#include <functional>
#include <system_error>

namespace mote::web {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t mostPageBytes = std::size_t{16} << 20;

std::string mediaType(const fs::path& name) {
    static const std::map<std::string, std::string, std::less<>> types{
        {".html", "text/html; charset=utf-8"}, {".js", "text/javascript; charset=utf-8"},
        {".css", "text/css; charset=utf-8"},   {".svg", "image/svg+xml"},
        {".wasm", "application/wasm"},         {".txt", "text/plain; charset=utf-8"}};
    const auto found = types.find(name.extension().string());
    return found == types.end() ? "application/octet-stream" : found->second;
}

}  // namespace

Result<PageFiles> loadPage(const fs::path& folder) {
    PageFiles files;
    std::error_code code;
    for (fs::directory_iterator each(folder, code), end; !code && each != end; each.increment(code)) {
        if (!each->is_regular_file(code)) continue;
        auto name = each->path().filename();
        const auto packed = name.extension();
        if (packed == ".br" || packed == ".gz") name.replace_extension();
        MOTE_ASSIGN_OR_RETURN(auto bytes, readTextFile(each->path(), mostPageBytes));
        auto& file = files[name.string()];
        file.type = mediaType(name);
        if (packed == ".br") {
            file.brotli = std::move(bytes);
        } else if (packed == ".gz") {
            file.gzip = std::move(bytes);
        } else {
            file.tag = fmt::format("\"{:x}-{:x}\"", bytes.size(), std::hash<std::string>{}(bytes));
            file.plain = std::move(bytes);
        }
    }
    if (!files.contains("index.html"))
        return notFound(folder.string(), "there is no page here: it is built where node and npm are found");
    return files;
}

}  // namespace mote::web
