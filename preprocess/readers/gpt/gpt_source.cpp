// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/file_number.h"
#include "preprocess/readers/gpt/gpt_table.h"
#include "preprocess/readers/odd_steps.h"
#include "preprocess/readers/particle_formats.h"
#include "preprocess/readers/text/byte_source.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

constexpr std::string_view magic = "\x75\x4c\x9f\x05";  // 94325877
constexpr std::uint64_t linesToLookAt = 100;

}  // namespace

bool looksLikeGdf(std::string_view begin) {
    return begin.starts_with(magic);
}

bool looksLikeGptText(const std::filesystem::path& path) {
    auto reader = LineReader::open(path);
    if (!reader) return false;
    for (std::string_view line; reader->lineNumber() < linesToLookAt;) {
        const auto more = reader->next(line);
        if (!more || !*more) return false;
        if (namesGptColumns(line)) return true;
    }
    return false;
}

Result<std::unique_ptr<ParticleSource>> openGpt(const std::vector<std::filesystem::path>& paths, double mass,
                                                Progress& progress) {
    std::vector<HeldTable> tables;
    HeldNumbers held;
    OddSteps odd;
    for (const std::filesystem::path& path : inOrder(paths)) {
        if (progress.cancelled()) return Error{ErrorCode::cancelled, "", "cancelled while a file was read"};
        std::string begin(magic.size(), '\0');
        MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(path));
        MOTE_ASSIGN_OR_RETURN(const auto got, source->read(begin));
        begin.resize(got);
        const std::string name = path.filename().string();
        auto blocks = looksLikeGdf(begin) ? readGdf(path, held) : readGptText(path, held);
        Status status = blocks ? success() : Status(blocks.error());
        if (blocks && blocks->empty())
            status = Error{ErrorCode::notFound, name, "holds no particles (arrays x, Bx or GBx, ...)"};
        MOTE_RETURN_IF_ERROR(odd.add(status));
        if (!status.ok()) continue;
        for (GptBlock& block : *blocks) tables.push_back(gptTable(std::move(block), mass, name));
        if (paths.size() > 1 && blocks->size() == 1) tables.back().iteration = fileNumber(path);
    }
    MOTE_RETURN_IF_ERROR(odd.finish(!tables.empty(), progress));
    return holdTables("gpt", std::move(tables), mass, progress);
}

}  // namespace mote::prep
