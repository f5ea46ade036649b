// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <filesystem>

#include "server/app/options.h"
#define TOML_EXCEPTIONS 0
#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

namespace mote::server {
namespace {

Error invalid(const std::string& path, const toml::source_region& source, std::string message) {
    return {ErrorCode::invalidArgument, fmt::format("{}:{}", path, source.begin.line), std::move(message)};
}

template <class T>
Status take(const std::string& path, std::string_view key, const toml::node& node, const char* kind,
            std::optional<T>& value) {
    value = node.value_exact<T>();
    if (value) return success();
    return invalid(path, node.source(), fmt::format("\"{}\" must be {}", key, kind));
}

Status takeRoots(const std::string& path, const toml::node& node, std::vector<std::string>& roots) {
    const auto* array = node.as_array();
    if (!array) return invalid(path, node.source(), "\"root\" must be a list of \"NAME=DIR\"");
    for (const auto& element : *array) {
        std::optional<std::string> root;
        MOTE_RETURN_IF_ERROR(take(path, "root", element, "a list of \"NAME=DIR\"", root));
        roots.push_back(*root);
    }
    return success();
}

Status takeOption(const std::string& path, std::string_view key, const toml::node& node,
                  FileOptions& options) {
    const std::pair<std::string_view, std::optional<std::string>*> texts[] = {
        {"state", &options.state},   {"connection", &options.connection}, {"listen", &options.listen},
        {"device", &options.device}, {"memory", &options.memory},
    };
    for (const auto& [name, value] : texts) {
        if (key == name) return take(path, key, node, "a text", *value);
    }
    if (key == "root") return takeRoots(path, node, options.roots);
    if (key != "threads") {
        return invalid(path, node.source(), fmt::format("there is no option \"{}\"", key));
    }
    MOTE_RETURN_IF_ERROR(take(path, key, node, "a whole number", options.threads));
    if (*options.threads >= 0 && *options.threads <= 4096) return success();
    return invalid(path, node.source(), "\"threads\" must be 0 to 4096");
}

}  // namespace

Result<FileOptions> readConfig(const std::string& path) {
    std::error_code code;
    if (!std::filesystem::is_regular_file(path, code)) {
        return Error{ErrorCode::notFound, path, "there is no such configuration file"};
    }
    const auto parsed = toml::parse_file(path);
    if (!parsed) {
        return invalid(path, parsed.error().source(), std::string(parsed.error().description()));
    }
    FileOptions options;
    for (const auto& [key, node] : parsed.table()) {
        MOTE_RETURN_IF_ERROR(takeOption(path, key.str(), node, options));
    }
    return options;
}

}  // namespace mote::server
